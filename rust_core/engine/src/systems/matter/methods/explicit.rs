//! Explicit integrators as methods of matter, for independent and for coupled particles.

use super::stepper::Stepper;
use super::{Angle, Job, Method, MethodMemory, MethodProperties, MethodRefusals, Treatment, coupled, independent};
use crate::catalog::Space;
use crate::error::Result;
use crate::history::History;
use crate::integrators::Integrator;
use crate::matter::{Columns, Matter};
use crate::parallel::Executor;
use crate::scene::Item;
use crate::stability::{Limit, LimitCache, SpectralBound};

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
            drift: self.stepper.drift(),
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
