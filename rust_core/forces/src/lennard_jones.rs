//! Lennard-Jones potential: attraction by dispersion, repulsion by overlap.
//!
//! The potential is U(r) = 4ε[(σ/r)¹² − (σ/r)⁶]. It is cut off at R with continuous energy and force (shifted force): F(r) − F(R)
//! and U(r) − U(R) + (r − R) F(R).
//!
//! Sources: J. E. Jones, Proc. R. Soc. Lond. A 106 (1924) 463; S. Toxvaerd, J. C. Dyre, J. Chem. Phys. 134 (2011) 081102.

use glam::DVec3;

use super::derivatives::Directed;
use super::pairs::{Attributes, Interaction, Pairs, Response, SUMS};
use super::{Declared, ForceKind, Forces, Reach, StateView, VelocityDependence};
use crate::error::Result;
use crate::math::{Real, Vector};
use crate::matter::Properties;
use crate::neighbors::sums::{Pair, PairLaw};
use crate::scene::{Item, Value};
use crate::simd::Number;
use crate::stability::SpectralBound;

/// Largest accurate step in units of σ √(m/ε): twice the usual one, because the default safety factor halves it. Source: M. P.
/// Allen, D. J. Tildesley, Computer Simulation of Liquids, 2nd ed. (2017), section 3.2.
const ACCURATE: f64 = 0.01;

/// The pair potential in the precision of the run.
#[derive(Debug, Clone, Copy)]
pub struct LennardJones<T> {
    /// Well depth ε [J].
    epsilon: f64,
    /// Distance of zero uncut energy σ [m].
    sigma: f64,
    /// Cutoff radius R [m].
    cutoff: f64,
    /// Uncut energy [J] and force [N] at R.
    edge: [f64; 2],
    /// Constants σ² [m²], 24ε [J], R² [m²], and the uncut force at R [N].
    square_sigma: T,
    strength: T,
    square_cutoff: T,
    shift: T,
}

/// Uncut energy [J], force [N] and stiffness [N/m] at a distance.
fn uncut(epsilon: f64, sigma: f64, distance: f64) -> [f64; 3] {
    let six = libm::pow(sigma / distance, 6.0);
    let twelve = six * six;
    // For coincident particles the difference is ∞, and not the undefined ∞ − ∞.
    let difference = if six.is_finite() { twelve - six } else { six };
    [
        4.0 * epsilon * difference,
        24.0 * epsilon * (2.0 * twelve - six) / distance,
        24.0 * epsilon * (26.0 * twelve - 7.0 * six) / (distance * distance),
    ]
}

/// Entry in the registry of forces.
pub fn kind<V: Vector>() -> ForceKind<V> {
    let build = |declared: &Declared<'_, V>| -> Result<Forces<V>> {
        let law = LennardJones::<V::Scalar>::new(declared.item)?;
        Ok(vec![Box::new(Pairs::<V, _>::new(declared.scene, declared.properties, &declared.chosen, law)?)])
    };
    ForceKind { name: "LennardJones", reach: Reach::Pairs, charges: false, build }
}

impl<T: Real> LennardJones<T> {
    /// Pair potential of an item.
    pub fn new(item: &Item) -> Result<Self> {
        let positive = |name: &str| match item.number(name)? {
            number if number > 0.0 => Ok(number),
            number => Err(item.wrong(name, "a number > 0", Some(&Value::Number(number)))),
        };
        let (epsilon, sigma, cutoff) = (positive("epsilon")?, positive("sigma")?, positive("cutoff")?);
        let [edge, shift, _] = uncut(epsilon, sigma, cutoff);
        Ok(Self {
            edge: [edge, shift],
            epsilon,
            sigma,
            cutoff,
            square_sigma: T::from_f64(sigma * sigma),
            strength: T::from_f64(24.0 * epsilon),
            square_cutoff: T::from_f64(cutoff * cutoff),
            shift: T::from_f64(shift),
        })
    }
}

impl<V: Vector> PairLaw<V, SUMS> for LennardJones<V::Scalar> {
    #[inline(always)]
    fn terms<N: Number<Scalar = V::Scalar>>(&self, pair: &Pair<N>) -> [N; SUMS] {
        let square = pair.square;
        let inverse = N::constant(1.0) / square;
        let ratio = N::of(self.square_sigma) * inverse;
        let six = ratio * ratio * ratio;
        let push = N::of(self.strength) * (six * six + six * six - six) * inverse - N::of(self.shift) * (pair.distance * inverse);
        let push = push.masked(square.less(N::of(self.square_cutoff)));
        let mut terms = [N::constant(0.0); SUMS];
        for axis in 0..V::DIMENSION {
            terms[axis] = push * pair.separation[axis];
        }
        terms
    }
}

impl<V: Vector> Interaction<V> for LennardJones<V::Scalar> {
    const NAME: &'static str = "Lennard-Jones";

    fn cutoff(&self) -> f64 {
        self.cutoff
    }

    fn velocity(&self) -> VelocityDependence {
        VelocityDependence::None
    }

    fn attributes(&self, _properties: &Properties<V>, _index: usize) -> Attributes {
        [0.0; 2]
    }

    fn potential(&self, _attributes: [Attributes; 2], distance: f64) -> f64 {
        if distance >= self.cutoff {
            return 0.0;
        }
        let [edge, shift] = self.edge;
        uncut(self.epsilon, self.sigma, distance)[0] - edge + (distance - self.cutoff) * shift
    }

    /// The longitudinal stiffness is U'', the transverse one −F/r.
    fn stiffness(&self, _attributes: [Attributes; 2], distance: f64) -> [Directed; 2] {
        if distance >= self.cutoff {
            return Default::default();
        }
        let [_, force, stiffness] = uncut(self.epsilon, self.sigma, distance);
        [Directed { along: stiffness.abs(), across: (force - self.edge[1]).abs() / distance }, Directed::default()]
    }

    /// The stiffness K is U'' along the pair and −F/r across it.
    fn response(&self, _attributes: [Attributes; 2], separation: DVec3, _velocity: DVec3) -> Response {
        let distance = separation.length();
        if distance >= self.cutoff || distance == 0.0 {
            return Response::NONE;
        }
        let [_, force, along] = uncut(self.epsilon, self.sigma, distance);
        let push = force - self.edge[1];
        let stiffness = Directed { along, across: -push / distance };
        Response { force: separation * (push / distance), stiffness, ..Response::NONE }
    }

    fn bound(&self, at: &StateView<'_, V>, members: &[u32], bound: &mut SpectralBound) {
        let lightest = members.iter().map(|&index| at.properties.mass[index as usize]).fold(f64::INFINITY, f64::min);
        bound.accuracy("Lennard-Jones", ACCURATE * self.sigma * (lightest / self.epsilon).sqrt());
    }
}
