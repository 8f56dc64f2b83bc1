//! Blanes and Moan's `SRKN₆ᵇ`, order 4, symplectic and reversible, with six evaluations per step. For equal energy error it needs
//! half the evaluations of PEFRL.
//!
//! Source: S. Blanes, P. C. Moan, J. Comput. Appl. Math. 142 (2002) 313, table 3.

use super::Splitting;
use super::splitting::palindrome;

/// Six drifts between seven kicks. The order holds for x'' = a(x, t), because a kick by a force that does not depend on velocity
/// changes only v.
///
/// At ωh = 3.1634… half the trace of the step passes −1, by 3e-6: a resonance so narrow that little damping suppresses it.
#[derive(Debug)]
pub struct BlanesMoan4;

const A1: f64 = 0.245_298_957_184_271;
const A2: f64 = 0.604_872_665_711_080;
const B1: f64 = 0.082_984_406_417_405_2;
const B2: f64 = 0.396_309_801_498_368;
const B3: f64 = -0.039_056_304_922_348_6;

impl Splitting for BlanesMoan4 {
    const NAME: &'static str = "BlanesMoan4";
    const ORDER: u32 = 4;
    const DRIFTS: &'static [f64] = &palindrome::<3, 6>([A1, A2, 0.5 - (A1 + A2)]);
    const KICKS: &'static [f64] = &palindrome::<4, 7>([B1, B2, B3, 1.0 - 2.0 * (B1 + B2 + B3)]);
    /// Measured by the search described at [`super::Pefrl`], which found no limit below that of the modes alone, for up to three
    /// modes.
    const COUPLED: f64 = 0.99;
}
