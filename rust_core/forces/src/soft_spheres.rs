//! Soft spheres: repulsive contact forces between overlapping spheres (discrete element method).
//!
//! With the overlap δ = rᵢ + rⱼ − |d| > 0, d = xᵢ − xⱼ, n = d/|d|, v = vᵢ − vⱼ, vₙ = v·n and vₜ = v − vₙn:
//!
//! Fᵢ = N n − min(γ |vₜ|, μN) vₜ/|vₜ|, N = max(k δᵖ − c vₙ, 0)
//!
//! Contacts are never attractive. Particles have no spin, so friction acts on the motion of their centers.
//!
//! The damping c is a constant, or follows from a coefficient of restitution e. Then c = 2ζ √(k m) for p = 1, and
//! c = √5 ζ √(k m) δ^¼ for p = 3/2. The reduced mass is m = 1/(1/mᵢ + 1/mⱼ); [`damping_ratio`] gives ζ. The speed of impact has
//! no effect on e.
//!
//! Sources for the linear law (p = 1): P. A. Cundall and O. D. L. Strack, Géotechnique 29 (1979) 47; for p = 3/2, elastic
//! spheres: H. Hertz, J. reine angew. Math. 92 (1881) 156; for friction that grows with the slip up to Coulomb's: P. K. Haff and
//! B. T. Werner, Powder Technol. 48 (1986) 239.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};

use super::derivatives::{Directed, outer};
use super::pairs::{Attributes, Interaction, Pairs, Response, SUMS, attribute, relative_velocity};
use super::{Declared, Force, ForceKind, Forces, Reach, StateView, VelocityDependence};
use crate::error::{Error, Result};
use crate::math::{AXES, Real, Vector};
use crate::matter::Properties;
use crate::neighbors::sums::{Pair, PairLaw};
use crate::scene::{Item, Value};
use crate::simd::Number;
use crate::stability::SpectralBound;

/// Name in the scene.
const KIND: &str = "SoftSpheres";

/// Name of the term.
const REPULSION: &str = "repulsion";

/// Steps per impact at the limit of accuracy. An automatic time step is half of that.
const STEPS_PER_IMPACT: f64 = 10.0;

/// The contact law in the precision of the run.
#[derive(Debug, Clone, Copy)]
pub struct SoftSpheres<T, const HERTZIAN: bool, const RESTITUTION: bool> {
    /// Stiffness k [N/m], or [N/m^1.5] for Hertz's law.
    stiffness: T,
    /// Normal damping c [N·s/m]; with a coefficient of restitution c/√(k m), for Hertz's law c/√(k m √δ).
    damping: T,
    /// Tangential damping γ [N·s/m].
    tangential_damping: T,
    /// Whether the tangential damping is the normal one.
    alike: bool,
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
    let force: Box<dyn Force<V>> = match (item.number("exponent")?, item.values.contains_key("restitution")) {
        (1.0, false) => Box::new(Pairs::new(scene, properties, chosen, SoftSpheres::<_, false, false>::new(item, range)?)?),
        (1.0, true) => Box::new(Pairs::new(scene, properties, chosen, SoftSpheres::<_, false, true>::new(item, range)?)?),
        (1.5, false) => Box::new(Pairs::new(scene, properties, chosen, SoftSpheres::<_, true, false>::new(item, range)?)?),
        (1.5, true) => Box::new(Pairs::new(scene, properties, chosen, SoftSpheres::<_, true, true>::new(item, range)?)?),
        (other, _) => return Err(item.wrong("exponent", "1 (linear) or 1.5 (Hertz)", Some(&Value::Number(other)))),
    };
    Ok(vec![force])
}

/// Damping ratio ζ at which an impact has the coefficient of restitution e, from 0 to 1.
///
/// An impact begins with δ = 0 and ends where the force vanishes, at k δ = c vₙ. For p = 1 the oscillator then gives
///
/// −ln e = 2ζ acos(ζ)/√(1 − ζ²), or 2ζ acosh(ζ)/√(ζ² − 1) for ζ > 1.
///
/// For p = 3/2, y = δ^(5/4) obeys vₙ dvₙ/dy = −(4/5)(k y/m + c vₙ/(m δ^¼)). This is the equation of that oscillator between speed
/// and displacement, with ζ = c/(√5 √(k m) δ^¼). Both ends of the impact are the same too, and so is e.
///
/// Sources: T. Schwager, T. Pöschel, Granul. Matter 9 (2007) 465; D. Antypov, J. A. Elliott, EPL 94 (2011) 50004.
fn damping_ratio(restitution: f64) -> f64 {
    let loss = -libm::log(restitution);
    let of = |ratio: f64| match ratio {
        1.0 => 2.0,
        _ if ratio < 1.0 => 2.0 * ratio * libm::acos(ratio) / (1.0 - ratio * ratio).sqrt(),
        _ => 2.0 * libm::acosh(ratio) / ((1.0 - 1.0 / ratio) * (1.0 + 1.0 / ratio)).sqrt(),
    };
    let (mut below, mut above) = (0.0, 1.0);
    while of(above) < loss {
        (below, above) = (above, 2.0 * above);
    }
    loop {
        let middle = 0.5 * (below + above);
        if middle <= below || middle >= above {
            return below;
        }
        if of(middle) < loss { below = middle } else { above = middle }
    }
}

impl<T: Real, const HERTZIAN: bool, const RESTITUTION: bool> SoftSpheres<T, HERTZIAN, RESTITUTION> {
    /// Contact law of an item, for particles with radii in this range [m].
    #[inline]
    pub fn new(item: &Item, [smallest, largest]: [f64; 2]) -> Result<Self> {
        let alike = !item.values.contains_key("tangential_damping");
        Ok(Self {
            stiffness: T::from_f64(item.non_negative("stiffness")?),
            damping: if RESTITUTION { Self::relative_damping(item)? } else { T::from_f64(item.non_negative("damping")?) },
            tangential_damping: T::from_f64(if alike { 0.0 } else { item.non_negative("tangential_damping")? }),
            alike,
            friction: T::from_f64(item.non_negative("friction")?),
            cutoff: 2.0 * largest,
            least: OVERLAP * smallest,
        })
    }

    /// Normal damping of an item's restitution, relative to √(k m) or √(k m √δ).
    fn relative_damping(item: &Item) -> Result<T> {
        let restitution = item.number("restitution")?;
        let wrong = |expected: &str| item.wrong("restitution", expected, Some(&Value::Number(restitution)));
        if !(restitution > 0.0 && restitution <= 1.0) {
            return Err(wrong("a number above 0, up to 1"));
        }
        let factor = if HERTZIAN { 5.0_f64.sqrt() } else { 2.0 };
        let damping = T::from_f64(factor * damping_ratio(restitution));
        if damping.to_f64().is_finite() { Ok(damping) } else { Err(wrong("a number with a finite damping")) }
    }

    /// Normal and tangential damping of a pair with the reduced mass m at an overlap [N·s/m]; tangential damping needs friction.
    fn dampings(&self, mass: f64, overlap: f64) -> Directed {
        let stiffness = self.stiffness.to_f64() * if HERTZIAN { overlap.sqrt() } else { 1.0 };
        let along = self.damping.to_f64() * if RESTITUTION { (stiffness * mass).sqrt() } else { 1.0 };
        let given = if self.alike { along } else { self.tangential_damping.to_f64() };
        Directed { along, across: if self.friction > T::ZERO { given } else { 0.0 } }
    }

    /// Normal stiffness at an overlap [N/m].
    fn stiffness_at(&self, overlap: f64) -> f64 {
        let stiffness = self.stiffness.to_f64();
        if HERTZIAN { 1.5 * stiffness * overlap.sqrt() } else { stiffness }
    }
}

/// Reduced mass of two particles with these inverse masses [kg]; 0 for two fixed particles.
fn reduced([one, other]: [Attributes; 2]) -> f64 {
    let inverse = one[1] + other[1];
    if inverse > 0.0 { 1.0 / inverse } else { 0.0 }
}

impl<V: Vector, const HERTZIAN: bool, const RESTITUTION: bool> PairLaw<V, SUMS>
    for SoftSpheres<V::Scalar, HERTZIAN, RESTITUTION>
{
    #[inline(always)]
    fn terms<N: Number<Scalar = V::Scalar>>(&self, pair: &Pair<N>) -> [N; SUMS] {
        let Pair { own, other, separation, .. } = pair;
        let (zero, one) = (N::constant(0.0), N::constant(1.0));
        let distance = pair.distance;
        let overlap = attribute::<V, N>(own, 0) + attribute::<V, N>(other, 0) - distance;
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
        let damping = if RESTITUTION {
            let inverse_mass = attribute::<V, N>(own, 1) + attribute::<V, N>(other, 1);
            let stiffness = if HERTZIAN { N::of(self.stiffness) * overlap.sqrt() } else { N::of(self.stiffness) };
            N::of(self.damping) * (stiffness / inverse_mass).sqrt().masked(zero.less(inverse_mass))
        } else {
            N::of(self.damping)
        };
        let tangential = if RESTITUTION && self.alike { damping } else { N::of(self.tangential_damping) };
        let damped = elastic - damping * parting;
        let push = damped.max(zero).masked(touches);
        let slip = square_slip.sqrt();
        let drag = (tangential * slip).min(N::of(self.friction) * push);
        let per_slip = (drag / slip).masked(zero.less(slip));
        let mut terms = [zero; SUMS];
        for axis in 0..V::DIMENSION {
            terms[axis] = push * normal[axis] - per_slip * tangent[axis];
        }
        terms[AXES] = (elastic - push) * parting + drag * slip;
        terms
    }
}

impl<V: Vector, const HERTZIAN: bool, const RESTITUTION: bool> Interaction<V> for SoftSpheres<V::Scalar, HERTZIAN, RESTITUTION> {
    const NAME: &'static str = REPULSION;
    const SPARES_BONDED: bool = true;
    const KINKS: bool = true;

    fn cutoff(&self) -> f64 {
        self.cutoff
    }

    fn velocity(&self) -> VelocityDependence {
        let damped = self.damping > V::Scalar::ZERO || self.friction > V::Scalar::ZERO;
        if damped { VelocityDependence::Dissipative } else { VelocityDependence::None }
    }

    /// Radius [m] and inverse mass [1/kg].
    fn attributes(&self, properties: &Properties<V>, index: usize) -> Attributes {
        [properties.radius[index], 1.0 / properties.mass[index]]
    }

    fn potential(&self, pair: [Attributes; 2], distance: f64) -> f64 {
        let overlap = (pair[0][0] + pair[1][0] - distance).max(0.0);
        let stiffness = self.stiffness.to_f64();
        if HERTZIAN { 0.4 * stiffness * overlap * overlap * overlap.sqrt() } else { 0.5 * stiffness * overlap * overlap }
    }

    /// The transverse stiffness comes from the repulsion alone. It causes buckling, and does not limit the time step.
    fn stiffness(&self, pair: [Attributes; 2], distance: f64) -> [Directed; 2] {
        let overlap = pair[0][0] + pair[1][0] - distance;
        if overlap <= 0.0 {
            return Default::default();
        }
        [Directed { along: self.stiffness_at(overlap), across: 0.0 }, self.dampings(reduced(pair), overlap)]
    }

    /// While N > 0, K is k p δ^(p−1) along the normal and −N/r across it. C is c along the normal and γ across it. Sliding
    /// friction does not grow with the slip, so that C is then μN/|vₜ|, and only across the slip. The change of friction and
    /// damping with the position at a given velocity is not symmetric, and is omitted.
    fn response(&self, pair: [Attributes; 2], separation: DVec3, velocity: DVec3) -> Response {
        let distance = separation.length();
        let overlap = pair[0][0] + pair[1][0] - distance;
        if overlap <= 0.0 || distance == 0.0 {
            return Response::NONE;
        }
        let normal = separation / distance;
        let parting = velocity.dot(normal);
        let elastic = self.stiffness.to_f64() * if HERTZIAN { overlap * overlap.sqrt() } else { overlap };
        let dampings = self.dampings(reduced(pair), overlap);
        let push = elastic - dampings.along * parting;
        if push <= 0.0 {
            return Response::NONE;
        }
        let tangent = velocity - parting * normal;
        let (slip, most) = (tangent.length(), self.friction.to_f64() * push);
        let slides = dampings.across * slip > most;
        let per_slip = if slides { most / slip } else { dampings.across };
        let mut damping = Directed { along: dampings.along, across: per_slip }.matrix(normal);
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
    ///
    /// The reduced mass of a pair is at most the mass of each particle.
    fn expected(&self, at: &StateView<'_, V>, members: &[u32]) -> Vec<[f64; 2]> {
        let (kissing, aligned) = if V::DIMENSION == 2 { (6.0, 3.0) } else { (12.0, 4.5) };
        let overlap = self.deepest(at, members);
        let stiffness = aligned * self.stiffness_at(overlap);
        let of = |&index: &u32| {
            let mass = at.properties.mass[index as usize];
            let Directed { along, across } = self.dampings(if mass.is_finite() { mass } else { 0.0 }, overlap);
            [stiffness, kissing * across + aligned * (along - across).max(0.0)]
        };
        members.iter().map(of).collect()
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

impl<T: Real, const HERTZIAN: bool, const RESTITUTION: bool> SoftSpheres<T, HERTZIAN, RESTITUTION> {
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
