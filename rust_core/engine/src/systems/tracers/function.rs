//! Velocity field of a user-defined function.

use std::sync::Arc;

use super::flow::Flow;
use super::law::Outcome;
use super::points::Points;
use super::staged::{Staged, Step};
use crate::error::{Error, Result};
use crate::integrators::explicit::Coefficients;
use crate::math::Real;
use crate::parallel::Executor;
use crate::scene::{Argument, Callback, Item};
use crate::systems::Interval;

/// Difference for derivatives, as a fraction of the largest coordinate.
const DIFFERENCE: f64 = 1e-6;

/// Velocity field v(t, x), called with all points at once.
pub struct VelocityFunction<T, const D: usize> {
    callback: Arc<dyn Callback>,
    path: String,
    staged: Staged<T, D>,
}

impl<T: Real, const D: usize> VelocityFunction<T, D> {
    /// Builds the function of an item, for `count` points.
    ///
    /// # Errors
    /// If the item has no function.
    pub fn declared(item: &Item, count: usize) -> Result<Self> {
        let path = format!("{}.function", item.path);
        Ok(Self { callback: item.callback("function")?, path, staged: Staged::new(count) })
    }
}

/// Velocities at rows of positions, as rows. An overflow belongs to a tracer that runs to infinity, as its position shows. A
/// velocity that is not a number is an error of the function.
fn call<const D: usize>(function: &dyn Callback, path: &str, time: f64, rows: &[f64]) -> Result<Vec<f64>> {
    let shape = [rows.len() / D, D];
    let arguments = [Argument::Number(time), Argument::Array { numbers: rows, shape: &shape }];
    let velocities = function.call(&arguments, "velocities", &shape).map_err(|failure| failure.at(path.to_owned()))?;
    let finite = |index: usize| rows[index * D..(index + 1) * D].iter().all(|value| value.is_finite());
    let undefined = |index: &usize| velocities[index * D..(index + 1) * D].iter().any(|value| value.is_nan());
    match (0..shape[0]).find(|index| undefined(index) && finite(*index)) {
        Some(tracer) => {
            let place = &rows[tracer * D..(tracer + 1) * D];
            let found = format!("NaN for tracer {tracer} at {place:?}, t = {time:?} s");
            Err(Error::undefined(path.to_owned(), "velocities that are numbers", found))
        }
        None => Ok(velocities),
    }
}

impl<T: Real, const D: usize> Flow<T, D> for VelocityFunction<T, D> {
    fn name(&self) -> &'static str {
        "a function"
    }

    /// Estimated duration of an evaluation per point [s], for a function of arrays with some thousands of points.
    fn cost(&self) -> f64 {
        1e-8
    }

    /// One step per batch, because the function may take long.
    fn most_steps(&self, _evaluations: usize) -> u64 {
        1
    }

    fn layout(&self) -> &'static str {
        "one call with all tracers per evaluation"
    }

    fn begin(&self, points: &Points<T, D>, time: f64) -> Result<()> {
        let velocities = call::<D>(&*self.callback, &self.path, time, &points.rows())?;
        if let Some(index) = velocities.iter().position(|&velocity| !T::from_f64(velocity).is_finite()) {
            let found = format!("{} for tracer {}", velocities[index], index / D);
            let expected = format!("velocities that are finite in {}", T::NAME);
            return Err(Error::parameter(self.path.clone(), expected, found));
        }
        Ok(())
    }

    fn advance(
        &mut self,
        method: Coefficients,
        points: &mut Points<T, D>,
        interval: Interval,
        executor: &Executor,
    ) -> Result<Outcome> {
        let Self { callback, path, staged } = self;
        let mut outcome = Outcome::default();
        for step in 0..interval.steps {
            executor.check()?;
            let size = Step { h: interval.h, estimated: interval.steps == 1 };
            let slope = |stage: usize, state: &Points<T, D>, out: &mut Points<T, D>| {
                let node = if stage < method.evaluations { method.nodes[stage] } else { 1.0 };
                out.fill(&call::<D>(&**callback, path, interval.time(step, node), &state.rows())?);
                Ok(())
            };
            outcome = outcome.and(staged.step(method, points, size, slope)?);
        }
        Ok(outcome)
    }

    fn velocities(&self, points: &Points<T, D>, time: f64) -> Result<Points<T, D>> {
        Ok(Points::from_rows(&call::<D>(&*self.callback, &self.path, time, &points.rows())?))
    }

    /// Largest |∇v| at all points [1/s], by differences.
    fn steepest(&self, points: &Points<T, D>, time: f64, executor: &Executor) -> Result<f64> {
        let rows = points.rows();
        let here = call::<D>(&*self.callback, &self.path, time, &rows)?;
        let largest = rows.iter().fold(0.0_f64, |most, value| value.abs().max(most));
        let step = DIFFERENCE * if largest > 0.0 { largest } else { 1.0 };
        let mut squares = vec![0.0; points.count];
        for axis in 0..D {
            executor.check()?;
            let mut moved = rows.clone();
            moved[axis..].iter_mut().step_by(D).for_each(|value| *value += step);
            let there = call::<D>(&*self.callback, &self.path, time, &moved)?;
            for (index, (one, other)) in here.iter().zip(&there).enumerate() {
                squares[index / D] += ((other - one) / step).powi(2);
            }
        }
        Ok(squares.into_iter().fold(0.0_f64, |most, square| square.sqrt().max(most)))
    }

    fn bytes(&self) -> usize {
        self.staged.bytes()
    }
}
