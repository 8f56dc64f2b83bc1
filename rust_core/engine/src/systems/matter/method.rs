//! Methods: the time stepping of matter, and its stability limits.

use std::marker::PhantomData;

use super::activity::Activity;
use super::coupled::Workspace;
use super::dynamics::Dynamics;
use super::{coupled, independent};
use crate::error::Result;
use crate::integrators::Integrator;
use crate::math::Vector;
use crate::matter::Matter;
use crate::parallel::Executor;
use crate::stability::{Limit, LimitCache, SpectralBound};
use crate::systems::{Interval, Record};

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

/// A time-stepping method for matter.
pub trait Method<V: Vector>: Send + Sync {
    /// The order of convergence without velocity-dependent forces.
    fn order(&self) -> u32;
    /// The number of registers that persist from step to step.
    fn persistent(&self) -> usize;
    /// The registers that hold the estimated errors of x and v, where a method of the order below is embedded in it.
    fn error(&self) -> Option<[usize; 2]>;
    /// Whether it is unconditionally unstable on an oscillator.
    fn gains_energy(&self) -> bool;
    /// A bound for the waves of a field as this method advances them.
    fn bound(&self, bound: SpectralBound) -> SpectralBound;
    /// The limit of the time step from a bound.
    fn limit(&self, bound: &SpectralBound, cache: &mut LimitCache) -> Limit;
    /// The limit sharpened by the present directions of the springs.
    fn sharp_limit(&self, bound: SpectralBound) -> Limit;
    /// Evaluates the dynamics at the state and fills the persistent registers.
    fn begin(&self, job: Job<'_, V>, executor: &Executor) -> Result<()>;
    /// Takes all steps of the interval.
    fn advance(&self, job: Job<'_, V>, executor: &Executor) -> Result<()>;
}

/// An explicit integrator.
pub struct Explicit<I>(PhantomData<I>);

impl<I> Explicit<I> {
    pub const NEW: Self = Self(PhantomData);
}

impl<V: Vector, I: Integrator> Method<V> for Explicit<I> {
    fn order(&self) -> u32 {
        I::ORDER
    }

    fn persistent(&self) -> usize {
        I::PERSISTENT
    }

    fn error(&self) -> Option<[usize; 2]> {
        I::ERROR
    }

    fn gains_energy(&self) -> bool {
        I::limit(0.0) == 0.0
    }

    fn bound(&self, bound: SpectralBound) -> SpectralBound {
        bound.stepped_by::<I>()
    }

    fn limit(&self, bound: &SpectralBound, cache: &mut LimitCache) -> Limit {
        bound.limit_after::<I>(cache)
    }

    fn sharp_limit(&self, bound: SpectralBound) -> Limit {
        bound.sharp_limit::<I>()
    }

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
