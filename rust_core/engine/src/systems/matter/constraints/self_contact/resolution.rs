//! Resolution of a step: velocities at which nothing passes through.

use std::collections::HashSet;

use glam::DVec3;

use super::distance::Closest;
use super::loads::Loads;
use super::nearby::Near;
use super::walls::WallProjection;
use super::zones::Zones;
use super::{MeshContact, Origin};
use super::{SelfContacts, limits};
use crate::parallel::Executor;
use crate::solvers::impulses::{self, Handle};

/// Number of rounds in which pairs that close or meet become contacts.
const ROUNDS: u32 = 8;
/// Number of rounds in which zones grow.
const MERGERS: u32 = 1000;
/// Activation distance of contacts beyond the thickness, in thicknesses: in the first round (`AHEAD`), in later rounds
/// (`LATE`). Later rounds add only pairs that close too far.
const AHEAD: f64 = 0.25;
const LATE: f64 = -0.1;
/// Rounding error of the kinetic energy, relative to itself.
const ROUNDING: f64 = 1e-12;

/// Failure of a step: particles that have to keep their velocities pass through each other.
#[derive(Debug, Clone, Copy)]
pub struct Unresolved {
    /// One of the particles.
    pub particle: usize,
}

/// Step, with its walls and threads.
#[derive(Clone, Copy)]
pub struct ContactStep<'a> {
    /// Size of the step [s].
    pub h: f64,
    /// Walls around the step.
    pub walls: &'a WallProjection<'a>,
    /// Threads for the step.
    pub executor: &'a Executor,
}

/// Contacts of a step.
struct Active {
    contacts: Vec<MeshContact>,
    /// Keys of the contacts along normals.
    known: HashSet<u64>,
    /// Whether each vertex has a contact with a wall.
    held: Vec<bool>,
    /// Index of the constraint of each spring with a limit, if it has one.
    taut: Vec<Option<usize>>,
}

impl Active {
    fn extend(&mut self, contacts: impl IntoIterator<Item = MeshContact>) {
        for contact in contacts {
            match contact.mark {
                Origin::Pair(key) => _ = self.known.insert(key),
                Origin::Wall(vertex) => self.held[vertex as usize] = true,
                Origin::Way => {}
            }
            self.contacts.push(contact);
        }
    }
}

impl SelfContacts {
    /// Changes the mean velocities of a step so that nothing passes through; returns whether they changed.
    ///
    /// # Errors
    /// If particles that have to keep their velocities pass through each other.
    pub fn resolve(&mut self, velocities: &mut Vec<DVec3>, step: ContactStep<'_>) -> Result<bool, Unresolved> {
        let h = step.h;
        let finite = |&vertex: &u32| (self.start[vertex as usize] + velocities[vertex as usize]).is_finite();
        if !self.vertices.iter().all(finite) {
            return Ok(false);
        }
        let free = velocities.clone();
        let thickness = self.rules.iter().map(|rule| rule.thickness).fold(0.0, f64::max);
        let mut active = self.start_from_last(&free, thickness, step);
        impulses::start(&mut active.contacts, velocities);
        impulses::solve(&mut active.contacts, velocities);
        self.keep_inside(&mut active, &free, velocities, step);
        self.mesh.sort(|vertex| self.start[vertex as usize]);
        self.nearby.begin(&self.vertices, (&self.start, velocities), h, thickness);
        for round in 0..=ROUNDS {
            if step.executor.stopped() {
                break;
            }
            let known = active.contacts.len();
            let longer = self.tauten(&mut active, velocities, h);
            self.keep_inside(&mut active, &free, velocities, step);
            self.cover(velocities, step);
            let margin = if round == 0 { AHEAD } else { LATE };
            let reached = self.reached(velocities, margin, step);
            active.extend(self.closing(&reached, &active.known, (margin, &free, velocities), step));
            let more = active.contacts.len() > known;
            let met = self.meetings(&reached, velocities, step);
            // The contacts of the first round are solved together with those of the last step, once.
            if met.is_empty() && !longer && (!more || round > 0) {
                break;
            }
            if round == ROUNDS {
                self.merge(met, velocities, step)?;
                break;
            }
            active.extend(met.iter().filter_map(|(near, closest)| self.on_the_way(near, closest, h)));
            impulses::solve(&mut active.contacts, velocities);
            if self.gains(&active.contacts, &free, velocities) {
                active.contacts.iter_mut().for_each(|contact| contact.least = contact.least.min(0.0));
                impulses::solve(&mut active.contacts, velocities);
            }
        }
        let held = self.limited.iter().zip(&active.taut).filter(|(_, taut)| taut.is_some());
        self.excess = held.map(|(limit, _)| limit.excess(&self.start, velocities, h)).fold(self.excess, f64::max);
        self.loads = Loads::new(&active.contacts, h);
        Ok(*velocities != free)
    }

    /// Contacts of the last step, and constraints of the springs that exceed their longest lengths.
    fn start_from_last(&self, free: &[DVec3], thickness: f64, step: ContactStep<'_>) -> Active {
        let (held, taut) = (vec![false; free.len()], vec![None; self.limited.len()]);
        let mut active = Active { contacts: Vec::new(), known: HashSet::new(), held, taut };
        active.extend(self.lasting(free, step));
        active.extend(self.loads.walls.iter().filter_map(|wall| self.resting(wall, thickness, step)));
        self.tauten(&mut active, free, step.h);
        active
    }

    /// Adds or renews the constraints of springs that exceed their longest lengths. Returns whether one exceeds it by more
    /// than the tolerance.
    fn tauten(&self, active: &mut Active, velocities: &[DVec3], h: f64) -> bool {
        let mut largest = 0.0_f64;
        for (limit, taut) in self.limited.iter().zip(&mut active.taut) {
            let excess = limit.excess(&self.start, velocities, h);
            if excess <= 0.0 {
                continue;
            }
            let needed = limit.needed(&self.start, velocities, h);
            if let Some(index) = *taut {
                active.contacts[index].least = needed.1;
            } else {
                let impulse = h * self.loads.of(limit.key()).unwrap_or(0.0);
                let Some(constraint) = limit.constraint(needed, impulse, &self.inverse_mass) else { continue };
                *taut = Some(active.contacts.len());
                active.contacts.push(constraint);
            }
            largest = largest.max(excess);
        }
        largest > limits::TOLERANCE
    }

    /// Whether contacts that bounce give more kinetic energy than fixed particles supply by the impulses on them. Newton's
    /// law of restitution treats one pair at a time; it may give energy where several pairs act together.
    fn gains(&self, contacts: &[MeshContact], free: &[DVec3], velocities: &[DVec3]) -> bool {
        if contacts.iter().all(|contact| contact.least <= 0.0) {
            return false;
        }
        let (mut before, mut after) = (0.0, 0.0);
        for vertex in self.vertices.iter().map(|&vertex| vertex as usize).filter(|&vertex| self.inverse_mass[vertex] > 0.0) {
            before += free[vertex].length_squared() / self.inverse_mass[vertex];
            after += velocities[vertex].length_squared() / self.inverse_mass[vertex];
        }
        let is_fixed = |end: Handle| end.inverse_mass(&self.inverse_mass) == 0.0;
        let supplied: f64 = contacts.iter().map(|contact| contact.supplied(is_fixed, velocities)).sum();
        0.5 * (after - before) > supplied + ROUNDING * (before + after)
    }

    /// Ends the paths of vertices at walls, if impulses lead them out, and adds their contacts.
    fn keep_inside(&self, active: &mut Active, free: &[DVec3], velocities: &mut [DVec3], step: ContactStep<'_>) {
        for &vertex in &self.vertices {
            let index = vertex as usize;
            if velocities[index] == free[index] {
                continue;
            }
            let (from, to) = (self.start[index], self.start[index] + step.h * velocities[index]);
            if let Some(inside) = (step.walls)(index, to) {
                if !active.held[index] {
                    active.extend(self.arriving(vertex, [from, to], inside, step.h));
                    active.held[index] = true;
                }
                velocities[index] = (inside.position - from) / step.h;
            }
        }
    }

    /// Finds the pairs that may touch with these velocities.
    fn cover(&mut self, velocities: &[DVec3], ContactStep { h, executor, .. }: ContactStep<'_>) {
        let paths = (self.start.as_slice(), velocities);
        self.nearby.cover((&mut self.mesh, &self.rules), &self.vertices, paths, h, executor);
    }

    /// Moves particles together until no pair meets.
    fn merge(
        &mut self,
        mut met: Vec<(Near, Closest)>,
        velocities: &mut [DVec3],
        step: ContactStep<'_>,
    ) -> Result<(), Unresolved> {
        self.merged += u64::from(!met.is_empty());
        let mut zones = Zones::new(self.start.len());
        let mut last = 0;
        for _ in 0..MERGERS {
            if met.is_empty() || step.executor.stopped() {
                return Ok(());
            }
            last = met[0].0.pair.nodes[0] as usize;
            met.iter().for_each(|(near, _)| zones.join(&near.pair.nodes));
            zones.merge(&self.inverse_mass, velocities, |members, velocity| self.within_walls(members, velocity, step));
            self.cover(velocities, step);
            let mut reached = self.reached(velocities, 0.0, step);
            reached.retain(|&index| self.nearby.pairs[index as usize].pair.nodes.iter().any(|&node| zones.contains(node)));
            met = self.meetings(&reached, velocities, step);
        }
        Err(Unresolved { particle: last })
    }
}
