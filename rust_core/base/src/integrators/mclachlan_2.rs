//! `McLachlan`'s two-stage method, order 2, symplectic and reversible, with two evaluations per step: the smallest energy error
//! at its cost for large steps.
//!
//! Source: R. I. `McLachlan`, SIAM J. Sci. Comput. 16 (1995) 151; I. P. Omelyan, I. M. Mryglod, R. Folk, Comput. Phys. Commun.
//! 146 (2002) 188, eqs. 9 and 14.

use super::Splitting;

/// Drifts by λ, 1 − 2λ, λ around two kicks by ½, in units of h.
///
/// Half the trace of the step is 1 − y/2 + λ(1 − 2λ) y²/4 with y = (ωh)², which falls from 1 to −1 at ωh = 2.5531….
#[derive(Debug)]
pub struct McLachlan2;

/// Value of λ that minimizes the sum of squares of the leading errors of a general force.
const LAMBDA: f64 = 0.193_183_327_503_783_6;

impl Splitting for McLachlan2 {
    const NAME: &'static str = "McLachlan2";
    const ORDER: u32 = 2;
    const DRIFTS: &'static [f64] = &[LAMBDA, 1.0 - 2.0 * LAMBDA, LAMBDA];
    const KICKS: &'static [f64] = &[0.5, 0.5];
    /// Measured by the search described at [`super::Pefrl`], which found no limit below that of the modes alone, for up to three
    /// modes.
    const COUPLED: f64 = 0.99;
}
