//! Embedded pair of Dormand and Prince: order 5 with an error estimate, six evaluations per step.
//!
//! Source: J. R. Dormand, P. J. Prince, J. Comput. Appl. Math. 6 (1980) 19; E. Hairer, S. P. Nørsett, G. Wanner, Solving
//! Ordinary Differential Equations I, 2nd ed. (1993), table II.5.2.

use super::tableau::{RungeKutta, Tableau};

/// Method of order 5, with an embedded method of order 4.
pub type DormandPrince5 = RungeKutta<DormandPrince>;

/// Tableau of Dormand and Prince. R(z) = 1 + z + z²/2 + z³/6 + z⁴/24 + z⁵/120 + z⁶/600. At ξ = 0, with u = (ωh)², |R|² = 1 − u³
/// (1/1800 − u/1600 + u²/14400 − u³/360000) gives the limit u = 0.9943….
#[derive(Debug)]
pub struct DormandPrince;

impl Tableau for DormandPrince {
    const NAME: &'static str = "DormandPrince5";
    const ORDER: u32 = 5;
    const A: &'static [&'static [f64]] = &[
        &[],
        &[1.0 / 5.0],
        &[3.0 / 40.0, 9.0 / 40.0],
        &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0],
        &[19_372.0 / 6_561.0, -25_360.0 / 2_187.0, 64_448.0 / 6_561.0, -212.0 / 729.0],
        &[9_017.0 / 3_168.0, -355.0 / 33.0, 46_732.0 / 5_247.0, 49.0 / 176.0, -5_103.0 / 18_656.0],
        &[35.0 / 384.0, 0.0, 500.0 / 1_113.0, 125.0 / 192.0, -2_187.0 / 6_784.0, 11.0 / 84.0],
    ];
    const B: &'static [f64] = &[35.0 / 384.0, 0.0, 500.0 / 1_113.0, 125.0 / 192.0, -2_187.0 / 6_784.0, 11.0 / 84.0, 0.0];
    const C: &'static [f64] = &[0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0];
    /// Weights minus those of order 4; their sum is 0.
    const ERRORS: &'static [f64] =
        &[71.0 / 57_600.0, 0.0, -71.0 / 16_695.0, 71.0 / 1_920.0, -17_253.0 / 339_200.0, 22.0 / 525.0, -1.0 / 40.0];
    /// Condition R ≤ 1: the real root of z⁵ + 5z⁴ + 25z³ + 100z² + 300z + 600 = 0.
    const REAL_AXIS: f64 = 3.306_567_892_634_947;
}
