//! Division of steps of a given size among several systems. Limits are found at the start of each segment of the clock, after a
//! change of fields, and, where they vary, every few steps. The division is therefore a function of the trajectory.

use super::Simulation;
use crate::error::Result;
use crate::parallel::Executor;
use crate::systems::several::{Division, Several};

impl Simulation {
    /// Divides steps of `dt` seconds, and later steps of other sizes, among several systems: a system whose own limit is smaller
    /// takes equal substeps. The steps of a system alone are never divided, and neither are adaptive steps.
    ///
    /// # Errors
    /// If a user-defined function fails, or on an interrupt.
    pub fn divide(&mut self, dt: f64, interrupted: &dyn Fn() -> bool) -> Result<()> {
        let steps = self.segment.steps;
        self.divide_by(interrupted, |several, time, executor| several.divided(dt, steps, time, executor))
    }

    /// Divides the next steps if that is due, and returns the largest number of steps until it is due again.
    pub(super) fn divide_next(&mut self, interrupted: &dyn Fn() -> bool) -> Result<u64> {
        let (dt, steps) = (self.segment.dt, self.segment.steps);
        let Some(division) = self.division().filter(|division| division.h > 0.0) else { return Ok(u64::MAX) };
        if steps == 0 || division.h != dt {
            self.divide(dt, interrupted)?;
        } else if steps >= division.until {
            self.divide_by(interrupted, |several, time, executor| several.divided_further(steps, time, executor))?;
        }
        Ok(self.division().map_or(u64::MAX, |division| division.until.saturating_sub(steps).max(1)))
    }

    /// Divides the next steps by a function of the present state, if there are several systems.
    fn divide_by(
        &mut self,
        interrupted: &dyn Fn() -> bool,
        divided: impl FnOnce(&Several, f64, &Executor) -> Result<Division> + Send,
    ) -> Result<()> {
        let division = self.ask(interrupted, |system, time, executor| {
            Several::of(system).map(|several| divided(several, time, executor)).transpose()
        })?;
        self.set_division(division);
        Ok(())
    }

    /// Division of steps, if there are several systems.
    pub(super) fn division(&self) -> Option<&Division> {
        Several::of(&*self.system).map(Several::division)
    }

    /// Replaces the division of steps.
    pub(super) fn set_division(&mut self, division: Option<Division>) {
        if let (Some(several), Some(division)) = (Several::of_mut(&mut *self.system), division) {
            several.divide(division);
            self.hints = self.system.hints();
        }
    }
}
