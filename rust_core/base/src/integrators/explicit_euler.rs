//! Explicit (forward) Euler, order 1: for teaching. It gains energy on every oscillation, whatever the step.

use super::tableau::{RungeKutta, Tableau};

/// x ← x + h v, v ← v + h a(x, v), both with the values at the step's start.
pub type ExplicitEuler = RungeKutta<Euler>;

/// Its tableau.
#[derive(Debug)]
pub struct Euler;

impl Tableau for Euler {
    const NAME: &'static str = "ExplicitEuler";
    const ORDER: u32 = 1;
    const A: &'static [&'static [f64]] = &[&[]];
    const B: &'static [f64] = &[1.0];
    const C: &'static [f64] = &[0.0];
    /// R(z) = 1 + z ≥ −1.
    const REAL_AXIS: f64 = 2.0;

    /// |R(z)|² = 1 − 2ξωh + ω²h², so ωh ≤ 2ξ.
    fn underdamped_limit(damping_ratio: f64) -> f64 {
        2.0 * damping_ratio
    }
}
