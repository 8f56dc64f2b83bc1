//! Explicit methods for y' = f(y). Each stage evaluates F = f(Y) and computes the next Y as a linear combination:
//!
//! ```text
//!     Y' = y₀ + μ (Y − y₀) + ν (Y₋ − y₀) + h (Σ wⱼ Fⱼ + w F)
//! ```
//!
//! Here y₀ is the state at the step's start, Y₋ the state of the stage before Y, and Fⱼ are stored slopes. Runge–Kutta methods
//! with a [`Tableau`] have μ = ν = 0. A stabilized method has few slopes and the recurrence instead. The state is y alone: no
//! slope is kept from step to step. Weights apply to differences from y₀, not to states, so rounded weights change no sum of y.

use super::Tableau;
use super::bogacki_shampine_3::BogackiShampine;
use super::dormand_prince_5::DormandPrince;
use super::explicit_euler::Euler;
use super::runge_kutta_4::Kutta;
use super::runge_kutta_chebyshev as chebyshev;

/// Maximum number of stored slopes.
pub const SLOPES: usize = 6;

/// Base of the next state, without the slopes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Base {
    /// Y, which equals y₀; stored if later stages need it.
    Here {
        /// Whether later stages need y₀.
        keep: bool,
    },
    /// Initial state y₀.
    Start,
    /// Sum y₀ + μ (Y − y₀).
    Own(f64),
    /// Sum y₀ + μ (Y − y₀) + ν (Y₋ − y₀).
    Recurrence(f64, f64),
}

/// Stage of a method: the combination that gives the next state.
#[derive(Debug, Clone, PartialEq)]
pub struct Combination {
    /// Base of the next state.
    pub base: Base,
    /// Weights wⱼ of the stored slopes.
    pub slopes: Vec<f64>,
    /// Weight w of the slope F at this stage.
    pub slope: f64,
    /// Index at which F is stored.
    pub keep: Option<usize>,
    /// Weight b of F in the step's end, with which gains and losses are integrated.
    pub weight: f64,
    /// Node c: the time of Y is c h after the step's start.
    pub node: f64,
}

/// Error estimate of a step: start·y₀ + end·y + h (Σ wⱼ Fⱼ + w f(y)), where y is the step's end.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// Weight of y₀.
    pub start: f64,
    /// Weight of y.
    pub end: f64,
    /// Weights of the stored slopes.
    pub slopes: Vec<f64>,
    /// Weight of f(y).
    pub slope: f64,
    /// Order k of the estimate, which is O(hᵏ).
    pub order: u32,
}

/// Explicit method for y' = f(y).
#[derive(Debug, Clone)]
pub struct FirstOrder {
    /// Name of the class in Python.
    pub name: &'static str,
    /// Order of convergence.
    pub order: u32,
    /// Error estimate, if any.
    pub estimate: Option<Estimate>,
    /// Number of stored slopes.
    pub kept: usize,
    /// Stable interval on the negative real axis, and the stages; None for a method that chooses them by the step.
    fixed: Option<(f64, Vec<Combination>)>,
}

/// Names of all methods.
pub const NAMES: [&str; 5] = [Euler::NAME, BogackiShampine::NAME, Kutta::NAME, DormandPrince::NAME, chebyshev::NAME];

impl FirstOrder {
    /// Returns the method with this name, if any.
    pub fn named(name: &str) -> Option<Self> {
        Some(match name {
            Euler::NAME => Self::of::<Euler>(),
            BogackiShampine::NAME => Self::of::<BogackiShampine>(),
            Kutta::NAME => Self::of::<Kutta>(),
            DormandPrince::NAME => Self::of::<DormandPrince>(),
            chebyshev::NAME => {
                Self { name: chebyshev::NAME, order: 2, estimate: Some(chebyshev::estimate()), kept: 1, fixed: None }
            }
            _ => return None,
        })
    }

    /// Returns the method of a tableau. Slopes that only the error estimate needs are those of the step's end.
    fn of<S: Tableau>() -> Self {
        let count = S::B.iter().rposition(|&weight| weight != 0.0).map_or(0, |last| last + 1);
        let stage = |index: usize| {
            let (last, weights) = (index + 1 == count, if index + 1 == count { S::B } else { S::A[index + 1] });
            Combination {
                base: if index == 0 { Base::Here { keep: !last } } else { Base::Start },
                slopes: weights[..index].to_vec(),
                slope: weights[index],
                keep: (!last || !S::ERRORS.is_empty()).then_some(index),
                weight: S::B[index],
                node: S::C[index],
            }
        };
        let estimate = || Estimate {
            start: 0.0,
            end: 0.0,
            slopes: S::ERRORS[..count].to_vec(),
            slope: S::ERRORS[count..].iter().sum(),
            order: S::ORDER,
        };
        let stages: Vec<_> = (0..count).map(stage).collect();
        Self {
            name: S::NAME,
            order: S::ORDER,
            kept: stages.iter().filter(|stage| stage.keep.is_some()).count(),
            estimate: (!S::ERRORS.is_empty()).then(estimate),
            fixed: Some((S::REAL_AXIS, stages)),
        }
    }

    /// Number of columns besides the state: y₀ and the stored slopes; 0 for a method of one stage.
    pub fn columns(&self) -> usize {
        if self.kept > 0 { 1 + self.kept } else { 0 }
    }

    /// Whether the method chooses its stages by the step size.
    pub fn is_stabilized(&self) -> bool {
        self.fixed.is_none()
    }

    /// Stages of a step of `h` seconds, if the eigenvalues of diffusion reach down to −`diffusion` [1/s].
    pub fn stages(&self, h: f64, diffusion: f64) -> Vec<Combination> {
        match &self.fixed {
            Some((_, stages)) => stages.clone(),
            None => chebyshev::stages(chebyshev::count(h * diffusion)),
        }
    }

    /// Largest stable step [s], if the eigenvalues of diffusion reach down to −`diffusion` and the rates of a reaction up to
    /// `reaction` [1/s].
    pub fn limit(&self, diffusion: f64, reaction: f64) -> f64 {
        match &self.fixed {
            Some((interval, _)) => interval / (diffusion + reaction),
            None => (chebyshev::REACTION / reaction).min(chebyshev::farthest() / diffusion),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Computes a step of y' = λy by the combinations, with the estimated error.
    fn step(method: &FirstOrder, h: f64, rate: f64) -> (f64, f64, f64) {
        solved(method, h, rate.abs(), |y, _| rate * y)
    }

    /// Computes a step of y' = f(y, t) from y = 1 at t = 0.
    fn solved(method: &FirstOrder, h: f64, fastest: f64, f: impl Fn(f64, f64) -> f64) -> (f64, f64, f64) {
        let stages = method.stages(h, fastest);
        let (mut y, mut before, start, mut kept, mut integral) = (1.0, f64::NAN, 1.0, [0.0; SLOPES], 0.0);
        for stage in &stages {
            let slope = f(y, stage.node * h);
            let base = match stage.base {
                Base::Here { .. } => y,
                Base::Start => start,
                Base::Own(own) => start + own * (y - start),
                Base::Recurrence(own, other) => start + own * (y - start) + other * (before - start),
            };
            let sum: f64 = stage.slopes.iter().zip(&kept).map(|(weight, slope)| weight * slope).sum();
            integral += h * stage.weight * slope;
            if let Some(place) = stage.keep {
                kept[place] = slope;
            }
            (before, y) = (y, base + h * (sum + stage.slope * slope));
        }
        let error = method.estimate.as_ref().map_or(0.0, |estimate| {
            let sum: f64 = estimate.slopes.iter().zip(&kept).map(|(weight, slope)| weight * slope).sum();
            estimate.start * start + estimate.end * y + h * (sum + estimate.slope * f(y, h))
        });
        (y, integral, error)
    }

    /// Order test: the error of a step is C h^(p + 1), and so is its estimate, for a pair whose better method has order k.
    #[test]
    fn every_method_has_its_order_and_its_weights_are_those_of_the_end() {
        for name in NAMES {
            let method = FirstOrder::named(name).unwrap();
            let error = |h: f64| (step(&method, h, -1.0).0 - libm::exp(-h)).abs();
            let order = (error(0.2) / error(0.1)).log2() - 1.0;
            assert!((order - f64::from(method.order)).abs() < 0.2, "{name}: {order}");
            let (y, integral, _) = step(&method, 0.3, -1.3);
            assert!((y - 1.0 - integral).abs() < 1e-14, "{name}: {y} {integral}");
            if let Some(estimate) = &method.estimate {
                let order = (step(&method, 0.2, -1.0).2 / step(&method, 0.1, -1.0).2).log2();
                assert!((order - f64::from(estimate.order)).abs() < 0.2, "{name}: {order}");
            }
            assert!(method.columns() <= 1 + SLOPES);
        }
    }

    /// Node test: y' = 1 makes Y the time of the stage, and a rate that grows in time is integrated to the order of the method.
    #[test]
    fn every_node_is_the_time_of_its_stage() {
        for name in NAMES {
            let method = FirstOrder::named(name).unwrap();
            for fastest in [1.0, 200.0] {
                let check = |y: f64, time: f64| {
                    assert!((y - 1.0 - time).abs() < 1e-14, "{name}: {y} {time}");
                    1.0
                };
                assert!((solved(&method, 0.5, fastest, check).0 - 1.5).abs() < 1e-14, "{name}");
                let power = method.order.cast_signed() - 1;
                let error = solved(&method, 0.5, fastest, |_, time| time.powi(power)).0
                    - 1.0
                    - 0.5_f64.powi(power + 1) / f64::from(power + 1);
                assert!(error.abs() < 1e-14, "{name}: {error}");
            }
        }
    }

    /// Stability test: |R| ≤ 1 on the whole interval, and above 1 beyond it.
    #[test]
    fn every_method_is_stable_on_its_interval_alone() {
        for name in NAMES {
            let method = FirstOrder::named(name).unwrap();
            let Some((interval, _)) = &method.fixed else { continue };
            let grows = |fraction: f64| step(&method, 1.0, -fraction * interval).0.abs() > 1.0;
            assert!((1..=1000).all(|part| !grows(0.999_999e-3 * f64::from(part))), "{name}");
            assert!(grows(1.001), "{name}");
        }
    }
}
