//! Splittings: alternating drifts x ← x + aᵢ h v and kicks v ← v + bᵢ h a(x), symplectic, and reversible where the same
//! backwards.
//!
//! A list with one drift more than kicks begins and ends with a drift. One with a kick more begins with a kick by the
//! acceleration that ended the step before, which persists, so that it takes no evaluation more than it has drifts.
//!
//! Forces that depend on velocity are taken at the velocity predicted for the middle of each kick, v + bᵢh/2 a with the
//! last acceleration that was evaluated; the kicks that end a step and begin the next are one with the step's end in its
//! middle. The prediction is off by O(h²) and enters with a factor h: order 2. It could not stay above at any price: a
//! splitting above order 2 has negative substeps (Sheng 1989, Suzuki 1991), in which dissipation would run backwards.

use super::swept::{DriftsAndKicks, Swept};
use super::{Component, DriftKick, Integrator, amplification};
use crate::simd::Number;

/// The coefficients of a symmetric splitting.
pub trait Splitting: Send + Sync + 'static {
    /// The class's name in Python.
    const NAME: &'static str;
    /// The order of convergence without velocity-dependent forces.
    const ORDER: u32;
    /// aᵢ, in units of h.
    const DRIFTS: &'static [f64];
    /// bᵢ, in units of h.
    const KICKS: &'static [f64];
    /// As [`Integrator::COUPLED`].
    const COUPLED: f64;
    /// As [`Integrator::GYRATES`].
    const GYRATES: bool = false;
}

/// The last acceleration that was evaluated.
pub(super) const ACCELERATION: usize = 0;
/// The velocity before the kick.
pub(super) const BEFORE: usize = 1;
/// The most drifts of any splitting.
const MOST: usize = 16;

/// A list that reads the same backwards, from its first half with the middle.
pub const fn palindrome<const HALF: usize, const FULL: usize>(half: [f64; HALF]) -> [f64; FULL] {
    let mut full = [0.0; FULL];
    let mut index = 0;
    while index < FULL {
        full[index] = half[if index < HALF { index } else { FULL - 1 - index }];
        index += 1;
    }
    full
}

/// Where each of `stages` drifts ends, summed up from the nearer end of the step.
const fn ends(drifts: &[f64], stages: usize) -> [f64; MOST] {
    let mut nodes = [0.0; MOST];
    let (mut from_start, mut from_end) = (0.0, 1.0);
    let mut index = 0;
    while 2 * index < stages {
        from_start += drifts[index];
        nodes[index] = from_start;
        index += 1;
    }
    if drifts.len() > stages {
        from_end -= drifts[stages];
    }
    index = stages;
    while 2 * index > stages + 1 {
        index -= 1;
        nodes[index] = from_end;
        from_end -= drifts[index];
    }
    nodes
}

/// How a splitting is laid out in stages, each a drift with the kick after it.
trait Layout: Splitting {
    const KICKS_FIRST: bool = Self::KICKS.len() > Self::DRIFTS.len();
    const STAGES: usize = if Self::KICKS_FIRST { Self::DRIFTS.len() } else { Self::KICKS.len() };
    const ENDS: &'static [f64; MOST] = &ends(Self::DRIFTS, Self::STAGES);
    /// The kick that begins the step, if one does, and those after each drift.
    const SPLIT: (&'static [f64], &'static [f64]) = Self::KICKS.split_at(Self::KICKS.len() - Self::STAGES);
}

impl<S: Splitting> Layout for S {}

impl<S: Splitting> Integrator for S {
    type Swept = DriftsAndKicks;
    const NAME: &'static str = S::NAME;
    const ORDER: u32 = S::ORDER;
    const ORDER_DISSIPATIVE: u32 = 2;
    const NODES: &'static [f64] = S::ENDS.split_at(S::STAGES).0;
    const WEIGHTS: &'static [f64] = S::SPLIT.1;
    const LAST_WEIGHT: f64 = if S::KICKS_FIRST { S::KICKS[0] } else { 0.0 };
    const REGISTERS: usize = 2;
    const PERSISTENT: usize = 1;
    const DRIFT_KICK: Option<DriftKick> = Some(DriftKick { drifts: S::DRIFTS, velocity: BEFORE });
    const COUPLED: f64 = S::COUPLED;
    const GYRATES: bool = S::GYRATES;

    fn limit(damping_ratio: f64) -> f64 {
        amplification::limit::<S>(damping_ratio, 0.0)
    }

    /// An undamped one of that longest step. Damping that quenches a resonance is not relied on: the limit without any holds
    /// too.
    fn oscillator(frequency: f64, damping: f64, decay: f64) -> [f64; 2] {
        let frequency = frequency.max((damping + decay) / amplification::STEEPEST);
        if damping + decay == 0.0 {
            return [frequency, 0.0];
        }
        let longest = S::COUPLED * amplification::limit::<S>(0.5 * damping / frequency, decay / frequency);
        [frequency * (<S as Integrator>::limit(0.0) / longest).max(1.0), 0.0]
    }

    #[inline(always)]
    fn begin<T: Number>(component: &mut Component<T>, a: T) {
        DriftsAndKicks::begin(component, a);
    }

    #[inline(always)]
    fn stage_state<T: Number>(stage: usize, component: &mut Component<T>, h: T) {
        const { DriftsAndKicks::new(S::DRIFTS, S::KICKS) }.state(stage, component, h);
    }

    #[inline(always)]
    fn stage_update<T: Number>(stage: usize, component: &mut Component<T>, a: T, h: T) {
        const { DriftsAndKicks::new(S::DRIFTS, S::KICKS) }.update(stage, component, a, h);
    }
}
