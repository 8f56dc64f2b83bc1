//! The pair of Bogacki and Shampine, order 3 with an estimate of its error, three evaluations.
//!
//! Source: P. Bogacki, L. F. Shampine, Appl. Math. Lett. 2 (1989) 321.

use super::{Component, Integrator, amplification};
use crate::math::Real;

/// kᵢ = f(y + h Σ aᵢⱼ kⱼ) for y = (x, v), with k₄ at the step's end, where it is k₁ of the next one:
///
/// ```text
///     k₂ = f(y + h/2 k₁),  k₃ = f(y + 3h/4 k₂),  y ← y + h (2/9 k₁ + 1/3 k₂ + 4/9 k₃),  k₄ = f(y)
///     error = h (−5/72 k₁ + 1/12 k₂ + 1/9 k₃ − 1/8 k₄)
/// ```
#[derive(Debug)]
pub struct BogackiShampine3;

/// Between steps the acceleration at the state; from the second stage on, the sum for v so far.
const ACCELERATION: usize = 0;
const SUM_V: usize = 0;
/// Between steps the error of x; at the first stage nothing.
const ERROR_X: usize = 1;
/// Between steps the error of v; at the first stage v at the step's start.
const ERROR_V: usize = 2;
const V0: usize = 2;
/// x at the step's start; from the second stage on, the sum for x so far.
const SUM_X: usize = 3;

/// The weights of the four slopes.
const WEIGHTS: [f64; 4] = [2.0 / 9.0, 1.0 / 3.0, 4.0 / 9.0, 0.0];
/// By how much they differ from those of order 2: 7/24, 1/4, 1/3, 1/8.
const ERRORS: [f64; 4] = [-5.0 / 72.0, 1.0 / 12.0, 1.0 / 9.0, -1.0 / 8.0];

impl Integrator for BogackiShampine3 {
    const NAME: &'static str = "BogackiShampine3";
    const ORDER: u32 = 3;
    const ORDER_DISSIPATIVE: u32 = 3;
    const NODES: &'static [f64] = &[0.5, 0.75, 1.0];
    const WEIGHTS: &'static [f64] = WEIGHTS.split_at(1).1;
    const LAST_WEIGHT: f64 = WEIGHTS[0];
    const REGISTERS: usize = 4;
    const PERSISTENT: usize = 1;
    const READABLE: usize = 3;
    const ERROR: Option<[usize; 2]> = Some([ERROR_X, ERROR_V]);
    const POSITION_REGISTER: Option<usize> = Some(SUM_X);

    /// The amplification factors are R(z) = 1 + z + z²/2 + z³/6 at z = ωh(−ξ ± √(ξ² − 1)). At ξ = 0,
    /// |R|² = 1 − y⁴/12 + y⁶/36 with y = ωh gives √3. For ξ ≥ 1 both z are real, and R ≥ −1 as far as z = −2.512…, the
    /// real root of z³ + 3z² + 6z + 12 = 0.
    fn limit(damping_ratio: f64) -> f64 {
        const REAL_AXIS: f64 = 2.512_745_326_618_329;
        if damping_ratio < 1.0 {
            amplification::limit::<Self>(damping_ratio, 0.0)
        } else {
            REAL_AXIS / (damping_ratio + ((damping_ratio - 1.0) * (damping_ratio + 1.0)).sqrt())
        }
    }

    #[inline(always)]
    fn begin<T: Real>(component: &mut Component<T>, a: T) {
        component.registers[ACCELERATION] = a;
    }

    #[inline(always)]
    fn stage_state<T: Real>(stage: usize, component: &mut Component<T>, h: T) {
        // The later stages stand where `absorb` has left them.
        if stage == 0 {
            let (x, v, a) = (component.x, component.v, component.registers[ACCELERATION]);
            component.registers[..Self::REGISTERS].copy_from_slice(&[a, T::ZERO, v, x]);
            let half = T::from_f64(0.5) * h;
            component.x = x + half * v;
            component.v = v + half * a;
        }
    }

    #[inline(always)]
    fn stage_update<T: Real>(stage: usize, component: &mut Component<T>, a: T, h: T) {
        let [weight, error] = [WEIGHTS, ERRORS].map(|of| h * T::from_f64(of[stage + 1]));
        let registers = &mut component.registers;
        match stage {
            0 => {
                let [x0, v0, a0] = [registers[SUM_X], registers[V0], registers[ACCELERATION]];
                let [first, first_error] = [WEIGHTS, ERRORS].map(|of| h * T::from_f64(of[0]));
                registers[SUM_X] = x0 + (first * v0 + weight * component.v);
                registers[SUM_V] = v0 + (first * a0 + weight * a);
                registers[ERROR_X] = first_error * v0 + error * component.v;
                registers[ERROR_V] = first_error * a0 + error * a;
                let reach = T::from_f64(0.75) * h;
                component.x = x0 + reach * component.v;
                component.v = v0 + reach * a;
            }
            1 => {
                registers[ERROR_X] += error * component.v;
                registers[ERROR_V] += error * a;
                component.x = registers[SUM_X] + weight * component.v;
                component.v = registers[SUM_V] + weight * a;
            }
            _ => {
                registers[ERROR_X] += error * component.v;
                registers[ERROR_V] += error * a;
                registers[ACCELERATION] = a;
            }
        }
    }
}
