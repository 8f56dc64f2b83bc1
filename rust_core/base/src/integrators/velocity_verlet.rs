//! Velocity Verlet method, order 2, symplectic and reversible if forces do not depend on velocity.
//!
//! Source: W. C. Swope, H. C. Andersen, P. H. Berens, K. R. Wilson, J. Chem. Phys. 76 (1982) 637.
//!
//! Velocity-dependent forces are evaluated at the predicted velocity v + h aₙ, as in R. D. Groot, P. B. Warren, J. Chem. Phys.
//! 107 (1997) 4423 with λ = 1. The prediction has an error of O(h²), and so has the acceleration with which the next step starts.
//! Both enter with a factor h, so order 2 remains, at one evaluation per step. The price is that damping limits the step:
//! critical damping to ωh ≤ 0.47. Evaluation at vₙ₊₁ would have no such limit, but requires the solution of equations if springs
//! are damped. The benchmark `benches/damping.py` measures both.
//!
//! The power of damping is its force times the velocity of the trajectory through the positions:
//!
//! ```text
//!     ẋₙ = (xₙ₊₁ − xₙ₋₁)/2h − h²/6 x⃛ = vₙ − h²/6 x⃛
//! ```
//!
//! The reason is that the shadow Hamiltonian, which the other forces conserve, changes by F·∂H/∂p, and ∂H/∂p is ẋ (E. Hairer, C.
//! Lubich, G. Wanner, "Geometric Numerical Integration", § IX). The predicted velocity is vₙ + h/2 (aₙ₋₁ − aₙ) = vₙ − h²/2 x⃛.
//! Therefore ẋₙ is one third of the predicted velocity and two thirds of vₙ. With the predicted velocity alone, the power of a
//! mode of frequency ω would be too large by (ωh)²/3.

use super::{Compiled, Component, DriftKick, Integrator};
use crate::math::Real;
use crate::simd::Number;

/// Velocity Verlet: v½ = v + h/2 a, x ← x + h v½, a ← a(x, v½ + h/2 a), v ← v½ + h/2 a.
#[derive(Debug)]
pub struct VelocityVerlet;

/// Register of the acceleration evaluated at the end of the last step.
const ACCELERATION: usize = 0;
/// Register of the velocity in the middle of the step.
const HALF: usize = 1;

impl Integrator for VelocityVerlet {
    type Swept = Compiled<Self>;
    const NAME: &'static str = "VelocityVerlet";
    const ORDER: u32 = 2;
    const ORDER_DISSIPATIVE: u32 = 2;
    const NODES: &'static [f64] = &[1.0];
    const WEIGHTS: &'static [f64] = &[0.5];
    const LAST_WEIGHT: f64 = 0.5;
    const CORRECTED_WEIGHT: f64 = 2.0 / 3.0;
    const REGISTERS: usize = 2;
    const PERSISTENT: usize = 1;
    const DRIFT_KICK: Option<DriftKick> = Some(DriftKick { drifts: &[1.0], velocity: HALF });
    const DRIFTS_FIRST: bool = true;
    const IN_REGISTERS: bool = true;

    /// Limit ωh ≤ 2(√(4ξ² + 1) − 2ξ).
    ///
    /// Let y = ωh, c = 2ξy and g be the growth factor per step. Then v = h/2 (g + 1)/(g − 1) a and x = h² g/(g − 1)² a. The
    /// stored a obeys g³ + (y² + 3c/2 − 2) g² + (1 − 2c) g + c/2 = 0. Jury's condition at g = −1 is y² + 4c ≤ 4, hence the limit.
    /// This condition is the strictest: it bounds c by 1. Then the condition at g = 1 is y² ≥ 0, and the product of the roots is
    /// c/2 < 1. The last condition, cy²/2 + c + c² ≤ 2, follows from c(4 − 4c)/2 + c + c² = 3c − c² ≤ 2.
    fn limit(damping_ratio: f64) -> f64 {
        let twice = 2.0 * damping_ratio;
        2.0 / (libm::hypot(twice, 1.0) + twice)
    }

    /// Equals the limit, because stable steps form one interval.
    fn last(damping_ratio: f64) -> f64 {
        Self::limit(damping_ratio)
    }

    /// Equivalent oscillator, in which the decay d counts with half its rate. With d and v½ = v + h/2 a as above,
    /// x ← (1 − dh) x + h v½. Jury's condition at g = −1 becomes y² + 4c + 2dh ≤ 4, without the product of both, which is
    /// negative.
    fn oscillator(frequency: f64, damping: f64, decay: f64) -> [f64; 2] {
        [frequency, damping + 0.5 * decay]
    }

    #[inline(always)]
    fn correct_velocity<T: Real>(component: &mut Component<T>, h: T) {
        let kick = T::from_f64(0.5) * h * component.registers[ACCELERATION];
        // A component without contact keeps its bits.
        if component.v != component.registers[HALF] + kick {
            component.registers[HALF] = component.v - kick;
        }
    }

    #[inline(always)]
    fn begin<T: Number>(component: &mut Component<T>, a: T) {
        component.registers[ACCELERATION] = a;
    }

    #[inline(always)]
    fn stage_state<T: Number>(_stage: usize, component: &mut Component<T>, h: T) {
        let kick = T::constant(0.5) * h * component.registers[ACCELERATION];
        let half = component.v + kick;
        component.x += h * half;
        component.v = half + kick;
        component.registers[HALF] = half;
    }

    #[inline(always)]
    fn stage_update<T: Number>(_stage: usize, component: &mut Component<T>, a: T, h: T) {
        component.v = component.registers[HALF] + T::constant(0.5) * h * a;
        component.registers[ACCELERATION] = a;
    }
}
