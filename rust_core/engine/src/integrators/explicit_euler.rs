//! Explicit (forward) Euler, order 1: for teaching. It gains energy on every oscillation, whatever the step.

use super::{Component, Integrator};
use crate::math::Real;

/// x ← x + h v, v ← v + h a(x, v), both with the values at the step's start.
#[derive(Debug)]
pub struct ExplicitEuler;

impl Integrator for ExplicitEuler {
    const NAME: &'static str = "ExplicitEuler";
    const ORDER: u32 = 1;
    const ORDER_DISSIPATIVE: u32 = 1;
    const NODES: &'static [f64] = &[0.0];
    const WEIGHTS: &'static [f64] = &[1.0];

    /// The amplification factor is 1 + z with z = hμ and μ² + 2ξωμ + ω² = 0. For ξ < 1, |1 + z|² = 1 − 2ξωh + ω²h², so
    /// ωh ≤ 2ξ. For ξ ≥ 1 both z are real and the larger, −ωh(ξ + √(ξ² − 1)), must not pass −2: ωh ≤ 2(ξ − √(ξ² − 1)).
    fn limit(damping_ratio: f64) -> f64 {
        if damping_ratio < 1.0 {
            2.0 * damping_ratio
        } else {
            2.0 / (damping_ratio + (damping_ratio * damping_ratio - 1.0).sqrt())
        }
    }

    /// Stable steps are one interval.
    fn last(damping_ratio: f64) -> f64 {
        Self::limit(damping_ratio)
    }

    #[inline(always)]
    fn stage_state<T: Real>(_stage: usize, _register: &mut Component<T>, _h: T) {}

    #[inline(always)]
    fn stage_update<T: Real>(_stage: usize, component: &mut Component<T>, a: T, h: T) {
        component.x += h * component.v;
        component.v += h * a;
    }
}
