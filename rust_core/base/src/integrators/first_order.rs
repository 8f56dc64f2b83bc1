//! Explicit methods for y' = f(y): each stage evaluates F = f(Y) and combines what is known of the step linearly to the next Y.
//!
//! ```text
//!     Y' = y₀ + μ (Y − y₀) + ν (Y₋ − y₀) + h (Σ wⱼ Fⱼ + w F)
//! ```
//!
//! y₀ is the state at the step's start, Y₋ that of the stage before Y, and Fⱼ are slopes that were kept. Of Runge–Kutta methods
//! with a [`Tableau`] μ = ν = 0; a stabilized method has few slopes and the recurrence instead. A state is y alone: no slope is
//! kept from one step to the next. Differences from y₀ are weighted rather than states, so that rounded weights move no sum of y.

use super::Tableau;
use super::bogacki_shampine_3::BogackiShampine;
use super::dormand_prince_5::DormandPrince;
use super::explicit_euler::Euler;
use super::runge_kutta_4::Kutta;
use super::runge_kutta_chebyshev as chebyshev;

/// The most slopes that are kept.
pub const SLOPES: usize = 6;

/// What the next state is based on, besides slopes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Base {
    /// Y, which is y₀; it is kept as such where later stages need it.
    Here {
        /// Whether they do.
        keep: bool,
    },
    /// y₀.
    Start,
    /// y₀ + μ (Y − y₀).
    Own(f64),
    /// y₀ + μ (Y − y₀) + ν (Y₋ − y₀).
    Recurrence(f64, f64),
}

/// A stage.
#[derive(Debug, Clone, PartialEq)]
pub struct Combination {
    /// What the next state is based on.
    pub base: Base,
    /// wⱼ of the slopes that were kept.
    pub slopes: Vec<f64>,
    /// w of the slope F at this stage.
    pub slope: f64,
    /// The place where F is kept.
    pub keep: Option<usize>,
    /// b: the weight of F in the step's end, with which gains and losses are integrated.
    pub weight: f64,
}

/// The estimate of a step's error: start·y₀ + end·y + h (Σ wⱼ Fⱼ + w f(y)), y being the step's end.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// The weight of y₀.
    pub start: f64,
    /// The weight of y.
    pub end: f64,
    /// The weights of the slopes that were kept.
    pub slopes: Vec<f64>,
    /// The weight of f(y).
    pub slope: f64,
    /// k, where it is of the order hᵏ.
    pub order: u32,
}

/// A method.
#[derive(Debug, Clone)]
pub struct FirstOrder {
    /// The class's name in Python.
    pub name: &'static str,
    /// The order of convergence.
    pub order: u32,
    /// The estimate of its errors, if it has one.
    pub estimate: Option<Estimate>,
    /// The number of slopes that are kept.
    pub kept: usize,
    /// The stable interval on the negative real axis, and the stages; none of a method that chooses them.
    fixed: Option<(f64, Vec<Combination>)>,
}

/// The names of all methods.
pub const NAMES: [&str; 5] = [Euler::NAME, BogackiShampine::NAME, Kutta::NAME, DormandPrince::NAME, chebyshev::NAME];

impl FirstOrder {
    /// The method of a name, if there is one.
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

    /// The method of a tableau. Slopes that only the error estimate needs are those of the step's end.
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

    /// The number of columns besides the state: y₀ and the slopes that are kept; none of a method of one stage.
    pub fn columns(&self) -> usize {
        if self.kept > 0 { 1 + self.kept } else { 0 }
    }

    /// Whether it chooses its stages by the step.
    pub fn is_stabilized(&self) -> bool {
        self.fixed.is_none()
    }

    /// The stages of a step of `h` seconds where the eigenvalues of diffusion reach down to −`diffusion` [1/s].
    pub fn stages(&self, h: f64, diffusion: f64) -> Vec<Combination> {
        match &self.fixed {
            Some((_, stages)) => stages.clone(),
            None => chebyshev::stages(chebyshev::count(h * diffusion)),
        }
    }

    /// The largest stable step [s] where the eigenvalues of diffusion reach down to −`diffusion`, and the rates of a reaction to
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

    /// A step of y' = λy as the combinations take it, with the estimated error.
    fn step(method: &FirstOrder, h: f64, rate: f64) -> (f64, f64, f64) {
        let stages = method.stages(h, rate.abs());
        let (mut y, mut before, start, mut kept, mut integral) = (1.0, f64::NAN, 1.0, [0.0; SLOPES], 0.0);
        for stage in &stages {
            let slope = rate * y;
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
            estimate.start * start + estimate.end * y + h * (sum + estimate.slope * rate * y)
        });
        (y, integral, error)
    }

    /// The error of a step is C h^(p + 1), and so is that of its estimate of a pair whose better method has order k.
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

    /// |R| ≤ 1 on the whole interval, and above 1 beyond it.
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
