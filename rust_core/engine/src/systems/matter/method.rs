//! Methods: the time stepping of matter, and its stability limits.

use super::activity::Activity;
use super::constraints::{Constraints, DriftVelocity};
use super::coupled::Workspace;
use super::dynamics::Dynamics;
use super::step::MatterStep;
use super::stepper::Stepper;
use super::{coupled, independent};
use crate::error::{Error, Result};
use crate::forces::Space;
use crate::history::History;
use crate::integrators::Integrator;
use crate::matter::{Columns, Matter};
use crate::parallel::Executor;
use crate::scene::Item;
use crate::stability::{Limit, LimitCache, SpectralBound};
use crate::systems::{Control, Interval, RecordedSteps};

/// Angle by which a method turns velocities in a magnetic field in a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Angle {
    /// 2 atan(|q B| h/2m).
    Boris,
    /// |q B| h/m.
    Exact,
}

/// Treatment of springs by a method.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Treatment {
    /// Springs are forces.
    Forces,
    /// Springs are forces; springs of infinite stiffness are rods that the method keeps at their lengths.
    Rods,
    /// Springs are forces whose derivatives the method uses to solve its equations.
    Solved,
    /// Springs are projections: the method moves particles onto them, so that they add no force.
    Projections,
}

/// Data of a method's steps.
pub struct Job<'a, V: Space> {
    pub dynamics: &'a mut Dynamics<V>,
    pub constraints: &'a mut Constraints<V>,
    /// Initial state, which does not change.
    pub from: &'a Matter<V>,
    pub state: &'a mut Matter<V>,
    /// Activity to record, and the recorded steps.
    pub record: (&'a mut Activity, RecordedSteps),
    /// Buffers of sweeps, for coupled particles.
    pub workspace: Option<&'a mut Workspace<V>>,
    pub interval: Interval,
}

impl<'a, V: Space> Job<'a, V> {
    /// Coupled matter with the activity to record, and the interval; None for independent particles.
    pub fn coupled(self, executor: &'a Executor) -> Option<(MatterStep<'a, V>, &'a mut Activity, Interval)> {
        let Self { dynamics, constraints, state, record, workspace, interval, .. } = self;
        Some((MatterStep { dynamics, constraints, matter: state, workspace: workspace?, executor }, record.0, interval))
    }
}

/// Vectors that a method stores per particle.
#[derive(Debug, Clone, Copy, Default)]
pub struct MethodMemory {
    /// Number of registers in use between stages, and of registers that can be read after a step.
    pub registers: usize,
    pub readable: usize,
    /// Number of further vectors.
    pub own: usize,
    /// Whether the force by the damping of springs is kept apart; see [`Integrator::CORRECTED_WEIGHT`].
    pub damping: bool,
}

/// Reasons why a method refuses parts of a scene; None if it does not.
#[derive(Debug, Clone, Copy, Default)]
pub struct MethodRefusals {
    /// Fields that diffuse.
    pub fields: Option<&'static str>,
    /// Contacts and fluids, whose motion is not smooth.
    pub kinks: Option<&'static str>,
}

/// Properties of a method.
#[derive(Debug, Clone, Copy)]
pub struct MethodProperties {
    /// Name of the class in Python.
    pub name: &'static str,
    /// Orders of convergence: without velocity-dependent forces, and with dissipation.
    pub orders: [u32; 2],
    /// Number of evaluations of the forces per step.
    pub evaluations: usize,
    pub memory: MethodMemory,
    /// Whether each stage is a sweep over all particles, even if these are independent.
    pub sweeps: bool,
    /// Angle by which the method turns velocities in magnetic fields, if it does; see [`Integrator::GYRATES`].
    pub angle: Option<Angle>,
    /// Limit of the time step; see [`Integrator::limit`].
    pub limit: fn(f64) -> f64,
    /// Treatment of springs.
    pub springs: Treatment,
    /// Velocity of the drift that constraints change; None if the method carries no constraints.
    pub drift: Option<DriftVelocity>,
    pub refusals: MethodRefusals,
}

impl MethodProperties {
    /// Whether contacts are resolved within the drift, before the evaluation of forces; see [`Integrator::DRIFTS_FIRST`].
    pub fn drifts_first(&self) -> bool {
        matches!(self.drift, Some(DriftVelocity::Register(_)))
    }

    /// Refuses a method of smooth motion for a scene with kinks in its motion.
    ///
    /// # Errors
    /// If the method is for smooth motion alone.
    pub fn refuse_kinks(&self, found: &str) -> Result<()> {
        let Some(reason) = self.refusals.kinks else { return Ok(()) };
        let expected = format!("an explicit one, such as VelocityVerlet(), for a scene with {found}");
        Err(Error::parameter("integrator", expected, self.name).with_hint(reason))
    }
}

/// Time-stepping method for matter. Its history is the data that it stores itself from step to step, besides the registers.
pub trait Method<V: Space>: History + Send + Sync {
    /// Properties of the method.
    fn about(&self) -> MethodProperties;
    /// Number of registers that persist from step to step.
    fn persistent(&self) -> usize;
    /// Estimated error of the last step of `h` seconds, if the method has an estimate.
    fn error(&self, state: &Matter<V>, h: f64) -> Option<f64>;
    /// Control of the step size by the estimated error.
    fn control(&self) -> Control {
        Control::pair(self.about().orders[0])
    }
    /// Whether the method is unconditionally unstable on an oscillator.
    fn gains_energy(&self) -> bool;
    /// Converts a bound to the waves of a field as this method advances them.
    fn bound(&self, bound: SpectralBound) -> SpectralBound;
    /// Limit of the time step from a bound.
    fn limit(&self, bound: &SpectralBound, cache: &mut LimitCache) -> Limit;
    /// Limit of the time step, sharpened by the present directions of the springs.
    fn sharp_limit(&self, bound: SpectralBound) -> Limit;
    /// Note for the plan on the steps so far.
    fn note(&self) -> Option<String> {
        None
    }
    /// Memory of the data that the method stores itself [bytes].
    fn bytes(&self) -> usize {
        0
    }
    /// Updates the springs from the dynamics, after some have broken or are restored.
    fn take_springs(&mut self, _dynamics: &Dynamics<V>) {}
    /// Evaluates the dynamics at the state and fills the persistent registers.
    fn begin(&mut self, job: Job<'_, V>, executor: &Executor) -> Result<()>;
    /// Takes all steps of the interval.
    fn advance(&mut self, job: Job<'_, V>, executor: &Executor) -> Result<()>;
}

/// Explicit integrator.
pub struct Explicit<V: Space> {
    /// Angle of rotation; see [`MethodProperties::angle`].
    angle: Option<Angle>,
    pub stepper: Stepper<V>,
}

impl<V: Space> Explicit<V> {
    /// Builds the integrator of an item.
    ///
    /// # Errors
    /// If a value is wrong.
    pub fn declared<I: Integrator>(item: &Item) -> Result<Self> {
        let exact = I::GYRATES && item.flag("exact_angle")?;
        let angle = I::GYRATES.then_some(if exact { Angle::Exact } else { Angle::Boris });
        Ok(Self { angle, stepper: Stepper::of::<I>() })
    }
}

impl<V: Space> History for Explicit<V> {}

impl<V: Space> Method<V> for Explicit<V> {
    fn about(&self) -> MethodProperties {
        let facts = &self.stepper.facts;
        let drift = facts.drift_kick.filter(|_| facts.drifts_first);
        MethodProperties {
            name: facts.name,
            orders: [facts.order, facts.order_dissipative],
            evaluations: facts.stages(),
            memory: MethodMemory {
                registers: facts.registers,
                readable: facts.readable,
                own: 0,
                damping: facts.corrected_weight != 0.0,
            },
            sweeps: false,
            angle: self.angle,
            limit: facts.limit,
            springs: Treatment::Forces,
            drift: drift.map(|drift_kick| DriftVelocity::Register(drift_kick.velocity)),
            refusals: MethodRefusals { fields: facts.refuses_fields, kinks: None },
        }
    }

    fn persistent(&self) -> usize {
        self.stepper.facts.persistent
    }

    /// Largest position error, or velocity error times the step, over all particles [m].
    fn error(&self, state: &Matter<V>, h: f64) -> Option<f64> {
        let [x, v] = self.stepper.facts.error?.map(|register| &state.registers[register]);
        let length = |columns: &Columns<V>, index: usize| columns.get(index).widen().length();
        let errors = (0..state.count()).map(|index| length(x, index).max(h * length(v, index)));
        Some(errors.fold(0.0, f64::max))
    }

    fn gains_energy(&self) -> bool {
        self.stepper.facts.gains_energy()
    }

    fn bound(&self, bound: SpectralBound) -> SpectralBound {
        bound.stepped_by(&self.stepper.facts)
    }

    fn limit(&self, bound: &SpectralBound, cache: &mut LimitCache) -> Limit {
        bound.limit_after(&self.stepper.facts, cache)
    }

    fn sharp_limit(&self, bound: SpectralBound) -> Limit {
        bound.sharp_limit(&self.stepper.facts)
    }

    fn begin(&mut self, job: Job<'_, V>, executor: &Executor) -> Result<()> {
        if job.workspace.is_none() {
            independent::begin(&self.stepper, job.dynamics, job.from, job.state, job.interval);
            return Ok(());
        }
        let Some((mut step, _, interval)) = job.coupled(executor) else { return Ok(()) };
        coupled::begin(&self.stepper, &mut step, interval)
    }

    fn advance(&mut self, job: Job<'_, V>, executor: &Executor) -> Result<()> {
        if job.workspace.is_none() {
            let Job { dynamics, from, state, record, interval, .. } = job;
            independent::advance(&self.stepper, dynamics, from, state, interval, record, executor);
            return Ok(());
        }
        let Some((mut step, activity, interval)) = job.coupled(executor) else { return Ok(()) };
        coupled::advance(&self.stepper, &mut step, interval, activity)
    }
}
