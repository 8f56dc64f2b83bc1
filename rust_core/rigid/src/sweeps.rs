//! Steps of large groups of bodies: equal pieces with few iterations each, in which all contacts within reach are rows.
//!
//! Each piece has the two halves of [`crate::island`]. The arms and normals of contacts stay as they are during the step, and
//! gaps follow from the velocities at the contacts. A gap that would close within a piece is closed at its end at most, so that
//! nothing passes through anything, at the price of the time of impact. Overlaps are pushed apart by a damped spring, whose
//! velocity the second half removes. Source: E. Catto, "Solver2D", 2024 (small steps with soft contacts and relaxation).

use glam::DVec3;

use crate::island::{Accuracy, FirstHalf, Island, lost};
use crate::rows::{ContactImpulse, Rows, Velocities};
use crate::shapes::Shape;

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
struct Sweep {
    /// Rows of a half of a piece; those of contacts last throughout the step.
    half: FirstHalf,
    /// Gap of each contact [m].
    gaps: Vec<f64>,
    /// Velocity and angular velocity at each contact at the start of a half.
    slips: Vec<(DVec3, DVec3)>,
}

impl Island {
    /// Advances the group by `h` seconds in equal pieces. The last one is left open.
    pub fn sweep(&mut self, shapes: &[Shape], h: f64, (pieces, accuracy): (usize, Accuracy)) {
        self.accuracy = accuracy;
        // Impacts may pass the largest speed on to any body.
        let way = 2.0 * h * self.speed();
        self.find_contacts(shapes, |_, pair| way.min(pair.size));
        let length = h / pieces as f64;
        let mut sweep = self.start_sweep();
        for piece in 0..pieces {
            self.first_half(&mut sweep, length);
            if piece + 1 < pieces {
                self.second_half(&mut sweep, length);
            }
        }
        self.leave_open(sweep.half, length, h);
    }

    /// Rows of all contacts.
    fn start_sweep(&mut self) -> Sweep {
        let v = Velocities::of(&self.movers);
        let mut sweep = Sweep { half: FirstHalf::default(), gaps: Vec::new(), slips: Vec::new() };
        sweep.half.rows.planar = self.planar;
        for (index, contact) in self.contacts.iter().enumerate() {
            if let Some(row) = self.row(contact, &v) {
                sweep.slips.push((row.velocity(&v), row.turning(&v)));
                sweep.half.rows.contacts.push(row);
                sweep.half.contacts.push(index);
                sweep.gaps.push(contact.touch.gap);
            }
        }
        sweep
    }

    /// Takes the first half of a piece, and its drift.
    fn first_half(&mut self, sweep: &mut Sweep, length: f64) {
        let start = Velocities::of(&self.movers);
        self.movers.iter_mut().for_each(|mover| mover.kick(0.5 * length));
        let mut v = Velocities::of(&self.movers);
        let half = &mut sweep.half;
        half.clear_joints();
        self.hold_joints((length, length), &v, half);
        let softness = Softness::of(length);
        for ((row, &index), (&gap, slip)) in
            half.rows.contacts.iter_mut().zip(&half.contacts).zip(sweep.gaps.iter().zip(&sweep.slips))
        {
            let (pressing, size) = (self.pressing(&self.contacts[index]), self.pairs[self.contacts[index].pair].size);
            let contact = &mut self.contacts[index];
            let approach = -row.normal.dot(slip.0);
            // Bounces of less than a piece are contacts at rest.
            let least = 0.5 * length * pressing;
            contact.strikes = approach > least;
            contact.rebound = if contact.restitution * approach > least { contact.restitution * approach } else { 0.0 };
            // Overlaps are left no faster than a fall through the size of the bodies is.
            let push = (-gap * softness.rate).min((2.0 * pressing * size).sqrt());
            row.least = if gap > 0.0 { -gap / length } else { push };
            row.yields = if gap < 0.0 { softness.yields } else { 0.0 };
            row.before = ContactImpulse::default();
            row.impulse = contact.load.scaled(0.5 * length);
        }
        half.rows.start(&mut v);
        for iteration in 0..self.accuracy.iterations {
            half.rows.relax_all(iteration, &mut v);
        }
        half.lost = half.rows.stopped(&start, &v);
        half.work = half.rows.supplied(&start, &v);
        self.meter(sweep, &v);
        for (gap, (row, slip)) in sweep.gaps.iter_mut().zip(sweep.half.rows.contacts.iter().zip(&sweep.slips)) {
            *gap += length * row.normal.dot(slip.0);
        }
        sweep.half.rows.apply(&mut self.movers);
        self.movers.iter_mut().for_each(|mover| mover.drift(length));
    }

    /// Takes the second half of a piece.
    fn second_half(&mut self, sweep: &mut Sweep, length: f64) {
        self.movers.iter_mut().for_each(|mover| mover.kick(0.5 * length));
        let start = Velocities::of(&self.movers);
        let mut rows = Rows { planar: self.planar, ..Rows::default() };
        self.hold_joint_velocities(&sweep.half, &start, &mut rows);
        rows.contacts = std::mem::take(&mut sweep.half.rows.contacts);
        for (row, &index) in rows.contacts.iter_mut().zip(&sweep.half.contacts) {
            row.before = row.impulse;
            row.yields = 0.0;
            row.least = if row.before.normal > 0.0 { self.contacts[index].rebound } else { 0.0 };
        }
        let mut v = start.clone();
        rows.start(&mut v);
        for iteration in 0..self.accuracy.iterations {
            rows.relax_all(iteration, &mut v);
        }
        rows.apply(&mut self.movers);
        self.keep_loads(&sweep.half, &rows, length);
        self.keep_reactions(&sweep.half, &rows);
        sweep.half.lost += rows.stopped(&start, &v);
        self.meters.work += sweep.half.work + rows.supplied(&start, &v);
        sweep.half.rows.contacts = rows.contacts;
        self.meter(sweep, &v);
        // A sum below 0 is an error of the piece, which is left to the drift.
        self.meters.dissipated += sweep.half.lost.max(0.0);
    }

    /// Adds what the contacts dissipate in half a piece, and takes their velocities for the start of the next.
    fn meter(&self, sweep: &mut Sweep, v: &Velocities) {
        let half = &mut sweep.half;
        for ((row, slip), &index) in half.rows.contacts.iter().zip(&mut sweep.slips).zip(&half.contacts) {
            let after = (row.velocity(v), row.turning(v));
            half.lost += lost(row, self.contacts[index].strikes, *slip, after);
            *slip = after;
        }
    }
}
