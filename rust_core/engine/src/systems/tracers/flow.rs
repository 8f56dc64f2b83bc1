//! Flows: the velocity fields that advance points.

use std::any::Any;

use super::law::{self, Outcome, VelocityLaw};
use super::points::Points;
use crate::error::Result;
use crate::integrators::explicit::Coefficients;
use crate::math::Real;
use crate::parallel::Executor;
use crate::systems::Interval;

/// Velocity field in which points move, x' = v(x, t).
pub trait Flow<T, const D: usize>: Any + Send + Sync {
    /// Name, for plans.
    fn name(&self) -> &'static str;

    /// Estimated duration of an evaluation at a point [s].
    fn cost(&self) -> f64;

    /// Maximum number of steps of a batch, by a method of so many evaluations.
    fn most_steps(&self, _evaluations: usize) -> u64 {
        u64::MAX
    }

    /// Description of the layout, for plans.
    fn layout(&self) -> &'static str;

    /// Checks the initial positions.
    ///
    /// # Errors
    /// If the velocity there cannot be evaluated, or is not finite.
    fn begin(&self, _points: &Points<T, D>, _time: f64) -> Result<()> {
        Ok(())
    }

    /// Takes the steps of an interval by a method.
    ///
    /// # Errors
    /// If the velocity cannot be evaluated, or on an interrupt.
    fn advance(
        &mut self,
        method: Coefficients,
        points: &mut Points<T, D>,
        interval: Interval,
        executor: &Executor,
    ) -> Result<Outcome>;

    /// Velocities of the points.
    ///
    /// # Errors
    /// If they cannot be evaluated.
    fn velocities(&self, points: &Points<T, D>, time: f64) -> Result<Points<T, D>>;

    /// Largest |∇v| at all points [1/s].
    ///
    /// # Errors
    /// As [`Flow::velocities`], or on an interrupt.
    fn steepest(&self, points: &Points<T, D>, time: f64, executor: &Executor) -> Result<f64>;

    /// Hamiltonian [m⁴/s²], if there is one.
    fn hamiltonian(&self, _points: &Points<T, D>) -> Option<f64> {
        None
    }

    /// Memory [bytes].
    fn bytes(&self) -> usize {
        0
    }
}

/// Flow with a law that is known from the start.
pub struct Known<L> {
    /// Name, for plans.
    pub name: &'static str,
    /// Velocity field v.
    pub law: L,
}

impl<T: Real, L: VelocityLaw<T, D> + 'static, const D: usize> Flow<T, D> for Known<L> {
    fn name(&self) -> &'static str {
        self.name
    }

    fn cost(&self) -> f64 {
        2e-10 + 4e-11 * size_of::<T>() as f64
    }

    fn layout(&self) -> &'static str {
        "blocks of tracers in the cache, each through all steps of a batch"
    }

    fn advance(
        &mut self,
        method: Coefficients,
        points: &mut Points<T, D>,
        interval: Interval,
        executor: &Executor,
    ) -> Result<Outcome> {
        let (law, Interval { h, steps, .. }) = (self.law, interval);
        let outcome = law::advance(law, method, points, h, steps, executor);
        executor.check()?;
        Ok(outcome)
    }

    fn velocities(&self, points: &Points<T, D>, _time: f64) -> Result<Points<T, D>> {
        let mut out = points.clone();
        law::velocities(self.law, 0, points, &mut out, &crate::parallel::SERIAL);
        Ok(out)
    }

    fn steepest(&self, points: &Points<T, D>, _time: f64, executor: &Executor) -> Result<f64> {
        let steepest = law::steepest(self.law, 0, points, executor);
        executor.check()?;
        Ok(steepest)
    }
}
