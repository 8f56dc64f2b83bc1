//! Matter: particles and what acts on them, advanced by an integrator.

mod activity;
mod collisions;
mod coupled;
mod displacement;
mod dynamics;
mod independent;
mod kernels;

pub use dynamics::Dynamics;

use activity::Activity;
use coupled::Workspace;

use crate::error::{Error, Result};
use crate::integrators::Integrator;
use crate::math::Vector;
use crate::matter::{Columns, Matter};
use crate::parallel::{Executor, SERIAL, ThreadPool};

/// Which activities of a batch are recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Record {
    /// Those of all steps.
    EveryStep,
    /// Those of all steps, but under an inverse-square law alone, where it takes a tenth of the time of a step: there that of
    /// every 32nd.
    Sampled,
    /// That of the last step at least: all that is known where linear laws run in registers.
    LastStep,
}

/// Equal steps to take.
#[derive(Debug, Clone, Copy)]
pub struct Interval {
    /// When the clock's segment began [s].
    pub start: f64,
    /// The steps taken in that segment before these.
    pub first: u64,
    /// The length of each [s].
    pub h: f64,
    /// Their number.
    pub steps: u64,
}

impl Interval {
    /// The time at a fraction of one of the steps [s]: the same bits however the steps are cut into intervals.
    pub fn time(&self, step: u64, node: f64) -> f64 {
        self.start + ((self.first + step) as f64 + node) * self.h
    }
}

/// How long a batch of steps should take [s]: long enough that what is done once per batch costs little, short enough that
/// little is lost when somebody interrupts it.
const BATCH: f64 = 0.05;
/// The longest job that the calling thread does by itself, deaf to interrupts [s].
const SHORT: f64 = 2e-3;
/// The work that is worth sharing among threads [s].
const WORTH_SHARING: f64 = 2e-4;
/// Particles in a block that runs many steps: position, velocity and memory in three dimensions fit into the first-level
/// cache.
const INDEPENDENT_BLOCK: usize = 512;
/// Particles in a block that looks at its neighbors: large against the rows of a grid that it shares with other blocks,
/// small against the second-level cache.
const COUPLED_BLOCK: usize = 4096;

/// Particles with their law of motion.
pub struct MatterSystem<V: Vector> {
    dynamics: Dynamics<V>,
    state: Matter<V>,
    /// The state at the last batch's start.
    kept: Matter<V>,
    activity: Activity,
    workspace: Option<Workspace<V>>,
    stepper: Box<dyn Stepper<V>>,
    pool: ThreadPool,
    /// A rough idea of what a step costs [s].
    cost: f64,
}

impl<V: Vector> MatterSystem<V> {
    /// The number of particles in a block, for independent particles or others.
    pub fn block<I: Integrator>(independent: bool) -> usize {
        match (independent, I::REGISTERS) {
            (false, _) => COUPLED_BLOCK,
            (true, 0..=2) => INDEPENDENT_BLOCK,
            // More memory per particle, fewer particles in the same cache.
            (true, _) => INDEPENDENT_BLOCK / 2,
        }
    }

    /// A system at a given state.
    pub fn new<I: Integrator>(dynamics: Dynamics<V>, mut state: Matter<V>, threads: usize) -> Self {
        // What is only kept between the stages of a step need not outlive a block that runs through whole steps.
        let kept = if dynamics.is_independent() { I::READABLE } else { I::REGISTERS };
        state.registers = vec![Columns::zeros(state.count()); kept];
        let count = state.count() as f64;
        // Nanoseconds on a common core; only the sizes of batches hang on them, never a bit of the result.
        let per_particle = if dynamics.is_fused() && dynamics.contacts.is_none() { 1.0 } else { 8.0 };
        let per_stage = 500.0 + count * per_particle + 6.0 * dynamics.pairs() as f64;
        let cost = 1e-9 * I::NODES.len() as f64 * per_stage;
        let threads = if cost < WORTH_SHARING { 1 } else { threads };
        let workspace =
            (!dynamics.is_independent()).then(|| Workspace::new(state.count(), state.tallies.len(), dynamics.contacts.is_some()));
        let kept = state.clone();
        let stepper = Box::new(By::<I>(std::marker::PhantomData));
        let mut system = Self {
            dynamics,
            state,
            kept,
            activity: Activity::default(),
            workspace,
            stepper,
            pool: ThreadPool::new(threads),
            cost,
        };
        let blocks = if system.workspace.is_none() { system.state.tallies.len() } else { 0 };
        system.activity = Activity::new(blocks, system.batch().min(system.most_recorded()));
        system
    }

    /// What acts.
    pub fn dynamics(&self) -> &Dynamics<V> {
        &self.dynamics
    }

    /// The state.
    pub fn state(&self) -> &Matter<V> {
        &self.state
    }

    /// The state, to change between runs; [`MatterSystem::begin`] or [`MatterSystem::resume`] must follow.
    pub fn state_mut(&mut self) -> &mut Matter<V> {
        &mut self.state
    }

    /// The number of threads that it uses.
    pub fn threads(&self) -> usize {
        self.pool.threads()
    }

    /// The number of steps in a batch: as many as fit into [`BATCH`], but not so few that moving the state in and out of the
    /// caches, or keeping a copy of it, takes longer than the steps. An interrupt abandons a batch between two blocks. A
    /// function of the user's is called in the order of time and never again for the same step, so it takes one at a time.
    pub fn batch(&self) -> u64 {
        let least = match &self.workspace {
            _ if self.dynamics.callbacks() > 0 => return 1,
            None if self.dynamics.is_fused() => 200.0,
            None => 25.0,
            Some(_) => 5.0,
        };
        (BATCH / self.cost).clamp(least, 1e6) as u64
    }

    /// The most steps in a batch in which the activity after every one is recorded.
    pub fn most_recorded(&self) -> u64 {
        Activity::most_steps(self.state.tallies.len())
    }

    /// Whether what acts on each particle is linear in its position and velocity and the same at all times. Steps of at most
    /// half of the limit of stability then never double the energy: the invariant of an oscillator's step is elongated by
    /// 1/√(1 − ½²) at the most.
    pub fn is_linear(&self) -> bool {
        self.workspace.is_none() && self.dynamics.is_fused() && self.dynamics.contacts.is_none()
    }

    /// The memory that it takes [bytes].
    pub fn bytes(&self) -> usize {
        let workspace = self.workspace.as_ref().map_or(0, Workspace::bytes);
        let properties = self.state.count() * (5 * size_of::<f64>() + 2 * size_of::<V::Scalar>());
        self.dynamics.bytes() + self.state.bytes() + self.kept.bytes() + self.activity.bytes() + workspace + properties
    }

    /// Goes on from a state that is complete with what the integrator carries.
    pub fn resume(&mut self) {
        self.dynamics.observe(&self.state.velocity);
    }

    /// Begins anew from the positions and velocities: the integrator has nothing to carry on from.
    ///
    /// # Errors
    /// If it fails, or the executor was asked to stop.
    pub fn begin(&mut self, time: f64, executor: &Executor) -> Result<()> {
        self.resume();
        let Self { dynamics, state, kept, activity, workspace, stepper, .. } = self;
        kept.copy_from(state);
        let interval = Interval { start: time, first: 0, h: 0.0, steps: 0 };
        let record = (activity, Record::LastStep);
        stepper.begin(Job { dynamics, from: kept, state, record, workspace: workspace.as_mut(), interval }, executor)?;
        executor.check()
    }

    /// Takes steps, or none of them if it fails.
    pub fn advance(&mut self, interval: Interval, record: Record, interrupted: &dyn Fn() -> bool) -> Result<()> {
        let Self { dynamics, state, kept, activity, workspace, stepper, pool, cost } = self;
        activity.clear();
        dynamics.forces_mut().iter_mut().for_each(|force| force.keep());
        if workspace.is_some() {
            kept.copy_from(state);
        } else {
            std::mem::swap(kept, state);
        }
        let short = *cost * interval.steps as f64 <= SHORT;
        let mut outcome = Ok(());
        let mut job = |executor: &Executor| {
            let record = (&mut *activity, record);
            outcome =
                stepper.advance(Job { dynamics, from: kept, state, record, workspace: workspace.as_mut(), interval }, executor);
        };
        let ended = if short {
            job(&Executor::serial());
            Ok(())
        } else {
            pool.run(interrupted, job)
        };
        let outcome = ended.and(outcome);
        if outcome.is_err() {
            self.rollback()?;
        }
        outcome
    }

    /// Whether it takes long to go through all of the forces.
    pub fn is_long(&self) -> bool {
        self.cost >= WORTH_SHARING
    }

    /// Finds something out that may take long, and asks `interrupted` meanwhile whether to stop.
    ///
    /// # Errors
    /// If it fails, or was stopped.
    pub fn ask<T: Send>(
        &mut self,
        interrupted: &dyn Fn() -> bool,
        question: impl FnOnce(&Dynamics<V>, &Matter<V>, &Executor) -> Result<T> + Send,
    ) -> Result<T> {
        let is_long = self.is_long();
        let Self { dynamics, state, pool, .. } = self;
        if !is_long {
            return question(dynamics, state, &SERIAL);
        }
        let mut answer = Err(Error::Interrupted);
        pool.run(interrupted, |executor| answer = question(dynamics, state, executor))?;
        answer
    }

    /// Goes back to the state before the last [`MatterSystem::advance`].
    pub fn rollback(&mut self) -> Result<()> {
        std::mem::swap(&mut self.kept, &mut self.state);
        self.dynamics.forces_mut().iter_mut().try_for_each(|force| force.undo())
    }

    /// What the forces keep from step to step.
    pub fn recollection(&self) -> Vec<f64> {
        self.dynamics.forces().iter().flat_map(|force| force.capture()).collect()
    }

    /// Goes on from what the forces kept.
    pub fn recollect(&mut self, mut numbers: &[f64]) -> Result<()> {
        self.dynamics.forces_mut().iter_mut().try_for_each(|force| force.restore(&mut numbers))?;
        if numbers.is_empty() { Ok(()) } else { Err(Error::State("it holds more than the forces of this scene keep".to_owned())) }
    }

    /// The activity after each step of the last advance, or after its last step alone [J]: not a number, or infinite, where
    /// a velocity is, or at the end a position.
    pub fn activity(&self) -> &[f64] {
        self.activity.steps()
    }
}

/// What a stepper works on.
struct Job<'a, V: Vector> {
    dynamics: &'a mut Dynamics<V>,
    /// The state at the beginning, which stays as it is.
    from: &'a Matter<V>,
    state: &'a mut Matter<V>,
    /// Where the activity goes, and which.
    record: (&'a mut Activity, Record),
    workspace: Option<&'a mut Workspace<V>>,
    interval: Interval,
}

/// An integrator with its type erased, once for whole batches.
trait Stepper<V: Vector>: Send + Sync {
    /// Evaluates the law at the state and fills the carried memory.
    fn begin(&self, job: Job<'_, V>, executor: &Executor) -> Result<()>;
    /// Takes all steps of the interval.
    fn advance(&self, job: Job<'_, V>, executor: &Executor) -> Result<()>;
}

struct By<I>(std::marker::PhantomData<I>);

impl<V: Vector, I: Integrator> Stepper<V> for By<I> {
    fn begin(&self, Job { dynamics, from, state, workspace, interval, .. }: Job<'_, V>, executor: &Executor) -> Result<()> {
        if let Some(workspace) = workspace {
            return coupled::begin::<V, I>(dynamics, state, workspace, interval, executor);
        }
        independent::begin::<V, I>(dynamics, from, state, interval);
        Ok(())
    }

    fn advance(&self, Job { dynamics, from, state, record, workspace, interval }: Job<'_, V>, executor: &Executor) -> Result<()> {
        if let Some(workspace) = workspace {
            return coupled::advance::<V, I>(dynamics, state, workspace, interval, record.0, executor);
        }
        independent::advance::<V, I>(dynamics, from, state, interval, record, executor);
        Ok(())
    }
}
