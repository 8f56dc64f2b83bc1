//! Velocity Verlet, order 2, symplectic and reversible where forces do not depend on velocity.
//!
//! Source: W. C. Swope, H. C. Andersen, P. H. Berens, K. R. Wilson, J. Chem. Phys. 76 (1982) 637. Forces that depend on
//! velocity are taken at the predicted velocity v + h aₙ, as in R. D. Groot, P. B. Warren, J. Chem. Phys. 107 (1997)
//! 4423 with λ = 1. The prediction is off by O(h²), and so is the acceleration that the next step starts with; either
//! enters with a factor h, so that order 2 remains, at one evaluation per step.

use super::{Integrator, Register};
use crate::math::Real;

/// v½ = v + h/2 a, x ← x + h v½, a ← a(x, v½ + h/2 a), v ← v½ + h/2 a.
#[derive(Debug)]
pub struct VelocityVerlet;

/// The acceleration at the end of the last step, as it was evaluated.
const ACCELERATION: usize = 0;
/// The velocity in the middle of the step.
const HALF: usize = 1;

impl Integrator for VelocityVerlet {
    const NAME: &'static str = "VelocityVerlet";
    const ORDER: u32 = 2;
    const ORDER_DISSIPATIVE: u32 = 2;
    const NODES: &'static [f64] = &[1.0];
    const WEIGHTS: &'static [f64] = &[0.5];
    const LAST_WEIGHT: f64 = 0.5;
    const MEMORY: usize = 2;
    const CARRIED: usize = 1;

    fn limit(damping_ratio: f64) -> f64 {
        let _ = damping_ratio;
        2.0
    }

    #[inline(always)]
    fn begin<T: Real>(register: &mut Register<T>, a: T) {
        register.memory[ACCELERATION] = a;
    }

    #[inline(always)]
    fn point<T: Real>(_stage: usize, register: &mut Register<T>, h: T) {
        let kick = T::from_f64(0.5) * h * register.memory[ACCELERATION];
        let half = register.v + kick;
        register.x += h * half;
        register.v = half + kick;
        register.memory[HALF] = half;
    }

    #[inline(always)]
    fn absorb<T: Real>(_stage: usize, register: &mut Register<T>, a: T, h: T) {
        register.v = register.memory[HALF] + T::from_f64(0.5) * h * a;
        register.memory[ACCELERATION] = a;
    }
}
