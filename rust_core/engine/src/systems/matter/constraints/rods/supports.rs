//! Rods at walls: impacts and support of particles, resolved together with the rods that hold the particles.
//!
//! A contact is one more row, on one particle, in the direction n of its wall's normal. Its impulse pushes: p ≥ 0. Active
//! contacts that would pull are removed, and inactive contacts that are violated are added, until neither occurs. These are
//! the Kuhn–Tucker conditions of the step.
//!
//! Consider a particle with the gap g₀ > 0 at the start of a step that would have the gap g < 0 at its end. It meets its wall
//! at τ = h g₀/(g₀ − g) with the normal velocity u, and leaves it with −e u (Newton's law of restitution). With its normal
//! acceleration a
//!
//!     g ← (h − τ) (−e u + a (h − τ)/2),   n·v ← −e u + a (h − τ),   0 at the least
//!
//! The gap is set after the drift, and the rods of the particle share in it. The velocity is set at the end of the step. If
//! the particle touched at the start, the wall supports it, and both are 0.
//!
//! Impulses are the sums of both stages. They act at τ, or throughout the step of support (τ = h/2). They remove the energy
//! −p n·(v₀ + v₁ + a (2τ − h))/2, with the velocities v₀ at the start and v₁ at the end. Contacts of one network at different
//! times within a step are resolved together; this is of order 1. Where that error is a gain of energy, it is drift and no
//! negative dissipation. Source: J. J. Moreau, "Unilateral contact and dry friction in finite freedom dynamics", in Nonsmooth
//! Mechanics and Applications, CISM 302 (1988).

use glam::DVec3;

use super::network::{Network, Rod, Unsolved, along};
use super::{ConstrainedStep, SHIFT, SHIFT_OF_TENSIONS, count_reactions, resolution};
use crate::catalog::Space;
use crate::contacts::{ContactGap, Contacts};
use crate::error::Error;
use crate::math::{Real, Vector};
use crate::matter::{Matter, Properties};
use crate::parallel::{Executor, SERIAL};

/// Maximum number of rounds in the search for the active contacts. Only the first half of the rounds removes contacts.
const MOST_ROUNDS: usize = 60;
/// Tolerance of normal velocities, in units of the rounding error of the velocity.
const STILL: f64 = 64.0;

/// Contact of a particle of a rod with a wall.
#[derive(Debug, Clone, Copy)]
struct RodContact {
    /// Index of the particle in the network, of the contact's row, and of the wall.
    particle: usize,
    row: usize,
    wall: usize,
    normal: DVec3,
    /// Time at which the particle meets the wall, after the start of the step [s].
    meets: f64,
    /// Required gap [m] and normal velocity [m/s] at the end of the step. For tensions: the normal acceleration [m/s²]
    /// instead.
    gap: f64,
    speed: f64,
    /// Acceleration of the particle and its rods without contacts [m/s²].
    acceleration: DVec3,
    /// Sum of the contact's impulses in this step [N·s].
    impulse: DVec3,
    active: bool,
}

/// Walls of a scene, and the particles that meet them.
#[derive(Clone, Copy)]
pub struct RodWalls<'a, V: Vector> {
    pub contacts: &'a Contacts<V>,
    pub properties: &'a Properties<V>,
    /// Particles of the network.
    pub particles: &'a [u32],
}

impl<V: Vector> RodWalls<'_, V> {
    fn gap(&self, wall: usize, particle: usize, x: DVec3) -> ContactGap {
        self.contacts.gap(wall, x, self.properties, self.particles[particle] as usize, resolution::<V>())
    }

    /// Nearest walls of a particle, at most `most`.
    fn nearest(&self, particle: usize, x: DVec3, most: usize) -> Vec<ContactGap> {
        let walls = self.contacts.walls_of(self.properties, self.particles[particle] as usize);
        let mut gaps: Vec<ContactGap> = walls.map(|wall| self.gap(wall, particle, x)).collect();
        gaps.sort_by(|one, other| one.distance.total_cmp(&other.distance));
        gaps.truncate(most);
        gaps
    }
}

/// Contacts of rods with walls.
#[derive(Debug, Clone)]
pub struct Supports {
    /// Rods, then as many rows per particle as there are axes. The rows start at an additional last particle, which stands
    /// for all walls.
    network: Network,
    rods: usize,
    axes: usize,
    contacts: Vec<RodContact>,
    /// Positions [m] and velocities [m/s] at the start of the step.
    start: Vec<[DVec3; 2]>,
}

impl Supports {
    /// Contacts of a network of rods.
    ///
    /// # Errors
    /// If the equations do not fit into memory, or on an interrupt.
    pub fn new(rods: &Network, axes: usize, executor: &Executor) -> Result<Self, Error> {
        let count = rods.inverse_mass.len();
        let rows = (0..count as u32).flat_map(|end| (0..axes).map(move |_| Rod { ends: [count as u32, end], length: 1.0 }));
        let links: Vec<Rod> = rods.links.iter().copied().chain(rows).collect();
        let inverse_mass = rods.inverse_mass.iter().copied().chain([0.0]).collect();
        let (contacts, start) = (Vec::new(), vec![[DVec3::ZERO; 2]; count]);
        let network = Network::new(links, inverse_mass, executor)?;
        Ok(Self { network, rods: rods.links.len(), axes, contacts, start })
    }

    /// Records the state at the start of a step.
    pub fn start<V: Vector>(&mut self, particles: &[u32], matter: &Matter<V>) {
        for (start, &particle) in self.start.iter_mut().zip(particles) {
            *start = [matter.exact_position(particle as usize), matter.velocity.get(particle as usize).widen()];
        }
    }

    /// Keeps the particles outside walls after the drift of a step, at the end of which the rods, with these directions, have
    /// their lengths.
    ///
    /// # Errors
    /// If rods and walls contradict each other.
    pub fn hold_positions<V: Space>(
        &mut self,
        step: &mut ConstrainedStep<'_, V>,
        walls: &RodWalls<'_, V>,
        directions: &[DVec3],
    ) -> Result<(), Unsolved> {
        let h = step.h;
        self.contacts.clear();
        let from: Vec<DVec3> = walls.particles.iter().map(|&particle| step.matter.exact_position(particle as usize)).collect();
        let mobile = |particle: &usize| self.network.inverse_mass[*particle] > 0.0;
        let near: Vec<(usize, Vec<ContactGap>)> = (0..from.len())
            .filter(mobile)
            .map(|particle| (particle, walls.nearest(particle, from[particle], self.axes)))
            .collect();
        if near.iter().all(|(_, gaps)| gaps.first().is_none_or(|gap| gap.distance >= 0.0)) {
            return Ok(());
        }
        let mut contacts = Vec::new();
        for (particle, gaps) in near {
            let velocity = step.drift_velocity(walls.particles[particle] as usize);
            for (place, gap) in gaps.into_iter().enumerate() {
                let row = self.rods + self.axes * particle + place;
                let before = walls.gap(gap.wall, particle, self.start[particle][0]).distance;
                contacts.push(RodContact { particle, row, ..meeting(&gap, before, velocity, self.start[particle][1], h) });
            }
        }
        self.network.directions[..self.rods].copy_from_slice(directions);
        let epsilon = resolution::<V>();
        let gap = |contact: &RodContact, x: DVec3| walls.gap(contact.wall, contact.particle, x);
        self.settle(
            &mut contacts,
            &from,
            (SHIFT, step.executor),
            |_, rod, _, ends| rod.excess(ends, epsilon),
            |contact, x| (gap(contact, x).distance - contact.gap, gap(contact, x).slack),
            |contact, x| gap(contact, x).distance < -gap(contact, x).slack,
        )?;
        for (particle, &index) in walls.particles.iter().enumerate() {
            step.pull(index as usize, self.network.changes[particle]);
            step.matter.set_exact_position(index as usize, self.network.vectors[particle]);
        }
        for contact in contacts.iter_mut().filter(|contact| contact.active) {
            contact.impulse = -self.network.multipliers[contact.row] / h * contact.normal;
            push_out(step.matter, walls, contact);
        }
        count_reactions(&self.network, self.rods, walls.particles, step.matter, 1.0 / h);
        contacts.retain(|contact| contact.active);
        self.contacts = contacts;
        Ok(())
    }

    /// Removes velocities along rods, with these directions, and into walls at the end of a step. Tallies the
    /// energy that contacts dissipated in the step. Returns whether there are any contacts.
    ///
    /// # Errors
    /// If rods and walls contradict each other.
    pub fn hold_velocities<V: Space>(
        &mut self,
        step: &mut ConstrainedStep<'_, V>,
        walls: &RodWalls<'_, V>,
        directions: &[DVec3],
    ) -> Result<bool, Unsolved> {
        let (h, executor) = (step.h, step.executor);
        let matter = &mut *step.matter;
        let mut contacts = self.touching(matter, walls, h);
        if contacts.is_empty() {
            return Ok(false);
        }
        self.network.directions[..self.rods].copy_from_slice(directions);
        let epsilon = V::Scalar::EPSILON.to_f64();
        let from: Vec<DVec3> = walls.particles.iter().map(|&particle| matter.velocity.get(particle as usize).widen()).collect();
        self.settle(
            &mut contacts,
            &from,
            (SHIFT, executor),
            |_, _, direction, ends| along(direction, ends, epsilon),
            |contact, v| (contact.normal.dot(v) - contact.speed, 2.0 * epsilon * (v.length() + contact.speed)),
            |contact, v| contact.normal.dot(v) < contact.speed - STILL * epsilon * v.length(),
        )?;
        for (&vector, &particle) in self.network.vectors.iter().zip(walls.particles) {
            matter.velocity.set(particle as usize, V::narrow(vector));
        }
        count_reactions(&self.network, self.rods, walls.particles, matter, 1.0);
        let mut losses = Vec::with_capacity(contacts.len());
        for contact in contacts {
            let index = walls.particles[contact.particle] as usize;
            let push = if contact.active { -self.network.multipliers[contact.row] } else { 0.0 };
            let impulse = contact.impulse + push * contact.normal;
            let (start, end) = (self.start[contact.particle][1], matter.velocity.get(index).widen());
            let lost = -0.5 * impulse.dot(start + end + contact.acceleration * (2.0 * contact.meets - h));
            losses.push((index, lost));
        }
        matter.lose_in_contacts(&losses, false);
        Ok(true)
    }

    /// Tensions [N] of rods with these directions, if some touch walls; None if none does. The function `state` returns the
    /// position of a particle, its velocity, and its acceleration by all other forces. The function `residual` returns the
    /// residual of a rod for accelerations of its ends. A wall of the curvature κ requires n·a ≥ −κ v².
    pub fn tensions<V: Vector>(
        &mut self,
        walls: &RodWalls<'_, V>,
        directions: &[DVec3],
        state: impl Fn(usize) -> [DVec3; 3],
        residual: impl Fn(usize, &Rod, DVec3, [DVec3; 2]) -> (f64, f64),
    ) -> Option<Vec<f64>> {
        let states: Vec<[DVec3; 3]> = walls.particles.iter().map(|&particle| state(particle as usize)).collect();
        let mut contacts = Vec::new();
        for particle in (0..states.len()).filter(|&particle| self.network.inverse_mass[particle] > 0.0) {
            let [x, v, _] = states[particle];
            for (place, gap) in walls.nearest(particle, x, self.axes).into_iter().enumerate() {
                let leaves = gap.normal.dot(v) > STILL * V::Scalar::EPSILON.to_f64() * v.length();
                if gap.distance <= gap.slack && !leaves {
                    let row = self.rods + self.axes * particle + place;
                    let curvature = walls.contacts.curvature(gap.wall, x, v.normalize_or_zero());
                    let speed = -curvature * v.length_squared();
                    contacts.push(RodContact { particle, row, speed, active: true, ..support(&gap, 0.0) });
                }
            }
        }
        if contacts.is_empty() {
            return None;
        }
        self.network.directions[..self.rods].copy_from_slice(directions);
        let from: Vec<DVec3> = states.iter().map(|&[_, _, acceleration]| acceleration).collect();
        // If the iterations stop above rounding, the multipliers are those of the last one.
        let _ = self.settle(
            &mut contacts,
            &from,
            (SHIFT_OF_TENSIONS, &SERIAL),
            residual,
            |contact, a| (contact.normal.dot(a) - contact.speed, 2.0 * f64::EPSILON * (a.length() + contact.speed.abs())),
            |contact, a| contact.normal.dot(a) < contact.speed - STILL * f64::EPSILON * (a.length() + contact.speed.abs()),
        );
        Some(self.network.multipliers[..self.rods].to_vec())
    }

    /// Contacts of the drift, and contacts of particles that touch walls at its end.
    fn touching<V: Vector>(&self, matter: &Matter<V>, walls: &RodWalls<'_, V>, h: f64) -> Vec<RodContact> {
        let mut contacts = Vec::new();
        for particle in (0..walls.particles.len()).filter(|&particle| self.network.inverse_mass[particle] > 0.0) {
            let x = matter.exact_position(walls.particles[particle] as usize);
            let first = contacts.len();
            for known in self.contacts.iter().filter(|contact| contact.particle == particle) {
                contacts.push(RodContact { normal: walls.gap(known.wall, particle, x).normal, ..*known });
            }
            for gap in walls.nearest(particle, x, self.axes).into_iter().filter(|gap| gap.distance <= gap.slack) {
                let known = contacts[first..].iter().any(|contact: &RodContact| contact.wall == gap.wall);
                if !known && contacts.len() - first < self.axes {
                    contacts.push(RodContact { particle, ..support(&gap, h) });
                }
            }
            for (place, contact) in contacts[first..].iter_mut().enumerate() {
                contact.row = self.rods + self.axes * particle + place;
            }
        }
        contacts
    }

    /// Finds the active contacts, and the impulses of these and of all rods. `from` are the vectors of the particles before
    /// the projection.
    fn settle(
        &mut self,
        contacts: &mut [RodContact],
        from: &[DVec3],
        (shift, executor): (f64, &Executor),
        rod: impl Fn(usize, &Rod, DVec3, [DVec3; 2]) -> (f64, f64),
        row: impl Fn(&RodContact, DVec3) -> (f64, f64),
        violated: impl Fn(&RodContact, DVec3) -> bool,
    ) -> Result<(), Unsolved> {
        let Self { network, rods, .. } = self;
        let mut places = vec![usize::MAX; network.links.len()];
        contacts.iter().enumerate().for_each(|(place, contact)| places[contact.row] = place);
        let mut outcome = Ok(());
        for round in 0..MOST_ROUNDS {
            network.vectors[..from.len()].copy_from_slice(from);
            network.directions[*rods..].fill(DVec3::ZERO);
            for contact in contacts.iter().filter(|contact| contact.active) {
                network.directions[contact.row] = contact.normal;
            }
            network.factorize(shift, executor);
            let residual = |index: usize, link: &Rod, direction, ends: [DVec3; 2]| match contacts.get(places[index]) {
                Some(contact) if contact.active => row(contact, ends[1]),
                _ if index < *rods => rod(index, link, direction, ends),
                _ => (0.0, 1.0),
            };
            outcome = network.project(residual, executor);
            let mut settled = true;
            for contact in contacts.iter_mut() {
                let pulls = contact.active && network.multipliers[contact.row] > 0.0 && round < MOST_ROUNDS / 2;
                let enters = !contact.active && outcome.is_ok() && violated(contact, network.vectors[contact.particle]);
                if pulls || enters {
                    contact.active = enters;
                    settled = false;
                }
            }
            if settled {
                break;
            }
        }
        outcome
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        self.network.bytes() + size_of_val(self.contacts.as_slice()) + size_of_val(self.start.as_slice())
    }
}

/// Contact that supports a particle.
fn support(gap: &ContactGap, h: f64) -> RodContact {
    RodContact {
        particle: 0,
        row: 0,
        wall: gap.wall,
        normal: gap.normal,
        meets: 0.5 * h,
        gap: 0.0,
        speed: 0.0,
        acceleration: DVec3::ZERO,
        impulse: DVec3::ZERO,
        active: gap.distance < 0.0,
    }
}

/// Contact of a particle with the gap `gap` at the end of a drift of `h` seconds with `velocity`. At the start of the step
/// the gap was `before`, and the velocity `start`.
fn meeting(gap: &ContactGap, before: f64, velocity: DVec3, start: DVec3, h: f64) -> RodContact {
    let acceleration = 2.0 * (velocity - start) / h;
    let (normal_speed, normal_acceleration) = (gap.normal.dot(start), gap.normal.dot(acceleration));
    let meets = if before > gap.slack {
        if gap.distance < 0.0 { h * before / (before - gap.distance) } else { h }
    } else if -normal_speed > normal_acceleration.abs() * h {
        0.0
    } else {
        return RodContact { acceleration, ..support(gap, h) };
    };
    let left = h - meets;
    let away = -gap.restitution * (normal_speed + normal_acceleration * meets).min(0.0);
    RodContact {
        meets,
        gap: (left * (away + 0.5 * normal_acceleration * left)).max(0.0),
        speed: (away + normal_acceleration * left).max(0.0),
        acceleration,
        ..support(gap, h)
    }
}

/// Moves a particle out of its wall, if rounding left it inside.
fn push_out<V: Vector>(matter: &mut Matter<V>, walls: &RodWalls<'_, V>, contact: &RodContact) {
    let index = walls.particles[contact.particle] as usize;
    for round in 0..8 {
        let x = matter.exact_position(index);
        let gap = walls.gap(contact.wall, contact.particle, x);
        if gap.distance >= 0.0 {
            break;
        }
        let extra = 0.25 * f64::from(1 << round) * resolution::<V>() * x.abs().max_element();
        matter.set_exact_position(index, x + gap.normal * (extra - gap.distance));
    }
}
