//! The classical Runge–Kutta method, order 4, four evaluations; accurate over short times, but it loses energy steadily.
//!
//! Source: W. Kutta, Z. Math. Phys. 46 (1901) 435; E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential
//! Equations I, 2nd ed. (1993), table II.1.2.

use super::{Integrator, Register};
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
    const MEMORY: usize = 4;

    fn limit(damping_ratio: f64) -> f64 {
        let _ = damping_ratio;
        2.0 * std::f64::consts::SQRT_2
    }

    #[inline(always)]
    fn point<T: Real>(stage: usize, register: &mut Register<T>, _h: T) {
        // The later stages stand where `absorb` has left them.
        if stage == 0 {
            register.memory = [register.x, register.v, T::ZERO, T::ZERO];
        }
    }

    #[inline(always)]
    fn absorb<T: Real>(stage: usize, register: &mut Register<T>, a: T, h: T) {
        let memory = &mut register.memory;
        let twice = T::from_f64(2.0);
        if stage == 0 {
            memory[SUM_X] = register.v;
            memory[SUM_V] = a;
        } else if stage < 3 {
            memory[SUM_X] += twice * register.v;
            memory[SUM_V] += twice * a;
        } else {
            let sixth = h * T::from_f64(1.0 / 6.0);
            register.x = memory[X0] + sixth * (memory[SUM_X] + register.v);
            register.v = memory[V0] + sixth * (memory[SUM_V] + a);
            return;
        }
        let reach = if stage < 2 { T::from_f64(0.5) * h } else { h };
        register.x = memory[X0] + reach * register.v;
        register.v = memory[V0] + reach * a;
    }
}
