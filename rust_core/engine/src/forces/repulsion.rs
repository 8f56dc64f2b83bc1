//! Soft spheres that push each other apart where they overlap.
//!
//! With the overlap δ = rᵢ + rⱼ − |d| > 0, d = xᵢ − xⱼ, n = d/|d|, v = vᵢ − vⱼ, vₙ = v·n and vₜ = v − vₙn:
//!
//! Fᵢ = N n − min(γ |vₜ|, μN) vₜ/|vₜ|,   N = max(k δᵖ − c vₙ, 0)
//!
//! The linear law (p = 1) is P. A. Cundall and O. D. L. Strack's, Géotechnique 29 (1979) 47; p = 3/2 is H. Hertz's for elastic
//! spheres, J. reine angew. Math. 92 (1881) 156; friction that grows with the slip up to Coulomb's is P. K. Haff and B. T.
//! Werner's, Powder Technol. 48 (1986) 239. Contacts pull at no time. Particles have no spin, so friction acts on the motion of
//! their centers.

use super::pairs::{Directed, Interaction, Pairs, SUMS, attribute, relative_velocity};
use super::{Force, Moment, VelocityDependence};
use crate::error::{Error, Result};
use crate::math::{AXES, Real, Vector};
use crate::matter::Properties;
use crate::neighbors::sums::PairLaw;
use crate::scene::{Scene, Term, Value};
use crate::simd::Record;

/// The law in the precision of the run.
#[derive(Debug, Clone, Copy)]
pub struct Repulsion<T, const HERTZIAN: bool> {
    /// Stiffness k [N/m], or [N/m^1.5] for Hertz's law.
    stiffness: T,
    /// Damping c of the approach [N·s/m].
    damping: T,
    /// Damping γ of the slip [N·s/m].
    tangential_damping: T,
    /// Coulomb's coefficient μ.
    friction: T,
    /// The largest sum of two radii [m].
    cutoff: f64,
}

/// The force that a term declares between the `chosen` particles.
///
/// # Errors
/// If a parameter makes no sense, or no particle has a radius.
pub fn force<V: Vector>(scene: &Scene, term: &Term, properties: &Properties<V>, chosen: &[bool]) -> Result<Box<dyn Force<V>>> {
    let radii = properties.radius.iter().zip(chosen).filter(|(_, chosen)| **chosen).map(|(radius, _)| *radius);
    let largest = radii.fold(0.0, f64::max);
    if largest == 0.0 {
        return Err(Error::parameter(&term.path, "particles with a radius", "none that it acts on")
            .with_hint("give Particles a radius, or name bodies that have one with on="));
    }
    match term.number("exponent")? {
        1.0 => Ok(Box::new(Pairs::new(scene, properties, chosen, Repulsion::<V::Scalar, false>::new(term, largest)?)?)),
        1.5 => Ok(Box::new(Pairs::new(scene, properties, chosen, Repulsion::<V::Scalar, true>::new(term, largest)?)?)),
        other => Err(term.wrong("exponent", "1 (linear) or 1.5 (Hertz)", Some(&Value::Number(other)))),
    }
}

impl<T: Real, const HERTZIAN: bool> Repulsion<T, HERTZIAN> {
    /// The law as declared, for particles of at most this radius [m].
    pub fn new(term: &Term, largest: f64) -> Result<Self> {
        Ok(Self {
            stiffness: T::from_f64(term.non_negative("stiffness")?),
            damping: T::from_f64(term.non_negative("damping")?),
            tangential_damping: T::from_f64(term.non_negative("tangential_damping")?),
            friction: T::from_f64(term.non_negative("friction")?),
            cutoff: 2.0 * largest,
        })
    }

    /// The damping of a pair [N·s/m]; across it there is none without friction.
    fn dampings(&self) -> Directed {
        let across = if self.friction > T::ZERO { self.tangential_damping.to_f64() } else { 0.0 };
        Directed { along: self.damping.to_f64(), across }
    }

    /// The stiffness at an overlap [N/m].
    fn stiffness_at(&self, overlap: f64) -> f64 {
        let stiffness = self.stiffness.to_f64();
        if HERTZIAN { 1.5 * stiffness * overlap.sqrt() } else { stiffness }
    }
}

impl<V: Vector, const HERTZIAN: bool> PairLaw<V, SUMS> for Repulsion<V::Scalar, HERTZIAN> {
    #[inline(always)]
    fn terms(
        &self,
        own: &Record<V::Scalar>,
        other: &Record<V::Scalar>,
        apart: [V::Scalar; AXES],
        square: V::Scalar,
    ) -> [V::Scalar; SUMS] {
        let (zero, one) = (V::Scalar::ZERO, V::Scalar::ONE);
        let distance = square.sqrt();
        let overlap = attribute::<V>(own) + attribute::<V>(other) - distance;
        // Spheres with one center have no direction in which to part.
        let touches = overlap > zero && distance > zero;
        let inverse = if touches { one / distance } else { zero };
        let overlap = if touches { overlap } else { zero };
        let elastic = self.stiffness * if HERTZIAN { overlap * overlap.sqrt() } else { overlap };
        let v = relative_velocity::<V>(own, other);
        let (mut normal, mut tangent) = ([zero; AXES], [zero; AXES]);
        let (mut parting, mut square_slip) = (zero, zero);
        for axis in 0..V::DIMENSION {
            normal[axis] = apart[axis] * inverse;
            parting += v[axis] * normal[axis];
        }
        for axis in 0..V::DIMENSION {
            tangent[axis] = v[axis] - parting * normal[axis];
            square_slip += tangent[axis] * tangent[axis];
        }
        let damped = elastic - self.damping * parting;
        let push = if touches && damped > zero { damped } else { zero };
        let slip = square_slip.sqrt();
        let (viscous, coulomb) = (self.tangential_damping * slip, self.friction * push);
        let drag = if viscous < coulomb { viscous } else { coulomb };
        let per_slip = if slip > zero { drag / slip } else { zero };
        let mut terms = [zero; SUMS];
        for axis in 0..V::DIMENSION {
            terms[axis] = push * normal[axis] - per_slip * tangent[axis];
        }
        terms[AXES] = (elastic - push) * parting + drag * slip;
        terms
    }
}

impl<V: Vector, const HERTZIAN: bool> Interaction<V> for Repulsion<V::Scalar, HERTZIAN> {
    const NAME: &'static str = "repulsion";

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

    /// Across the pair the push alone acts, which lets it buckle and limits no step.
    fn stiffness(&self, radii: [f64; 2], distance: f64) -> [Directed; 2] {
        let overlap = radii[0] + radii[1] - distance;
        if overlap <= 0.0 {
            return Default::default();
        }
        [Directed { along: self.stiffness_at(overlap), across: 0.0 }, self.dampings()]
    }

    /// As many neighbors as equal spheres can have that only just touch, each pressed in as far as by the impact of two of the
    /// heaviest at twice the largest speed: ½ (m/2) v² = ⅖ k δ^2.5.
    ///
    /// The largest eigenvalue of Σ nnᵀ over directions that are 60° apart: in 2D 3, because those around one end of any axis,
    /// at t − 60°, t and t + 60°, have cos² of 3/2 together; in 3D 9/2, of two that lie on an axis and ten at 60° from it.
    fn expected(&self, at: &Moment<'_, V>, members: &[u32]) -> [f64; 2] {
        let (kissing, aligned) = if V::DIMENSION == 2 { (6.0, 3.0) } else { (12.0, 4.5) };
        let speed = members.iter().map(|&index| at.velocity.get(index as usize).widen().length()).fold(0.0, f64::max);
        let mobile = members.iter().map(|&index| at.properties.mass[index as usize]).filter(|mass| mass.is_finite());
        let energy = mobile.fold(0.0, f64::max) * speed * speed;
        let overlap = libm::pow(2.5 * energy / self.stiffness.to_f64().max(f64::MIN_POSITIVE), 0.4).min(0.5 * self.cutoff);
        let Directed { along, across } = self.dampings();
        let damping = kissing * across + aligned * (along - across).max(0.0);
        [aligned * self.stiffness_at(overlap), damping]
    }
}
