//! Walls of the scene that vertices are pressed on by contacts: contacts of one vertex, with the wall's friction and restitution.
//!
//! The stage of walls has taken each particle's own momentum into a wall before, with the friction of that; what others press it on
//! with comes on top here.

use glam::DVec3;

use super::SelfContacts;
use super::impulses::{self, Contact, Origin};
use super::resolution::Step;

/// A position inside all walls, with the coefficients of the wall that is in the way.
#[derive(Debug, Clone, Copy)]
pub struct Inside {
    /// The position [m].
    pub position: DVec3,
    /// Coulomb's coefficient of friction μ.
    pub friction: f64,
    /// The coefficient of restitution e.
    pub restitution: f64,
}

/// What keeps particles inside walls: where a particle that would be outside at a position is inside.
pub type Walls<'a> = dyn Fn(usize, DVec3) -> Option<Inside> + Sync + 'a;

/// Corrections of a zone's velocity at walls.
const CORRECTIONS: u32 = 8;

impl SelfContacts {
    /// The contact of a vertex that was on a wall in the last step, if it is within the thickness of one.
    pub(super) fn resting(
        &self,
        &(vertex, normal, load): &(u32, DVec3, f64),
        thickness: f64,
        Step { h, walls, .. }: Step<'_>,
    ) -> Option<Contact> {
        let from = self.start[vertex as usize];
        let beyond = from - thickness * normal;
        let mut contact = self.wall(vertex, [from, beyond], walls(vertex as usize, beyond)?, h)?;
        contact.impulse = h * load;
        Some(contact)
    }

    /// The contact of a vertex with the wall that it would pass on a path. What rests on the wall, stays; what arrives, bounces.
    pub(super) fn arriving(&self, vertex: u32, [from, to]: [DVec3; 2], inside: Inside, h: f64) -> Option<Contact> {
        let mut contact = self.wall(vertex, [from, to], inside, h)?;
        let approach = contact.normal.dot(to - from) / h;
        contact.least = contact.least.max(-inside.restitution * approach);
        Some(contact)
    }

    fn wall(&self, vertex: u32, [from, to]: [DVec3; 2], inside: Inside, h: f64) -> Option<Contact> {
        let way = (inside.position - to).length();
        let normal = (inside.position - to) / way;
        // What solving leaves of a velocity is no reason for another round.
        (way > impulses::CONVERGED * (to - from).length()).then_some(())?;
        let least = normal.dot(inside.position - from) / h;
        let weights = [1.0, 0.0, 0.0, 0.0];
        Contact::new(([vertex; 4], Origin::Wall), weights, normal, (least, inside.friction), &self.inverse_mass)
    }

    /// The velocity of particles that move together, without what leads one of them out of the walls; 0 if that is not found.
    pub(super) fn within_walls(&self, members: &[u32], mut velocity: DVec3, Step { h, walls, .. }: Step<'_>) -> DVec3 {
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
