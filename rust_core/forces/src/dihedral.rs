//! Bending of a triangle mesh by the angles between adjacent faces (discrete shells).
//!
//! A hinge is an edge from x₀ to x₁ with the opposite corners x₂ and x₃ of its two faces. Let e = x₁ − x₀. The normals n₁ = e ×
//! (x₂ − x₀) and n₂ = (x₃ − x₀) × e have twice the area of their faces. The angle is
//!
//! θ = atan2(|e| n₁·(x₃ − x₀), n₁·n₂), 0 for coplanar faces.
//!
//! With the bending rigidity B [J], the damping c [J·s] and a weight w of the rest shape, the energy and the torque about the
//! edge are
//!
//! U = ½ w B (θ − θ₀)², τ = w (B (θ − θ₀) + c dθ/dt), Fᵢ = −τ ∇ᵢθ.
//!
//! The gradient is ∇₂θ = |e| n₁/|n₁|², ∇₃θ = |e| n₂/|n₂|². With the feet s = (x − x₀)·e/|e|² of the heights from x₂ and x₃ on the
//! edge, the others are
//!
//! ∇₀θ = −(1 − s₂) ∇₂θ − (1 − s₃) ∇₃θ, ∇₁θ = −s₂ ∇₂θ − s₃ ∇₃θ,
//!
//! so that the forces of a hinge have neither a sum nor a moment. The difference θ − θ₀ is taken in (−π, π]. Without loss of
//! digits, it is the angle of (cos θ, sin θ) rotated back by θ₀. All quantities are computed in double precision, in every
//! precision of the run.
//!
//! Sources: for discrete shells E. Grinspun, A. N. Hirani, M. Desbrun, P. Schröder, Symposium on Computer Animation 2003; for the
//! gradient R. Bridson, S. Marino, R. Fedkiw, Symposium on Computer Animation 2003.

mod hinge;

use std::ops::Range;

use glam::DVec3;

use super::corners::Corners;
use super::derivatives::{Derivatives, MatrixBlock, Motion, Push, outer};
use super::{About, Declared, Force, ForceKind, Forces, Rates, Reach, StateView, Validity, VelocityDependence};
use crate::error::{Error, Result};
use crate::history::History;
use crate::math::Vector;
use crate::matter::EnergySink;
use crate::parallel::Executor;
use crate::stability::{Horizon, SpectralBound};
use hinge::{Bent, Hinge, hessian};

/// Bending of networks.
#[derive(Debug)]
pub struct Dihedral<V: Vector> {
    hinges: Vec<Hinge>,
    /// Forces on the corners, and the dissipated power.
    corners: Corners<V, 4, 1>,
}

/// Entry in the registry of forces.
pub fn kind<V: Vector>() -> ForceKind<V> {
    let build = |declared: &Declared<'_, V>| -> Result<Forces<V>> { Ok(vec![Box::new(Dihedral::<V>::new(declared)?)]) };
    ForceKind { name: "Dihedral", reach: Reach::Network, charges: false, build }
}

impl<V: Vector> Dihedral<V> {
    /// Bending that an item declares. Its hinges number the particles of its named bodies consecutively, body after body.
    fn new(declared: &Declared<'_, V>) -> Result<Self> {
        let Declared { scene, item, properties, .. } = declared;
        if V::DIMENSION != 3 {
            return Err(Error::parameter(&item.path, "a scene in 3D", format!("{}D", V::DIMENSION)));
        }
        let corners = item.tuples::<4>("hinges")?;
        let (rest_angle, weight) = (item.numbers("rest_angle", corners.len())?, item.numbers("weight", corners.len())?);
        let (stiffness, damping) = (item.non_negative("stiffness")?, item.non_negative("damping")?);
        let engine = properties.engine();
        let named = item.on.clone().unwrap_or_else(|| (0..scene.bodies.len()).collect());
        let particles: Vec<u32> =
            named.iter().flat_map(|&body| &engine[scene.first(body)..scene.first(body + 1)]).copied().collect();
        if let Some(row) = corners.iter().position(|corners| corners.iter().any(|&end| end as usize >= particles.len())) {
            let path = format!("{}.hinges[{row}]", item.path);
            return Err(Error::parameter(path, format!("four of {} particles", particles.len()), format!("{:?}", corners[row])));
        }
        let hinges: Vec<Hinge> = (corners.iter().zip(rest_angle).zip(weight))
            .map(|((corners, &angle), &weight)| Hinge {
                corners: corners.map(|corner| particles[corner as usize]),
                rest: [libm::cos(angle), libm::sin(angle)],
                stiffness: stiffness * weight,
                damping: damping * weight,
                torn: false,
            })
            .collect();
        let elements = hinges.iter().map(|hinge| hinge.corners);
        Ok(Self { corners: Corners::new(properties.count(), elements), hinges })
    }
}

impl<V: Vector> History for Dihedral<V> {}

impl<V: Vector> Force<V> for Dihedral<V> {
    fn about(&self) -> About {
        let damped = self.hinges.iter().any(|hinge| hinge.damping != 0.0);
        About {
            velocity: if damped { VelocityDependence::Dissipative } else { VelocityDependence::None },
            pairs: self.hinges.len(),
            bytes: size_of_val(self.hinges.as_slice()) + self.corners.bytes(),
            layout: format!("{} hinges", self.hinges.len()),
            ..About::new("dihedral", Reach::Network)
        }
    }

    fn prepare(&mut self, at: &StateView<'_, V>, executor: &Executor) -> Result<()> {
        let hinges = &self.hinges;
        self.corners.evaluate(executor, |hinge| {
            hinges[hinge].bent(at).map_or_else(Default::default, |Bent { gradient, torque, dissipated, .. }| {
                (gradient.map(|gradient| gradient * -torque), [dissipated])
            })
        })
    }

    fn accumulate(&self, block: Range<usize>, _at: &StateView<'_, V>, rates: &mut Rates<'_, V>) {
        self.corners.accumulate(&block, [EnergySink::Damping], rates);
    }

    /// The energy of a hinge counts at its first corner.
    fn potential(&self, block: Range<usize>, at: &StateView<'_, V>) -> f64 {
        let corners = self.corners.particles(&block).flat_map(|index| self.corners.of(index));
        let places = corners.filter(|&(_, corner)| corner == 0);
        places.filter_map(|(hinge, _)| self.hinges[hinge].bent(at)).map(|bent| bent.energy).sum()
    }

    fn tear(&mut self, torn: &dyn Fn([u32; 2]) -> bool, at: &StateView<'_, V>) -> f64 {
        let mut lost = 0.0;
        for hinge in &mut self.hinges {
            let energy = hinge.bent(at).map_or(0.0, |bent| bent.energy);
            hinge.torn = hinge.sides().into_iter().any(torn);
            lost += if hinge.torn { energy } else { 0.0 };
        }
        lost
    }

    /// The stiffness matrix is w B ∇θ ∇θᵀ + τ ∇²θ, the damping matrix w c ∇θ ∇θᵀ. A symmetric block matrix with blocks Kᵢⱼ is
    /// bounded above by the diagonal matrix of the row sums Σⱼ |Kᵢⱼ|. The row sums of ∇θ ∇θᵀ are |∇ᵢθ| Σⱼ |∇ⱼθ|.
    ///
    /// A face contributes to ∇ᵢθ of each of its corners i a part along its normal of at most 1/hᵢ, with the height hᵢ. If a
    /// corner j moves, the normal turns by at most |δxⱼ|/hⱼ, and that part changes by at most a fraction 2 |δxⱼ|/hⱼ. The sum for
    /// each face is √5/hᵢ Σⱼ 1/hⱼ.
    fn bound(&self, at: &StateView<'_, V>, bound: &mut SpectralBound) -> Result<()> {
        for hinge in &self.hinges {
            let Some(Bent { gradient, torque, .. }) = hinge.bent(at) else { continue };
            let (slopes, inverse_heights) = (gradient.map(DVec3::length), hinge.inverse_heights(at));
            for (corner, &index) in hinge.corners.iter().enumerate() {
                let slope = slopes[corner] * slopes.iter().sum::<f64>();
                let of_face = |inverse: &[f64; 4]| inverse[corner] * inverse.iter().sum::<f64>();
                let turning = 5.0_f64.sqrt() * torque.abs() * inverse_heights.iter().map(of_face).sum::<f64>();
                bound.point(index as usize, "dihedral", hinge.stiffness * slope + turning, hinge.damping * slope);
            }
        }
        Ok(())
    }

    fn validity(&self, _at: &StateView<'_, V>, _horizon: Horizon) -> Validity {
        if self.hinges.is_empty() { Validity::Always } else { Validity::Now }
    }

    fn derivatives(&mut self) -> Option<&mut dyn Derivatives> {
        Some(self)
    }
}

impl<V: Vector> Dihedral<V> {
    /// The hinges that are not torn, with the positions of their corners and their states.
    fn bent(&self, at: &Motion<'_>) -> impl Iterator<Item = (&Hinge, [DVec3; 4], Bent)> {
        self.hinges.iter().filter_map(|hinge| {
            let [x, v] = [at.position, at.velocity].map(|values| hinge.corners.map(|corner| values[corner as usize]));
            hinge.bent_at(x, v).map(|bent| (hinge, x, bent))
        })
    }
}

/// The stiffness is K = w B ∇θ ∇θᵀ + τ ∇²θ, the damping C = w c ∇θ ∇θᵀ. The change of damping with the position at a given
/// velocity is not symmetric, and is omitted. Without τ ∇²θ (Gauss–Newton), K is positive semidefinite.
impl<V: Vector> Derivatives for Dihedral<V> {
    fn forces(&self, at: &Motion<'_>, push: &mut dyn FnMut(Push)) {
        for (hinge, _, Bent { gradient, torque, .. }) in self.bent(at) {
            let slope = gradient.iter().map(|gradient| gradient.length()).sum::<f64>();
            for (corner, gradient) in hinge.corners.iter().zip(gradient) {
                let stiffness = (hinge.stiffness + torque.abs()) * gradient.length() * slope;
                push(Push { particle: *corner as usize, force: gradient * -torque, stiffness });
            }
        }
    }

    fn blocks(&self, at: &Motion<'_>, [position, rate]: [f64; 2], add: &mut dyn FnMut(MatrixBlock)) {
        for (hinge, x, Bent { gradient, torque, .. }) in self.bent(at) {
            let (weight, bending) = (position * hinge.stiffness + rate * hinge.damping, hessian(x));
            for (other, one) in (0..4).flat_map(|other| (0..other).map(move |one| (other, one))) {
                let definite = -weight * outer(gradient[one], gradient[other]);
                let exact = definite - position * torque * bending[one][other];
                add(MatrixBlock { ends: [hinge.corners[one], hinge.corners[other]], exact, definite });
            }
        }
    }
}
