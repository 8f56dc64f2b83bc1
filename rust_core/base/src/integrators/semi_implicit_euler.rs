//! Semi-implicit (symplectic) Euler method, order 1: kick, then drift. The energy error is large but bounded.
//!
//! Source: E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, 2nd ed. (2006), sec. I.1.2.

use super::{Compiled, Component, DriftKick, Integrator};
use crate::simd::Number;

/// Semi-implicit Euler: v ← v + h a(x, v), x ← x + h v, with the new velocity.
#[derive(Debug)]
pub struct SemiImplicitEuler;

impl Integrator for SemiImplicitEuler {
    type Swept = Compiled<Self>;
    const NAME: &'static str = "SemiImplicitEuler";
    const ORDER: u32 = 1;
    const ORDER_DISSIPATIVE: u32 = 1;
    const NODES: &'static [f64] = &[0.0];
    const WEIGHTS: &'static [f64] = &[1.0];
    /// Drift with the velocity of the step's end, which no register holds.
    const DRIFT_KICK: Option<DriftKick> = Some(DriftKick { drifts: &[0.0, 1.0], velocity: 0 });

    /// Limit ωh ≤ 2(√(ξ² + 1) − ξ). With y = ωh the step maps (x, hv) by a matrix of trace 2 − 2ξy − y² and determinant 1 − 2ξy.
    /// Both roots of a real quadratic g² − tr g + det are in the unit disc if |det| ≤ 1 and |tr| ≤ 1 + det (Jury). The condition
    /// 1 + det + tr ≥ 0 gives y² + 4ξy − 4 ≤ 0, hence the limit. The other conditions (ξy ≤ 1, y² ≥ 0) are weaker.
    fn limit(damping_ratio: f64) -> f64 {
        2.0 / ((damping_ratio * damping_ratio + 1.0).sqrt() + damping_ratio)
    }

    /// Equals the limit, because stable steps form one interval.
    fn last(damping_ratio: f64) -> f64 {
        Self::limit(damping_ratio)
    }

    /// Equivalent oscillator, in which the decay d counts as much as the damping. With d the trace is 2 − 2ξy − dh − y² and the
    /// determinant (1 − 2ξy)(1 − dh). The condition 1 + det + tr ≥ 0 gives y² + 4ξy + 2dh − 2ξy dh ≤ 4.
    fn oscillator(frequency: f64, damping: f64, decay: f64) -> [f64; 2] {
        [frequency, damping + decay]
    }

    #[inline(always)]
    fn stage_state<T: Number>(_stage: usize, _component: &mut Component<T>, _h: T) {}

    #[inline(always)]
    fn stage_update<T: Number>(_stage: usize, component: &mut Component<T>, a: T, h: T) {
        component.v += h * a;
        component.x += h * component.v;
    }
}
