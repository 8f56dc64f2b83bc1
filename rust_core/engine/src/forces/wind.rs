//! Wind on the faces of a surface: quasi-steady forces of a plate in a uniform stream.
//!
//! A face of area A and unit normal n, whose centroid moves with u, meets air of density ρ and velocity w with the relative velocity
//! r = w − u, of which q n is normal and t tangential. With the coefficients `C_n` of normal force and `C_t` of skin friction it feels
//!
//! F = ½ ρ A (`C_n` |q| q n + `C_t` |t| t),
//!
//! a third at each corner. Its power F·u splits into that of the wind, F·w, and the dissipated one, F·r ≥ 0. Source: S. F. Hoerner,
//! "Fluid-Dynamic Drag", 1965, chapters 2 and 3, the cross-flow principle. All of this is computed in double precision.

use std::ops::Range;

use glam::{DMat3, DVec3};

use super::corners::Corners;
use super::derivatives::{Block, Derivatives, Directed, Motion, Push, outer};
use super::{About, Declared, Force, Forces, Kind, Rates, Reach, StateView, Validity, VelocityDependence};
use crate::error::{Error, Result};
use crate::history::History;
use crate::math::Vector;
use crate::matter::{EnergySink, View};
use crate::parallel::Executor;
use crate::stability::{Horizon, SpectralBound};

/// Air in uniform motion.
#[derive(Debug)]
struct Air {
    /// w [m/s].
    velocity: DVec3,
    /// ρ [kg/m³].
    density: f64,
    /// `C_n`.
    normal: f64,
    /// `C_t`.
    tangential: f64,
}

/// Wind on some networks with faces.
#[derive(Debug)]
pub struct Wind<V: Vector> {
    air: Air,
    /// The corners of the faces, in the engine's order.
    faces: Vec<[u32; 3]>,
    /// Whether a side of each is torn: it feels nothing then.
    torn: Vec<bool>,
    /// The forces on the corners, and the powers that are dissipated and supplied.
    corners: Corners<V, 3, 2>,
}

/// The registry's entry.
pub fn kind<V: Vector>() -> Kind<V> {
    let build = |declared: &Declared<'_, V>| -> Result<Forces<V>> { Ok(vec![Box::new(Wind::<V>::new(declared)?)]) };
    Kind { name: "Wind", reach: Reach::Network, charges: false, build }
}

/// The positions or velocities of the corners of a face.
fn gather<V: Vector>(face: [u32; 3], columns: &View<'_, V>) -> [DVec3; 3] {
    face.map(|corner| columns.get(corner as usize).widen())
}

/// The area times the unit normal [m²].
fn area([a, b, c]: [DVec3; 3]) -> DVec3 {
    0.5 * (b - a).cross(c - a)
}

impl Air {
    /// The velocity relative to a face, r.
    fn relative(&self, velocities: [DVec3; 3]) -> DVec3 {
        self.velocity - velocities.iter().sum::<DVec3>() / 3.0
    }

    /// The force on a face [N], for its area times its normal and the relative velocity.
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

    /// ∂F/∂r = ½ ρ A (2 `C_n` |q| nnᵀ + `C_t` (|t| (1 − nnᵀ) + ttᵀ/|t|)), symmetric and positive semidefinite.
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
        let Declared { scene, item, properties, .. } = declared;
        if V::DIMENSION != 3 {
            return Err(Error::parameter(&item.path, "a scene in 3D", format!("{}D", V::DIMENSION)));
        }
        let air = Air {
            velocity: item.vector("velocity")?,
            density: item.non_negative("density")?,
            normal: item.non_negative("normal")?,
            tangential: item.non_negative("tangential")?,
        };
        let engine = properties.engine();
        let named = item.on.clone().unwrap_or_else(|| (0..scene.bodies.len()).collect());
        let mut faces = Vec::new();
        for body in named {
            let number = |corner: u32| engine[scene.first(body) + corner as usize];
            let own = scene.bodies[body].item.tuples::<3>("faces").unwrap_or(&[]);
            faces.extend(own.iter().map(|face| face.map(number)));
        }
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
            pairs: self.faces.len(),
            bytes: size_of_val(self.faces.as_slice()) + size_of_val(self.torn.as_slice()) + self.corners.bytes(),
            layout: format!("{} faces", self.faces.len()),
            ..About::new("wind", Reach::Network)
        }
    }

    fn prepare(&mut self, at: &StateView<'_, V>, executor: &Executor) -> Result<()> {
        let (air, faces, torn) = (&self.air, &self.faces, &self.torn);
        self.corners.evaluate(executor, |face| {
            if torn[face] {
                return Default::default();
            }
            let relative = air.relative(gather(faces[face], &at.velocity));
            let force = air.force(area(gather(faces[face], &at.position)), relative);
            ([force / 3.0; 3], [force.dot(relative), force.dot(air.velocity)])
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

    /// A symmetric matrix of blocks is at most the diagonal one of its row sums. ∂F/∂u is at most ρ A c with c the larger of `C_n` |q|
    /// and `C_t` |t|; a corner feels a third of F, and moves the centroid by a third of its way. Where a corner j moves by δ, the
    /// normal turns by δ/hⱼ at most, hⱼ its height, and the area changes by the fraction δ/hⱼ at most. With q² + t² = r², F then
    /// changes by ½ ρ A r² (5/2 `C_n` + 7/2 `C_t`) δ/hⱼ at most, and A Σ 1/hⱼ is half the perimeter.
    fn bound(&self, at: &StateView<'_, V>, bound: &mut SpectralBound) -> Result<()> {
        for face in self.faces.iter().zip(&self.torn).filter_map(|(face, torn)| (!torn).then_some(*face)) {
            let x = gather(face, &at.position);
            let (area, relative) = (area(x), self.air.relative(gather(face, &at.velocity)));
            let across = area.normalize_or_zero().dot(relative).abs();
            let along = (relative.length_squared() - across * across).max(0.0).sqrt();
            let damping = self.air.density * area.length() * (self.air.normal * across).max(self.air.tangential * along) / 3.0;
            let perimeter = (0..3).map(|side| (x[(side + 1) % 3] - x[side]).length()).sum::<f64>();
            let pressure = 0.5 * self.air.density * relative.length_squared();
            let stiffness = pressure * (2.5 * self.air.normal + 3.5 * self.air.tangential) * perimeter / 6.0;
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
    /// The corners of each face that is there, its area times its normal, and its velocity relative to the air.
    fn met(&self, at: &Motion<'_>) -> impl Iterator<Item = ([u32; 3], DVec3, DVec3)> {
        let of = |values: &[DVec3], face: [u32; 3]| face.map(|corner| values[corner as usize]);
        let there = self.faces.iter().zip(&self.torn).filter(|(_, torn)| !**torn);
        there.map(move |(&face, _)| (face, area(of(at.position, face)), self.air.relative(of(at.velocity, face))))
    }
}

/// A third of F acts on each corner, and each moves the centroid by a third: −∂Fᵢ/∂vⱼ is a ninth of ∂F/∂r for all corners i and j. The
/// changes with position have no symmetric part worth the name, and are left out.
impl<V: Vector> Derivatives for Wind<V> {
    fn forces(&self, at: &Motion<'_>, push: &mut dyn FnMut(Push)) {
        for (face, area, relative) in self.met(at) {
            let force = self.air.force(area, relative) / 3.0;
            // An area is as uncertain as its sides are.
            let stiffness = force.length() / area.length().sqrt();
            face.iter().for_each(|&corner| push(Push { particle: corner as usize, force, stiffness }));
        }
    }

    fn blocks(&self, at: &Motion<'_>, [_, rate]: [f64; 2], add: &mut dyn FnMut(Block)) {
        for (face, area, relative) in self.met(at) {
            let matrix = rate / 9.0 * self.air.damping(area, relative);
            for (place, &corner) in face.iter().enumerate() {
                add(Block::of(corner as usize, 3.0 * matrix, 3.0 * matrix));
                face[..place].iter().for_each(|&other| add(Block { ends: [corner, other], exact: -matrix, definite: -matrix }));
            }
        }
    }
}
