//! Methods: the time stepping of matter, and its stability limits.

use super::activity::Activity;
use super::coupled::Workspace;
use super::dynamics::{Angle, Dynamics, Impulses, Treatment};
use super::stepper::Stepper;
use super::{coupled, independent};
use crate::error::Result;
use crate::forces::Space;
use crate::history::History;
use crate::integrators::Integrator;
use crate::matter::{Columns, Matter};
use crate::parallel::Executor;
use crate::scene::Item;
use crate::stability::{Limit, LimitCache, SpectralBound};
use crate::systems::{Control, Interval, RecordedSteps};

/// Data of a method's steps.
pub struct Job<'a, V: Space> {
    pub dynamics: &'a mut Dynamics<V>,
    /// Initial state, which does not change.
    pub from: &'a Matter<V>,
    pub state: &'a mut Matter<V>,
    /// Activity to record, and the recorded steps.
    pub record: (&'a mut Activity, RecordedSteps),
    /// Buffers of sweeps, for coupled particles.
    pub workspace: Option<&'a mut Workspace<V>>,
    pub interval: Interval,
}

/// Properties of a method.
#[derive(Debug, Clone, Copy)]
pub struct MethodProperties {
    /// Name of the class in Python.
    pub name: &'static str,
    /// Order of convergence without velocity-dependent forces, and with dissipation.
    pub order: u32,
    pub order_dissipative: u32,
    /// Number of evaluations of the forces per step.
    pub evaluations: usize,
    /// Number of registers in use between stages, and of registers that can be read after a step.
    pub registers: usize,
    pub readable: usize,
    /// Number of further vectors that the method stores per particle.
    pub own: usize,
    /// Whether contacts come first; see [`Integrator::DRIFTS_FIRST`].
    pub drifts_first: bool,
    /// Whether each stage is a sweep over all particles, even if these are independent.
    pub sweeps: bool,
    /// Corrected weight; see [`Integrator::CORRECTED_WEIGHT`].
    pub corrected_weight: f64,
    /// Angle by which the method turns velocities in magnetic fields, if it does; see [`Integrator::GYRATES`].
    pub angle: Option<Angle>,
    /// Limit of the time step; see [`Integrator::limit`].
    pub limit: fn(f64) -> f64,
    /// Treatment of springs.
    pub springs: Treatment,
    /// Whether the method holds springs of infinite stiffness at their lengths.
    pub holds_rods: bool,
    /// Reason why the method cannot advance a field that diffuses, if it cannot.
    pub refuses_fields: Option<&'static str>,
    /// Reason why the method accepts neither contacts nor fluids, if it is for smooth motion alone.
    pub smooth_only: Option<&'static str>,
    /// Velocity that contacts between meshes change, if the method supports these.
    pub impulses: Option<Impulses>,
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
        Control::pair(self.about().order)
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
        MethodProperties {
            name: facts.name,
            order: facts.order,
            order_dissipative: facts.order_dissipative,
            evaluations: facts.stages(),
            registers: facts.registers,
            readable: facts.readable,
            own: 0,
            drifts_first: facts.drifts_first,
            sweeps: false,
            corrected_weight: facts.corrected_weight,
            angle: self.angle,
            limit: facts.limit,
            springs: Treatment::Forces,
            holds_rods: false,
            refuses_fields: facts.refuses_fields,
            smooth_only: None,
            impulses: facts.drift_kick.filter(|_| facts.drifts_first).map(|drift_kick| Impulses::Register(drift_kick.velocity)),
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

    fn begin(&mut self, Job { dynamics, from, state, workspace, interval, .. }: Job<'_, V>, executor: &Executor) -> Result<()> {
        if let Some(workspace) = workspace {
            return coupled::begin(&self.stepper, dynamics, state, workspace, interval, executor);
        }
        independent::begin(&self.stepper, dynamics, from, state, interval);
        Ok(())
    }

    fn advance(
        &mut self,
        Job { dynamics, from, state, record, workspace, interval }: Job<'_, V>,
        executor: &Executor,
    ) -> Result<()> {
        if let Some(workspace) = workspace {
            return coupled::advance(&self.stepper, dynamics, state, workspace, interval, record.0, executor);
        }
        independent::advance(&self.stepper, dynamics, from, state, interval, record, executor);
        Ok(())
    }
}
