//! Steps of y' = f(y) by the tableau of an explicit method, number by number: in registers if f can be evaluated there.
//!
//! ```text
//!     Yᵢ = y₀ + Σ (h aᵢⱼ) kⱼ,   kᵢ = f(Yᵢ),   y = y₀ + Σ (h bᵢ) kᵢ
//! ```

use std::marker::PhantomData;

pub use super::bogacki_shampine_3::BogackiShampine;
pub use super::dormand_prince_5::DormandPrince;
pub use super::explicit_euler::Euler;
pub use super::runge_kutta_4::Kutta;
pub use super::runge_kutta_chebyshev::TwoStages;
use super::tableau::Tableau;
use crate::simd::Number;

/// Maximum number of slopes of a tableau, including the slope at the step's end.
pub const SLOPES: usize = 7;

/// Registry of first-order methods: binds `$S` to the tableau with a name and evaluates `$body`, or `$otherwise`.
macro_rules! with_tableau {
    ($name:expr, $S:ident => $body:expr, $otherwise:expr) => {
        $crate::integrators::explicit::with_tableau!(@each $name, $S, $body, $otherwise;
            Euler, BogackiShampine, Kutta, DormandPrince, TwoStages)
    };
    (@each $name:expr, $S:ident, $body:expr, $otherwise:expr; $($tableau:ident),+) => {
        match $name {
            $(name if name == <$crate::integrators::explicit::$tableau as $crate::integrators::Tableau>::NAME => {
                type $S = $crate::integrators::explicit::$tableau;
                $body
            })+
            _ => $otherwise,
        }
    };
}
pub(crate) use with_tableau;

/// Tableau in the form in which first-order steps use it.
pub trait ExplicitTableau: Tableau {
    /// Number of slopes on which the step's end depends.
    const EVALUATIONS: usize = {
        let mut last = Self::B.len();
        while last > 1 && Self::B[last - 1] == 0.0 {
            last -= 1;
        }
        last
    };
    /// Weights of the slopes in the states at which slopes are evaluated, and in the step's end.
    const ROWS: &'static [&'static [f64]; SLOPES + 1] = &{
        let mut rows: [&'static [f64]; SLOPES + 1] = [&[]; SLOPES + 1];
        let mut row = 0;
        while row < Self::EVALUATIONS {
            rows[row] = Self::A[row];
            row += 1;
        }
        rows[Self::EVALUATIONS] = Self::B.split_at(Self::EVALUATIONS).0;
        rows
    };
}

impl<S: Tableau> ExplicitTableau for S {}

/// Coefficients of a tableau.
#[derive(Debug, Clone, Copy)]
pub struct Coefficients {
    /// [`Tableau::NAME`].
    pub name: &'static str,
    /// [`ExplicitTableau::EVALUATIONS`].
    pub evaluations: usize,
    /// [`ExplicitTableau::ROWS`].
    pub rows: &'static [&'static [f64]; SLOPES + 1],
    /// [`Tableau::ERRORS`].
    pub errors: &'static [f64],
    /// [`Tableau::C`].
    pub nodes: &'static [f64],
}

impl Coefficients {
    /// Coefficients of the method with this name, if any.
    pub fn named(name: &str) -> Option<Self> {
        with_tableau!(name, S => Some(Self {
            name: S::NAME,
            evaluations: S::EVALUATIONS,
            rows: S::ROWS,
            errors: S::ERRORS,
            nodes: S::C,
        }), None)
    }
}

/// Computes start + Σ (h wⱼ) kⱼ over the nonzero weights, adding slopes of equal weights in a row first. The sum is written out:
/// slopes stay in registers only if the compiler unrolls the loop.
#[inline(always)]
#[allow(unused_assignments, reason = "the last pass of a loop that is written out")]
pub fn combine<N: Number>(weights: &[f64], start: N, slopes: &[N; SLOPES], h: f64) -> N {
    let (mut sum, mut equal): (Option<N>, Option<N>) = (None, None);
    macro_rules! add {
        ($($slope:literal)*) => {
            $(if $slope < weights.len() && weights[$slope] != 0.0 {
                let equals = if let Some(equal) = equal { equal + slopes[$slope] } else { slopes[$slope] };
                equal = Some(equals);
                if $slope + 1 == weights.len() || weights[$slope + 1] != weights[$slope] {
                    let term = N::constant(h * weights[$slope]) * equals;
                    (sum, equal) = (Some(if let Some(sum) = sum { sum + term } else { term }), None);
                }
            })*
        };
    }
    add!(0 1 2 3 4 5 6);
    if let Some(sum) = sum { start + sum } else { start }
}

/// Computes [`combine`] for several numbers with their slopes.
#[inline(always)]
pub fn combine_all<N: Number, const D: usize>(weights: &[f64], start: &[N; D], slopes: &[[N; D]; SLOPES], h: f64) -> [N; D] {
    let mut result = *start;
    for axis in 0..D {
        let own = [
            slopes[0][axis],
            slopes[1][axis],
            slopes[2][axis],
            slopes[3][axis],
            slopes[4][axis],
            slopes[5][axis],
            slopes[6][axis],
        ];
        result[axis] = combine(weights, start[axis], &own, h);
    }
    result
}

/// Tableau for loops that keep a state in registers for a whole step: compiled, or as [`Coefficients`].
pub trait TableauRows: Copy + Send + Sync {
    /// Whether the stages of a step are written out, so that slopes stay in registers.
    const WRITTEN_OUT: bool;
    /// [`ExplicitTableau::EVALUATIONS`].
    fn evaluations(self) -> usize;
    /// [`ExplicitTableau::ROWS`].
    fn row(self, stage: usize) -> &'static [f64];
    /// [`Tableau::ERRORS`].
    fn errors(self) -> &'static [f64];
}

/// Tableau for which loops are compiled.
#[derive(Debug)]
pub struct CompiledTableau<S>(PhantomData<fn() -> S>);

impl<S> CompiledTableau<S> {
    /// Value of the tableau.
    pub const NEW: Self = Self(PhantomData);
}

impl<S> Clone for CompiledTableau<S> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<S> Copy for CompiledTableau<S> {}

impl<S: ExplicitTableau> TableauRows for CompiledTableau<S> {
    const WRITTEN_OUT: bool = true;

    #[inline(always)]
    fn evaluations(self) -> usize {
        S::EVALUATIONS
    }

    #[inline(always)]
    fn row(self, stage: usize) -> &'static [f64] {
        S::ROWS[stage]
    }

    #[inline(always)]
    fn errors(self) -> &'static [f64] {
        S::ERRORS
    }
}

impl TableauRows for Coefficients {
    const WRITTEN_OUT: bool = false;

    #[inline(always)]
    fn evaluations(self) -> usize {
        self.evaluations
    }

    #[inline(always)]
    fn row(self, stage: usize) -> &'static [f64] {
        self.rows[stage]
    }

    #[inline(always)]
    fn errors(self) -> &'static [f64] {
        self.errors
    }
}

/// Right-hand side f of y' = f(y).
pub trait Slope<N, const D: usize> {
    /// Evaluates the slope at a state, for the evaluation with this number in the step.
    fn slope(&self, number: usize, state: [N; D]) -> [N; D];
}

/// Computes the state after a step of `h` seconds, and the slopes of the step.
#[inline(always)]
pub fn step<M: TableauRows, N: Number, F: Slope<N, D>, const D: usize>(
    method: M,
    f: &F,
    start: &[N; D],
    h: f64,
) -> ([N; D], [[N; D]; SLOPES]) {
    let mut slopes = [[N::constant(0.0); D]; SLOPES];
    macro_rules! stage {
        ($($stage:literal)*) => {
            $(if $stage < method.evaluations() {
                slopes[$stage] = f.slope($stage, combine_all(method.row($stage), start, &slopes, h));
            })*
        };
    }
    if M::WRITTEN_OUT {
        stage!(0 1 2 3 4 5 6);
    } else {
        for stage in 0..method.evaluations() {
            slopes[stage] = f.slope(stage, combine_all(method.row(stage), start, &slopes, h));
        }
    }
    (combine_all(method.row(method.evaluations()), start, &slopes, h), slopes)
}

/// Computes the estimated error of a step from its slopes, including the slope at its end.
#[inline(always)]
pub fn estimate<N: Number, const D: usize>(method: impl TableauRows, slopes: &[[N; D]; SLOPES], h: f64) -> [N; D] {
    combine_all(method.errors(), &[N::constant(0.0); D], slopes, h)
}

#[cfg(test)]
mod tests {
    use super::super::first_order::{FirstOrder, NAMES};
    use super::*;

    /// Test equation y' = λ y.
    struct Decay(f64);

    impl Slope<f64, 1> for Decay {
        fn slope(&self, _number: usize, [y]: [f64; 1]) -> [f64; 1] {
            [self.0 * y]
        }
    }

    /// Order test: errors of steps are C h^(p + 1), and estimates O(hᵏ) with the order k of the better method of a pair.
    #[test]
    fn every_method_of_first_order_has_a_tableau_of_its_order() {
        for name in NAMES {
            let method = FirstOrder::named(name).unwrap();
            let run = |h: f64| {
                with_tableau!(name, S => {
                    let method = CompiledTableau::<S>::NEW;
                    let ([end], mut slopes) = step(method, &Decay(-1.0), &[1.0], h);
                    slopes[S::EVALUATIONS.min(SLOPES - 1)] = [-end];
                    let values = Coefficients::named(name).unwrap();
                    assert_eq!(step(values, &Decay(-1.0), &[1.0], h).0, [end], "{name}");
                    (end - libm::exp(-h), estimate(method, &slopes, h)[0], <S as ExplicitTableau>::EVALUATIONS)
                }, panic!("{name} has none"))
            };
            let order = (run(0.2).0 / run(0.1).0).abs().log2() - 1.0;
            assert!((order - f64::from(method.order)).abs() < 0.2, "{name}: {order}");
            let stages = if method.is_stabilized() { 2 } else { method.stages(0.0, 0.0).len() };
            assert_eq!(run(0.1).2, stages, "{name}");
            if let Some(estimate) = &method.estimate {
                let order = (run(0.2).1 / run(0.1).1).abs().log2();
                assert!((order - f64::from(estimate.order)).abs() < 0.2, "{name}: {order}");
            }
        }
    }
}
