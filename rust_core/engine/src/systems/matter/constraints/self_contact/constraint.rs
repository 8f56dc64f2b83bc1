//! Self-contact and strain limits as a constraint of matter's steps.

use glam::DVec3;

use super::super::{Breakage, ConstrainedStep, Constraint, ConstraintProperties, DriftVelocity};
use super::{ContactStep, InsidePosition, SelfContacts};
use crate::catalog::Space;
use crate::error::{Error, Result};

impl<V: Space> Constraint<V> for SelfContacts {
    fn about(&self) -> ConstraintProperties {
        ConstraintProperties {
            name: "self_contact",
            stages: self.stages(),
            // Contacts begin at the start of a step.
            order: 1,
            varies: false,
            exact: false,
            iterates: true,
            cost: 2000.0 * self.elements() as f64,
        }
    }

    fn bytes(&self) -> usize {
        self.mesh.bytes()
            + self.nearby.bytes()
            + self.loads.bytes()
            + 2 * size_of_val(self.start.as_slice())
            + size_of_val(self.inverse_mass.as_slice())
    }

    fn notes(&self) -> Vec<String> {
        self.remarks()
    }

    /// Checks that meshes do not pass through each other.
    fn initialize(&mut self, step: &mut ConstrainedStep<'_, V>) -> Result<()> {
        self.check(|index| step.matter.exact_position(index), step.executor).map_err(|ends| {
            let [one, other] = ends.map(|end| step.properties.caller[end as usize]);
            let found = format!("the edge between the particles {one} and {other} in a triangle");
            Error::parameter("scene", "bodies with SelfContact that do not pass through each other", found)
        })
    }

    fn begin(&mut self, step: &ConstrainedStep<'_, V>) {
        self.record(|index| [step.matter.exact_position(index), step.matter.velocity.get(index).widen()]);
    }

    /// Resolves the contacts on the path of the step.
    fn positions(&mut self, step: &mut ConstrainedStep<'_, V>) -> Result<bool> {
        let ConstrainedStep { properties, walls, h, .. } = *step;
        let free: Vec<DVec3> = self.start.iter().zip(0..).map(|(x, index)| (step.matter.exact_position(index) - x) / h).collect();
        let mut velocities = free.clone();
        let inside = |index: usize, x: DVec3| {
            let position = walls?.confine(x, properties, index)?;
            let [friction, restitution] = walls?.coefficients(x, properties, index)?;
            Some(InsidePosition { position, friction, restitution })
        };
        let contacts = ContactStep { h, walls: &inside, executor: step.executor };
        let touched = self.resolve(&mut velocities, contacts).map_err(|unresolved| {
            let index = properties.caller[unresolved.particle] as usize;
            Error::unsolved(
                index,
                "passes through others, whatever impulses act: fixed particles drive it there, or it is too fast",
            )
        })?;
        if !touched {
            return Ok(false);
        }
        let mut losses = Vec::new();
        for (index, (before, after)) in free.iter().zip(&velocities).enumerate() {
            if before == after || properties.is_fixed(index) {
                continue;
            }
            let change = *after - *before;
            let end = self.start[index] + h * *after;
            step.matter.set_exact_position(index, inside(index, end).map_or(end, |inside| inside.position));
            // The impulse acts at the start of the step, on the velocity before half of its kick: particles that rest on
            // others then lose no energy.
            let end_velocity = step.matter.velocity.get(index).widen();
            let old = match step.drift {
                DriftVelocity::Register(_) => 2.0 * step.drift_velocity(index) - end_velocity,
                DriftVelocity::End => 0.5 * (self.start_velocities[index] + *before),
            };
            step.push(index, change);
            let lost = -properties.mass[index] * change.dot(old + 0.5 * change);
            losses.push((index, lost));
        }
        step.matter.lose_in_contacts(&losses, step.driven);
        Ok(true)
    }

    fn leave_out(&mut self, breakage: &Breakage) {
        self.leave_out_broken(&breakage.broken);
    }
}
