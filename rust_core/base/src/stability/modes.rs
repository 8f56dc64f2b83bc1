//! Modes of a body as a box of frequencies and dampings, and the largest stable step of all of them.
//!
//! All modes have ω² and γ between a lower and an upper bound. Along a ray of constant ξ = γ/2ω the limit is L(ξ)/ω. It is
//! smallest where the ray leaves the box: at the highest ω, or at the highest γ. One minimization over ξ remains. A particle
//! under harmonic wells and linear drag alone is one oscillator, and its box is a point.

use super::rows::GershgorinRow;
use crate::integrators::{Facts, amplification};

/// Stability limits of an integrator for an oscillator.
#[derive(Debug, Clone, Copy)]
pub struct OscillatorLimits {
    /// [`Integrator::limit`].
    pub largest: fn(f64) -> f64,
    /// [`Integrator::last`].
    pub last: fn(f64) -> f64,
    /// [`Integrator::COUPLED`].
    pub coupled: f64,
}

impl OscillatorLimits {
    /// Limits of an integrator.
    pub fn of(facts: &Facts) -> Self {
        Self { largest: facts.limit, last: facts.last, coupled: facts.coupled }
    }
}

/// Range of a rate, ω² [1/s²] or γ [1/s], over all modes of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpectralRange {
    /// Upper bound.
    pub highest: GershgorinRow,
    /// Lower bound.
    pub least: f64,
    /// Lower bound of the largest rate; 0 if unknown.
    pub reached: f64,
}

impl SpectralRange {
    /// Band of a single rate.
    pub fn exactly(row: GershgorinRow) -> Self {
        Self { highest: row, least: row.rate, reached: row.rate }
    }

    /// Smallest band that contains two bands.
    pub fn with(self, other: Self) -> Self {
        let highest = if other.highest.rate > self.highest.rate { other.highest } else { self.highest };
        Self { highest, least: self.least.min(other.least), reached: self.reached.max(other.reached) }
    }
}

/// Box that encloses the modes of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Modes {
    pub stiffness: SpectralRange,
    pub damping: SpectralRange,
}

/// Damping ratio that stands for pure damping: here 2ξL(ξ) is within 1e-12 of its limit for ξ → ∞.
const PURE_DAMPING: f64 = 1e6;
/// Number of rays on each of the two outer edges. The lowest ray is then refined between its neighbors, so it only has to lie in
/// the basin of the minimum of L. The narrowest basins are those of PEFRL and `BlanesMoan4`. PEFRL's, 0.28 < ξ < 0.32, matters
/// while the corner of the box lies between it and ξ = 0.5; it then holds four rays. `BlanesMoan4`'s, 0.10 < ξ < 0.14, matters up
/// to 0.31; it then holds eight. With 20,000 rays, the limits are equal for all corners of the boxes of all integrators.
const RAYS: usize = 64;

/// Factor of the upper bound of stable steps where stiffness and damping couple the modes: no mode then has the highest frequency
/// or damping. Measured, not proved; without it, a network was stable up to 5 % above the bound.
const MIXED: f64 = 1.5;

impl Modes {
    /// Bounding box of two boxes.
    pub fn with(&self, other: &Self) -> Self {
        Self { stiffness: self.stiffness.with(other.stiffness), damping: self.damping.with(other.damping) }
    }

    /// Whether this box contains the other one.
    pub fn enclose(&self, other: &Self) -> bool {
        let encloses =
            |band: &SpectralRange, inner: &SpectralRange| band.highest.rate >= inner.highest.rate && band.least <= inner.least;
        encloses(&self.stiffness, &other.stiffness) && encloses(&self.damping, &other.damping)
    }

    /// Largest stable step of all modes [s], and the term that sets it.
    pub fn limit(&self, method: &OscillatorLimits) -> (f64, &'static str) {
        let Self { stiffness, damping } = self;
        let OscillatorLimits { largest, coupled, .. } = *method;
        let by_damping = 2.0 * PURE_DAMPING * largest(PURE_DAMPING) / damping.highest.rate;
        if stiffness.highest.rate == 0.0 {
            return (by_damping, damping.highest.term);
        }
        let frequency = stiffness.highest.rate.sqrt().max(damping.highest.rate / (2.0 * PURE_DAMPING));
        if frequency.is_infinite() {
            return (0.0, if stiffness.highest.rate.is_infinite() { stiffness } else { damping }.highest.term);
        }
        let along = |angle: f64| {
            let ratio = libm::tan(angle).clamp(0.0, PURE_DAMPING);
            // At ξ = 0 without damping the second operand is 0/0, which `min` ignores.
            largest(ratio) / frequency.min(damping.highest.rate / (2.0 * ratio))
        };
        let corner = libm::atan(damping.highest.rate / (2.0 * frequency));
        let stiff = minimize(along, libm::atan(damping.least / (2.0 * frequency)), corner);
        let slowest = libm::atan(damping.highest.rate / (2.0 * stiffness.least.sqrt()));
        let damped = if damping.highest.rate > 0.0 { minimize(along, corner, slowest) } else { f64::INFINITY };
        let binding = if largest(0.0) / frequency <= by_damping { stiffness } else { damping };
        let margin = if damping.least < damping.highest.rate { coupled } else { 1.0 };
        (margin * stiff.min(damped), binding.highest.term)
    }

    /// Upper bound of the stable steps [s]. It is the largest stable step of the mode with the highest frequency, or with the
    /// highest damping, for any value of its other rate. Infinite if neither is known.
    pub fn endured(&self, method: &OscillatorLimits) -> f64 {
        let Self { stiffness, damping } = self;
        let ratio = |damping: f64, square: f64| damping / (2.0 * square.sqrt());
        let ends = |low: f64, high: f64| [low, high].map(|ratio| ratio.clamp(0.0, PURE_DAMPING));
        let by_frequency = if stiffness.reached > 0.0 {
            let [low, high] = ends(ratio(damping.least, stiffness.highest.rate), ratio(damping.highest.rate, stiffness.reached));
            peak(method.last, low, high) / stiffness.reached.sqrt()
        } else {
            f64::INFINITY
        };
        let by_damping = if damping.reached > 0.0 {
            let [low, high] = ends(ratio(damping.reached, stiffness.highest.rate), ratio(damping.highest.rate, stiffness.least));
            peak(|ratio| 2.0 * ratio * (method.last)(ratio), low, high) / damping.reached
        } else {
            f64::INFINITY
        };
        let margin = if damping.least < damping.highest.rate { MIXED } else { 1.0 };
        margin * by_frequency.min(by_damping)
    }
}

/// Maximum of a function of the damping ratio, on rays from `low` to `high`. The function may be larger between two rays. Unlike
/// a limit, this value is only informative, and a quarter of the rays suffices.
fn peak(function: impl Fn(f64) -> f64, low: f64, high: f64) -> f64 {
    let rays = if low < high { RAYS / 4 } else { 0 };
    let (low, high) = (libm::atan(low), libm::atan(high));
    let at = |ray: usize| if ray == rays { high } else { low + (high - low) * ray as f64 / rays as f64 };
    (0..=rays).map(|ray| function(libm::tan(at(ray)).clamp(0.0, PURE_DAMPING))).fold(0.0, f64::max)
}

/// Minimum of a function between `low` and `high`.
fn minimize(function: impl Fn(f64) -> f64, low: f64, high: f64) -> f64 {
    if low >= high {
        return function(high);
    }
    let at = |ray: usize| if ray == RAYS { high } else { low + (high - low) * ray as f64 / RAYS as f64 };
    let values: Vec<f64> = (0..=RAYS).map(|ray| function(at(ray))).collect();
    let least = (0..=RAYS).min_by(|&one, &other| values[one].total_cmp(&values[other])).unwrap_or(0);
    let refined = amplification::lowest(&function, at(least.saturating_sub(1)), at((least + 1).min(RAYS)));
    values[least].min(function(refined))
}

/// Cache of an integrator's limits for the boxes of modes of the previous bound. Most boxes stay equal from step to step, and a
/// box with damping takes thousands of trial steps.
#[derive(Debug, Default)]
pub struct LimitCache(Vec<(Modes, (f64, &'static str))>);

impl LimitCache {
    /// Updates the cache to these boxes, computing the limits of new ones. Returns the smallest limit and the term that sets it.
    pub fn least(&mut self, boxes: &[Modes], method: &OscillatorLimits) -> (f64, &'static str) {
        let known = std::mem::take(&mut self.0);
        let of = |modes: &Modes| {
            let before = known.iter().find(|(other, _)| other == modes);
            before.map_or_else(|| modes.limit(method), |&(_, limit)| limit)
        };
        self.0 = boxes.iter().map(|modes| (*modes, of(modes))).collect();
        let limits = self.0.iter().map(|&(_, limit)| limit);
        limits.min_by(|one, other| one.0.total_cmp(&other.0)).unwrap_or((f64::INFINITY, ""))
    }
}
