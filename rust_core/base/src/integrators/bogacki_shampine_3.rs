//! Embedded pair of Bogacki and Shampine: order 3 with an error estimate, three evaluations per step.
//!
//! Source: P. Bogacki, L. F. Shampine, Appl. Math. Lett. 2 (1989) 321.

use super::tableau::{RungeKutta, Tableau};

/// Method of order 3, with an embedded method of order 2.
pub type BogackiShampine3 = RungeKutta<BogackiShampine>;

/// Tableau of Bogacki and Shampine. R(z) = 1 + z + z²/2 + z³/6. At ξ = 0, |R|² = 1 − y⁴/12 + y⁶/36 with y = ωh gives the limit
/// √3.
#[derive(Debug)]
pub struct BogackiShampine;

impl Tableau for BogackiShampine {
    const NAME: &'static str = "BogackiShampine3";
    const ORDER: u32 = 3;
    const A: &'static [&'static [f64]] = &[&[], &[0.5], &[0.0, 0.75], &[2.0 / 9.0, 1.0 / 3.0, 4.0 / 9.0]];
    const B: &'static [f64] = &[2.0 / 9.0, 1.0 / 3.0, 4.0 / 9.0, 0.0];
    const C: &'static [f64] = &[0.0, 0.5, 0.75, 1.0];
    /// Weights minus those of order 2, which are 7/24, 1/4, 1/3, 1/8.
    const ERRORS: &'static [f64] = &[-5.0 / 72.0, 1.0 / 12.0, 1.0 / 9.0, -1.0 / 8.0];
    /// Condition R ≥ −1: the real root of z³ + 3z² + 6z + 12 = 0.
    const REAL_AXIS: f64 = 2.512_745_326_618_329;
}
