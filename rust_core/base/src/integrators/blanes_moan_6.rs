//! Blanes and Moan's `SRKN₁₁ᵇ`, order 6, symplectic and reversible, with eleven evaluations per step: the cheapest method for
//! positions, and for energy errors below 1e-6.
//!
//! Source: S. Blanes, P. C. Moan, J. Comput. Appl. Math. 142 (2002) 313, table 3.

use super::Splitting;
use super::splitting::palindrome;

/// Eleven drifts between twelve kicks. The order holds for x'' = a(x, t), because a kick by a force that does not depend on
/// velocity changes only v.
///
/// At ωh = 3.1414… half the trace of the step passes −1, by 1e-7: a resonance so narrow that little damping suppresses it.
#[derive(Debug)]
pub struct BlanesMoan6;

const A: [f64; 5] =
    [0.123_229_775_946_271, 0.290_553_797_799_558, -0.127_049_212_625_417, -0.246_331_761_062_075, 0.357_208_872_795_928];
const B: [f64; 5] =
    [0.041_464_998_518_262_4, 0.198_128_671_918_067, -0.040_006_192_104_153_3, 0.075_253_984_301_580_7, -0.011_511_387_420_687_9];
const A6: f64 = 1.0 - 2.0 * (A[0] + A[1] + A[2] + A[3] + A[4]);
const B6: f64 = 0.5 - (B[0] + B[1] + B[2] + B[3] + B[4]);

impl Splitting for BlanesMoan6 {
    const NAME: &'static str = "BlanesMoan6";
    const ORDER: u32 = 6;
    const DRIFTS: &'static [f64] = &palindrome::<6, 11>([A[0], A[1], A[2], A[3], A[4], A6]);
    const KICKS: &'static [f64] = &palindrome::<6, 12>([B[0], B[1], B[2], B[3], B[4], B6]);
    /// Measured by the search described at [`super::Pefrl`]. It found 0.907 of the limit of the modes alone, at damping ratios
    /// near 1.6. Outside 1.3 to 2.5 it found none below 1.
    const COUPLED: f64 = 0.89;
}
