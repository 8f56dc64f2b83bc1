//! Classical Runge–Kutta method, order 4, four evaluations per step. Accurate over short times, but the energy decreases
//! steadily.
//!
//! Source: W. Kutta, Z. Math. Phys. 46 (1901) 435; E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential
//! Equations I, 2nd ed. (1993), table II.1.2.

use super::tableau::{RungeKutta, Tableau};

/// Classical Runge–Kutta method for y = (x, v): kᵢ = f(y + cᵢ h kᵢ₋₁) with c = 0, ½, ½, 1, and y ← y + h/6 (k₁ + 2k₂ + 2k₃ + k₄).
pub type RungeKutta4 = RungeKutta<Kutta>;

/// Tableau of Kutta. R(z) = 1 + z + z²/2 + z³/6 + z⁴/24. At ξ = 0, |R|² = 1 − y⁶/72 + y⁸/576 with y = ωh gives the limit 2√2. For
/// 0 < ξ < 1, |R| = 1 is of degree 7 in y: 2.960 at ξ = 0.14, then 2.616 at ξ = 0.54 and 2.855 at ξ = 0.91.
#[derive(Debug)]
pub struct Kutta;

impl Tableau for Kutta {
    const NAME: &'static str = "RungeKutta4";
    const ORDER: u32 = 4;
    const A: &'static [&'static [f64]] = &[&[], &[0.5], &[0.0, 0.5], &[0.0, 0.0, 1.0]];
    const B: &'static [f64] = &[1.0 / 6.0, 2.0 / 6.0, 2.0 / 6.0, 1.0 / 6.0];
    const C: &'static [f64] = &[0.0, 0.5, 0.5, 1.0];
    /// Condition R ≤ 1: the real root of z³ + 4z² + 12z + 24 = 0.
    const REAL_AXIS: f64 = 2.785_293_563_405_282;
    const IN_REGISTERS: bool = true;
}
