//! Steps of large groups of bodies: equal pieces with few iterations each, in which all contacts within reach are rows.
//!
//! Each piece has the two halves of a piece of a small group. The arms and normals of contacts stay as they are during the step,
//! and gaps follow from the velocities at the contacts. A gap that would close within a piece is closed at its end at most. Nothing
//! passes through anything, at the price of the time of impact. Overlaps are pushed apart by a damped spring, whose
//! velocity the second half removes. Source: E. Catto, "`Solver2D`", 2024 (small steps with soft contacts and relaxation).

use glam::DVec3;

use crate::island::{CLOSED, FirstHalf, Island, lost, pushed};
use crate::rotation::{Inertia, Orientation};
use crate::rows::{BodyVelocities, ContactImpulse, ContactRow, InPlane, InSpace, RowSpace, RowVector, add_energy};
use crate::shapes::SolidShape;
use crate::sweep_steps::SweepPieces;

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
    /// Softness in pieces of a length, of which the usual one is `usual` [s].
    fn of(length: f64, usual: f64) -> Self {
        let frequency = std::f64::consts::TAU * PART_OF_PERIOD / usual.max(length);
        let first = 2.0 * DAMPING + length * frequency;
        Self { rate: frequency / first, yields: 1.0 / (1.0 + length * frequency * first) }
    }
}

/// Contacts of a group during a step: in the plane if it has no joints.
#[derive(Debug, Clone)]
pub enum GroupSweep {
    InPlane(RowSweep<InPlane>),
    InSpace(RowSweep<InSpace>),
}

impl Default for GroupSweep {
    fn default() -> Self {
        Self::InSpace(RowSweep::default())
    }
}

/// Contacts of a group during a step.
#[derive(Debug, Clone, Default)]
pub struct RowSweep<S: RowSpace> {
    /// Rows of joints in a half of a piece.
    joints: FirstHalf,
    /// Rows of contacts, which last throughout the step, with the contact of each.
    rows: Vec<ContactRow<S>>,
    touching: Vec<Touching<S>>,
    /// Velocities, and those at the start of a half if there are joints.
    v: BodyVelocities<S>,
    start: BodyVelocities<S>,
    /// Energies of a piece that contacts and limits dissipate, and that is supplied [J].
    lost: f64,
    work: f64,
    /// Whether a fixed body moves.
    is_driven: bool,
}

/// Contact during a step.
#[derive(Debug, Clone, Copy)]
struct Touching<S: RowSpace> {
    /// Index of the contact.
    contact: usize,
    /// Gap [m].
    gap: f64,
    /// Velocity and angular velocity at the contact at the start of a half.
    slip: (S::Vector, S::Turn),
    /// Bound on the acceleration that presses the contact [m/s²].
    pressing: f64,
    /// Size of the smaller body [m].
    size: f64,
    restitution: f64,
    /// Least normal velocity at the end of the piece [m/s].
    rebound: f64,
    /// Whether the bodies approach at the start of a piece, whether they are apart there, and whether they overlap and are pushed
    /// apart. The normal impulse dissipates energy in the first two cases.
    strikes: bool,
    closes: bool,
    pushes: bool,
    /// Mean force of the last piece.
    load: ContactImpulse<S>,
}

impl Island {
    /// Advances the group by `h` seconds in equal pieces. The last one is left open.
    pub fn sweep(&mut self, shapes: &[SolidShape], h: f64, pieces: &SweepPieces) {
        self.accuracy = pieces.accuracy;
        let length = h / pieces.count as f64;
        self.joints.iter_mut().for_each(|held| held.held = [true; 2]);
        // Impacts may pass the largest speed on to any body.
        let way = 2.0 * h * self.speed();
        self.find_contacts(shapes, |_, pair| way.min(pair.size));
        let is_flat = self.planar && self.joints.is_empty();
        let mut sweep = match self.take_sweep() {
            GroupSweep::InSpace(_) if is_flat => GroupSweep::InPlane(RowSweep::default()),
            GroupSweep::InPlane(_) if !is_flat => GroupSweep::default(),
            sweep => sweep,
        };
        match &mut sweep {
            GroupSweep::InPlane(sweep) => sweep.take(self, length, pieces),
            GroupSweep::InSpace(sweep) => sweep.take(self, length, pieces),
        }
        self.open_sweep(sweep, length, h);
    }

    /// Ends the last piece of a sweep, at the velocities after the kick.
    pub fn end_sweep(&mut self) {
        let mut sweep = self.take_sweep();
        match &mut sweep {
            GroupSweep::InPlane(sweep) => sweep.end(self),
            GroupSweep::InSpace(sweep) => sweep.end(self),
        }
        self.keep_sweep(sweep);
    }

    /// Adds the impulses of the second half of the open piece of a sweep to the velocities after the kick, and leaves it open.
    pub fn add_second_half(&mut self) {
        let sweep = self.take_sweep();
        match sweep.clone() {
            GroupSweep::InPlane(mut sweep) => sweep.predict(self),
            GroupSweep::InSpace(mut sweep) => sweep.predict(self),
        }
        self.keep_sweep(sweep);
    }
}

impl<S: RowSpace> RowSweep<S> {
    /// Takes all pieces of a length but the second half of the last.
    fn take(&mut self, island: &mut Island, length: f64, pieces: &SweepPieces) {
        let softness = Softness::of(length, pieces.usual);
        self.begin(island);
        for piece in 0..pieces.count {
            let last = piece + 1 == pieces.count;
            self.first_half(island, (length, softness), piece == 0);
            self.drift(island, length, last);
            if !last {
                self.v.kick(&island.movers, 0.5 * length);
                self.second_half(island, length);
            }
        }
    }

    /// Rows of all contacts.
    fn begin(&mut self, island: &Island) {
        let moves = |velocity: DVec3, spin: DVec3| velocity != DVec3::ZERO || spin != DVec3::ZERO;
        self.is_driven = island.movers.iter().any(|mover| mover.is_fixed() && moves(mover.velocity, mover.spin));
        self.v.fill(&island.movers);
        self.rows.clear();
        self.touching.clear();
        for (index, contact) in island.contacts.iter().enumerate() {
            let Some(row) = island.row(contact, &self.v) else { continue };
            self.touching.push(Touching {
                contact: index,
                gap: contact.touch.gap,
                slip: row.slip_of(&self.v),
                pressing: island.pressing(contact),
                size: island.pairs[contact.pair].size,
                restitution: contact.restitution,
                rebound: 0.0,
                strikes: false,
                closes: false,
                pushes: false,
                load: ContactImpulse::narrow(&contact.load),
            });
            self.rows.push(row);
        }
    }

    /// Takes the impulses of the first half of a piece.
    fn first_half(&mut self, island: &Island, (length, softness): (f64, Softness), is_first: bool) {
        let joined = !island.joints.is_empty();
        if joined {
            self.start.clone_from(&self.v);
        }
        self.v.kick(&island.movers, 0.5 * length);
        self.joints.clear_joints();
        if let Some(v) = S::in_space(&mut self.v) {
            island.hold_joints((length, length), v, &mut self.joints);
        }
        let are_strange = is_first || self.touching.iter().any(|contact| contact.strikes);
        for (row, contact) in self.rows.iter_mut().zip(&mut self.touching) {
            let approach = -row.normal.dot(contact.slip.0);
            // Bounces of less than a piece are contacts at rest.
            let least = 0.5 * length * contact.pressing;
            contact.strikes = approach > least;
            contact.closes = contact.gap > CLOSED * contact.size;
            contact.pushes = !contact.strikes && contact.gap < -CLOSED * contact.size;
            let rebound = contact.restitution * approach;
            contact.rebound = if rebound > least { rebound } else { 0.0 };
            (row.least, row.yields) = if contact.gap < 0.0 {
                // Overlaps are left no faster than a fall through the size of the bodies is.
                let push = (-contact.gap * softness.rate).min((2.0 * contact.pressing * contact.size).sqrt());
                (push, softness.yields)
            } else {
                (-contact.gap / length, 0.0)
            };
            row.before = ContactImpulse::default();
            row.impulse = contact.load.scaled(0.5 * length);
        }
        self.start_impulses(are_strange);
        self.relax(island.accuracy.iterations);
        self.lost = 0.0;
        self.meter(length);
        self.work = self.supplied();
        for (row, contact) in self.rows.iter().zip(&mut self.touching) {
            contact.gap += length * row.normal.dot(contact.slip.0);
        }
    }

    /// Moves the bodies to the end of a piece.
    fn drift(&mut self, island: &mut Island, length: f64, last: bool) {
        if let Some(v) = S::in_space(&mut self.v) {
            take_velocities(island, v);
            island.movers.iter_mut().for_each(|mover| mover.drift(length));
            v.fill(&island.movers);
        } else {
            for (mover, body) in island.movers.iter_mut().zip(&self.v.bodies) {
                mover.position += S::widen(body.linear * length);
                mover.orientation.angle += S::widen_turn(body.angular * length).z;
                // Contacts need the rotation at the end of the step alone.
                if last && !mover.is_fixed() {
                    mover.orientation = Orientation::planar(mover.orientation.angle);
                }
            }
            if last {
                take_velocities(island, &self.v);
            }
        }
        if !island.joints.is_empty() {
            self.start.clone_from(&self.v);
        }
    }

    /// Solves for the impulses of the second half of a piece, at the velocities after the kick. Returns the rows of joints in the
    /// first half.
    fn solve_second_half(&mut self, island: &Island) -> FirstHalf {
        let first = std::mem::take(&mut self.joints);
        if let Some(v) = S::in_space(&mut self.v) {
            island.hold_joint_velocities(&first, v, &mut self.joints.rows);
        }
        for (row, contact) in self.rows.iter_mut().zip(&self.touching) {
            row.before = row.impulse;
            row.yields = 0.0;
            row.least = match row.before.normal > 0.0 {
                true => contact.rebound,
                // A gap that is open may close in the next piece.
                false if contact.gap > 0.0 => f64::NEG_INFINITY,
                false => 0.0,
            };
        }
        self.start_impulses(false);
        self.relax(island.accuracy.iterations);
        first
    }

    /// Takes the second half of a piece.
    fn second_half(&mut self, island: &mut Island, length: f64) {
        let first = self.solve_second_half(island);
        for (row, contact) in self.rows.iter().zip(&mut self.touching) {
            contact.load = row.before.plus(&row.impulse).scaled(1.0 / length);
            island.meters.pushed += if contact.pushes { pushed(row, contact.slip.0) } else { 0.0 };
        }
        if !island.joints.is_empty() {
            island.keep_joint_loads(&first, &self.joints.rows, length);
            island.keep_reactions(&first, &self.joints.rows);
        }
        self.meter(length);
        island.meters.work += self.work + self.supplied();
        // A sum below 0 is an error of the piece, which is left to the drift.
        island.meters.dissipated += self.lost.max(0.0);
    }

    /// Takes the velocities after the second half of the last piece.
    fn predict(&mut self, island: &mut Island) {
        self.v.fill(&island.movers);
        self.solve_second_half(island);
        take_velocities(island, &self.v);
    }

    /// Ends the last piece.
    fn end(&mut self, island: &mut Island) {
        self.v.fill(&island.movers);
        self.second_half(island, island.open);
        take_velocities(island, &self.v);
        for touching in &self.touching {
            island.contacts[touching.contact].load = touching.load.widen();
        }
    }

    /// Adds the initial impulses to the velocities. Those of the last step or of an impact may hold a load that nothing balances:
    /// they are strange. If these would add energy, all begin at zero.
    fn start_impulses(&mut self, are_strange: bool) {
        let free = are_strange.then(|| self.v.clone());
        if let Some(v) = S::in_space(&mut self.v) {
            self.joints.rows.start(v);
        }
        self.rows.iter().for_each(|row| row.start(&mut self.v));
        let Some(mut free) = free else { return };
        let stopped = self.stopped(&mut free);
        if add_energy(&self.rows, stopped, &free, &self.v) {
            self.joints.rows.clear_impulses();
            self.rows.iter_mut().for_each(|row| row.impulse = ContactImpulse::default());
            self.v = free;
        }
    }

    /// Iterates over all rows, in alternating order.
    fn relax(&mut self, iterations: usize) {
        let v = &mut self.v;
        for iteration in 0..iterations {
            if let Some(v) = S::in_space(v) {
                self.joints.rows.relax_all(iteration, v);
            }
            let mut relax = |row: &mut ContactRow<S>| {
                row.relax(v);
            };
            if iteration.is_multiple_of(2) {
                self.rows.iter_mut().for_each(&mut relax);
            } else {
                self.rows.iter_mut().rev().for_each(&mut relax);
            }
        }
    }

    /// Energy that limits of joints dissipate by the impulses of a half, from velocities before [J].
    fn stopped(&mut self, before: &mut BodyVelocities<S>) -> f64 {
        match (S::in_space(before), S::in_space(&mut self.v)) {
            (Some(before), Some(v)) => self.joints.rows.stopped(before, v),
            _ => 0.0,
        }
    }

    /// Energy that motors and moved bodies supply by the impulses of a half [J].
    fn supplied(&mut self) -> f64 {
        let moved = if self.is_driven { self.rows.iter().map(|row| row.supplied(&self.v)).sum() } else { 0.0 };
        match (S::in_space(&mut self.start), S::in_space(&mut self.v)) {
            (Some(start), Some(v)) => self.joints.rows.supplied(start, v) + moved,
            _ => moved,
        }
    }

    /// Adds the energy that contacts and limits dissipate in a half of a piece of a length [s]; takes the velocities of contacts for the start of
    /// the next.
    fn meter(&mut self, length: f64) {
        let mut start = std::mem::take(&mut self.start);
        self.lost += self.stopped(&mut start);
        self.start = start;
        for (row, contact) in self.rows.iter().zip(&mut self.touching) {
            let after = row.slip_of(&self.v);
            // Impacts of other contacts in the first half may have made the bodies approach.
            let approaches = -row.normal.dot(contact.slip.0) > 0.5 * length * contact.pressing;
            let strikes = contact.strikes || contact.closes || approaches;
            self.lost += lost(row, strikes, contact.slip, after);
            contact.slip = after;
        }
    }
}

/// Takes the velocities of a solve.
fn take_velocities<S: RowSpace>(island: &mut Island, v: &BodyVelocities<S>) {
    for (mover, body) in island.movers.iter_mut().zip(&v.bodies).filter(|(mover, _)| !mover.is_fixed()) {
        mover.velocity = S::widen(body.linear);
        if mover.inertia != Inertia::NONE {
            mover.spin = mover.inertia.spin(&mover.orientation, S::widen_turn(body.angular));
        }
    }
}
