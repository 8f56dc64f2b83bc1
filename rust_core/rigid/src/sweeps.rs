//! Steps of large groups of bodies: equal pieces with few iterations each, in which all contacts within reach are rows.
//!
//! Each piece has the two halves of a piece of a small group. The arms and normals of contacts stay as they are during the step,
//! and gaps follow from the velocities at the contacts. A gap that would close within a piece is closed at its end at most. Nothing
//! passes through anything, at the price of the time of impact. Overlaps are pushed apart by a damped spring, whose
//! velocity the second half removes. Source: E. Catto, "`Solver2D`", 2024 (small steps with soft contacts and relaxation).

use glam::DVec3;

use crate::island::{Accuracy, CLOSED, FirstHalf, Island, lost, pushed};
use crate::rotation::Inertia;
use crate::rows::{BodyVelocities, ContactImpulse, ContactRow, Rows};
use crate::shapes::SolidShape;

/// Damping ratio of contacts that overlap, and the part of a period that a piece takes.
const DAMPING: f64 = 10.0;
const PART_OF_PERIOD: f64 = 0.25;

/// Response of contacts that overlap.
#[derive(Debug, Clone, Copy)]
struct Softness {
    /// Rate at which overlaps vanish [1/s].
    rate: f64,
    /// Part of the impulse that yields.
    yields: f64,
}

impl Softness {
    /// Softness in pieces of a length [s].
    fn of(length: f64) -> Self {
        let frequency = std::f64::consts::TAU * PART_OF_PERIOD / length;
        let first = 2.0 * DAMPING + length * frequency;
        Self { rate: frequency / first, yields: 1.0 / (1.0 + length * frequency * first) }
    }
}

/// Contacts of a group during a step.
#[derive(Debug, Default)]
pub struct GroupSweep {
    /// Rows of a half of a piece; those of contacts last throughout the step.
    half: FirstHalf,
    /// Each contact of the rows.
    touching: Vec<Touching>,
    /// Velocities, and those at the start of a half if there are joints.
    v: BodyVelocities,
    start: BodyVelocities,
}

/// Contact during a step.
#[derive(Debug, Clone, Copy)]
struct Touching {
    /// Gap [m].
    gap: f64,
    /// Velocity and angular velocity at the contact at the start of a half.
    slip: (DVec3, DVec3),
    /// Bound on the acceleration that presses the contact [m/s²].
    pressing: f64,
    /// Size of the smaller body [m].
    size: f64,
    restitution: f64,
    /// Least normal velocity at the end of the piece [m/s].
    rebound: f64,
    /// Whether the normal impulse dissipates energy, and whether it pushes overlapping bodies apart.
    strikes: bool,
    pushes: bool,
    /// Mean force of the last piece.
    load: ContactImpulse,
}

impl Island {
    /// Advances the group by `h` seconds in equal pieces. The last one is left open.
    pub fn sweep(&mut self, shapes: &[SolidShape], h: f64, (pieces, accuracy): (usize, Accuracy)) {
        self.accuracy = accuracy;
        self.joints.iter_mut().for_each(|held| held.held = [true; 2]);
        // Impacts may pass the largest speed on to any body.
        let way = 2.0 * h * self.speed();
        self.find_contacts(shapes, |_, pair| way.min(pair.size));
        let length = h / pieces as f64;
        let mut sweep = self.start_sweep();
        for piece in 0..pieces {
            let last = piece + 1 == pieces;
            self.first_half(&mut sweep, length, last);
            if !last {
                sweep.v.kick(&self.movers, 0.5 * length);
                self.second_half(&mut sweep, length);
            }
        }
        self.open_sweep(sweep, length, h);
    }

    /// Ends the last piece of a sweep, at the velocities after the kick.
    pub fn end_sweep(&mut self, sweep: &mut GroupSweep) {
        sweep.v.fill(&self.movers);
        self.second_half(sweep, self.open);
        self.take_velocities(&sweep.v);
        for (&index, touching) in sweep.half.contacts.iter().zip(&sweep.touching) {
            self.contacts[index].load = touching.load;
        }
    }

    /// Impulses of the second half of the open piece of a sweep, from the velocities after the kick.
    pub fn close_sweep(&self, sweep: &GroupSweep) -> Rows {
        let GroupSweep { half, touching, .. } = sweep;
        self.solve_second_half(half.rows.contacts.clone(), half, touching, &mut BodyVelocities::of(&self.movers))
    }

    /// Rows of all contacts.
    fn start_sweep(&mut self) -> GroupSweep {
        let mut sweep = self.take_sweep();
        sweep.v.fill(&self.movers);
        sweep.half.rows.planar = self.planar;
        sweep.half.rows.contacts.clear();
        sweep.half.contacts.clear();
        sweep.touching.clear();
        for (index, contact) in self.contacts.iter().enumerate() {
            let Some(row) = self.row(contact, &sweep.v) else { continue };
            sweep.touching.push(Touching {
                gap: contact.touch.gap,
                slip: (row.velocity(&sweep.v), row.turning(&sweep.v)),
                pressing: self.pressing(contact),
                size: self.pairs[contact.pair].size,
                restitution: contact.restitution,
                rebound: 0.0,
                strikes: false,
                pushes: false,
                load: contact.load,
            });
            sweep.half.rows.contacts.push(row);
            sweep.half.contacts.push(index);
        }
        sweep
    }

    /// Takes the first half of a piece, and its drift.
    fn first_half(&mut self, sweep: &mut GroupSweep, length: f64, last: bool) {
        let GroupSweep { half, touching, v, start } = sweep;
        let joined = !self.joints.is_empty();
        if joined {
            start.clone_from(v);
        }
        v.kick(&self.movers, 0.5 * length);
        half.clear_joints();
        self.hold_joints((length, length), v, half);
        let softness = Softness::of(length);
        for (row, contact) in half.rows.contacts.iter_mut().zip(touching.iter_mut()) {
            let approach = -row.normal.dot(contact.slip.0);
            // Bounces of less than a piece are contacts at rest.
            let least = 0.5 * length * contact.pressing;
            contact.strikes = approach > least;
            contact.pushes = !contact.strikes && contact.gap < -CLOSED * contact.size;
            let rebound = contact.restitution * approach;
            contact.rebound = if rebound > least { rebound } else { 0.0 };
            // Overlaps are left no faster than a fall through the size of the bodies is.
            let push = (-contact.gap * softness.rate).min((2.0 * contact.pressing * contact.size).sqrt());
            (row.least, row.yields) = if contact.gap < 0.0 { (push, softness.yields) } else { (-contact.gap / length, 0.0) };
            row.before = ContactImpulse::default();
            row.impulse = contact.load.scaled(0.5 * length);
        }
        half.rows.start_safely(v);
        for iteration in 0..self.accuracy.iterations {
            half.rows.relax_all(iteration, v);
        }
        half.lost = if joined { half.rows.stopped(start, v) } else { 0.0 };
        half.work = if joined || self.driven() { half.rows.supplied(if joined { start } else { v }, v) } else { 0.0 };
        half.lost += meter(half, touching, v);
        for (row, contact) in half.rows.contacts.iter().zip(touching.iter_mut()) {
            contact.gap += length * row.normal.dot(contact.slip.0);
        }
        self.take_velocities(v);
        for mover in &mut self.movers {
            if self.planar && !last && !joined {
                // Contacts need the rotation matrix at the end of the step alone.
                mover.orientation.angle += length * mover.angular_velocity().z;
                mover.position += length * mover.velocity;
            } else {
                mover.drift(length);
            }
        }
        if !self.planar || joined {
            v.fill(&self.movers);
        }
        if joined {
            start.clone_from(v);
        }
    }

    /// Takes the second half of a piece, at the velocities after the kick.
    fn second_half(&mut self, sweep: &mut GroupSweep, length: f64) {
        let GroupSweep { half, touching, v, start } = sweep;
        let joined = !self.joints.is_empty();
        let contacts = std::mem::take(&mut half.rows.contacts);
        let rows = self.solve_second_half(contacts, half, touching, v);
        for (row, contact) in rows.contacts.iter().zip(touching.iter_mut()) {
            contact.load = row.before.plus(&row.impulse).scaled(1.0 / length);
            self.meters.pushed += if contact.pushes { pushed(row, contact.slip.0) } else { 0.0 };
        }
        if joined {
            self.keep_joint_loads(half, &rows, length);
            self.keep_reactions(half, &rows);
            half.lost += rows.stopped(start, v);
        }
        self.meters.work += half.work;
        if joined || self.driven() {
            self.meters.work += rows.supplied(if joined { start } else { v }, v);
        }
        half.rows.contacts = rows.contacts;
        half.lost += meter(half, touching, v);
        // A sum below 0 is an error of the piece, which is left to the drift.
        self.meters.dissipated += half.lost.max(0.0);
        self.take_velocities(v);
    }

    /// Impulses of the second half of a piece, given the rows of contacts in the first. Changes the velocities after the kick.
    fn solve_second_half(
        &self,
        contacts: Vec<ContactRow>,
        half: &FirstHalf,
        touching: &[Touching],
        v: &mut BodyVelocities,
    ) -> Rows {
        let mut rows = Rows { planar: self.planar, ..Rows::default() };
        if !self.joints.is_empty() {
            self.hold_joint_velocities(half, v, &mut rows);
        }
        rows.contacts = contacts;
        for (row, contact) in rows.contacts.iter_mut().zip(touching) {
            row.before = row.impulse;
            row.yields = 0.0;
            row.least = match row.before.normal > 0.0 {
                true => contact.rebound,
                // A gap that is open may close in the next piece.
                false if contact.gap > 0.0 => f64::NEG_INFINITY,
                false => 0.0,
            };
        }
        rows.start(v);
        for iteration in 0..self.accuracy.iterations {
            rows.relax_all(iteration, v);
        }
        rows
    }

    /// Whether a fixed body moves.
    fn driven(&self) -> bool {
        self.movers.iter().any(|mover| mover.is_fixed() && (mover.velocity != DVec3::ZERO || mover.spin != DVec3::ZERO))
    }

    /// Takes the velocities of a solve.
    fn take_velocities(&mut self, v: &BodyVelocities) {
        for (body, mover) in self.movers.iter_mut().enumerate().filter(|(_, mover)| !mover.is_fixed()) {
            let [linear, angular] = v.of_body(body);
            mover.velocity = linear;
            if mover.inertia != Inertia::NONE {
                mover.spin = mover.inertia.spin(&mover.orientation, angular);
            }
        }
    }
}

/// Energy that contacts dissipate in half a piece [J]; takes their velocities for the start of the next.
fn meter(half: &FirstHalf, touching: &mut [Touching], v: &BodyVelocities) -> f64 {
    let mut sum = 0.0;
    for (row, contact) in half.rows.contacts.iter().zip(touching) {
        let after = (row.velocity(v), row.turning(v));
        sum += lost(row, contact.strikes, contact.slip, after);
        contact.slip = after;
    }
    sum
}
