//! A force given by a function of the user's: slow, correct, and called for all particles at once.

use std::ops::Range;
use std::sync::Arc;

use glam::DVec3;

use super::{Force, Moment, Rates, Reach, VelocityDependence};
use crate::error::{Error, Result};
use crate::math::{Real, Vector};
use crate::matter::{Channel, Columns};
use crate::parallel::Crew;
use crate::scene::{Callback, Term};
use crate::simd::LANES;
use crate::stability::Bound;

/// A user's force on given particles. Without a potential, all that it does counts as work from outside.
pub struct Custom<V: Vector> {
    callback: Arc<dyn Callback>,
    path: String,
    /// The engine's index of each particle that it acts on, in the caller's order.
    members: Vec<usize>,
    /// The forces that the function gave last [N].
    force: Columns<V>,
}

impl<V: Vector> Custom<V> {
    /// A custom force as declared, on `members` in the caller's order, among `count` particles.
    pub fn new(term: &Term, members: Vec<usize>, count: usize) -> Result<Self> {
        Ok(Self { callback: term.callback("function")?, path: term.path.clone(), members, force: Columns::zeros(count) })
    }

    fn positions(&self, at: &Moment<'_, V>) -> Vec<DVec3> {
        self.members.iter().map(|&index| at.properties.origin + at.position.get(index).widen()).collect()
    }

    fn error(&self, function: &str, message: String) -> Error {
        Error::Callback { path: format!("{}.{function}", self.path), message }
    }
}

impl<V: Vector> Force<V> for Custom<V> {
    fn name(&self) -> &'static str {
        "custom"
    }

    fn reach(&self) -> Reach {
        Reach::Whole
    }

    /// The function is given velocities, so it has to be expected that it uses them.
    fn velocity(&self) -> VelocityDependence {
        VelocityDependence::Dissipative
    }

    fn prepare(&mut self, at: &Moment<'_, V>, _crew: &Crew) -> Result<()> {
        if self.members.is_empty() {
            return Ok(());
        }
        let velocities: Vec<DVec3> = self.members.iter().map(|&index| at.velocity.get(index).widen()).collect();
        let forces =
            self.callback.forces(at.time, &self.positions(at), &velocities).map_err(|message| self.error("function", message))?;
        if forces.len() != self.members.len() || forces.iter().any(|force| !force.is_finite()) {
            return Err(self.error("function", format!("must give {} finite forces", self.members.len())));
        }
        for (&index, force) in self.members.iter().zip(forces) {
            self.force.set(index, V::narrow(force));
        }
        Ok(())
    }

    fn accumulate(&self, block: Range<usize>, at: &Moment<'_, V>, rates: &mut Rates<'_, V>) {
        let mine = self.force.view();
        let work = &mut rates.power[Channel::Work as usize];
        let conservative = self.callback.has_potential();
        for axis in 0..V::DIMENSION {
            let velocity = at.velocity.slice(axis, block.clone());
            let forces = mine.slice(axis, block.clone());
            for (index, ((sum, &force), &velocity)) in rates.force.axes[axis].iter_mut().zip(forces).zip(velocity).enumerate() {
                *sum += force;
                if !conservative {
                    work[index % LANES] += force.to_f64() * velocity.to_f64();
                }
            }
        }
    }

    fn has_potential(&self) -> bool {
        self.callback.has_potential()
    }

    fn potential(&self, _block: Range<usize>, _at: &Moment<'_, V>) -> f64 {
        0.0
    }

    fn potential_of_all(&self, at: &Moment<'_, V>) -> Result<f64> {
        if self.members.is_empty() {
            return Ok(0.0);
        }
        self.callback.potential(&self.positions(at)).map_err(|message| self.error("potential", message))
    }

    fn bound(&self, _at: &Moment<'_, V>, _bound: &mut Bound) {}

    fn bytes(&self) -> usize {
        self.force.bytes() + std::mem::size_of_val(self.members.as_slice())
    }
}
