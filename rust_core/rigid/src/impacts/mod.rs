//! Impacts of the bodies of a group, at their times and in sequence.
//!
//! A step is cut where a gap closes on the path of a trial piece. The impact then acts on the velocities at that time. Pairs
//! with restitution come first, one after another until none approaches. All contacts together without restitution follow.
//! Bounces that last less than a step are contacts at rest. Sources for the times: B. Mirtich, "Impulse-based dynamic
//! simulation of rigid body systems", 1996; of the law: W. J. Stronge, "Impact Mechanics", 2000.

mod paths;
mod strikes;
mod times;

use crate::direct;
use crate::face::largest_of;
use crate::island::{CLOSED, GroupContact, Island};
use crate::mover::Mover;
use crate::shapes::SolidShape;
use crate::sweep_steps::SweepPieces;

pub(crate) use paths::BodyPath;
pub(crate) use times::first_zero;

/// Velocity that is no motion, over the largest speed.
const REST: f64 = 1e-10;
/// Part of the energy that a step may gain by errors of its impulses.
const GAINED: f64 = 1e-2;
/// Length of a piece that is not taken, over the step.
const SHORTEST: f64 = 1e-9;
/// Largest number of pieces of a step: these, one for each body, and one for each size that the fastest moves, up to a bound.
const PIECES: usize = 8;
const MOST_SIZES: usize = 1000;
/// Largest number of rows of contacts in all pieces of a step that is cut at an impact. With a third of it, the energy of discs that
/// bounce in a heap has errors above order 2. With more, heaps of cuboids take longer and err as much.
const MOST_ROWS: usize = 128;

impl Island {
    /// Advances the group by `h` seconds, with each impact at its time. The last piece is left open. A step whose impulses would
    /// add energy, because iterations did not converge, is taken in equal pieces instead.
    pub fn advance(&mut self, shapes: &[SolidShape], h: f64, pieces: &SweepPieces) {
        let (movers, meters, joints) = (self.movers.clone(), self.meters, self.joints.clone());
        self.take_impacts(shapes, h, pieces);
        if self.gain(&movers, h) > self.meters.work - meters.work + self.open_work() {
            (self.movers, self.meters, self.joints) = (movers, meters, joints);
            self.contacts.clear();
            self.meters.retaken += 1;
            self.take_sweeps(shapes, (h, h), pieces);
        }
    }

    /// Kinetic energy gained since the start of a step beyond the work of the forces, less a tolerance [J].
    fn gain(&self, start: &[Mover], h: f64) -> f64 {
        let (mut gain, mut scale) = (0.0, 0.0);
        for (before, after) in start.iter().zip(&self.movers).filter(|(before, _)| !before.is_fixed()) {
            let mass = 1.0 / before.inverse_mass;
            let kinetic = |mover: &Mover| 0.5 * mass * mover.velocity.length_squared() + mover.rotational_energy();
            let mut after = *after;
            after.kick(0.5 * self.open);
            let turn = 0.5 * h * (before.angular_velocity() + after.angular_velocity());
            let work = mass * before.acceleration.dot(after.position - before.position) + before.torque.dot(turn);
            // A kick against a contact at rest is undone by the second half.
            let turning = before.torque.dot(before.inverse_inertia() * before.torque);
            let kick = h * h * (mass * before.acceleration.length_squared() + turning);
            gain += kinetic(&after) - kinetic(before) - work - kick;
            scale += kinetic(before) + work.abs();
            // Free rotation by splitting errs by up to (hω)²/12 of its energy, and not by more than the whole.
            let turn =
                if self.planar { 0.0 } else { h * before.angular_velocity().length().max(after.angular_velocity().length()) };
            gain -= (turn * turn / 12.0).min(1.0) * before.rotational_energy().max(after.rotational_energy());
        }
        gain - GAINED * scale
    }

    /// Advances the group by `h` seconds, with each impact at its time. After many impacts, or where many contacts bear, the rest
    /// of the step is taken in sweeps. Bodies that would need too many of them after many impacts stay where they are.
    fn take_impacts(&mut self, shapes: &[SolidShape], h: f64, pieces: &SweepPieces) {
        let sizes = ((h * self.speed() / self.least(|pair| pair.size)) as usize).min(MOST_SIZES);
        let most = PIECES + self.movers.len() + sizes;
        let mut rows = 0;
        let mut time = 0.0;
        for piece in 0..most {
            let (movers, faces) = (&self.movers, &self.faces);
            let way = |mover: &Mover| h * (mover.speed() + h * mover.acceleration.length());
            for pair in &mut self.pairs {
                pair.reach =
                    pair.bodies.iter().map(|&body| largest_of(body, movers, faces, way)).sum::<f64>() + CLOSED * pair.size;
            }
            self.find_contacts(shapes);
            self.strike(h);
            self.hold_resting(h);
            rows += self.rows_of_contacts();
            let are_many = piece > 0 && rows > MOST_ROWS && self.joints.is_empty();
            if !self.is_small() || (are_many && self.may_be_swept(h - time)) {
                return self.take_sweeps(shapes, (h - time, h), pieces);
            }
            let remaining = h - time;
            let mut start = self.movers.clone();
            self.begin_piece(remaining, h);
            let landing = self.landing();
            if !landing.is_empty() {
                self.movers.copy_from_slice(&start);
                self.renew_touches();
                self.settle(&landing);
                start.copy_from_slice(&self.movers);
                self.begin_piece(remaining, h);
            }
            let impact = self.first_impact(shapes, &start, remaining);
            let Some(after) = impact.filter(|&after| after < remaining) else { return };
            self.movers.copy_from_slice(&start);
            self.renew_touches();
            // An impact at the very start takes a piece of no length.
            if after > SHORTEST * h {
                self.begin_piece(after, h);
                self.kick_and_end_piece();
                time += after;
            }
        }
        if self.may_be_swept(h - time) {
            self.take_sweeps(shapes, (h - time, h), pieces);
        } else {
            self.wait(h);
        }
    }

    /// Number of rows of the contacts that hold.
    fn rows_of_contacts(&self) -> usize {
        self.contacts.iter().filter(|contact| contact.held).count() * if self.planar { 2 } else { 3 }
    }

    /// Whether the rows that hold are few enough to be solved by Newton steps.
    fn is_small(&self) -> bool {
        let contacts = self.rows_of_contacts();
        let joints: usize = self.joints.iter().map(|held| held.joint.count()).sum();
        contacts <= direct::MOST_OF_CONTACTS && contacts + joints <= direct::MOST
    }

    /// Holds the contacts that are closed and do not open in this step, and the limits that joints have reached.
    fn hold_resting(&mut self, h: f64) {
        let v = self.velocities();
        let still = REST * self.speed();
        for index in 0..self.contacts.len() {
            let contact = self.contacts[index];
            let closed = contact.touch.gap <= CLOSED * self.pairs[contact.pair].size;
            let opening = self.row(&contact, &v).map_or(f64::INFINITY, |row| row.normal.dot(row.velocity(&v)));
            self.contacts[index].bounces = opening > still;
            self.contacts[index].held = closed && opening <= (0.5 * h * self.pressing(&contact)).max(still);
        }
        self.hold_closed_limits();
    }

    /// Bound on the acceleration that presses a contact [m/s²].
    pub fn pressing(&self, contact: &GroupContact) -> f64 {
        let acceleration = |mover: &Mover| mover.acceleration.length();
        contact.bodies.iter().map(|&body| largest_of(body, &self.movers, &self.faces, acceleration)).sum()
    }
}
