//! Walls of the scene on which contacts press vertices: contacts of one vertex, with the wall's friction and restitution.
//!
//! The contact stage has already resolved each particle's own momentum into a wall, with its friction. The pressure by other
//! particles is added here.

use glam::DVec3;

use super::SelfContacts;
use super::resolution::ContactStep;
use super::{MeshContact, Origin};
use crate::solvers::impulses::{self, Handle};

/// A position inside all walls, with the coefficients of the wall in the way.
#[derive(Debug, Clone, Copy)]
pub struct InsidePosition {
    /// Position [m].
    pub position: DVec3,
    /// Coulomb's coefficient of friction μ.
    pub friction: f64,
    /// Coefficient of restitution e.
    pub restitution: f64,
}

/// Projection of positions inside walls: for a particle and a position outside, the position inside.
pub type WallProjection<'a> = dyn Fn(usize, DVec3) -> Option<InsidePosition> + Sync + 'a;

/// Maximum number of corrections of a zone's velocity at walls.
const CORRECTIONS: u32 = 8;

impl SelfContacts {
    /// Contact of a vertex that was on a wall in the last step, if a wall is within the thickness.
    pub(super) fn resting(
        &self,
        &(vertex, normal, load): &(u32, DVec3, f64),
        thickness: f64,
        ContactStep { h, walls, .. }: ContactStep<'_>,
    ) -> Option<MeshContact> {
        let from = self.start[vertex as usize];
        let beyond = from - thickness * normal;
        let mut contact = self.wall(vertex, [from, beyond], walls(vertex as usize, beyond)?, h)?;
        contact.impulse = h * load;
        Some(contact)
    }

    /// Contact of a vertex with the wall that it would pass on a path. A resting vertex stays; an arriving one bounces.
    pub(super) fn arriving(&self, vertex: u32, [from, to]: [DVec3; 2], inside: InsidePosition, h: f64) -> Option<MeshContact> {
        let mut contact = self.wall(vertex, [from, to], inside, h)?;
        let approach = contact.normal.dot(to - from) / h;
        contact.least = contact.least.max(-inside.restitution * approach);
        Some(contact)
    }

    fn wall(&self, vertex: u32, [from, to]: [DVec3; 2], inside: InsidePosition, h: f64) -> Option<MeshContact> {
        let way = (inside.position - to).length();
        let normal = (inside.position - to) / way;
        // The remainder of an iterative solution is no reason for another round.
        (way > impulses::CONVERGED * (to - from).length()).then_some(())?;
        let least = normal.dot(inside.position - from) / h;
        let weights = [1.0, 0.0, 0.0, 0.0];
        let ends = [Handle::Particle(vertex), Handle::Fixed, Handle::Fixed, Handle::Fixed];
        MeshContact::new((ends, Origin::Wall(vertex)), weights, normal, (least, inside.friction), &self.inverse_mass)
    }

    /// Velocity of particles that move together, corrected so that none leaves the walls; 0 if no such velocity is found.
    pub(super) fn within_walls(
        &self,
        members: &[u32],
        mut velocity: DVec3,
        ContactStep { h, walls, .. }: ContactStep<'_>,
    ) -> DVec3 {
        for _ in 0..CORRECTIONS {
            let way_back = |&vertex: &u32| {
                let to = self.start[vertex as usize] + h * velocity;
                walls(vertex as usize, to).map(|inside| inside.position - to)
            };
            let farthest = members.iter().filter_map(way_back).max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
            let Some(way) = farthest else { return velocity };
            velocity += way / h;
        }
        DVec3::ZERO
    }
}
