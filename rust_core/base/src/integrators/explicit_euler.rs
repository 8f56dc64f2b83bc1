//! Explicit (forward) Euler method, order 1, for teaching. The energy of every oscillation grows, at any step size.

use super::tableau::{RungeKutta, Tableau};

/// Explicit Euler: x ← x + h v, v ← v + h a(x, v), both with the values at the step's start.
pub type ExplicitEuler = RungeKutta<Euler>;

/// Tableau of the explicit Euler method.
#[derive(Debug)]
pub struct Euler;

impl Tableau for Euler {
    const NAME: &'static str = "ExplicitEuler";
    const ORDER: u32 = 1;
    const A: &'static [&'static [f64]] = &[&[]];
    const B: &'static [f64] = &[1.0];
    const C: &'static [f64] = &[0.0];
    /// Condition R(z) = 1 + z ≥ −1.
    const REAL_AXIS: f64 = 2.0;

    /// Limit ωh ≤ 2ξ, from |R(z)|² = 1 − 2ξωh + ω²h² ≤ 1.
    fn underdamped_limit(damping_ratio: f64) -> f64 {
        2.0 * damping_ratio
    }
}
