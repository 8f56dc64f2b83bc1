//! Position-extended Forest–Ruth-like, order 4, symplectic and reversible, four evaluations: the accurate choice where
//! energy is conserved.
//!
//! Source: I. P. Omelyan, I. M. Mryglod, R. Folk, Comput. Phys. Commun. 146 (2002) 188, eqs. 20–22.
//!
//! Forces that depend on velocity are taken at the velocity predicted for the middle of each kick, v + cᵢh/2 a with the
//! last acceleration that was evaluated. The prediction is off by O(h²) and enters with a factor h: order 2. It could
//! not stay 4 at any price: a splitting above order 2 has negative substeps (Sheng 1989, Suzuki 1991), in which
//! dissipation would run backwards.

use super::{Integrator, Register, amplification};
use crate::math::Real;

/// Drifts by ξ, χ, 1 − 2(χ + ξ), χ, ξ around kicks by (1 − 2λ)/2, λ, λ, (1 − 2λ)/2, in units of h.
#[derive(Debug)]
pub struct Pefrl;

const XI: f64 = 0.178_617_895_844_809_1;
const LAMBDA: f64 = -0.212_341_831_062_605_4;
const CHI: f64 = -0.066_264_582_669_818_5;
const DRIFTS: [f64; 4] = [XI, CHI, 1.0 - 2.0 * (CHI + XI), CHI];
const KICKS: [f64; 4] = [0.5 - LAMBDA, LAMBDA, LAMBDA, 0.5 - LAMBDA];

/// The last acceleration that was evaluated.
const ACCELERATION: usize = 0;
/// The velocity before the kick.
const BEFORE: usize = 1;

impl Integrator for Pefrl {
    const NAME: &'static str = "PEFRL";
    const ORDER: u32 = 4;
    const ORDER_DISSIPATIVE: u32 = 2;
    const NODES: &'static [f64] = &[XI, XI + CHI, 1.0 - XI - CHI, 1.0 - XI];
    const WEIGHTS: &'static [f64] = &KICKS;
    const MEMORY: usize = 2;
    const CARRIED: usize = 1;
    /// Searching pairs of matrices that do not commute, of up to four modes, for the least limit found 0.995 of that of the
    /// modes alone, at damping ratios near 0.5, and none below 1 elsewhere.
    const COUPLED: f64 = 0.99;

    /// At ξ = 0 half the trace of the step is a polynomial of degree 4 in (ωh)², which falls from 1 to −1 at ωh = 2.98945….
    /// With damping the step maps (x, v, a) by the product of four stages, of which no closed form is worth having.
    fn limit(damping_ratio: f64) -> f64 {
        amplification::limit::<Self>(damping_ratio)
    }

    #[inline(always)]
    fn begin<T: Real>(register: &mut Register<T>, a: T) {
        register.memory[ACCELERATION] = a;
    }

    #[inline(always)]
    fn point<T: Real>(stage: usize, register: &mut Register<T>, h: T) {
        let before = register.v;
        register.x += T::from_f64(DRIFTS[stage]) * h * before;
        register.v = before + T::from_f64(0.5 * KICKS[stage]) * h * register.memory[ACCELERATION];
        register.memory[BEFORE] = before;
    }

    #[inline(always)]
    fn absorb<T: Real>(stage: usize, register: &mut Register<T>, a: T, h: T) {
        register.v = register.memory[BEFORE] + T::from_f64(KICKS[stage]) * h * a;
        register.memory[ACCELERATION] = a;
        if stage == 3 {
            register.x += T::from_f64(XI) * h * register.v;
        }
    }
}
