//! Pieces of a step of a small group.

use arrayvec::ArrayVec;
use glam::DVec3;

use super::Island;
use crate::rows::{BodyVelocities, ContactImpulse, ContactRow, MOST_ROWS, Rows};

/// Length of a piece whose forces are kept, over the step: those of shorter ones are impulses of impacts.
const LONG: f64 = 0.1;

/// First half of a piece, on which the second depends.
#[derive(Debug, Default)]
pub struct FirstHalf {
    pub rows: Rows,
    /// Contact of each row; joint of each bounded row.
    pub contacts: Vec<usize>,
    pub(super) bounded: Vec<(usize, usize)>,
    /// Gap of each contact, and error of each joint, that are left at the end of the piece.
    remainders: Vec<f64>,
    pub(super) errors: Vec<ArrayVec<f64, MOST_ROWS>>,
    /// Velocities after the drift, and velocity and angular velocity of each contact.
    drifted: BodyVelocities,
    middle: Vec<(DVec3, DVec3)>,
    /// Energies dissipated by contacts, and supplied [J].
    pub lost: f64,
    pub work: f64,
}

impl FirstHalf {
    /// Removes the rows of joints.
    pub fn clear_joints(&mut self) {
        self.rows.joints.clear();
        self.rows.system = None;
        self.rows.bounds.clear();
        self.bounded.clear();
        self.errors.clear();
    }
}

impl Island {
    /// Tolerance of velocities in iterations [m/s].
    fn tolerance(&self, h: f64) -> f64 {
        let pushed = self.movers.iter().map(|mover| mover.acceleration.length()).fold(0.0, f64::max);
        self.accuracy.velocities * self.speed().max(h * pushed)
    }

    /// Takes the first half of a piece of a step of `h` seconds, and its drift. Gaps and errors of joints that are there at the
    /// start are closed within a step, however short the piece is.
    pub fn begin_piece(&mut self, length: f64, h: f64) {
        let start = BodyVelocities::of(&self.movers);
        let tolerance = self.tolerance(length);
        self.movers.iter_mut().for_each(|mover| mover.kick(0.5 * length));
        let mut v = BodyVelocities::of(&self.movers);
        let mut first = FirstHalf::default();
        first.rows.planar = self.planar;
        self.hold_joints((length, h), &v, &mut first);
        let poses = self.poses();
        let mut before = Vec::new();
        let mut anchors = Vec::new();
        for (index, contact) in self.contacts.iter().enumerate().filter(|(_, contact)| contact.held) {
            let Some(mut row) = self.row(contact, &v) else { continue };
            row.least = -contact.touch.gap / h;
            first.remainders.push(contact.touch.gap * (1.0 - length / h));
            row.impulse = contact.load.scaled(0.5 * length);
            row.impulse.tangential = row.impulse.tangential.reject_from_normalized(row.normal);
            before.push((row.velocity(&start), row.turning(&start)));
            anchors.push(contact.anchors(&poses));
            first.rows.contacts.push(row);
            first.contacts.push(index);
        }
        first.rows.start(&mut v);
        let kicked = self.movers.clone();
        for linearization in 0..self.accuracy.linearizations {
            first.rows.solve(&mut v, tolerance, self.accuracy.iterations);
            self.movers.copy_from_slice(&kicked);
            first.rows.apply(&mut self.movers);
            let middle = BodyVelocities::of(&self.movers);
            self.movers.iter_mut().for_each(|mover| mover.drift(length));
            let last = linearization + 1 == self.accuracy.linearizations;
            if last || !self.correct(&mut first, &anchors, (&v, &middle), length) {
                break;
            }
        }
        for (row, before) in first.rows.contacts.iter().zip(before) {
            first.lost += lost(row, false, before, (row.velocity(&v), row.turning(&v)));
        }
        first.lost += first.rows.stopped(&start, &v);
        first.work = first.rows.supplied(&start, &v);
        self.leave_open(first, length, h);
    }

    /// Leaves a piece open after its drift.
    fn leave_open(&mut self, mut first: FirstHalf, length: f64, h: f64) {
        // Velocities at the new poses, for the second half.
        let v = BodyVelocities::of(&self.movers);
        self.renew_touches();
        first.middle = first
            .contacts
            .iter()
            .map(|&index| {
                let contact = &self.contacts[index];
                self.row(contact, &v).map_or_else(Default::default, |row| (row.velocity(&v), row.turning(&v)))
            })
            .collect();
        first.drifted = v;
        (self.first, self.open, self.step) = (first, length, h);
    }

    /// Corrects the targets of the rows by what gaps, slips and joints came to; returns whether an error is too large.
    fn correct(
        &self,
        first: &mut FirstHalf,
        anchors: &[[(DVec3, DVec3); 2]],
        (v, middle): (&BodyVelocities, &BodyVelocities),
        length: f64,
    ) -> bool {
        let poses = self.poses();
        let mut worst = 0.0_f64;
        let mut size = f64::INFINITY;
        let rows = first.rows.contacts.iter_mut().zip(&first.contacts).zip(&first.remainders).zip(anchors);
        for (((row, &index), remainder), anchors) in rows {
            let contact = &self.contacts[index];
            size = size.min(self.pairs[contact.pair].size);
            let gap = contact.at(&poses).gap - remainder;
            let relative = row.velocity(v);
            row.least = row.normal.dot(relative) - gap / length;
            if row.impulse.normal > 0.0 || gap < 0.0 {
                worst = worst.max(gap.abs());
            }
            if row.friction.sliding > 0.0 && row.impulse.normal > 0.0 {
                let way = contact.way(anchors, &poses, middle, length);
                let slip = (way / length).reject_from_normalized(row.normal);
                row.slip = relative.reject_from_normalized(row.normal) - slip;
            }
        }
        for ((rows, held), errors) in first.rows.joints.iter_mut().zip(&self.joints).zip(&first.errors) {
            let bodies = rows.bodies;
            size = size.min(held.joint.lever);
            for ((row, (_, error)), left) in rows.rows.iter_mut().zip(self.equations(held)).zip(errors) {
                let error = error - left;
                row.target = row.velocity(bodies, v) - error / length;
                worst = worst.max(error.abs());
            }
        }
        worst > self.accuracy.positions * size
    }

    /// Takes the second half of a piece, at the velocities after the kick.
    pub fn end_piece(&mut self) {
        if std::mem::take(&mut self.is_swept) {
            let mut sweep = std::mem::take(&mut self.sweep);
            self.end_sweep(&mut sweep);
            self.sweep = sweep;
            return;
        }
        let first = std::mem::take(&mut self.first);
        let length = self.open;
        let start = BodyVelocities::of(&self.movers);
        let mut rows = Rows { planar: self.planar, ..Rows::default() };
        self.hold_joint_velocities(&first, &start, &mut rows);
        for (past, &index) in first.rows.contacts.iter().zip(&first.contacts) {
            let contact = &self.contacts[index];
            let Some(mut row) = self.row(contact, &start) else { continue };
            row.before = past.impulse;
            row.before.tangential = row.before.tangential.reject_from_normalized(row.normal);
            row.impulse = row.before;
            row.least = 0.0;
            rows.contacts.push(row);
        }
        let mut v = start;
        rows.start(&mut v);
        let tolerance = self.tolerance(length);
        rows.solve(&mut v, tolerance, self.accuracy.iterations);
        rows.apply(&mut self.movers);
        let mut losses = first.lost + rows.stopped(&first.drifted, &v);
        for (row, &middle) in rows.contacts.iter().zip(&first.middle) {
            losses += lost(row, false, middle, (row.velocity(&v), row.turning(&v)));
        }
        // A sum below 0 is an error of the piece, which is left to the drift.
        self.meters.dissipated += losses.max(0.0);
        self.meters.work += first.work + rows.supplied(&first.drifted, &v);
        if length >= LONG * self.step {
            self.keep_loads(&first, &rows, length);
        }
        self.keep_reactions(&first, &rows);
    }

    /// Keeps the mean forces of a piece.
    fn keep_loads(&mut self, first: &FirstHalf, rows: &Rows, length: f64) {
        self.past.clear();
        self.contacts.iter_mut().for_each(|contact| contact.load = ContactImpulse::default());
        for (row, &index) in rows.contacts.iter().zip(&first.contacts) {
            self.contacts[index].load = row.before.plus(&row.impulse).scaled(1.0 / length);
        }
        self.keep_joint_loads(first, rows, length);
    }
}

/// Energy that a contact dissipates in half a piece [J]: by friction, and by the normal impulse if it strikes.
pub fn lost(row: &ContactRow, strikes: bool, before: (DVec3, DVec3), after: (DVec3, DVec3)) -> f64 {
    let normal = 0.5 * row.impulse.normal * row.normal.dot(before.0 + after.0);
    -row.work(before, after) + if strikes { 0.0 } else { normal }
}
