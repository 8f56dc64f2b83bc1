//! Methods: the time stepping of matter, and its stability limits.

use super::activity::Activity;
use super::coupled::Workspace;
use super::dynamics::{Angle, Dynamics, Impulses, Treatment};
use super::stepper::Stepper;
use super::{coupled, independent};
use crate::error::Result;
use crate::history::History;
use crate::integrators::Integrator;
use crate::math::Vector;
use crate::matter::{Columns, Matter};
use crate::parallel::Executor;
use crate::scene::Item;
use crate::stability::{Limit, LimitCache, SpectralBound};
use crate::systems::{Control, Interval, Record};

/// The data of a method's steps.
pub struct Job<'a, V: Vector> {
    pub dynamics: &'a mut Dynamics<V>,
    /// The initial state, which does not change.
    pub from: &'a Matter<V>,
    pub state: &'a mut Matter<V>,
    /// The activity to record, and its steps.
    pub record: (&'a mut Activity, Record),
    /// Buffers of sweeps, for coupled particles.
    pub workspace: Option<&'a mut Workspace<V>>,
    pub interval: Interval,
}

/// What is known of a method before it steps.
#[derive(Debug, Clone, Copy)]
pub struct About {
    /// The class's name in Python.
    pub name: &'static str,
    /// The order of convergence without velocity-dependent forces, and with dissipation.
    pub order: u32,
    pub order_dissipative: u32,
    /// Evaluations of the forces per step.
    pub evaluations: usize,
    /// The number of registers in use between stages, and of those that can be read after a step.
    pub registers: usize,
    pub readable: usize,
    /// Further vectors that it keeps of each particle.
    pub own: usize,
    /// Whether contacts come first, as [`Integrator::DRIFTS_FIRST`].
    pub drifts_first: bool,
    /// Whether each stage is a sweep over all particles, even where these are independent.
    pub sweeps: bool,
    /// As [`Integrator::CORRECTED_WEIGHT`].
    pub corrected_weight: f64,
    /// The angle by which it turns velocities in magnetic fields, if it does, as [`Integrator::GYRATES`].
    pub angle: Option<Angle>,
    /// As [`Integrator::limit`].
    pub limit: fn(f64) -> f64,
    /// Its treatment of springs.
    pub springs: Treatment,
    /// Whether it holds springs of infinite stiffness at their lengths.
    pub holds_rods: bool,
    /// Why it cannot advance a field that diffuses, if it cannot.
    pub refuses_fields: Option<&'static str>,
    /// Why it takes neither contacts nor fluids, if it takes smooth motion alone.
    pub smooth_only: Option<&'static str>,
    /// The velocity that contacts between meshes change, if it takes these.
    pub impulses: Option<Impulses>,
}

/// A time-stepping method for matter. Its history is the data that it keeps itself from step to step, beside the registers.
pub trait Method<V: Vector>: History + Send + Sync {
    /// What is known of it before it steps.
    fn about(&self) -> About;
    /// The number of registers that persist from step to step.
    fn persistent(&self) -> usize;
    /// The estimated error of the last step of `h` seconds, if it has an estimate.
    fn error(&self, state: &Matter<V>, h: f64) -> Option<f64>;
    /// The control of the step size by that.
    fn control(&self) -> Control {
        Control::pair(self.about().order)
    }
    /// Whether it is unconditionally unstable on an oscillator.
    fn gains_energy(&self) -> bool;
    /// A bound for the waves of a field as this method advances them.
    fn bound(&self, bound: SpectralBound) -> SpectralBound;
    /// The limit of the time step from a bound.
    fn limit(&self, bound: &SpectralBound, cache: &mut LimitCache) -> Limit;
    /// The limit sharpened by the present directions of the springs.
    fn sharp_limit(&self, bound: SpectralBound) -> Limit;
    /// A note for the plan on the steps so far.
    fn note(&self) -> Option<String> {
        None
    }
    /// Memory of the data that it keeps itself [bytes].
    fn bytes(&self) -> usize {
        0
    }
    /// Takes the springs of the dynamics anew, of which others are broken.
    fn take_springs(&mut self, _dynamics: &Dynamics<V>) {}
    /// Evaluates the dynamics at the state and fills the persistent registers.
    fn begin(&mut self, job: Job<'_, V>, executor: &Executor) -> Result<()>;
    /// Takes all steps of the interval.
    fn advance(&mut self, job: Job<'_, V>, executor: &Executor) -> Result<()>;
}

/// An explicit integrator.
pub struct Explicit<V: Vector> {
    /// As [`About::angle`].
    angle: Option<Angle>,
    pub stepper: Stepper<V>,
}

impl<V: Vector> Explicit<V> {
    /// The integrator of an item.
    ///
    /// # Errors
    /// If a value is wrong.
    pub fn declared<I: Integrator>(item: &Item) -> Result<Self> {
        let exact = I::GYRATES && item.flag("exact_angle")?;
        let angle = I::GYRATES.then_some(if exact { Angle::Exact } else { Angle::Boris });
        Ok(Self { angle, stepper: Stepper::of::<I>() })
    }
}

impl<V: Vector> History for Explicit<V> {}

impl<V: Vector> Method<V> for Explicit<V> {
    fn about(&self) -> About {
        let facts = &self.stepper.facts;
        About {
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

    /// The largest over all particles, of the position error, or of the velocity error times the step [m].
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
