//! The pair of Dormand and Prince, order 5 with an estimate of its error, six evaluations.
//!
//! Source: J. R. Dormand, P. J. Prince, J. Comput. Appl. Math. 6 (1980) 19; E. Hairer, S. P. Nørsett, G. Wanner, Solving
//! Ordinary Differential Equations I, 2nd ed. (1993), table II.5.2.

use super::{Component, Integrator, amplification};
use crate::math::Real;

/// kᵢ = f(y + h Σ aᵢⱼ kⱼ) for y = (x, v), with k₇ at the step's end, where it is k₁ of the next one. As x' = v, all that has
/// to be kept of a slope is its acceleration: with the velocity of each stage put in,
///
/// ```text
///     xᵢ = x + h cᵢ v + h² Σ āᵢⱼ aⱼ,   vᵢ = v + h Σ aᵢⱼ aⱼ,   ā = a·a
/// ```
#[derive(Debug)]
pub struct DormandPrince5;

/// Between steps the acceleration at the state, a₁; from the fifth on, the sum for v so far.
const ACCELERATION: usize = 0;
const SUM_V: usize = 0;
/// Between steps the error of x; up to the fourth a₂.
const ERROR_X: usize = 1;
const SECOND: usize = 1;
/// Between steps the error of v; up to the fourth v at the step's start.
const ERROR_V: usize = 2;
const V0: usize = 2;
/// x at the step's start; from the fifth on, the sum for x.
const X0: usize = 3;
const SUM_X: usize = 3;
const THIRD: usize = 4;
const FOURTH: usize = 5;

/// aᵢⱼ of the stages 2 to 7; the last row holds the weights of the step.
const VELOCITY: [[f64; 6]; 6] = [
    [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [19_372.0 / 6_561.0, -25_360.0 / 2_187.0, 64_448.0 / 6_561.0, -212.0 / 729.0, 0.0, 0.0],
    [9_017.0 / 3_168.0, -355.0 / 33.0, 46_732.0 / 5_247.0, 49.0 / 176.0, -5_103.0 / 18_656.0, 0.0],
    [35.0 / 384.0, 0.0, 500.0 / 1_113.0, 125.0 / 192.0, -2_187.0 / 6_784.0, 11.0 / 84.0],
];
/// The row of the step, which is that of its last stage.
const STEP: usize = 5;
/// āᵢⱼ of the same stages.
const POSITION: [[f64; 6]; 6] = {
    let mut rows = [[0.0; 6]; 6];
    let mut stage = 0;
    while stage < rows.len() {
        rows[stage] = of_accelerations(&VELOCITY[stage]);
        stage += 1;
    }
    rows
};
/// By how much the weights of the seven slopes differ from those of order 4; they add up to 0.
const ERRORS: [f64; 7] =
    [71.0 / 57_600.0, 0.0, -71.0 / 16_695.0, 71.0 / 1_920.0, -17_253.0 / 339_200.0, 22.0 / 525.0, -1.0 / 40.0];
/// The same of the accelerations, for the error of x.
const ERRORS_OF_X: [f64; 6] = of_accelerations(&ERRORS);

/// Turns weights of the stages' velocities into those of the accelerations that made them.
const fn of_accelerations(weights: &[f64]) -> [f64; 6] {
    let mut found = [0.0; 6];
    // The velocity of the first stage is that of the step's start.
    let mut stage = 1;
    while stage < weights.len() {
        let mut slope = 0;
        while slope < found.len() {
            found[slope] += weights[stage] * VELOCITY[stage - 1][slope];
            slope += 1;
        }
        stage += 1;
    }
    found
}

/// Σ wⱼ aⱼ; the accelerations without weight are not yet known.
#[inline(always)]
fn sum<T: Real>(weights: &[f64], accelerations: [T; 5]) -> T {
    let known = weights.iter().zip(accelerations).filter(|&(&weight, _)| weight != 0.0);
    known.fold(T::ZERO, |sum, (&weight, a)| sum + T::from_f64(weight) * a)
}

impl Integrator for DormandPrince5 {
    const NAME: &'static str = "DormandPrince5";
    const ORDER: u32 = 5;
    const ORDER_DISSIPATIVE: u32 = 5;
    const NODES: &'static [f64] = &[0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0];
    const WEIGHTS: &'static [f64] =
        &[VELOCITY[STEP][1], VELOCITY[STEP][2], VELOCITY[STEP][3], VELOCITY[STEP][4], VELOCITY[STEP][5], 0.0];
    const LAST_WEIGHT: f64 = VELOCITY[STEP][0];
    const REGISTERS: usize = 6;
    const PERSISTENT: usize = 1;
    const READABLE: usize = 3;
    const ERROR: Option<[usize; 2]> = Some([ERROR_X, ERROR_V]);
    const POSITION_REGISTER: Option<usize> = Some(X0);

    /// The amplification factors are R(z) = 1 + z + z²/2 + z³/6 + z⁴/24 + z⁵/120 + z⁶/600 at z = ωh(−ξ ± √(ξ² − 1)). At
    /// ξ = 0, with u = (ωh)², |R|² = 1 − u³ (1/1800 − u/1600 + u²/14400 − u³/360000) gives u = 0.9943…. For ξ ≥ 1 both z are
    /// real, and R ≤ 1 as far as z = −3.306…, the real root of z⁵ + 5z⁴ + 25z³ + 100z² + 300z + 600 = 0.
    fn limit(damping_ratio: f64) -> f64 {
        const REAL_AXIS: f64 = 3.306_567_892_634_947;
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
            component.registers = [a, T::ZERO, v, x, T::ZERO, T::ZERO];
            let reach = T::from_f64(Self::NODES[0]) * h;
            component.x = x + reach * v;
            component.v = v + reach * a;
        }
    }

    #[inline(always)]
    fn stage_update<T: Real>(stage: usize, component: &mut Component<T>, a: T, h: T) {
        let registers = &mut component.registers;
        match stage {
            0..=3 => {
                if stage < 3 {
                    registers[[SECOND, THIRD, FOURTH][stage]] = a;
                }
                let (x0, v0) = (registers[X0], registers[V0]);
                let all = [registers[ACCELERATION], registers[SECOND], registers[THIRD], registers[FOURTH], a];
                let place = |c: f64, row: &[f64]| x0 + h * (T::from_f64(c) * v0 + h * sum(row, all));
                let velocity = |row: &[f64]| v0 + h * sum(row, all);
                component.x = place(Self::NODES[stage + 1], &POSITION[stage + 1]);
                component.v = velocity(&VELOCITY[stage + 1]);
                if stage == 3 {
                    let [x, v] = [place(1.0, &POSITION[STEP]), velocity(&VELOCITY[STEP])];
                    let errors = [h * (h * sum(&ERRORS_OF_X, all)), h * sum(&ERRORS, all)];
                    [registers[SUM_X], registers[SUM_V]] = [x, v];
                    [registers[ERROR_X], registers[ERROR_V]] = errors;
                }
            }
            4 => {
                component.x = registers[SUM_X] + h * (h * (T::from_f64(POSITION[STEP][5]) * a));
                component.v = registers[SUM_V] + h * (T::from_f64(VELOCITY[STEP][5]) * a);
                registers[ERROR_X] += h * (h * (T::from_f64(ERRORS_OF_X[5]) * a));
                registers[ERROR_V] += h * (T::from_f64(ERRORS[5]) * a);
            }
            _ => {
                registers[ERROR_V] += h * T::from_f64(ERRORS[6]) * a;
                registers[ACCELERATION] = a;
            }
        }
    }
}
