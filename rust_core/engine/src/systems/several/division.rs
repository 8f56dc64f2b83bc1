//! Division of the steps of a scene into equal substeps of each system whose own limit is smaller.
//!
//! A system takes steps undivided up to its limit in the present state, as it does alone. Its substeps are within the smaller
//! limit that holds for all directions of springs.

use std::any::Any;

use super::{RecordedSteps, Several, System};
use crate::error::{Error, Result};
use crate::parallel::Executor;
use crate::stability::Horizon;

/// Largest number of substeps.
const MOST: f64 = (1 << 20) as f64;
/// Ratio of a limit to an earlier one at which it replaces this one. Substeps change rarely then, and their method keeps its
/// long-term behavior.
const RECOVERED: f64 = 2.0;
/// Largest number of steps between two searches of limits that vary.
const SELDOM: f64 = 8.0;
/// Time between two searches of limits that vary, in units of the smallest one.
const SOON: f64 = 2.0;

/// Division of steps among several systems.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Division {
    /// Size of the steps [s]; 0 if they are not divided.
    pub h: f64,
    /// Limit of the substeps of each system [s]; infinite for undivided systems.
    pub limits: Vec<f64>,
    /// Number of steps in the clock's segment from which on limits that vary are out of date; the largest number if none varies.
    pub until: u64,
}

impl Division {
    /// Number of equal substeps of a system in each step.
    pub fn substeps(&self, system: usize) -> u64 {
        let substeps = self.limits.get(system).map_or(1.0, |limit| (self.h / limit).ceil());
        if substeps > 1.0 { substeps.min(MOST) as u64 } else { 1 }
    }

    /// Note for the plan on a system that divides its steps.
    pub fn note(&self, system: usize, name: &str) -> Option<String> {
        let (substeps, h) = (self.substeps(system), self.h);
        let note = || {
            let limit = self.limits[system];
            format!("{name} takes {substeps} equal substeps per step of {h:.3e} s: its own limit is {limit:.3e} s")
        };
        (substeps > 1).then(note)
    }

    /// Recorded steps of a system for the given ones of the scene. Records of all substeps of one long step could be large.
    pub fn recorded(&self, system: usize, steps: u64, record: RecordedSteps) -> RecordedSteps {
        match record {
            _ if self.substeps(system) == 1 => record,
            RecordedSteps::EveryStep | RecordedSteps::Sampled if steps > 1 => RecordedSteps::EveryStep,
            _ => RecordedSteps::LastStep,
        }
    }
}

impl Several {
    /// Systems of a simulation, if there is more than one.
    pub fn of(system: &dyn System) -> Option<&Self> {
        (system as &dyn Any).downcast_ref::<Self>().filter(|several| several.parts.len() > 1)
    }

    /// Mutable systems of a simulation, if there is more than one.
    pub fn of_mut(system: &mut dyn System) -> Option<&mut Self> {
        (system as &mut dyn Any).downcast_mut::<Self>().filter(|several| several.parts.len() > 1)
    }

    /// Present division of steps.
    pub fn division(&self) -> &Division {
        &self.division
    }

    /// Divides the following steps.
    pub fn divide(&mut self, division: Division) {
        self.division = division;
    }

    /// Division of steps of `h` seconds from the present state, after a number of steps in the clock's segment.
    ///
    /// # Errors
    /// If a user-defined function fails, or on an interrupt.
    pub fn divided(&self, h: f64, steps: u64, time: f64, executor: &Executor) -> Result<Division> {
        let limits = vec![f64::INFINITY; self.parts.len()];
        self.found(Division { h, limits, until: 0 }, |_| true, (steps, time), executor)
    }

    /// Division of further steps from the present state, by limits that vary.
    ///
    /// # Errors
    /// As [`Several::divided`].
    pub fn divided_further(&self, steps: u64, time: f64, executor: &Executor) -> Result<Division> {
        self.found(self.division.clone(), |varies| varies, (steps, time), executor)
    }

    /// Finds the limits of systems anew, chosen by whether they vary.
    fn found(
        &self,
        mut division: Division,
        is_sought: impl Fn(bool) -> bool,
        (steps, time): (u64, f64),
        executor: &Executor,
    ) -> Result<Division> {
        division.until = u64::MAX;
        for (system, limit) in division.limits.iter_mut().enumerate().filter(|(system, _)| !self.is_coupled(*system)) {
            let varies = self.parts[system].system.limit_varies(Horizon::Certified, time);
            if is_sought(varies) {
                let certified = self.own_limit(system, Horizon::Certified, time, executor)?;
                let sharp = || self.own_limit(system, Horizon::Sharp, time, executor);
                let is_undivided = limit.is_infinite() && (division.h <= certified || division.h <= sharp()?);
                *limit = succeeding(*limit, if is_undivided { f64::INFINITY } else { certified });
                let wait = (SOON * certified / division.h).clamp(1.0, SELDOM) as u64;
                division.until = if varies { division.until.min(steps + wait) } else { division.until };
            }
        }
        Ok(division)
    }

    /// Whether a system takes the same steps as another one.
    fn is_coupled(&self, system: usize) -> bool {
        self.couplings.iter().any(|coupling| coupling.systems().contains(&system))
    }

    /// Limit of a system's steps [s]; infinite if it is unstable at any size, or if its state is out of range.
    fn own_limit(&self, system: usize, horizon: Horizon, time: f64, executor: &Executor) -> Result<f64> {
        match self.parts[system].system.limit(horizon, time, executor) {
            Err(error @ (Error::Interrupted | Error::Callback { .. })) => Err(error),
            Ok(limit) if limit.dt() > 0.0 => Ok(limit.dt()),
            _ => Ok(f64::INFINITY),
        }
    }
}

/// Limit of substeps that succeeds a kept one [s].
fn succeeding(kept: f64, found: f64) -> f64 {
    if found < kept || found >= RECOVERED * kept { found } else { kept }
}
