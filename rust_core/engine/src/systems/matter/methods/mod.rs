//! Methods: the time stepping of matter, and its stability limits.

mod collisions;
pub mod coupled;
mod displacement;
pub mod explicit;
pub mod implicit;
mod independent;
pub mod projection;
pub mod radau;
pub mod rattle;
pub mod stepper;

use super::activity::Activity;
use super::constraints::{Constraints, DriftVelocity};
use super::dynamics::Dynamics;
use super::step::MatterStep;
use crate::catalog::Space;
use crate::error::{Error, Result};
use crate::history::History;
use crate::matter::Matter;
use crate::parallel::Executor;
use crate::stability::{Limit, LimitCache, SpectralBound};
use crate::systems::{Control, Interval, RecordedSteps};
use coupled::Workspace;

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
    /// Whether the force by the damping of springs is kept apart; see [`crate::integrators::Integrator::CORRECTED_WEIGHT`].
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
    /// Angle by which the method turns velocities in magnetic fields, if it does; see [`crate::integrators::Integrator::GYRATES`].
    pub angle: Option<Angle>,
    /// Limit of the time step; see [`crate::integrators::Integrator::limit`].
    pub limit: fn(f64) -> f64,
    /// Treatment of springs.
    pub springs: Treatment,
    /// Velocity of the drift that constraints change; None if the method carries no constraints.
    pub drift: Option<DriftVelocity>,
    pub refusals: MethodRefusals,
}

impl MethodProperties {
    /// Whether contacts are resolved within the drift, before the evaluation of forces; see [`crate::integrators::Integrator::DRIFTS_FIRST`].
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
