//! Central force: F = −s rᵖ d/r toward the center for d = x − center, with r² = |d|² + ε² (Plummer softening).
//!
//! With q = r² the force is F = −s q^((p−1)/2) d. The potential is U = s q^((p+1)/2)/(p+1), or (s/2) ln q for p = −1. A harmonic
//! force (p = 1) is fused.
//!
//! Source for the softening: H. C. Plummer, Mon. Not. R. Astron. Soc. 71 (1911) 460.

use std::f64::consts::TAU;
use std::ops::Range;

use glam::DVec3;

use super::derivatives::{Derivatives, Directed, MatrixBlock, Motion, Push};
use super::linear::Fusion;
use super::pointwise;
use super::{About, Declared, Force, ForceKind, Forces, Rates, Reach, StateView, Validity};
use crate::error::Result;
use crate::history::History;
use crate::math::{Real, Vector};
use crate::matter::Properties;
use crate::scene::Item;
use crate::stability::{Horizon, SpectralBound};
use physcore_matter::forces::{CentralLaw, InverseCube, InverseSquare, PowerLaw};

/// Name in the scene.
const NAME: &str = "CentralForce";

/// Steps per period of the fastest orbit at an automatic time step.
const STEPS_PER_TURN: f64 = 100.0;

/// A central force with a power law of the distance.
#[derive(Debug)]
pub struct Central<V: Vector> {
    /// The center [m].
    center: DVec3,
    /// Strength s [N at r = 1 m], positive for attraction.
    strength: f64,
    /// Exponent p.
    exponent: f64,
    /// Softening length ε [m].
    softening: f64,
    /// Weights of the particles: 1 if affected, else 0; padded.
    members: Vec<V::Scalar>,
}

/// Entry in the registry of forces.
pub fn kind<V: Vector>() -> ForceKind<V> {
    let build = |declared: &Declared<'_, V>| -> Result<Forces<V>> {
        Ok(vec![Box::new(Central::<V>::new(declared.item, declared.mask())?)])
    };
    ForceKind { name: NAME, reach: Reach::Pointwise, charges: false, build }
}

/// Speed [m/s] of particles of this mass that fall to the center from the particle farthest from it. If the potential is
/// unbounded at the center, they fall to the nearest particle. None if the item is another force.
pub fn fall(item: &Item, mass: f64, positions: &[DVec3]) -> Result<Option<f64>> {
    if item.kind != NAME {
        return Ok(None);
    }
    let law = Central::<DVec3>::new(item, Vec::new())?;
    let potential = |distance: f64| law.potential_at(distance * distance + law.softening * law.softening);
    let distances = || positions.iter().map(|x| (*x - law.center).length());
    let (nearest, farthest) = (distances().fold(f64::INFINITY, f64::min), distances().fold(0.0, f64::max));
    let lowest = if law.exponent > -1.0 || law.softening > 0.0 { 0.0 } else { nearest };
    let drop = if positions.is_empty() { 0.0 } else { (potential(farthest) - potential(lowest)).abs() };
    Ok(Some((2.0 * drop / mass).sqrt()))
}

impl<V: Vector> Central<V> {
    /// Central force of an item.
    fn new(item: &Item, members: Vec<V::Scalar>) -> Result<Self> {
        let (strength, exponent) = (item.number("strength")?, item.number("exponent")?);
        Ok(Self { center: item.vector("center")?, strength, exponent, softening: item.non_negative("softening")?, members })
    }

    fn members(&self, block: Range<usize>) -> impl Iterator<Item = usize> {
        block.filter(|&index| self.members[index] != V::Scalar::ZERO)
    }

    fn law<P>(&self, origin: DVec3, power: P) -> CentralLaw<V::Scalar, P> {
        let [strength, square] = [self.strength, self.softening * self.softening].map(V::Scalar::from_f64);
        CentralLaw { strength, square, center: (self.center - origin).to_array().map(V::Scalar::from_f64), power }
    }

    fn potential_at(&self, q: f64) -> f64 {
        // The force at the center is set to 0. The energy, which may have no limit there, is set to 0 too.
        if self.strength == 0.0 || q == 0.0 {
            0.0
        } else if self.exponent == -1.0 {
            0.5 * self.strength * libm::log(q)
        } else {
            self.strength * half_power(q, self.exponent + 1.0) / (self.exponent + 1.0)
        }
    }

    /// Periapsis of a particle under this force alone [m].
    fn closest(&self, mass: f64, from_center: DVec3, velocity: DVec3) -> f64 {
        let potential = |r: f64| self.potential_at(r * r + self.softening * self.softening);
        let here = from_center.length();
        let spin = from_center.cross(velocity).length_squared();
        let energy = 0.5 * mass * velocity.length_squared() + potential(here);
        periapsis(here, potential, 0.5 * mass * spin, energy)
    }
}

impl<V: Vector> History for Central<V> {}

impl<V: Vector> Force<V> for Central<V> {
    fn about(&self) -> About {
        About { bytes: std::mem::size_of_val(self.members.as_slice()), ..About::new("central", Reach::Pointwise) }
    }

    fn fuse(&self, properties: &Properties<V>, fusion: &mut Fusion) -> bool {
        if self.exponent != 1.0 {
            return false;
        }
        for index in self.members(0..properties.count()) {
            let rate = self.strength / properties.mass[index];
            fusion.well[index] -= rate;
            fusion.acceleration[index] += self.center * rate;
        }
        true
    }

    fn inverse_square(&self, properties: &Properties<V>) -> Option<InverseSquare<'_, V::Scalar>> {
        (self.exponent == -2.0).then(|| {
            let law = self.law(properties.origin, InverseCube);
            InverseSquare { law, members: &self.members }
        })
    }

    fn accumulate(&self, block: Range<usize>, at: &StateView<'_, V>, rates: &mut Rates<'_, V>) {
        let half_power = 0.5 * (self.exponent - 1.0);
        macro_rules! run {
            ($power:expr) => {
                pointwise::accumulate::<V>(self.law(at.properties.origin, $power), &self.members, block, at, rates)
            };
        }
        // The inverse square takes a root and a division; any other exponent takes a call of pow.
        if self.exponent == -2.0 {
            run!(InverseCube);
        } else {
            run!(General(half_power));
        }
    }

    fn potential(&self, block: Range<usize>, at: &StateView<'_, V>) -> f64 {
        let offset = at.properties.origin - self.center;
        let square = self.softening * self.softening;
        self.members(block)
            .map(|index| self.potential_at((at.position.get(index).widen() + offset).length_squared() + square))
            .sum()
    }

    /// A harmonic force limits the stability. Other exponents have no largest stiffness, and limit the accuracy to a hundred
    /// steps per period. The period is that of the frequency at the periapsis, or at the present distance.
    fn bound(&self, at: &StateView<'_, V>, bound: &mut SpectralBound) -> Result<()> {
        let properties = at.properties;
        for index in self.members(0..properties.count()) {
            let mass = properties.mass[index];
            if self.exponent == 1.0 {
                bound.point(index, "central", self.strength.max(0.0), 0.0);
                bound.steady(index, self.strength, 0.0);
            } else if self.strength != 0.0 {
                let from_center = properties.origin + at.position.get(index).widen() - self.center;
                let distance = if bound.horizon() == Horizon::Present {
                    from_center.length()
                } else {
                    self.closest(mass, from_center, at.velocity.get(index).widen())
                };
                let q = distance * distance + self.softening * self.softening;
                if q == 0.0 {
                    continue;
                }
                let stiffness = self.strength.abs() * half_power(q, self.exponent - 1.0) * self.exponent.abs().max(1.0);
                bound.accuracy("central", TAU * (mass / stiffness).sqrt() / STEPS_PER_TURN);
            }
        }
        Ok(())
    }

    fn validity(&self, _at: &StateView<'_, V>, horizon: Horizon) -> Validity {
        if horizon == Horizon::Present && self.exponent != 1.0 { Validity::Now } else { Validity::Always }
    }

    fn derivatives(&mut self) -> Option<&mut dyn Derivatives> {
        Some(self)
    }
}

impl<V: Vector> Central<V> {
    /// Displacement d from the center of each affected particle, with the stiffness along and across d. With w = s q^((p−1)/2),
    /// the stiffness is w across d, and w (1 + (p − 1) |d|²/q) along it.
    fn stiffness(&self, at: &Motion<'_>) -> impl Iterator<Item = (usize, DVec3, Directed)> {
        let (center, square) = (self.center - at.origin, self.softening * self.softening);
        self.members(0..at.position.len()).filter_map(move |index| {
            let d = at.position[index] - center;
            let q = d.length_squared() + square;
            let across = self.strength * half_power(q, self.exponent - 1.0);
            let along = across * (1.0 + (self.exponent - 1.0) * d.length_squared() / q);
            (q > 0.0 && self.strength != 0.0).then_some((index, d, Directed { along, across }))
        })
    }
}

impl<V: Vector> Derivatives for Central<V> {
    fn forces(&self, at: &Motion<'_>, push: &mut dyn FnMut(Push)) {
        for (particle, d, stiffness) in self.stiffness(at) {
            push(Push { particle, force: -stiffness.across * d, stiffness: stiffness.largest() });
        }
    }

    fn blocks(&self, at: &Motion<'_>, [position, _]: [f64; 2], add: &mut dyn FnMut(MatrixBlock)) {
        for (particle, d, stiffness) in self.stiffness(at) {
            let [exact, definite] =
                [stiffness, stiffness.definite()].map(|stiffness| position * stiffness.matrix(d.normalize_or_zero()));
            add(MatrixBlock::of(particle, exact, definite));
        }
    }
}

/// Periapsis [m]: the radius at which the effective potential U(r) + `barrier`/r² equals the energy, with the barrier L²/2m. Found
/// by bisection between 0 and the present distance.
pub fn periapsis(distance: f64, potential: impl Fn(f64) -> f64, barrier: f64, energy: f64) -> f64 {
    let (mut inside, mut outside) = (0.0, distance);
    for _ in 0..20 {
        let middle = 0.5 * (inside + outside);
        if potential(middle) + barrier / (middle * middle) > energy { inside = middle } else { outside = middle }
    }
    outside
}

/// Computes q^(n/2). Small integers n take roots and products, a hundred times as fast as pow.
fn half_power(q: f64, n: f64) -> f64 {
    if n.fract() != 0.0 || n.abs() > 8.0 {
        return libm::pow(q, 0.5 * n);
    }
    let root = q.sqrt();
    let power = (0..n.abs() as u32).fold(1.0, |product, _| product * root);
    if n < 0.0 { 1.0 / power } else { power }
}

/// Any power of q.
#[derive(Clone, Copy)]
struct General(f64);

impl<T: Real> PowerLaw<T> for General {
    #[inline(always)]
    fn times(self, factor: T, q: T) -> T {
        let power = T::from_f64(libm::pow(q.to_f64(), self.0));
        if factor != T::ZERO && q > T::ZERO { factor * power } else { T::ZERO }
    }
}
