//! Position-extended Forest–Ruth-like (PEFRL) method, order 4, symplectic and reversible, with four evaluations per step: the
//! accurate choice where energy is conserved.
//!
//! Source: I. P. Omelyan, I. M. Mryglod, R. Folk, Comput. Phys. Commun. 146 (2002) 188, eqs. 20–22.

use super::Splitting;

/// Drifts by ξ, χ, 1 − 2(χ + ξ), χ, ξ around kicks by (1 − 2λ)/2, λ, λ, (1 − 2λ)/2, in units of h.
///
/// Half the trace of the step is a polynomial of degree 4 in (ωh)², which falls from 1 to −1 at ωh = 2.98945….
#[derive(Debug)]
pub struct Pefrl;

const XI: f64 = 0.178_617_895_844_809_1;
const LAMBDA: f64 = -0.212_341_831_062_605_4;
const CHI: f64 = -0.066_264_582_669_818_5;

impl Splitting for Pefrl {
    const NAME: &'static str = "PEFRL";
    const ORDER: u32 = 4;
    const DRIFTS: &'static [f64] = &[XI, CHI, 1.0 - 2.0 * (CHI + XI), CHI, XI];
    const KICKS: &'static [f64] = &[0.5 - LAMBDA, LAMBDA, LAMBDA, 0.5 - LAMBDA];
    /// Measured by a search over pairs of matrices that do not commute, of up to four modes, for the least limit. It found 0.995
    /// of the limit of the modes alone, at damping ratios near 0.5, and none below 1 elsewhere.
    const COUPLED: f64 = 0.99;
}
