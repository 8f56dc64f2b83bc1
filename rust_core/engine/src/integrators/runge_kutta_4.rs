//! The classical Runge–Kutta method, order 4, four evaluations; accurate over short times, but it loses energy steadily.
//!
//! Source: W. Kutta, Z. Math. Phys. 46 (1901) 435; E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential
//! Equations I, 2nd ed. (1993), table II.1.2.

use super::{Component, Integrator, amplification};
use crate::math::Real;

/// kᵢ = f(y + cᵢ h kᵢ₋₁) with c = 0, ½, ½, 1, and y ← y + h/6 (k₁ + 2k₂ + 2k₃ + k₄), for y = (x, v).
#[derive(Debug)]
pub struct RungeKutta4;

/// The state at the step's start.
const X0: usize = 0;
const V0: usize = 1;
/// The weighted sums of the slopes so far.
const SUM_X: usize = 2;
const SUM_V: usize = 3;

impl Integrator for RungeKutta4 {
    const NAME: &'static str = "RungeKutta4";
    const ORDER: u32 = 4;
    const ORDER_DISSIPATIVE: u32 = 4;
    const NODES: &'static [f64] = &[0.0, 0.5, 0.5, 1.0];
    const WEIGHTS: &'static [f64] = &[1.0 / 6.0, 2.0 / 6.0, 2.0 / 6.0, 1.0 / 6.0];
    const REGISTERS: usize = 4;
    const POSITION_REGISTER: Option<usize> = Some(X0);

    /// The amplification factors are R(z) = 1 + z + z²/2 + z³/6 + z⁴/24 at z = ωh(−ξ ± √(ξ² − 1)). At ξ = 0,
    /// |R|² = 1 − y⁶/72 + y⁸/576 with y = ωh gives 2√2. For ξ ≥ 1 both z are real, R ≤ 1 as far as z = −2.785…, the real
    /// root of z³ + 4z² + 12z + 24 = 0, and the larger z governs. Between them |R| = 1 is of degree 7 in y, solved
    /// numerically: 2.960 at ξ = 0.14, then 2.616 at ξ = 0.54 and 2.855 at ξ = 0.91, not monotonic.
    fn limit(damping_ratio: f64) -> f64 {
        const REAL_AXIS: f64 = 2.785_293_563_405_282;
        if damping_ratio < 1.0 {
            amplification::limit::<Self>(damping_ratio, 0.0)
        } else {
            REAL_AXIS / (damping_ratio + ((damping_ratio - 1.0) * (damping_ratio + 1.0)).sqrt())
        }
    }

    /// On the real axis stable steps are one interval.
    fn last(damping_ratio: f64) -> f64 {
        if damping_ratio < 1.0 { amplification::last::<Self>(damping_ratio) } else { Self::limit(damping_ratio) }
    }

    #[inline(always)]
    fn stage_state<T: Real>(stage: usize, component: &mut Component<T>, _h: T) {
        // The later stages stand where `absorb` has left them.
        if stage == 0 {
            component.registers[..Self::REGISTERS].copy_from_slice(&[component.x, component.v, T::ZERO, T::ZERO]);
        }
    }

    #[inline(always)]
    fn stage_update<T: Real>(stage: usize, component: &mut Component<T>, a: T, h: T) {
        let registers = &mut component.registers;
        let twice = T::from_f64(2.0);
        if stage == 0 {
            registers[SUM_X] = component.v;
            registers[SUM_V] = a;
        } else if stage < 3 {
            registers[SUM_X] += twice * component.v;
            registers[SUM_V] += twice * a;
        } else {
            let sixth = h * T::from_f64(1.0 / 6.0);
            component.x = registers[X0] + sixth * (registers[SUM_X] + component.v);
            component.v = registers[V0] + sixth * (registers[SUM_V] + a);
            return;
        }
        let reach = if stage < 2 { T::from_f64(0.5) * h } else { h };
        component.x = registers[X0] + reach * component.v;
        component.v = registers[V0] + reach * a;
    }
}
