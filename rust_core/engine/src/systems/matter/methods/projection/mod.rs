//! Projection methods, which move particles onto their springs: extended position-based dynamics and projective dynamics.
//!
//! A step of h seconds predicts displacements y = h v + h² a, with the accelerations a of all other forces at its start. A
//! projector converts them to displacements u. The step ends at x + u with the velocity u/h. Both projectors approach
//! backward Euler's equation for the springs, M (u − y) = h² F(x + u, u/h). This method is stable at any stiffness and of
//! order 1. Its damping is an error of the method and no dissipation. Contacts are resolved on the path from x to x + u.

mod curvature;
mod links;
mod projective;
mod sweep;

pub use links::colored;
pub use projective::{NAME as PROJECTIVE, Projective};
pub use sweep::{NAME as XPBD, Sweeps};

use super::{Job, Method, MethodMemory, MethodProperties, MethodRefusals, Treatment};
use crate::catalog::Space;
use crate::error::Result;
use crate::forces::Rates;
use crate::history::History;
use crate::integrators::{Facts, Integrator, SemiImplicitEuler};
use crate::math::Real;
use crate::matter::{Columns, Matter, Power, SINKS};
use crate::parallel::{BlockedSlice, Executor};
use crate::simd::LANES;
use crate::stability::{Limit, LimitCache, SpectralBound};
use crate::systems::matter::constraints::DriftVelocity;
use crate::systems::matter::dynamics::Dynamics;
use crate::systems::matter::kernels;
use crate::systems::matter::methods::coupled::{self, BlocksWithForces};
use crate::systems::matter::step::MatterStep;

/// Projector: finds displacements for springs.
pub trait Projector<V: Space>: Send + Sync {
    /// Properties of the method.
    fn about(&self) -> MethodProperties;
    /// Number of steps of the projector within a step of the method.
    fn substeps(&self) -> usize;
    /// Prepares for the springs of a scene.
    fn begin(&mut self, dynamics: &Dynamics<V>);
    /// Converts predicted displacements over `h` seconds [m], of particles in a state, into projected ones. Ends early on an
    /// interrupt.
    ///
    /// # Errors
    /// If what the projection needs does not fit into memory.
    fn project(
        &mut self,
        dynamics: &Dynamics<V>,
        state: &Matter<V>,
        displacement: &mut Columns<V>,
        h: f64,
        executor: &Executor,
    ) -> Result<()>;
    /// Memory [bytes].
    fn bytes(&self) -> usize;
}

/// Method of a projector.
pub struct ProjectionMethod<V: Space, P> {
    projector: P,
    displacement: Columns<V>,
}

impl<V: Space, P: Projector<V>> ProjectionMethod<V, P> {
    /// Creates the method.
    pub fn new(projector: P) -> Self {
        Self { projector, displacement: Columns::zeros(0) }
    }

    /// Takes one step of `h` seconds; returns the activity at its end.
    fn step(&mut self, step: &mut MatterStep<'_, V>, (time, h): (f64, f64)) -> Result<f64> {
        step.dynamics.prepare(step.matter, time, step.executor)?;
        step.begin(h, Some(DriftVelocity::End));
        self.predict(step, (time, h));
        let MatterStep { dynamics, matter, executor, .. } = step;
        self.projector.project(dynamics, matter, &mut self.displacement, h, executor)?;
        executor.check()?;
        for index in 0..matter.count() {
            let change = self.displacement.get(index).widen();
            // Fixed particles keep the exact bits of their velocities.
            if !dynamics.properties.is_fixed(index) {
                matter.velocity.set(index, V::narrow(change / h));
            }
            let moved = matter.exact_position(index) + change;
            matter.set_exact_position(index, moved);
        }
        step.drifted(h, DriftVelocity::End, None)?;
        step.end(h, Some(DriftVelocity::End))?;
        finish(step, (time, h));
        Ok(step.workspace.activity.iter().sum())
    }

    /// Sets the displacements to y = h v + h² a, and integrates the power of the forces at the start.
    fn predict(&mut self, step: &mut MatterStep<'_, V>, (time, h): (f64, f64)) {
        step.workspace.position.copy_from(&step.matter.position);
        step.workspace.velocity.copy_from(&step.matter.velocity);
        coupled::accelerate(step, time, [h, 0.0], false);
        let MatterStep { matter, workspace, .. } = step;
        let (h, square) = (V::Scalar::from_f64(h), V::Scalar::from_f64(h * h));
        let (displacement, velocity, acceleration) = (self.displacement.span(), &matter.velocity, &workspace.force);
        for axis in 0..V::DIMENSION {
            let columns = velocity.axis(axis).iter().zip(acceleration.axis(axis));
            displacement.axes[axis].iter_mut().zip(columns).for_each(|(y, (&v, &a))| *y = h * v + square * a);
        }
    }
}

/// Integrates the power of springs at the end of the step, and records the activity.
fn finish<V: Space>(step: &mut MatterStep<'_, V>, (time, h): (f64, f64)) {
    let MatterStep { dynamics, matter, workspace, executor, .. } = step;
    let dynamics = &**dynamics;
    workspace.position.copy_from(&matter.position);
    workspace.velocity.copy_from(&matter.velocity);
    let at = dynamics.state_view(workspace.position.view(), workspace.velocity.view(), time + h);
    let work = (BlocksWithForces::new(matter.blocks(), workspace.force.span()), BlockedSlice::new(&mut workspace.activity, 1));
    executor.for_each_block(work, &|(work, activity): (BlocksWithForces<'_, V>, BlockedSlice<'_, f64>)| {
        let BlocksWithForces { blocks, mut force, .. } = work;
        let mut power: Power = [[0.0; LANES]; SINKS];
        dynamics.spring_power(&blocks.range(), &at, &mut Rates::new(force.reborrow(), &mut power));
        kernels::integrate(&mut blocks.tallies[0], kernels::through_all(&power), h, 0.0, false);
        activity.items[0] = kernels::activity(dynamics, &blocks) + kernels::out_of_range(dynamics, &blocks);
    });
}

/// Common properties of all projectors: one sweep over all particles, of order 1, explicit in forces other than springs.
fn about(name: &'static str, evaluations: usize) -> MethodProperties {
    MethodProperties {
        name,
        orders: [1, 1],
        evaluations,
        // Displacements.
        memory: MethodMemory { own: 1, ..MethodMemory::default() },
        sweeps: true,
        angle: None,
        limit: SemiImplicitEuler::limit,
        springs: Treatment::Projections,
        drift: Some(DriftVelocity::End),
        refusals: MethodRefusals::default(),
    }
}

impl<V: Space, P> History for ProjectionMethod<V, P> {}

impl<V: Space, P: Projector<V>> Method<V> for ProjectionMethod<V, P> {
    fn about(&self) -> MethodProperties {
        self.projector.about()
    }

    fn persistent(&self) -> usize {
        0
    }

    fn error(&self, _state: &Matter<V>, _h: f64) -> Option<f64> {
        None
    }

    fn gains_energy(&self) -> bool {
        false
    }

    fn bytes(&self) -> usize {
        self.projector.bytes() + self.displacement.bytes()
    }

    fn bound(&self, bound: SpectralBound) -> SpectralBound {
        bound.stepped_by(&Facts::of::<SemiImplicitEuler>())
    }

    /// Limit of the forces other than springs, which are evaluated at the start of each part of a step.
    fn limit(&self, bound: &SpectralBound, cache: &mut LimitCache) -> Limit {
        bound.limit_after(&Facts::of::<SemiImplicitEuler>(), cache).in_parts(self.projector.substeps())
    }

    fn sharp_limit(&self, bound: SpectralBound) -> Limit {
        bound.sharp_limit(&Facts::of::<SemiImplicitEuler>()).in_parts(self.projector.substeps())
    }

    fn take_springs(&mut self, dynamics: &Dynamics<V>) {
        self.projector.begin(dynamics);
    }

    fn begin(&mut self, Job { dynamics, state, interval, .. }: Job<'_, V>, executor: &Executor) -> Result<()> {
        self.displacement = Columns::zeros(state.count());
        self.projector.begin(dynamics);
        dynamics.prepare(state, interval.start, executor)
    }

    fn advance(&mut self, job: Job<'_, V>, executor: &Executor) -> Result<()> {
        let Some((mut step, recorded, interval)) = job.coupled(executor) else { return Ok(()) };
        let parts = self.projector.substeps();
        for index in 0..interval.steps {
            let mut activity = 0.0;
            for part in 0..parts {
                let time = interval.time(index, part as f64 / parts as f64);
                activity = self.step(&mut step, (time, interval.h / parts as f64))?;
            }
            recorded.push(activity);
            if executor.stopped() {
                break;
            }
        }
        Ok(())
    }
}
