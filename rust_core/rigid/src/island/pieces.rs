//! Pieces of a step of a small group.

use arrayvec::ArrayVec;
use glam::DVec3;
use physcore_base::simd::Number;

use super::{CLOSED, HIT, Island};
use crate::mover::Mover;
use crate::rows::{BodyVelocities, ContactImpulse, ContactRow, Linear, MOST_ROWS, RowAlgebra, Rows};

/// Length of a piece whose forces are kept, over the step: those of shorter ones are impulses of impacts.
const LONG: f64 = 0.1;
/// Largest number of linearizations of rows whose solves do not converge.
const UNSOLVED: usize = 2;
/// Depth of an overlap that vanishes in a step, over the size of the bodies: deeper ones, as where a joint breaks, take several.
const SHALLOW: f64 = 1e-3;
/// Velocity of a contact that lasts, over that which forces give in a piece.
const STILL: f64 = 1e-6;

/// First half of a piece, on which the second depends.
#[derive(Debug, Clone, Default)]
pub struct FirstHalf {
    pub rows: Rows,
    /// Contact of each row; joint of each bounded row.
    pub contacts: Vec<usize>,
    pub(super) bounded: Vec<(usize, usize)>,
    /// Gap of each contact, and error of each joint, that are left at the end of the piece.
    remainders: Vec<f64>,
    pub(super) errors: Vec<ArrayVec<f64, MOST_ROWS>>,
    /// Velocities after the drift, and velocity and angular velocity of each contact at the start and after the drift.
    drifted: BodyVelocities,
    starts: Vec<ContactSlip>,
    middles: Vec<ContactSlip>,
    /// Whether each contact is that of overlapping bodies, which do not strike.
    pushing: Vec<bool>,
    /// Half the work of the impulses on the changes of velocities by the kick [J].
    kicked: f64,
    /// Energies dissipated by contacts, and supplied [J].
    pub lost: f64,
    pub work: f64,
}

/// Velocity and angular velocity of a contact.
type ContactSlip = (DVec3, DVec3);

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
        let start = self.velocities();
        let tolerance = self.tolerance(length);
        self.movers.iter_mut().for_each(|mover| mover.kick(0.5 * length));
        let free = self.velocities();
        let mut first = FirstHalf::default();
        first.rows.planar = self.planar;
        self.hold_joints((length, h), &free, &mut first);
        let poses = self.poses();
        let mut anchors = Vec::new();
        for (index, contact) in self.contacts.iter().enumerate().filter(|(_, contact)| contact.held) {
            let Some(mut row) = self.row(contact, &free) else { continue };
            let size = self.pairs[contact.pair].size;
            row.least = -contact.touch.gap.max(-SHALLOW * size) / h;
            first.remainders.push(contact.touch.gap + length * row.least);
            row.impulse = contact.load.scaled(0.5 * length);
            row.impulse.tangential = row.impulse.tangential.reject_from_normalized(row.normal);
            first.starts.push(row.slip_of(&start));
            anchors.push(contact.anchors(&poses));
            first.pushing.push(!contact.bounces && contact.touch.gap < -CLOSED * size);
            first.rows.contacts.push(row);
            first.contacts.push(index);
        }
        let kicked = self.movers.clone();
        let mut v = free.clone();
        for linearization in 1..=self.accuracy.linearizations {
            let converged;
            (v, converged) = first.rows.solve(&free, tolerance, self.accuracy.iterations);
            self.movers.copy_from_slice(&kicked);
            first.rows.apply(&mut self.movers, &self.faces);
            let middle = self.velocities();
            self.movers.iter_mut().for_each(|mover| mover.drift(length));
            let last = linearization >= if converged { self.accuracy.linearizations } else { UNSOLVED };
            if last || !self.correct(&mut first, &anchors, (&v, &middle), length) {
                break;
            }
        }
        first.kicked = work_on_kick(&kicked, &self.movers, length);
        for ((row, &index), &before) in first.rows.contacts.iter().zip(&first.contacts).zip(&first.starts) {
            first.lost += lost(row, self.contacts[index].bounces, before, row.slip_of(&v));
        }
        first.lost += first.rows.stopped(&start, &v);
        first.work = first.rows.supplied(&start, &v);
        self.leave_open(first, length, h);
    }

    /// Leaves a piece open after its drift.
    fn leave_open(&mut self, mut first: FirstHalf, length: f64, h: f64) {
        // Velocities at the new poses, for the second half.
        let v = self.velocities();
        self.renew_touches();
        let slip = |&index: &usize| self.row(&self.contacts[index], &v).map_or_else(Default::default, |row| row.slip_of(&v));
        first.middles = first.contacts.iter().map(slip).collect();
        first.drifted = v;
        (self.first, self.open, self.step) = (first, length, h);
    }

    /// Contacts that open at the start of the open piece and are pressed again by its end: their bounces are shorter than a step.
    pub fn landing(&self) -> Vec<usize> {
        let rows = self.first.rows.contacts.iter().zip(&self.first.contacts);
        let lands = |row: &ContactRow, index: usize| self.contacts[index].bounces && row.impulse.normal > 0.0;
        rows.filter(|(row, index)| lands(row, **index)).map(|(_, index)| *index).collect()
    }

    /// Ends a step of `h` seconds in the present state: the bodies wait.
    pub fn wait(&mut self, h: f64) {
        self.meters.waits += 1;
        (self.first, self.open, self.step) = (FirstHalf::default(), 0.0, h);
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

    /// Predicts the impulses of the second half of the open piece, as those under the forces at the start of the step.
    pub fn predict(&mut self) {
        let open = self.movers.clone();
        self.movers.iter_mut().for_each(|mover| mover.kick(0.5 * self.open));
        let kicked = self.movers.clone();
        if self.is_swept {
            self.add_second_half();
        } else {
            self.close_piece(&self.first).0.apply(&mut self.movers, &self.faces);
        }
        let changes = self.movers.iter().zip(&kicked);
        self.ahead = changes.map(|(after, before)| [after.velocity - before.velocity, after.spin - before.spin]).collect();
        self.movers = open;
    }

    /// Takes the second half of the open piece, under the forces at the start of the step.
    pub fn kick_and_end_piece(&mut self) {
        let half = 0.5 * self.open;
        self.movers.iter_mut().for_each(|mover| mover.kick(half));
        self.end_piece();
    }

    /// Takes the second half of a piece, at the velocities after the kick.
    pub fn end_piece(&mut self) {
        if std::mem::take(&mut self.is_swept) {
            self.end_sweep();
            return;
        }
        let first = std::mem::take(&mut self.first);
        let length = self.open;
        let kicked = self.movers.clone();
        let (rows, v) = self.close_piece(&first);
        rows.apply(&mut self.movers, &self.faces);
        let stopped = rows.stopped(&first.drifted, &v);
        let mut losses = first.lost + stopped;
        for (((row, &index), pushing), &before) in
            rows.contacts.iter().zip(&first.contacts).zip(&first.pushing).zip(&first.middles)
        {
            losses += lost(row, self.contacts[index].bounces, before, row.slip_of(&v));
            self.meters.pushed += if *pushing { pushed(row, before.0) } else { 0.0 };
        }
        let ends = rows.contacts.iter().map(|row| row.velocity(&v)).zip(&first.contacts).zip(&first.starts);
        if stopped != 0.0
            || ends.zip(&rows.contacts).any(|(((end, &index), start), row)| self.changes(index, row, [start.0, end]))
        {
            losses += first.kicked - work_on_kick(&kicked, &self.movers, length);
        }
        // A sum below 0 is an error of the piece, which is left to the drift.
        self.meters.dissipated += losses.max(0.0);
        self.meters.work += first.work + rows.supplied(&first.drifted, &v);
        if length >= LONG * self.step {
            self.keep_loads(&first, &rows, length);
        }
        self.keep_reactions(&first, &rows);
    }

    /// Impulses of the second half of the open piece, and the velocities after them, from those after the kick.
    fn close_piece(&self, first: &FirstHalf) -> (Rows, BodyVelocities) {
        let start = self.velocities();
        let mut rows = Rows { planar: self.planar, ..Rows::default() };
        self.hold_joint_velocities(first, &start, &mut rows);
        for (past, &index) in first.rows.contacts.iter().zip(&first.contacts) {
            let contact = &self.contacts[index];
            let Some(mut row) = self.row(contact, &start) else { continue };
            row.before = past.impulse;
            row.before.tangential = row.before.tangential.reject_from_normalized(row.normal);
            row.impulse = row.before;
            // A body that has left the contact flies on.
            let flies = past.impulse.normal == 0.0 && contact.touch.gap > HIT * self.pairs[contact.pair].size;
            row.least = if flies { f64::NEG_INFINITY } else { 0.0 };
            rows.contacts.push(row);
        }
        let (v, _) = rows.solve(&start, self.tolerance(self.open), self.accuracy.iterations);
        (rows, v)
    }

    /// Whether a contact begins or ends in the open piece, or its sliding does, given its velocities at the start and the end.
    fn changes(&self, contact: usize, row: &ContactRow, velocities: [DVec3; 2]) -> bool {
        let contact = &self.contacts[contact];
        let still = STILL * self.open * self.pressing(contact);
        let [slid, slides] = velocities.map(|velocity| velocity.reject_from_normalized(row.normal).length() > still);
        contact.bounces || slid != slides || row.normal.dot(velocities[1]) > still
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

/// Half the work of impulses on the changes of velocities by the kick before them [J].
///
/// Impulses P and Q of the halves of a piece take Σ P·(u₀ + u½)/2 + Σ Q·(u½ + u₁)/2 + (κ·Q − κ·P)/2 from the energy, with the
/// changes κ by the kicks. Where contacts last, the last part is an error of order 3, which is left to the drift. Where they begin
/// or end, P and Q differ, and it belongs to their work.
fn work_on_kick(kicked: &[Mover], ended: &[Mover], length: f64) -> f64 {
    let of = |(before, after): (&Mover, &Mover)| {
        let linear = before.acceleration.dot(after.velocity - before.velocity) / before.inverse_mass;
        linear + (before.inverse_inertia() * before.torque).dot(after.spin - before.spin)
    };
    let free = kicked.iter().zip(ended).filter(|(before, _)| !before.is_fixed());
    0.25 * length * free.map(of).sum::<f64>()
}

/// Energy that a contact dissipates in half a piece [J]: by friction, and by the normal impulse if it strikes.
#[inline(always)]
pub fn lost<S: RowAlgebra>(
    row: &ContactRow<S>,
    strikes: <S::Number as Number>::Mask,
    before: (S::Vector, S::Turn),
    after: (S::Vector, S::Turn),
) -> S::Number {
    let normal = S::Number::constant(0.5) * row.impulse.normal * row.normal.dot(before.0 + after.0);
    S::Number::select(strikes, S::Number::constant(0.0), normal) - row.work(before, after)
}

/// Work of the normal impulses of a piece at the velocity of its drift [J]: the energy gained as the gap grows under load.
#[inline(always)]
pub fn pushed<S: RowAlgebra>(row: &ContactRow<S>, drift: S::Vector) -> S::Number {
    (row.before.normal + row.impulse.normal) * row.normal.dot(drift)
}
