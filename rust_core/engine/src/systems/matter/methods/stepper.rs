//! Explicit integrator with its kernels as values: sweeps over particles are compiled once for all integrators.

use super::collisions::collide;
use crate::catalog::Space;
use crate::contacts::{Before, Contacts};
use crate::forces::{InverseSquare, StateView};
use crate::integrators::{Facts, Integrator};
use crate::math::Vector;
use crate::matter::Blocks;
use crate::systems::matter::constraints::DriftVelocity;
use crate::systems::matter::dynamics::Dynamics;
use crate::systems::matter::kernels::{self, Evaluation, StageAction};

type StageFunction<V> =
    fn(&Dynamics<V>, &Facts, Option<&StateView<'_, V>>, &mut Blocks<'_, V>, &Evaluation<'_, V>, f64, StageAction) -> f64;
type LinearStepper<V> = fn(&Dynamics<V>, &mut Blocks<'_, V>, f64, u64);
type PointForceStepper<V> = fn(&Dynamics<V>, InverseSquare<'_, <V as Vector>::Scalar>, &mut Blocks<'_, V>, f64, u64);
/// Contacts of a block within the drift, with the registers of the integrator.
pub type Collide<V> = fn(&Dynamics<V>, &Contacts<V>, &mut Blocks<'_, V>, &Before<'_, V>, f64);

/// Integrator in the form that sweeps call.
#[derive(Debug)]
pub struct Stepper<V: Space> {
    pub facts: Facts,
    stage: StageFunction<V>,
    /// Whole steps in registers under the linear force alone, if they are compiled.
    pub linear_steps: Option<LinearStepper<V>>,
    /// Whole steps in registers under an inverse-square force alone, if they are compiled.
    pub point_force_steps: Option<PointForceStepper<V>>,
    /// Contacts within the drift, if contacts come first.
    pub collide: Option<Collide<V>>,
}

impl<V: Space> Stepper<V> {
    /// Velocity of the drift that constraints change; None if drifts follow the evaluations.
    pub fn drift(&self) -> Option<DriftVelocity> {
        let drift = self.facts.drift_kick.filter(|_| self.facts.drifts_first);
        drift.map(|drift_kick| DriftVelocity::Register(drift_kick.velocity))
    }

    /// Builds the kernels of an integrator.
    pub fn of<I: Integrator>() -> Self {
        let (mut linear_steps, mut point_force_steps, mut collides) = (None, None, None);
        // Constant conditions in blocks: only kernels that are called are compiled.
        if const { I::IN_REGISTERS } {
            linear_steps = Some(kernels::steps::<V, I> as LinearStepper<V>);
            point_force_steps = Some(kernels::point_force_steps::<V, I> as PointForceStepper<V>);
        }
        if const { I::DRIFTS_FIRST } {
            collides = Some(collide::<V, I> as Collide<V>);
        }
        Self { facts: Facts::of::<I>(), stage: kernels::stage::<V, I::Swept>, linear_steps, point_force_steps, collide: collides }
    }

    /// Runs one stage of one block, from the state `at`, or from the block's own state if None; returns the activity at the
    /// stage.
    pub fn stage(
        &self,
        dynamics: &Dynamics<V>,
        at: Option<&StateView<'_, V>>,
        blocks: &mut Blocks<'_, V>,
        evaluation: &Evaluation<'_, V>,
        h: f64,
        action: StageAction,
    ) -> f64 {
        (self.stage)(dynamics, &self.facts, at, blocks, evaluation, h, action)
    }
}
