//! Wind on the faces of a surface: quasi-steady forces on each face, as on a plate in a uniform stream.
//!
//! A face has the area A and the unit normal n; its centroid moves with the velocity u. The air has the density ρ and the
//! velocity w. The relative velocity r = w − u has the normal part q n and the tangential part t. With the coefficients `C_n` of
//! normal force and `C_t` of skin friction, the force on the face is
//!
//! F = ½ ρ A (`C_n` |q| q n + `C_t` |t| t),
//!
//! a third of it at each corner. Its power F·u splits into the power of the wind, F·w, and the dissipated power, F·r ≥ 0. All
//! quantities are computed in double precision.
//!
//! Rigid bodies feel half of this law on each face of their surface ([`solid`]).
//!
//! Source: S. F. Hoerner, "Fluid-Dynamic Drag", 1965, chapters 2 and 3, the cross-flow principle.

mod solid;

use std::ops::Range;

use glam::{DMat3, DVec3};

use super::corners::Corners;
use super::derivatives::{Derivatives, Directed, MatrixBlock, Motion, Push, outer};
use super::stream::Stream;
use super::{About, Declared, Force, ForceKind, Forces, Rates, Reach, StateView, Validity, VelocityDependence};
use crate::error::{Error, Result};
use crate::history::History;
use crate::math::Vector;
use crate::matter::{EnergySink, View};
use crate::parallel::Executor;
use crate::scene::Item;
use crate::stability::{Horizon, SpectralBound};
use solid::SolidWind;

/// Air in motion.
#[derive(Debug)]
struct Air {
    /// Velocity w [m/s], at the centroid of each face if it depends on the place.
    velocity: Stream,
    /// Density ρ [kg/m³].
    density: f64,
    /// Coefficient `C_n` of normal force.
    normal: f64,
    /// Coefficient `C_t` of skin friction.
    tangential: f64,
}

/// Wind on networks with faces.
#[derive(Debug)]
pub struct Wind<V: Vector> {
    air: Air,
    /// Corners of the faces, in the engine's order.
    faces: Vec<[u32; 3]>,
    /// Whether a side of each face is torn; such a face feels no force.
    torn: Vec<bool>,
    /// Forces on the corners, with the dissipated and supplied powers.
    corners: Corners<V, 3, 2>,
}

/// Entry in the registry of forces.
pub fn kind<V: Vector>() -> ForceKind<V> {
    let build = |declared: &Declared<'_, V>| -> Result<Forces<V>> {
        let mut forces: Forces<V> = Vec::new();
        if let Some(solid) = SolidWind::new(declared)? {
            forces.push(Box::new(solid));
        }
        let is_faced = V::DIMENSION == 3 && declared.faces().any(|(_, faces)| !faces.is_empty());
        if is_faced || forces.is_empty() {
            forces.push(Box::new(Wind::<V>::new(declared)?));
        }
        Ok(forces)
    };
    ForceKind { name: "Wind", reach: Reach::Network, charges: false, build }
}

/// Positions or velocities of the corners of a face.
fn gather<V: Vector>(face: [u32; 3], columns: &View<'_, V>) -> [DVec3; 3] {
    face.map(|corner| columns.get(corner as usize).widen())
}

/// Mean of the values at the corners of a face.
fn centroid(corners: [DVec3; 3]) -> DVec3 {
    corners.iter().sum::<DVec3>() / 3.0
}

/// Centroids of faces [m].
fn centroids<V: Vector>(faces: &[[u32; 3]], at: &StateView<'_, V>) -> Vec<DVec3> {
    faces.iter().map(|&face| at.properties.origin + centroid(gather(face, &at.position))).collect()
}

/// Area times unit normal [m²].
fn area([a, b, c]: [DVec3; 3]) -> DVec3 {
    0.5 * (b - a).cross(c - a)
}

impl<V: Vector> Declared<'_, V> {
    /// Bodies that the force acts on.
    fn bodies(&self) -> Vec<usize> {
        self.item.on.clone().unwrap_or_else(|| (0..self.scene.bodies.len()).collect())
    }

    /// Faces of each of these bodies, by its own particles.
    fn faces(&self) -> impl Iterator<Item = (usize, &[[u32; 3]])> {
        self.bodies().into_iter().map(move |body| (body, self.scene.bodies[body].item.tuples::<3>("faces").unwrap_or(&[])))
    }
}

impl Air {
    /// Air of an item, at `points` points.
    fn declared(item: &Item, dimension: usize, points: usize) -> Result<Self> {
        Ok(Self {
            velocity: Stream::declared(item, "velocity", dimension, points)?,
            density: item.non_negative("density")?,
            normal: item.non_negative("normal")?,
            tangential: item.non_negative("tangential")?,
        })
    }

    /// Velocity r of the air relative to a face with these velocities of its corners [m/s].
    fn relative(&self, face: usize, velocities: [DVec3; 3]) -> DVec3 {
        self.velocity.value(face) - centroid(velocities)
    }

    /// Force on a face [N], from its area times its unit normal and the relative velocity.
    fn force(&self, area: DVec3, relative: DVec3) -> DVec3 {
        let size = area.length();
        if size == 0.0 {
            return DVec3::ZERO;
        }
        let normal = area / size;
        let across = normal.dot(relative);
        let along = relative - across * normal;
        let pressure = self.normal * across.abs() * across * normal + self.tangential * along.length() * along;
        0.5 * self.density * size * pressure
    }

    /// Bound on |∂F/∂r| of a face [N·s/m].
    fn rate(&self, area: DVec3, relative: DVec3) -> f64 {
        let across = area.normalize_or_zero().dot(relative).abs();
        let along = (relative.length_squared() - across * across).max(0.0).sqrt();
        self.density * area.length() * (self.normal * across).max(self.tangential * along)
    }

    /// Derivative ∂F/∂r = ½ ρ A (2 `C_n` |q| nnᵀ + `C_t` (|t| (1 − nnᵀ) + ttᵀ/|t|)), symmetric and positive semidefinite.
    fn damping(&self, area: DVec3, relative: DVec3) -> DMat3 {
        let normal = area.normalize_or_zero();
        let across = normal.dot(relative);
        let along = relative - across * normal;
        let friction = Directed { along: 2.0 * self.normal * across.abs(), across: self.tangential * along.length() };
        let turned = self.tangential * outer(along, along.normalize_or_zero());
        0.5 * self.density * area.length() * (friction.matrix(normal) + turned)
    }
}

impl<V: Vector> Wind<V> {
    fn new(declared: &Declared<'_, V>) -> Result<Self> {
        let Declared { scene, item, properties, chosen, .. } = declared;
        if V::DIMENSION != 3 {
            return Err(Error::parameter(&item.path, "a scene in 3D", format!("{}D", V::DIMENSION)));
        }
        let engine = properties.engine();
        let mut faces = Vec::new();
        for (body, own) in declared.faces() {
            let number = |corner: u32| engine[scene.first(body) + corner as usize];
            let faces_in_engine = own.iter().map(|face| face.map(number));
            faces.extend(faces_in_engine.filter(|face| face.iter().all(|&corner| chosen[corner as usize])));
        }
        let air = Air::declared(item, V::DIMENSION, faces.len())?;
        let corners = Corners::new(properties.count(), faces.iter().copied());
        Ok(Self { air, torn: vec![false; faces.len()], corners, faces })
    }
}

impl<V: Vector> History for Wind<V> {}

impl<V: Vector> Force<V> for Wind<V> {
    fn about(&self) -> About {
        About {
            velocity: VelocityDependence::Dissipative,
            potential: None,
            callback: self.air.velocity.varies(),
            pairs: self.faces.len(),
            bytes: size_of_val(self.faces.as_slice())
                + size_of_val(self.torn.as_slice())
                + self.corners.bytes()
                + self.air.velocity.bytes(),
            layout: format!("{} faces", self.faces.len()),
            ..About::new("wind", Reach::Network)
        }
    }

    fn prepare(&mut self, at: &StateView<'_, V>, executor: &Executor) -> Result<()> {
        self.air.velocity.update(at.time, || centroids(&self.faces, at))?;
        let (air, faces, torn) = (&self.air, &self.faces, &self.torn);
        self.corners.evaluate(executor, |face| {
            if torn[face] {
                return Default::default();
            }
            let relative = air.relative(face, gather(faces[face], &at.velocity));
            let force = air.force(area(gather(faces[face], &at.position)), relative);
            ([force / 3.0; 3], [force.dot(relative), force.dot(air.velocity.value(face))])
        })
    }

    fn accumulate(&self, block: Range<usize>, _at: &StateView<'_, V>, rates: &mut Rates<'_, V>) {
        self.corners.accumulate(&block, [EnergySink::Drag, EnergySink::Work], rates);
    }

    fn tear(&mut self, torn: &dyn Fn([u32; 2]) -> bool, _at: &StateView<'_, V>) -> f64 {
        for (face, gone) in self.faces.iter().zip(&mut self.torn) {
            *gone = [[0, 1], [1, 2], [2, 0]].iter().any(|&[one, other]| {
                let [one, other] = [face[one], face[other]];
                torn([one.min(other), one.max(other)])
            });
        }
        0.0
    }

    /// A symmetric block matrix is bounded above by the diagonal matrix of its row sums. ∂F/∂u is at most ρ A c, where c is the
    /// larger of `C_n` |q| and `C_t` |t|. Each corner feels a third of F, and moves the centroid by a third of its displacement.
    ///
    /// Let a corner j move by δ, and let hⱼ be its height. The normal turns by at most δ/hⱼ, and the area changes by at most the
    /// fraction δ/hⱼ. With q² + t² = r², F then changes by at most ½ ρ A r² (5/2 `C_n` + 7/2 `C_t`) δ/hⱼ. A Σ 1/hⱼ is half the
    /// perimeter. Where the wind depends on the place, the displacement of the centroid changes r as a velocity does.
    fn bound(&self, at: &StateView<'_, V>, bound: &mut SpectralBound) -> Result<()> {
        let velocity = self.air.velocity.with_gradients(at.time, || centroids(&self.faces, at))?;
        for (index, (&face, _)) in self.faces.iter().zip(&self.torn).enumerate().filter(|(_, (_, torn))| !**torn) {
            let x = gather(face, &at.position);
            let (velocity, gradient) = velocity.at(index);
            let (area, relative) = (area(x), velocity - centroid(gather(face, &at.velocity)));
            let damping = self.air.rate(area, relative) / 3.0;
            let perimeter = (0..3).map(|side| (x[(side + 1) % 3] - x[side]).length()).sum::<f64>();
            let pressure = 0.5 * self.air.density * relative.length_squared();
            let stiffness = pressure * (2.5 * self.air.normal + 3.5 * self.air.tangential) * perimeter / 6.0 + gradient * damping;
            face.iter().for_each(|&corner| bound.point(corner as usize, "wind", stiffness, damping));
        }
        Ok(())
    }

    fn validity(&self, _at: &StateView<'_, V>, _horizon: Horizon) -> Validity {
        if self.faces.is_empty() { Validity::Always } else { Validity::Now }
    }

    fn derivatives(&mut self) -> Option<&mut dyn Derivatives> {
        Some(self)
    }
}

impl<V: Vector> Wind<V> {
    /// The corners of each face that is not torn, its area times unit normal, and the velocity of the air relative to it.
    fn met(&self, at: &Motion<'_>) -> impl Iterator<Item = ([u32; 3], DVec3, DVec3)> {
        let of = |values: &[DVec3], face: [u32; 3]| face.map(|corner| values[corner as usize]);
        let there = self.faces.iter().zip(&self.torn).enumerate().filter(|(_, (_, torn))| !**torn);
        there.map(move |(index, (&face, _))| (face, area(of(at.position, face)), self.air.relative(index, of(at.velocity, face))))
    }
}

/// A third of F acts on each corner, and each corner moves the centroid by a third of its displacement. −∂Fᵢ/∂vⱼ is therefore a
/// ninth of ∂F/∂r for all corners i and j. The derivatives by position have a negligible symmetric part, and are omitted.
impl<V: Vector> Derivatives for Wind<V> {
    fn arrange(&mut self, at: &Motion<'_>, _executor: &Executor) -> Result<()> {
        let corners = |face: [u32; 3]| face.map(|corner| at.position[corner as usize]);
        let centroids = || self.faces.iter().map(|&face| at.origin + centroid(corners(face))).collect();
        self.air.velocity.update(at.time, centroids)
    }

    fn forces(&self, at: &Motion<'_>, push: &mut dyn FnMut(Push)) {
        for (face, area, relative) in self.met(at) {
            let force = self.air.force(area, relative) / 3.0;
            // The relative uncertainty of an area is that of its sides.
            let stiffness = force.length() / area.length().sqrt();
            face.iter().for_each(|&corner| push(Push { particle: corner as usize, force, stiffness }));
        }
    }

    fn blocks(&self, at: &Motion<'_>, [_, rate]: [f64; 2], add: &mut dyn FnMut(MatrixBlock)) {
        for (face, area, relative) in self.met(at) {
            let matrix = rate / 9.0 * self.air.damping(area, relative);
            for (place, &corner) in face.iter().enumerate() {
                add(MatrixBlock::of(corner as usize, 3.0 * matrix, 3.0 * matrix));
                face[..place]
                    .iter()
                    .for_each(|&other| add(MatrixBlock { ends: [corner, other], exact: -matrix, definite: -matrix }));
            }
        }
    }
}
