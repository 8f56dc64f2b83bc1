//! Splitting methods: alternating drifts x ← x + aᵢ h v and kicks v ← v + bᵢ h a(x). They are symplectic, and reversible if their
//! coefficients are symmetric.
//!
//! A splitting with one more drift than kicks begins and ends with a drift. A splitting with one more kick begins with a kick by
//! the persistent acceleration of the previous step's end. It therefore needs only as many evaluations as drifts.
//!
//! Velocity-dependent forces are evaluated at the velocity predicted for the middle of each kick, v + bᵢh/2 a with the last
//! evaluated acceleration. The last kick of a step and the first kick of the next are treated as one kick, with the step's end in
//! its middle. The prediction has an error of O(h²) and enters with a factor h: order 2. A higher order is impossible with
//! dissipation. Splittings above order 2 have negative substeps (Sheng 1989, Suzuki 1991), in which dissipation would run
//! backwards.

use super::swept::{DriftsAndKicks, Swept};
use super::{Component, DriftKick, Integrator, amplification};
use crate::simd::Number;

/// Coefficients of a symmetric splitting.
pub trait Splitting: Send + Sync + 'static {
    /// Name of the class in Python.
    const NAME: &'static str;
    /// Order of convergence without velocity-dependent forces.
    const ORDER: u32;
    /// Drifts aᵢ, in units of h.
    const DRIFTS: &'static [f64];
    /// Kicks bᵢ, in units of h.
    const KICKS: &'static [f64];
    /// [`Integrator::COUPLED`].
    const COUPLED: f64;
    /// [`Integrator::GYRATES`].
    const GYRATES: bool = false;
}

/// Register of the last evaluated acceleration.
pub(super) const ACCELERATION: usize = 0;
/// Register of the velocity before the kick.
pub(super) const BEFORE: usize = 1;
/// Maximum number of drifts of a splitting.
const MOST: usize = 16;

/// Builds a palindrome from its first half, including the middle.
pub const fn palindrome<const HALF: usize, const FULL: usize>(half: [f64; HALF]) -> [f64; FULL] {
    let mut full = [0.0; FULL];
    let mut index = 0;
    while index < FULL {
        full[index] = half[if index < HALF { index } else { FULL - 1 - index }];
        index += 1;
    }
    full
}

/// End of each of `stages` drifts, summed from the nearer end of the step.
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

/// Layout of a splitting in stages, each a drift followed by a kick.
trait SplittingLayout: Splitting {
    const KICKS_FIRST: bool = Self::KICKS.len() > Self::DRIFTS.len();
    const STAGES: usize = if Self::KICKS_FIRST { Self::DRIFTS.len() } else { Self::KICKS.len() };
    const ENDS: &'static [f64; MOST] = &ends(Self::DRIFTS, Self::STAGES);
    /// Kick that begins the step, if any, and kicks after each drift.
    const SPLIT: (&'static [f64], &'static [f64]) = Self::KICKS.split_at(Self::KICKS.len() - Self::STAGES);
}

impl<S: Splitting> SplittingLayout for S {}

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

    /// Undamped oscillator with the longest stable step of the wave. Damping that suppresses a resonance is not relied on: the
    /// undamped limit holds too.
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
        DriftsAndKicks::state(const { DriftsAndKicks::new(S::DRIFTS, S::KICKS) }.at(stage), stage, component, h);
    }

    #[inline(always)]
    fn stage_update<T: Number>(stage: usize, component: &mut Component<T>, a: T, h: T) {
        DriftsAndKicks::update(const { DriftsAndKicks::new(S::DRIFTS, S::KICKS) }.at(stage), stage, component, a, h);
    }
}
