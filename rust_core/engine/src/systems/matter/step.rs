//! Step of coupled matter: the sequence in which a method, contacts and constraints act, for all methods.
//!
//!     MatterStep::begin        records the state at the start, for contacts and constraints
//!       method                 drift of all particles, without walls and constraints
//!     MatterStep::drifted      contacts: flights of independent particles from wall to wall
//!                              constraints, in their order: positions, the velocity of the drift, and that predicted for the end
//!       method                 forces and their powers at the new positions and predicted velocities, and the kick
//!     MatterStep::end          constraints, in their order: velocities
//!
//! A composed method repeats this for each of its parts. Springs break between the steps of the whole method
//! ([`super::MatterSystem`]). A method whose drifts follow its evaluations leaves contacts to its last sweep
//! ([`super::methods::coupled`]), and carries no constraints.

use super::constraints::{ConstrainedStep, Constraints, DriftVelocity};
use super::dynamics::Dynamics;
use super::methods::coupled::Workspace;
use super::methods::stepper::Collide;
use crate::catalog::Space;
use crate::contacts::Before;
use crate::error::Result;
use crate::matter::{Blocks, Matter};
use crate::parallel::Executor;

/// Coupled matter during the steps of a method.
pub struct MatterStep<'a, V: Space> {
    pub dynamics: &'a mut Dynamics<V>,
    pub constraints: &'a mut Constraints<V>,
    pub matter: &'a mut Matter<V>,
    pub workspace: &'a mut Workspace<V>,
    pub executor: &'a Executor,
}

impl<V: Space> MatterStep<'_, V> {
    /// Records the state at the start of a step of `h` seconds.
    pub fn begin(&mut self, h: f64, drift: Option<DriftVelocity>) {
        if let Some([position, velocity]) = &mut self.workspace.before {
            position.copy_from(&self.matter.position);
            velocity.copy_from(&self.matter.velocity);
        }
        if let Some(drift) = drift {
            let (constraints, step) = self.constrained(h, drift);
            constraints.iter_mut().for_each(|constraint| constraint.begin(&step));
        }
    }

    /// Records the forces at the start of a run.
    pub fn start(&mut self, drift: Option<DriftVelocity>) {
        if let Some(drift) = drift {
            let (constraints, step) = self.constrained(0.0, drift);
            constraints.iter_mut().for_each(|constraint| constraint.start(&step));
        }
    }

    /// Resolves contacts with walls on the drift, then the constraints. Returns whether constraints changed the state. If the
    /// method keeps registers of the drift, `collide` resolves contacts with them.
    ///
    /// # Errors
    /// If a constraint cannot be satisfied, or on an interrupt.
    pub fn drifted(&mut self, h: f64, drift: DriftVelocity, collide: Option<Collide<V>>) -> Result<bool> {
        if let (Some(contacts), Some([position, velocity])) = (&self.dynamics.contacts, &self.workspace.before) {
            let dynamics = &*self.dynamics;
            self.executor.for_each_block(self.matter.blocks(), &|mut block: Blocks<'_, V>| {
                let before = Before::part(position, velocity, &block.range());
                match collide {
                    Some(collide) => collide(dynamics, contacts, &mut block, &before, h),
                    None => contacts.resolve(&before, &mut block, &dynamics.properties, h),
                }
            });
        }
        let (constraints, mut step) = self.constrained(h, drift);
        let mut changed = false;
        for constraint in constraints.iter_mut() {
            changed |= constraint.positions(&mut step)?;
        }
        Ok(changed)
    }

    /// Applies the constraints to the velocities at the end of a step of `h` seconds.
    ///
    /// # Errors
    /// As [`MatterStep::drifted`].
    pub fn end(&mut self, h: f64, drift: Option<DriftVelocity>) -> Result<()> {
        let Some(drift) = drift else { return Ok(()) };
        let (constraints, mut step) = self.constrained(h, drift);
        constraints.iter_mut().try_for_each(|constraint| constraint.velocities(&mut step))
    }

    /// Constraints, and the step as they see it.
    fn constrained(&mut self, h: f64, drift: DriftVelocity) -> (&mut Constraints<V>, ConstrainedStep<'_, V>) {
        let Self { dynamics, constraints, matter, executor, .. } = self;
        (constraints, ConstrainedStep::new(dynamics, matter, (h, drift), executor))
    }
}
