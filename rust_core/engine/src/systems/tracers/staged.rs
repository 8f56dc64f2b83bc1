//! Steps of points whose velocities are evaluated for all points at once, stage by stage.

use super::law::Outcome;
use super::points::Points;
use crate::error::Result;
use crate::integrators::explicit::{Coefficients, SLOPES, combine};
use crate::math::Real;
use crate::simd::{Isa, Kernel, Number, Pack, dispatch};

/// Slopes of a step, and state at a stage.
pub struct Staged<T, const D: usize> {
    slopes: [Points<T, D>; SLOPES],
    state: Points<T, D>,
}

/// Step in an interval.
#[derive(Debug, Clone, Copy)]
pub struct Step {
    /// Step size [s].
    pub h: f64,
    /// Whether the error is estimated, if the method has an estimate.
    pub estimated: bool,
}

impl<T: Real, const D: usize> Staged<T, D> {
    /// Allocates memory for `count` points.
    pub fn new(count: usize) -> Self {
        Self { slopes: std::array::from_fn(|_| Points::zeros(count)), state: Points::zeros(count) }
    }

    /// Takes a step. The function `slope` evaluates the velocities at a stage, from the number of the stage and the state.
    ///
    /// # Errors
    /// The errors of `slope`. The points have then not moved.
    pub fn step(
        &mut self,
        method: Coefficients,
        points: &mut Points<T, D>,
        step: Step,
        mut slope: impl FnMut(usize, &Points<T, D>, &mut Points<T, D>) -> Result<()>,
    ) -> Result<Outcome> {
        let Self { slopes, state } = self;
        for stage in 0..method.evaluations {
            sum(method.rows[stage], Some(points), slopes, state, step.h);
            slope(stage, state, &mut slopes[stage])?;
        }
        sum(method.rows[method.evaluations], Some(points), slopes, state, step.h);
        let mut error = 0.0;
        if step.estimated && !method.errors.is_empty() {
            slope(method.evaluations, state, &mut slopes[method.evaluations])?;
        }
        std::mem::swap(points, state);
        if step.estimated && !method.errors.is_empty() {
            sum(method.errors, None, slopes, state, step.h);
            error = state.axes.iter().flatten().fold(0.0_f64, |most, value| value.to_f64().abs().max(most));
        }
        let finite = points.axes.iter().flatten().fold(0.0, |sum, &value| sum + 0.0 * value.to_f64());
        Ok(Outcome { finite, error })
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        self.slopes.iter().chain([&self.state]).map(Points::bytes).sum()
    }
}

/// Sums the slopes, multiplied by weights times h, and a state.
fn sum<T: Real, const D: usize>(
    weights: &'static [f64],
    start: Option<&Points<T, D>>,
    slopes: &[Points<T, D>; SLOPES],
    out: &mut Points<T, D>,
    h: f64,
) {
    for axis in 0..D {
        let start = start.map(|points| points.axes[axis].as_slice());
        let slopes = slopes.each_ref().map(|points| points.axes[axis].as_slice());
        dispatch(WeightedSum { weights, start, slopes, out: &mut out.axes[axis], h });
    }
}

struct WeightedSum<'a, T> {
    weights: &'static [f64],
    start: Option<&'a [T]>,
    slopes: [&'a [T]; SLOPES],
    out: &'a mut [T],
    h: f64,
}

impl<T: Real> Kernel for WeightedSum<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<I: Isa>(self, _isa: I) {
        let zero = <I::Pack<T> as Number>::constant(0.0);
        for at in (0..self.out.len()).step_by(<I::Pack<T> as Pack>::WIDTH) {
            let mut own = [zero; SLOPES];
            for slope in 0..self.weights.len() {
                own[slope] = <I::Pack<T> as Pack>::load(&self.slopes[slope][at..]);
            }
            let mut start = zero;
            if let Some(points) = self.start {
                start = <I::Pack<T> as Pack>::load(&points[at..]);
            }
            combine(self.weights, start, &own, self.h).store(&mut self.out[at..]);
        }
    }
}
