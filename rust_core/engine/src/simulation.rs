//! The simulation: a clock and a divergence monitor over a system.

mod adaptive;
mod checkpoint;
mod controlled;
mod division;
mod halving;
mod monitor;

pub use adaptive::{Adaptation, Course, StepSizeRule};
pub use checkpoint::Checkpoint;

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use crate::catalog::Catalog;
use crate::error::{Error, Result};
use crate::forces::Mach;
use crate::ledger::Ledger;
use crate::parallel::{Executor, SERIAL, ThreadPool};
use crate::plan::Plan;
use crate::scene::{Item, Scene};
use crate::simd::Level;
use crate::stability::{Horizon, Limit};
use crate::systems::{self, FieldInfo, Hints, Interval, RecordedSteps, Sample, System};
use monitor::{Monitor, StepSizes};

/// The numerical choices of a run.
#[derive(Debug, Clone)]
pub struct Numerics {
    /// The integrator.
    pub integrator: Item,
    /// Integrators of the further systems, by the systems' names or paths.
    pub integrators: BTreeMap<String, Item>,
    /// `f32` or `f64`.
    pub precision: String,
    /// Number of threads; None for all that the process may use.
    pub threads: Option<usize>,
    /// Divergence threshold: rise of the energy balance in units of the largest energy so far.
    pub max_energy_growth: f64,
    /// States that the divergence monitor diagnoses.
    pub vigilance: Vigilance,
}

/// States that the divergence monitor diagnoses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Vigilance {
    /// States with fields that are not finite.
    OutOfRange,
    /// States with more activity than any before.
    Active,
    /// Every state, at the cost of an energy budget per step.
    EveryStep,
}

impl Numerics {
    /// Number of threads that may be used.
    ///
    /// # Errors
    /// If it is 0, or the environment variable is not a number.
    pub fn threads(&self) -> Result<usize> {
        match self.threads {
            Some(0) => Err(Error::parameter("threads", "a whole number ≥ 1", 0)),
            Some(threads) => Ok(threads),
            None => ThreadPool::default_threads(),
        }
    }
}

/// The clock: a segment of equal steps.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Segment {
    /// Start time [s].
    pub start: f64,
    /// Number of steps of `dt` since then.
    pub steps: u64,
    /// Step size [s].
    pub dt: f64,
}

impl Segment {
    /// Present time [s].
    pub fn time(&self) -> f64 {
        self.start + self.steps as f64 * self.dt
    }
}

/// A running scene.
pub struct Simulation {
    system: Box<dyn System>,
    /// Facts about the system; only the amplitude may be out of date.
    hints: Hints,
    pool: ThreadPool,
    /// Machine epsilon of the state.
    epsilon: f64,
    adaptation: Adaptation,
    segment: Segment,
    /// Number of steps taken so far.
    steps: u64,
    monitor: Monitor,
    /// Certified limit of the time step at the start, once a step was tried.
    first: Option<Limit>,
    /// Whether forces were evaluated elsewhere since the system was initialized.
    moved: bool,
    /// Index of the field of the Mach number, if there is a fluid, and the largest value after a batch.
    mach: (Option<usize>, Option<Mach>),
}

/// Interval of polling for interrupts in a long call.
const POLL: Duration = Duration::from_millis(20);
/// Longest batch on the calling thread alone, without polling for interrupts [s].
const SHORT: f64 = 2e-3;
/// Shortest duration of a step that is divided among threads [s].
const WORTH_SHARING: f64 = 2e-4;

impl Simulation {
    /// Compiles a scene with the laws of a catalog.
    ///
    /// # Errors
    /// If the scene or the numerics are invalid or do not fit into memory, or on an interrupt.
    pub fn new(scene: &Scene, numerics: &Numerics, catalog: Catalog, executor: &Executor) -> Result<Self> {
        Level::check()?;
        let threads = numerics.threads()?;
        let system =
            systems::build(scene, (&numerics.integrator, &numerics.integrators), &numerics.precision, catalog, executor)?;
        let hints = system.hints();
        // An unconditionally unstable method may gain energy without limit; it serves to demonstrate the instability.
        let growth = if hints.gains_energy { f64::INFINITY } else { numerics.max_energy_growth };
        let threads = if system.cost() < WORTH_SHARING { 1 } else { threads };
        let mut simulation = Self {
            pool: ThreadPool::new(threads),
            epsilon: if numerics.precision == "f32" { f32::EPSILON.into() } else { f64::EPSILON },
            mach: (system.fields().iter().position(|field| field.name == "mach"), None),
            system,
            hints,
            adaptation: Adaptation::default(),
            segment: Segment::default(),
            steps: 0,
            monitor: Monitor::new(growth, numerics.vigilance),
            first: None,
            moved: false,
        };
        simulation.system.begin(0.0, executor)?;
        let energy = simulation.system.finite_audit(0.0, executor)?;
        simulation.monitor.begin(&energy, hints.lowest_potential, simulation.epsilon);
        simulation.monitor.expect_amplitude(hints.amplitude);
        Ok(simulation)
    }

    /// Plan of the simulation.
    pub fn plan(&self) -> Plan {
        Plan { threads: self.pool.threads(), simd: Level::current().name(), memory: self.memory(), stages: self.system.stages() }
    }

    /// Present memory [bytes].
    pub fn memory(&self) -> usize {
        self.system.bytes()
    }

    /// The present segment of the clock.
    pub fn segment(&self) -> Segment {
        self.segment
    }

    /// Number of steps taken so far.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// The present time [s].
    pub fn time(&self) -> f64 {
        self.segment.time()
    }

    /// Takes `steps` steps of `dt` seconds, polling `interrupted`.
    ///
    /// # Errors
    /// If a step fails: the simulation then stands at the last good step.
    pub fn step(&mut self, steps: u64, dt: f64, interrupted: &dyn Fn() -> bool) -> Result<()> {
        if !(dt.is_finite() && dt > 0.0) {
            return Err(Error::parameter("dt", "a finite number > 0", dt));
        }
        self.start(interrupted)?;
        let (before, first) = ((self.segment, self.monitor), self.steps);
        if dt != self.segment.dt {
            self.segment = Segment { start: self.time(), steps: 0, dt };
        }
        self.expect(dt);
        if !(Segment { steps: self.segment.steps.saturating_add(steps), ..self.segment }).time().is_finite() {
            self.segment = before.0;
            return Err(Error::parameter("dt", "steps that end at a time that is finite", format!("{steps} of {dt:e} s")));
        }
        let outcome = self.take(steps, interrupted);
        if outcome.is_err() && self.steps == first {
            (self.segment, self.monitor) = before;
        }
        outcome
    }

    /// Advances by `interval` seconds in steps chosen by a rule; the last one ends exactly there.
    ///
    /// # Errors
    /// As [`Simulation::step`].
    pub fn run(&mut self, interval: f64, rule: &StepSizeRule, interrupted: &dyn Fn() -> bool) -> Result<()> {
        self.cross(&mut Course::new(self.time(), interval), u64::MAX, rule, interrupted)
    }

    /// Initializes the system again before a further try of the very first step, which thus depends on the state alone. Finds the
    /// limit of the time step there, for the hint of a divergence.
    fn start(&mut self, interrupted: &dyn Fn() -> bool) -> Result<()> {
        if self.steps > 0 {
            return Ok(());
        }
        if std::mem::replace(&mut self.moved, true) {
            let (time, Self { system, pool, .. }) = (self.segment.time(), &mut *self);
            let mut outcome = Ok(());
            pool.run(interrupted, |executor| outcome = system.begin(time, executor)).and(outcome)?;
        }
        let limit = self.ask(interrupted, |system, time, executor| system.limit(Horizon::Certified, time, executor));
        self.first = match limit {
            Err(error @ (Error::Interrupted | Error::Callback { .. })) => return Err(error),
            // The step itself fails too, if the state is out of range.
            other => other.ok(),
        };
        Ok(())
    }

    fn take(&mut self, steps: u64, interrupted: &dyn Fn() -> bool) -> Result<()> {
        let (mut left, mut polled) = (steps, Instant::now());
        while left > 0 {
            let (division, first) = (self.division().cloned(), self.steps);
            let taken = self.divide_next(interrupted).and_then(|most| {
                let most = left.min(most).min(self.hints.most_steps);
                self.batch(most, StepSizes::Equal, interrupted).map_err(|error| self.with_hint(error, interrupted))
            });
            if taken.is_err() && self.steps == first {
                self.set_division(division);
            }
            left -= taken?;
            if left > 0 && polled.elapsed() >= POLL {
                if interrupted() {
                    return Err(Error::Interrupted);
                }
                polled = Instant::now();
            }
        }
        Ok(())
    }

    /// Takes all of the steps, or none.
    fn advance(&mut self, steps: u64, record: RecordedSteps, interrupted: &dyn Fn() -> bool) -> Result<()> {
        let interval = Interval { start: self.segment.start, first: self.segment.steps, h: self.segment.dt, steps };
        let Self { system, pool, hints, .. } = self;
        let outcome = if !hints.iterates && system.cost() * steps as f64 <= SHORT {
            system.advance(interval, record, &Executor::serial())
        } else {
            let mut outcome = Ok(());
            let ran = pool.run(interrupted, |executor| outcome = system.advance(interval, record, executor));
            if ran.is_err() && outcome.is_ok() {
                system.rollback(); // The interrupt came between the last poll and the end of the batch.
            }
            ran.and(outcome)
        };
        outcome?;
        self.segment.steps += steps;
        self.steps += steps;
        Ok(())
    }

    /// Rolls back the last [`Simulation::advance`], of `steps` steps.
    fn rollback(&mut self, steps: u64) {
        self.system.rollback();
        self.segment.steps -= steps;
        self.steps -= steps;
    }

    /// The state of the step-size control.
    pub fn adaptation(&self) -> Adaptation {
        self.adaptation
    }

    /// Quantities that can be read.
    pub fn fields(&self) -> Vec<FieldInfo> {
        self.system.fields()
    }

    /// Values of a field, element by element in the caller's order; None if there is no such field.
    pub fn read(&self, name: &str) -> Option<(FieldInfo, Vec<f64>)> {
        let fields = self.system.fields();
        let index = fields.iter().position(|field| field.name == name)?;
        let values = self.system.read(index, self.time());
        Some((fields.into_iter().nth(index)?, values))
    }

    /// Replaces fields by name; the change of energy counts as work.
    ///
    /// # Errors
    /// As [`System::write`].
    pub fn write(&mut self, fields: &[(&str, &[f64])], executor: &Executor) -> Result<()> {
        let time = self.time();
        self.system.write(fields, time, executor)?;
        self.monitor.expect_amplitude(self.system.hints().amplitude);
        Ok(())
    }

    /// Largest Mach number after a batch, if there is a fluid.
    pub fn mach(&self) -> Option<Mach> {
        self.mach.1
    }

    /// Updates the largest Mach number by that of the present state.
    fn observe_mach(&mut self) {
        let Some(field) = self.mach.0 else { return };
        let mut values = [0.0; 2];
        self.system.read_into(field, self.time(), &mut values);
        let [fast, sound] = values;
        let mach = (sound > 0.0).then_some(Mach { fast, sound });
        if mach > self.mach.1 {
            self.mach.1 = mach;
        }
    }

    /// Whether the energy budget and the limits may take long to compute.
    pub fn is_long(&self) -> bool {
        self.system.cost() >= WORTH_SHARING
    }

    /// Energy budget of the present state.
    ///
    /// # Errors
    /// If a user-defined function fails, on an interrupt, or if the last step diverged and no evaluation has noticed it yet.
    pub fn energy(&self, executor: &Executor) -> Result<Ledger> {
        self.system.audit(self.time(), executor).map_err(|error| self.or_divergence(error))
    }

    /// Limit of the time step.
    ///
    /// # Errors
    /// As [`Simulation::energy`].
    pub fn limit(&self, horizon: Horizon, executor: &Executor) -> Result<Limit> {
        self.system.limit(horizon, self.time(), executor)
    }

    /// Samples a field in space at some points.
    ///
    /// # Errors
    /// As [`System::sample`].
    pub fn sample(&self, sample: &Sample<'_>, executor: &Executor) -> Result<Vec<f64>> {
        self.system.sample(sample, executor)
    }

    /// Evaluates a function of the present state. If it may take long, runs on all threads and polls `interrupted`.
    fn ask<T: Send>(
        &mut self,
        interrupted: &dyn Fn() -> bool,
        question: impl FnOnce(&dyn System, f64, &Executor) -> Result<T> + Send,
    ) -> Result<T> {
        let (time, is_long) = (self.time(), self.is_long());
        let Self { system, pool, .. } = self;
        if !is_long {
            return question(system.as_ref(), time, &SERIAL);
        }
        let mut answer = Err(Error::Interrupted);
        pool.run(interrupted, |executor| answer = question(system.as_ref(), time, executor))?;
        answer
    }
}
