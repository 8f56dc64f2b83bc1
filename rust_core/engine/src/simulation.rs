//! The simulation: a clock and a divergence monitor over a system.

mod adaptive;
mod checkpoint;
mod controlled;
mod monitor;

pub use adaptive::{Adaptation, Rule};
pub use checkpoint::Checkpoint;

use std::time::{Duration, Instant};

use glam::DVec3;

use crate::error::{Error, Result};
use crate::forces::Mach;
use crate::ledger::Ledger;
use crate::parallel::{Executor, SERIAL, ThreadPool};
use crate::plan::Plan;
use crate::scene::Scene;
use crate::simd::Level;
use crate::stability::{Horizon, Limit};
use crate::systems::{self, FieldInfo, Interval, Record, System};
use monitor::{Monitor, Steps};

/// How to compute.
#[derive(Debug, Clone)]
pub struct Numerics {
    /// The integrator's name.
    pub integrator: String,
    /// `f32` or `f64`.
    pub precision: String,
    /// The number of threads; None for all that the process may use.
    pub threads: Option<usize>,
    /// A run counts as diverged when the energy balance has risen by this many times the largest energy so far.
    pub max_energy_growth: f64,
    /// Which states the divergence monitor diagnoses.
    pub vigilance: Vigilance,
}

/// Which states the divergence monitor diagnoses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Vigilance {
    /// Those whose fields are not finite.
    OutOfRange,
    /// Those with more activity than the motion has shown so far.
    Active,
    /// Each one, at the cost of a budget per step.
    EveryStep,
}

impl Numerics {
    /// The number of threads that may be used.
    ///
    /// # Errors
    /// If none may, or the environment says no number.
    pub fn threads(&self) -> Result<usize> {
        match self.threads {
            Some(0) => Err(Error::parameter("threads", "a whole number ≥ 1", 0)),
            Some(threads) => Ok(threads),
            None => ThreadPool::default_threads(),
        }
    }
}

/// The clock: equal steps since a time.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Segment {
    /// When it began [s].
    pub start: f64,
    /// The number of steps of `dt` since then.
    pub steps: u64,
    /// Their length [s].
    pub dt: f64,
}

impl Segment {
    /// The time now [s].
    pub fn time(&self) -> f64 {
        self.start + self.steps as f64 * self.dt
    }
}

/// A running scene.
pub struct Simulation {
    system: Box<dyn System>,
    pool: ThreadPool,
    /// The distance from 1 to the next number of the state.
    epsilon: f64,
    adaptation: Adaptation,
    segment: Segment,
    /// All steps taken so far.
    steps: u64,
    monitor: Monitor,
    /// The fastest flow that the monitor has seen.
    mach: Option<Mach>,
}

/// How often a long call asks whether it was interrupted.
const POLL: Duration = Duration::from_millis(20);
/// The longest batch that the calling thread runs by itself, deaf to interrupts [s].
const SHORT: f64 = 2e-3;
/// The duration of a step that is worth sharing among threads [s].
const WORTH_SHARING: f64 = 2e-4;

impl Simulation {
    /// Compiles a scene.
    ///
    /// # Errors
    /// If the scene or the numerics make no sense or do not fit into memory, or the executor was asked to stop.
    pub fn new(scene: &Scene, numerics: &Numerics, executor: &Executor) -> Result<Self> {
        Level::check()?;
        let threads = numerics.threads()?;
        let system = systems::build(scene, &numerics.integrator, &numerics.precision, executor)?;
        // A method that is stable on no oscillator may gain energy as it likes: that is what it is shown for.
        let growth = if system.gains_energy() { f64::INFINITY } else { numerics.max_energy_growth };
        let threads = if system.cost() < WORTH_SHARING { 1 } else { threads };
        let mut simulation = Self {
            pool: ThreadPool::new(threads),
            epsilon: if numerics.precision == "f32" { f32::EPSILON.into() } else { f64::EPSILON },
            system,
            adaptation: Adaptation::default(),
            segment: Segment::default(),
            steps: 0,
            monitor: Monitor::new(growth, numerics.vigilance),
            mach: None,
        };
        simulation.system.begin(0.0, executor)?;
        let energy = simulation.system.finite_audit(0.0, executor)?;
        simulation.monitor.begin(&energy, simulation.epsilon);
        Ok(simulation)
    }

    /// What it does.
    pub fn plan(&self) -> Plan {
        Plan { threads: self.pool.threads(), simd: Level::current().name(), memory: self.memory(), stages: self.system.stages() }
    }

    /// The memory that it takes now [bytes].
    pub fn memory(&self) -> usize {
        self.system.bytes()
    }

    /// The time and how it was reached.
    pub fn segment(&self) -> Segment {
        self.segment
    }

    /// All steps taken so far.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    fn time(&self) -> f64 {
        self.segment.time()
    }

    /// Takes `steps` steps of `dt` seconds, asking now and then whether it was interrupted.
    ///
    /// # Errors
    /// If a step fails: the simulation then stands at the step before.
    pub fn step(&mut self, steps: u64, dt: f64, interrupted: &dyn Fn() -> bool) -> Result<()> {
        if !(dt.is_finite() && dt > 0.0) {
            return Err(Error::parameter("dt", "a finite number > 0", dt));
        }
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

    /// Advances by `interval` seconds in steps that a rule chooses; the last one ends exactly there.
    ///
    /// # Errors
    /// As [`Simulation::step`].
    pub fn run(&mut self, interval: f64, rule: &Rule, interrupted: &dyn Fn() -> bool) -> Result<()> {
        self.advance_adaptively(interval, rule, interrupted)
    }

    fn take(&mut self, steps: u64, interrupted: &dyn Fn() -> bool) -> Result<()> {
        let (mut left, mut polled) = (steps, Instant::now());
        while left > 0 {
            let most = left.min(self.system.most_steps());
            left -= self.batch(most, Steps::Equal, interrupted).map_err(|error| self.with_hint(error, interrupted))?;
            if left > 0 && polled.elapsed() >= POLL {
                if interrupted() {
                    return Err(Error::Interrupted);
                }
                polled = Instant::now();
            }
        }
        Ok(())
    }

    /// Takes steps, or none of them if that fails.
    fn advance(&mut self, steps: u64, record: Record, interrupted: &dyn Fn() -> bool) -> Result<()> {
        let interval = Interval { start: self.segment.start, first: self.segment.steps, h: self.segment.dt, steps };
        let Self { system, pool, .. } = self;
        let outcome = if system.cost() * steps as f64 <= SHORT {
            system.advance(interval, record, &Executor::serial())
        } else {
            let mut outcome = Ok(());
            pool.run(interrupted, |executor| outcome = system.advance(interval, record, executor)).and(outcome)
        };
        outcome?;
        self.segment.steps += steps;
        self.steps += steps;
        Ok(())
    }

    /// Goes back to before the last [`Simulation::advance`], of `steps` steps.
    fn rollback(&mut self, steps: u64) {
        self.system.rollback();
        self.segment.steps -= steps;
        self.steps -= steps;
    }

    /// What adaptive steps remember.
    pub fn adaptation(&self) -> Adaptation {
        self.adaptation
    }

    /// The quantities that can be read.
    pub fn fields(&self) -> Vec<FieldInfo> {
        self.system.fields()
    }

    /// The values of a field, element by element in the caller's order; None if there is no such field.
    pub fn read(&self, name: &str) -> Option<(FieldInfo, Vec<f64>)> {
        let fields = self.system.fields();
        let index = fields.iter().position(|field| field.name == name)?;
        let values = self.system.read(index);
        Some((fields.into_iter().nth(index)?, values))
    }

    /// Replaces fields by name; the change of energy counts as work.
    ///
    /// # Errors
    /// As [`System::write`].
    pub fn write(&mut self, fields: &[(&str, &[f64])], executor: &Executor) -> Result<()> {
        let time = self.time();
        self.system.write(fields, time, executor)
    }

    /// The fastest flow of a fluid that was seen where the monitor looked, if there is a fluid.
    pub fn mach(&self) -> Option<Mach> {
        self.mach
    }

    /// Whether its budget and its limits may take long to find.
    pub fn is_long(&self) -> bool {
        self.system.cost() >= WORTH_SHARING
    }

    /// The energy budget now.
    ///
    /// # Errors
    /// If a function of the user's fails, or the executor was asked to stop.
    pub fn energy(&self, executor: &Executor) -> Result<Ledger> {
        self.system.audit(self.time(), executor)
    }

    /// The momentum [kg·m/s] and the angular momentum about the origin of coordinates [kg·m²/s].
    pub fn momenta(&self) -> (DVec3, DVec3) {
        self.system.momenta()
    }

    /// The limit of the time step.
    ///
    /// # Errors
    /// As [`Simulation::energy`].
    pub fn limit(&self, horizon: Horizon, executor: &Executor) -> Result<Limit> {
        self.system.limit(horizon, self.time(), executor)
    }

    /// Finds something out about the present state, on all threads and asking `interrupted` meanwhile whether to stop where it
    /// may take long.
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
