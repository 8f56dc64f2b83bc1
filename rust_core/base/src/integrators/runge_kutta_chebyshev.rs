//! Stabilized Runge–Kutta–Chebyshev method, order 2, for diffusion. With s evaluations the stable interval on the negative real
//! axis is 0.65 s²; s steps of Euler's method reach 2 s.
//!
//! With Chebyshev polynomials Tⱼ, ε = 2/13, w₀ = 1 + ε/s², w₁ = Tₛ'(w₀)/Tₛ''(w₀), bⱼ = Tⱼ''(w₀)/Tⱼ'(w₀)², b₀ = b₁ = b₂ and aⱼ = 1
//! − bⱼ Tⱼ(w₀) the stages are
//!
//! ```text
//!     Y₁ = y₀ + μ̃₁ h F₀,   Yⱼ = (1 − μⱼ − νⱼ) y₀ + μⱼ Yⱼ₋₁ + νⱼ Yⱼ₋₂ + μ̃ⱼ h Fⱼ₋₁ + γ̃ⱼ h F₀
//!     μ̃₁ = b₁ w₁,   μⱼ = 2 bⱼ w₀/bⱼ₋₁,   νⱼ = −bⱼ/bⱼ₋₂,   μ̃ⱼ = 2 bⱼ w₁/bⱼ₋₁,   γ̃ⱼ = −aⱼ₋₁ μ̃ⱼ
//! ```
//!
//! The stable interval is (w₀ + 1)/w₁, on which |R| ≤ 1 − ε/3 away from 0.
//!
//! Source: B. P. Sommeijer, L. F. Shampine, J. G. Verwer, J. Comput. Appl. Math. 88 (1998) 315.

use super::first_order::{Base, Combination, Estimate};
use super::tableau::Tableau;

/// Name of the class in Python.
pub const NAME: &str = "RungeKuttaChebyshev";
/// Damping ε.
const DAMPING: f64 = 2.0 / 13.0;
/// Part of the stable interval reserved for the reaction, whose rates ρ must obey ρh < 2: the interval of Euler's method.
pub const REACTION: f64 = 2.0;
/// Maximum number of stages.
const MOST: usize = 128;

/// Values Tⱼ, Tⱼ' and Tⱼ'' at w₀ for j = 0 … s.
fn polynomials(stages: usize) -> Vec<[f64; 3]> {
    let w = 1.0 + DAMPING / (stages * stages) as f64;
    let mut all = vec![[1.0, 0.0, 0.0], [w, 1.0, 0.0]];
    for j in 2..=stages {
        let ([t, d, dd], [t2, d2, dd2]) = (all[j - 1], all[j - 2]);
        all.push([2.0 * w * t - t2, 2.0 * (t + w * d) - d2, 2.0 * (2.0 * d + w * dd) - dd2]);
    }
    all
}

/// Stable interval for a number of stages.
pub fn interval(stages: usize) -> f64 {
    let [_, d, dd] = polynomials(stages)[stages];
    (2.0 + DAMPING / (stages * stages) as f64) * dd / d
}

/// Longest stable interval.
pub fn farthest() -> f64 {
    interval(MOST) - REACTION
}

/// Smallest number of stages whose interval holds `reach`, h times the largest rate of diffusion, and the part reserved for the
/// reaction.
pub fn count(reach: f64) -> usize {
    (2..MOST).find(|&stages| interval(stages) >= reach + REACTION).unwrap_or(MOST)
}

/// Method of two stages, w₀ = 27/26, for systems without diffusion.
#[derive(Debug)]
pub struct TwoStages;

impl Tableau for TwoStages {
    const NAME: &'static str = NAME;
    const ORDER: u32 = 2;
    const A: &'static [&'static [f64]] = &[&[], &[13.0 / 54.0], &[-14.0 / 13.0, 27.0 / 13.0]];
    const B: &'static [f64] = &[-14.0 / 13.0, 27.0 / 13.0, 0.0];
    const C: &'static [f64] = &[0.0, 13.0 / 54.0, 1.0];
    /// Weights of [`estimate`], with y₀ − y = −h Σ bᵢ kᵢ.
    const ERRORS: &'static [f64] = &[0.4 + 0.8 * 14.0 / 13.0, -0.8 * 27.0 / 13.0, 0.4];
    /// Interval (w₀ + 1)/w₁ with w₁ = w₀.
    const REAL_AXIS: f64 = 53.0 / 27.0;
}

/// Stages of a step.
pub fn stages(count: usize) -> Vec<Combination> {
    let polynomials = polynomials(count);
    let w0 = 1.0 + DAMPING / (count * count) as f64;
    let w1 = polynomials[count][1] / polynomials[count][2];
    let b = |j: usize| {
        let [_, d, dd] = polynomials[j.max(2)];
        dd / (d * d)
    };
    let a = |j: usize| 1.0 - b(j) * polynomials[j][0];
    let first = Combination {
        base: Base::Here { keep: true },
        slopes: Vec::new(),
        slope: b(1) * w1,
        keep: Some(0),
        weight: 0.0,
        node: 0.0,
    };
    let mut stages = vec![first];
    // Weights of h Fᵢ in the sums Yⱼ − y₀.
    let mut weights = [vec![0.0; count], vec![0.0; count]];
    weights[1][0] = b(1) * w1;
    for j in 2..=count {
        let (own, other) = (2.0 * b(j) * w0 / b(j - 1), -b(j) / b(j - 2));
        let slope = 2.0 * b(j) * w1 / b(j - 1);
        let first = -a(j - 1) * slope;
        let mut next: Vec<f64> = weights[0].iter().zip(&weights[1]).map(|(two, one)| own * one + other * two).collect();
        next[0] += first;
        next[j - 1] += slope;
        let node = weights[1].iter().sum();
        weights.rotate_left(1);
        weights[1] = next;
        let base = if j == 2 { Base::Own(own) } else { Base::Recurrence(own, other) };
        stages.push(Combination { base, slopes: vec![first], slope, keep: None, weight: 0.0, node });
    }
    stages.iter_mut().zip(&weights[1]).for_each(|(stage, &weight)| stage.weight = weight);
    stages
}

/// Error estimate ⅘ (y₀ − y) + ⅖ h (F₀ + f(y)), of order 3.
pub fn estimate() -> Estimate {
    Estimate { start: 0.8, end: -0.8, slopes: vec![0.4], slope: 0.4, order: 3 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Stability function R(z) by the recurrence.
    fn amplification(stages: &[Combination], z: f64) -> f64 {
        let (mut y, mut before, mut first) = (1.0, 1.0, 0.0);
        for stage in stages {
            let base = match stage.base {
                Base::Here { .. } | Base::Start => 1.0,
                Base::Own(own) => 1.0 + own * (y - 1.0),
                Base::Recurrence(own, other) => 1.0 + own * (y - 1.0) + other * (before - 1.0),
            };
            let next = base + stage.slopes.first().unwrap_or(&0.0) * first + stage.slope * z * y;
            first = if stage.keep.is_some() { z * y } else { first };
            (before, y) = (y, next);
        }
        y
    }

    /// The interval is ⅔ (s² − 1)(1 − 2ε/15), within O(ε²). On it |R| ≤ 1; a fifth beyond it |R| > 1. (|Tₛ| grows like cosh, and
    /// aₛ + bₛ |Tₛ| or bₛ |Tₛ| − aₛ passes 1 there for every s.)
    #[test]
    fn the_interval_grows_with_the_square_of_the_stages() {
        for count in [2, 3, 5, 10, 40, MOST] {
            let (found, s) = (interval(count), count as f64);
            let expected = 2.0 / 3.0 * (s * s - 1.0) * (1.0 - 2.0 / 15.0 * DAMPING);
            assert!((found / expected - 1.0).abs() < 0.01, "{count}: {found}, {expected}");
            let stages = stages(count);
            let largest = (0..=4000).map(|part| amplification(&stages, -found * f64::from(part) / 4000.0).abs());
            assert!(largest.fold(0.0, f64::max) <= 1.0 + 1e-9, "{count}");
            assert!(amplification(&stages, -1.2 * found).abs() > 1.0, "{count}");
            // Away from 0, |R| is damped: 1 − ε/3.
            assert!(amplification(&stages, -0.9 * found).abs() < 1.0 - 0.3 * DAMPING, "{count}");
        }
    }

    #[test]
    fn as_few_stages_are_taken_as_suffice() {
        for reach in [0.0, 1.0, 17.0, 350.0, 9000.0] {
            let stages = count(reach);
            assert!(interval(stages) >= reach + REACTION && (stages == 2 || interval(stages - 1) < reach + REACTION));
        }
    }
}
