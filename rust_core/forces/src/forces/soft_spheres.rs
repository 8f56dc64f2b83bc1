//! Soft spheres: repulsive contact forces between overlapping spheres (discrete element method).
//!
//! With the overlap δ = rᵢ + rⱼ − |d| > 0, d = xᵢ − xⱼ, n = d/|d|, v = vᵢ − vⱼ, vₙ = v·n and vₜ = v − vₙn:
//!
//! Fᵢ = N n − min(γ |vₜ|, μN) vₜ/|vₜ|, N = max(k δᵖ − c vₙ, 0)
//!
//! Contacts are never attractive. Particles have no spin, so friction acts on the motion of their centers.
//!
//! Sources for the linear law (p = 1): P. A. Cundall and O. D. L. Strack, Géotechnique 29 (1979) 47; for p = 3/2, elastic
//! spheres: H. Hertz, J. reine angew. Math. 92 (1881) 156; for friction that grows with the slip up to Coulomb's: P. K. Haff and
//! B. T. Werner, Powder Technol. 48 (1986) 239.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};

use super::derivatives::{Directed, outer};
use super::pairs::{Interaction, Pairs, Response, SUMS, attribute, relative_velocity};
use super::{Declared, ForceKind, Forces, Reach, StateView, VelocityDependence};
use crate::error::{Error, Result};
use crate::math::{AXES, Real, Vector};
use crate::matter::Properties;
use crate::neighbors::sums::{Pair, PairLaw};
use crate::scene::{Item, Value};
use crate::simd::Number;
use crate::stability::SpectralBound;

/// Name in the scene.
pub const KIND: &str = "SoftSpheres";

/// Name of the term.
const REPULSION: &str = "repulsion";

/// Steps per impact at the limit of accuracy. An automatic time step is half of that.
const STEPS_PER_IMPACT: f64 = 10.0;

/// The contact law in the precision of the run.
#[derive(Debug, Clone, Copy)]
pub struct SoftSpheres<T, const HERTZIAN: bool> {
    /// Stiffness k [N/m], or [N/m^1.5] for Hertz's law.
    stiffness: T,
    /// Normal damping c [N·s/m].
    damping: T,
    /// Tangential damping γ [N·s/m].
    tangential_damping: T,
    /// Coefficient of friction μ (Coulomb).
    friction: T,
    /// Cutoff radius: the largest sum of two radii [m].
    cutoff: f64,
    /// Smallest overlap assumed for the time step [m].
    least: f64,
}

/// Smallest expected overlap in units of the smallest radius. The overlaps of grains at rest do not indicate those of later
/// impacts. A Hertzian contact at zero overlap has no stiffness. Stiffness is usually chosen for overlaps of this size: P. W.
/// Cleary, Eng. Comput. 21 (2004) 169.
const OVERLAP: f64 = 0.01;

/// Entry in the registry of forces.
pub fn kind<V: Vector>() -> ForceKind<V> {
    ForceKind { name: KIND, reach: Reach::Pairs, charges: false, build }
}

/// Builds the force of an item.
///
/// # Errors
/// If a parameter is out of range, or no particle has a radius.
fn build<V: Vector>(declared: &Declared<'_, V>) -> Result<Forces<V>> {
    let Declared { scene, item, properties, chosen, .. } = declared;
    let radii = properties.radius.iter().zip(chosen).filter(|(radius, chosen)| **chosen && **radius > 0.0);
    let (smallest, largest) =
        radii.fold((f64::INFINITY, 0.0_f64), |(least, most), (&radius, _)| (least.min(radius), most.max(radius)));
    if largest == 0.0 {
        return Err(Error::parameter(&item.path, "particles with a radius", "none that it acts on")
            .with_hint("give Particles a radius, or name bodies that have one with on="));
    }
    let range = [smallest, largest];
    Ok(vec![match item.number("exponent")? {
        1.0 => Box::new(Pairs::new(scene, properties, chosen, SoftSpheres::<V::Scalar, false>::new(item, range)?)?),
        1.5 => Box::new(Pairs::new(scene, properties, chosen, SoftSpheres::<V::Scalar, true>::new(item, range)?)?),
        other => return Err(item.wrong("exponent", "1 (linear) or 1.5 (Hertz)", Some(&Value::Number(other)))),
    }])
}

impl<T: Real, const HERTZIAN: bool> SoftSpheres<T, HERTZIAN> {
    /// Contact law of an item, for particles with radii in this range [m].
    #[inline]
    pub fn new(item: &Item, [smallest, largest]: [f64; 2]) -> Result<Self> {
        Ok(Self {
            stiffness: T::from_f64(item.non_negative("stiffness")?),
            damping: T::from_f64(item.non_negative("damping")?),
            tangential_damping: T::from_f64(item.non_negative("tangential_damping")?),
            friction: T::from_f64(item.non_negative("friction")?),
            cutoff: 2.0 * largest,
            least: OVERLAP * smallest,
        })
    }

    /// Normal and tangential damping of a pair [N·s/m]; tangential damping needs friction.
    fn dampings(&self) -> Directed {
        let across = if self.friction > T::ZERO { self.tangential_damping.to_f64() } else { 0.0 };
        Directed { along: self.damping.to_f64(), across }
    }

    /// Normal stiffness at an overlap [N/m].
    fn stiffness_at(&self, overlap: f64) -> f64 {
        let stiffness = self.stiffness.to_f64();
        if HERTZIAN { 1.5 * stiffness * overlap.sqrt() } else { stiffness }
    }
}

impl<V: Vector, const HERTZIAN: bool> PairLaw<V, SUMS> for SoftSpheres<V::Scalar, HERTZIAN> {
    #[inline(always)]
    fn terms<N: Number<Scalar = V::Scalar>>(&self, pair: &Pair<N>) -> [N; SUMS] {
        let Pair { own, other, separation, .. } = pair;
        let (zero, one) = (N::constant(0.0), N::constant(1.0));
        let distance = pair.distance;
        let overlap = attribute::<V, N>(own) + attribute::<V, N>(other) - distance;
        // Concentric spheres have no contact normal.
        let touches = N::both(zero.less(overlap), zero.less(distance));
        let inverse = (one / distance).masked(touches);
        let overlap = overlap.masked(touches);
        let elastic = N::of(self.stiffness) * if HERTZIAN { overlap * overlap.sqrt() } else { overlap };
        let v = relative_velocity::<V, N>(pair);
        let (mut normal, mut tangent) = ([zero; AXES], [zero; AXES]);
        let (mut parting, mut square_slip) = (zero, zero);
        for axis in 0..V::DIMENSION {
            normal[axis] = separation[axis] * inverse;
            parting += v[axis] * normal[axis];
        }
        for axis in 0..V::DIMENSION {
            tangent[axis] = v[axis] - parting * normal[axis];
            square_slip += tangent[axis] * tangent[axis];
        }
        let damped = elastic - N::of(self.damping) * parting;
        let push = damped.max(zero).masked(touches);
        let slip = square_slip.sqrt();
        let drag = (N::of(self.tangential_damping) * slip).min(N::of(self.friction) * push);
        let per_slip = (drag / slip).masked(zero.less(slip));
        let mut terms = [zero; SUMS];
        for axis in 0..V::DIMENSION {
            terms[axis] = push * normal[axis] - per_slip * tangent[axis];
        }
        terms[AXES] = (elastic - push) * parting + drag * slip;
        terms
    }
}

impl<V: Vector, const HERTZIAN: bool> Interaction<V> for SoftSpheres<V::Scalar, HERTZIAN> {
    const NAME: &'static str = REPULSION;
    const SPARES_BONDED: bool = true;

    fn cutoff(&self) -> f64 {
        self.cutoff
    }

    fn velocity(&self) -> VelocityDependence {
        let damped = self.damping > V::Scalar::ZERO || self.friction > V::Scalar::ZERO;
        if damped { VelocityDependence::Dissipative } else { VelocityDependence::None }
    }

    fn attribute(&self, properties: &Properties<V>, index: usize) -> f64 {
        properties.radius[index]
    }

    fn potential(&self, radii: [f64; 2], distance: f64) -> f64 {
        let overlap = (radii[0] + radii[1] - distance).max(0.0);
        let stiffness = self.stiffness.to_f64();
        if HERTZIAN { 0.4 * stiffness * overlap * overlap * overlap.sqrt() } else { 0.5 * stiffness * overlap * overlap }
    }

    /// The transverse stiffness comes from the repulsion alone. It causes buckling, and does not limit the time step.
    fn stiffness(&self, radii: [f64; 2], distance: f64) -> [Directed; 2] {
        let overlap = radii[0] + radii[1] - distance;
        if overlap <= 0.0 {
            return Default::default();
        }
        [Directed { along: self.stiffness_at(overlap), across: 0.0 }, self.dampings()]
    }

    /// While N > 0, K is k p δ^(p−1) along the normal and −N/r across it. C is c along the normal and γ across it. Sliding
    /// friction does not grow with the slip, so that C is then μN/|vₜ|, and only across the slip. The change of friction and
    /// damping with the position at a given velocity is not symmetric, and is omitted.
    fn response(&self, radii: [f64; 2], separation: DVec3, velocity: DVec3) -> Response {
        let distance = separation.length();
        let overlap = radii[0] + radii[1] - distance;
        if overlap <= 0.0 || distance == 0.0 {
            return Response::NONE;
        }
        let normal = separation / distance;
        let parting = velocity.dot(normal);
        let elastic = self.stiffness.to_f64() * if HERTZIAN { overlap * overlap.sqrt() } else { overlap };
        let push = elastic - self.damping.to_f64() * parting;
        if push <= 0.0 {
            return Response::NONE;
        }
        let tangent = velocity - parting * normal;
        let (slip, most) = (tangent.length(), self.friction.to_f64() * push);
        let slides = self.tangential_damping.to_f64() * slip > most;
        let per_slip = if slides { most / slip } else { self.dampings().across };
        let mut damping = Directed { along: self.damping.to_f64(), across: per_slip }.matrix(normal);
        if slides {
            damping -= per_slip * outer(tangent, tangent) / (slip * slip);
        }
        let stiffness = Directed { along: self.stiffness_at(overlap), across: -push / distance };
        Response {
            force: push * normal - per_slip * tangent,
            stiffness,
            damping: if damping.is_finite() { damping } else { DMat3::ZERO },
        }
    }

    /// As many contacts as the kissing number of equal spheres, with one overlap δ, that of [`SoftSpheres::deepest`].
    ///
    /// The largest eigenvalue of Σ nnᵀ is needed for directions n at 60° to each other. In 2D it is 3. The directions around one
    /// end of any axis are at t − 60°, t and t + 60°, and their cos² sum to 3/2. In 3D it is 9/2: two directions lie on an axis,
    /// and ten are at 60° to it.
    fn expected(&self, at: &StateView<'_, V>, members: &[u32]) -> [f64; 2] {
        let (kissing, aligned) = if V::DIMENSION == 2 { (6.0, 3.0) } else { (12.0, 4.5) };
        let overlap = self.deepest(at, members);
        let Directed { along, across } = self.dampings();
        let damping = kissing * across + aligned * (along - across).max(0.0);
        [aligned * self.stiffness_at(overlap), damping]
    }

    /// The impact of two particles of the smallest mass lasts π √(m/2k). Fewer steps leave its restitution to chance.
    fn bound(&self, at: &StateView<'_, V>, members: &[u32], bound: &mut SpectralBound) {
        let lightest = members.iter().map(|&index| at.properties.mass[index as usize]).fold(f64::INFINITY, f64::min);
        let stiffness = self.stiffness_at(self.deepest(at, members));
        if stiffness > 0.0 && lightest.is_finite() {
            bound.accuracy(REPULSION, PI * (0.5 * lightest / stiffness).sqrt() / STEPS_PER_IMPACT);
        }
    }
}

impl<T: Real, const HERTZIAN: bool> SoftSpheres<T, HERTZIAN> {
    /// Overlap δ of an impact of two particles of the largest mass at twice the largest speed: ½ (m/2) v² = ⅖ k δ^2.5. It is at
    /// least [`OVERLAP`] of the smallest radius.
    fn deepest<V: Vector<Scalar = T>>(&self, at: &StateView<'_, V>, members: &[u32]) -> f64 {
        let speed = members.iter().map(|&index| at.velocity.get(index as usize).widen().length()).fold(0.0, f64::max);
        let mobile = members.iter().map(|&index| at.properties.mass[index as usize]).filter(|mass| mass.is_finite());
        let energy = mobile.fold(0.0, f64::max) * speed * speed;
        let overlap = libm::pow(2.5 * energy / self.stiffness.to_f64().max(f64::MIN_POSITIVE), 0.4);
        overlap.clamp(self.least, 0.5 * self.cutoff)
    }
}
