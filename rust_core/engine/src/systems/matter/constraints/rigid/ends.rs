//! Ends of joints in a state.

use glam::DVec3;
use physcore_rigid::mover::Mover;
use physcore_rigid::pose::Pose;
use physcore_rigid::world::{CenterMotion, WORLD};

use super::RigidBodies;
use crate::forces::{Space, StateView};

impl RigidBodies {
    /// Particle of an end of a joint; None for the world.
    pub(super) fn particle(&self, end: usize) -> Option<u32> {
        let point = |end: usize| self.points.binary_search_by_key(&end, |(_, point)| point.index).ok();
        match end {
            WORLD => None,
            end if end < self.particles.len() => Some(self.particles[end]),
            end => point(end - self.particles.len()).map(|point| self.points[point].0),
        }
    }

    /// End of a joint in a state.
    pub(super) fn end<V: Space>(&self, at: &StateView<'_, V>, end: usize) -> Mover {
        let Some(particle) = self.particle(end).map(|particle| particle as usize) else { return Mover::wall(&Pose::WORLD) };
        let mut position = DVec3::ZERO;
        (0..V::DIMENSION).for_each(|axis| position[axis] = at.exact_position(axis, particle));
        let (position, velocity) = (at.properties.origin + position, at.velocity.get(particle).widen());
        if let Some(tied) = self.tied.iter().find(|tied| tied.body == end) {
            let offset = tied.offset(&self.world.rotation(end));
            let velocity = velocity - self.world.angular_velocity(end).cross(offset);
            self.world.mover(end, &CenterMotion::free(position - offset, velocity), 1.0)
        } else if end < self.particles.len() {
            self.world.mover(end, &CenterMotion::free(position, velocity), 1.0)
        } else {
            Mover { position, velocity, inverse_mass: at.properties.mass[particle].recip(), ..Mover::wall(&Pose::WORLD) }
        }
    }
}
