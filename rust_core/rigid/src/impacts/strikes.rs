//! Changes of velocities by impacts.

use super::REST;
use crate::island::{CLOSED, GroupContact, Island};
use crate::rows::{BodyVelocities, BoundedRow, ContactRow, JointRows, Rows};

/// Velocity of a contact at rest, over that which forces give in a step.
const RESTING: f64 = 1e-4;
/// Largest number of passes over all pairs, beside one for each contact, and of iterations for one pair.
const MOST_PASSES: usize = 100;
const MOST_ITERATIONS: usize = 200;
/// Rounding of the energy of an impact, over the impulses times the velocities.
const ROUNDING: f64 = 1e-13;

/// Contact that is closed.
#[derive(Debug, Clone, Copy)]
struct ClosedContact {
    row: ContactRow,
    pair: usize,
    restitution: f64,
    /// Least velocity after a bounce [m/s]: slower ones end within the step.
    least: f64,
}

impl ClosedContact {
    /// Velocity at which the bodies approach each other [m/s].
    fn approach(&self, v: &BodyVelocities) -> f64 {
        -self.row.normal.dot(self.row.velocity(v))
    }

    /// Normal velocity after an impact [m/s]; 0 if the contact does not bounce.
    fn rebound(&self, v: &BodyVelocities) -> f64 {
        let rebound = self.restitution * self.approach(v);
        if rebound > self.least { rebound } else { 0.0 }
    }
}

impl Island {
    /// Resolves the impacts at contacts that are closed.
    pub(super) fn strike(&mut self, h: f64) {
        let pushed = self.movers.iter().map(|mover| mover.acceleration.length()).fold(0.0, f64::max);
        let still = REST * self.speed() + RESTING * h * pushed;
        let mut v = self.velocities();
        let mut closed = self.closed_contacts(h, still, &v);
        if !closed.iter().any(|each| each.approach(&v) > still) && !self.strikes_limit(&v, still) {
            return;
        }
        for _ in 0..MOST_PASSES + closed.len() {
            let mut struck = false;
            for pair in closed.chunk_by_mut(|one, other| one.pair == other.pair) {
                let rebounds: Vec<f64> = pair.iter().map(|each| each.rebound(&v)).collect();
                if rebounds.iter().all(|&rebound| rebound == 0.0) {
                    continue;
                }
                struck = true;
                if self.joints.is_empty() {
                    let (lost, supplied) = bounce(pair, &rebounds, &mut v);
                    self.meters.dissipated += lost;
                    self.meters.work += supplied;
                } else {
                    // Joints pass impulses on, and take part in each impact.
                    self.strike_together(pair, &rebounds);
                    v = self.velocities();
                }
            }
            if !struck {
                break;
            }
        }
        let rebounds: Vec<f64> = closed.iter().map(|each| each.rebound(&v)).collect();
        closed.iter().for_each(|each| each.row.apply(&mut self.movers, &self.faces));
        self.strike_together(&closed, &rebounds);
    }

    /// Ends the bounces of contacts: their normal velocities vanish, and with them energy. No other contact closes.
    pub(super) fn settle(&mut self, bouncing: &[usize]) {
        let start = self.velocities();
        let (ends, others): (Vec<_>, Vec<_>) =
            (0..self.contacts.len()).filter(|&index| self.contacts[index].held).partition(|index| bouncing.contains(index));
        let row = |&index: &usize| Some((self.contacts[index].pair, self.row(&self.contacts[index], &start)?));
        let closed = |(pair, row): (usize, ContactRow)| ClosedContact { row, pair, restitution: 0.0, least: 0.0 };
        let held: Vec<ClosedContact> = others.iter().filter_map(row).map(closed).collect();
        let bounds: Vec<BoundedRow> = ends.iter().filter_map(row).filter_map(|(_, row)| equation(&row, &start)).collect();
        self.strikes_to(&held, &vec![0.0; held.len()], &bounds);
        bouncing.iter().for_each(|&index| self.contacts[index].bounces = false);
    }

    /// Contacts that are closed, in the order of their pairs.
    fn closed_contacts(&self, h: f64, still: f64, v: &BodyVelocities) -> Vec<ClosedContact> {
        let closed = |&&contact: &&GroupContact| contact.touch.gap <= CLOSED * self.pairs[contact.pair].size;
        let of = |contact: &GroupContact| {
            // Bounces of less than a step are contacts at rest.
            let least = (0.5 * h * self.pressing(contact)).max(still);
            let (pair, restitution) = (contact.pair, contact.restitution);
            self.row(contact, v).map(|row| ClosedContact { row, pair, restitution, least })
        };
        self.contacts.iter().filter(closed).filter_map(of).collect()
    }

    /// Resolves the impacts of contacts together, with these least velocities after them, or with none if that would add energy.
    fn strike_together(&mut self, struck: &[ClosedContact], rebounds: &[f64]) {
        if !self.strikes_to(struck, rebounds, &[]) {
            self.strikes_to(struck, &vec![0.0; struck.len()], &[]);
        }
    }

    /// Resolves the impacts of all contacts together, with these velocities after them. Returns false, and changes nothing, if
    /// that would add energy.
    fn strikes_to(&mut self, struck: &[ClosedContact], targets: &[f64], bounces: &[BoundedRow]) -> bool {
        let start = self.velocities();
        let mut rows = Rows { planar: self.planar, ..Rows::default() };
        for held in &self.joints {
            let equations = self.equations(held).into_iter().map(|(row, _)| row);
            rows.joints.push(JointRows::new(held.bodies, equations.collect(), &start));
        }
        rows.link(&start);
        let limits = self.closed_limits(&start);
        rows.bounds.extend(limits.iter().map(|(_, row)| *row).chain(bounces.iter().copied()));
        rows.contacts.extend(struck.iter().zip(targets).map(|(each, &target)| each.row.anew(target)));
        let (v, _) = rows.solve(&start, self.accuracy.velocities * self.speed(), self.accuracy.iterations);
        let lost: f64 = rows.contacts.iter().map(|row| -row.work(row.slip_of(&start), row.slip_of(&v))).sum();
        // The error of the solve.
        let impulses: f64 = rows.contacts.iter().map(|row| row.impulse.normal + row.impulse.tangential.length()).sum();
        let error = impulses * self.accuracy.velocities * self.speed();
        if lost < -error && targets.iter().any(|&target| target > 0.0) {
            return false;
        }
        rows.apply(&mut self.movers, &self.faces);
        self.meters.dissipated += (lost + rows.stopped(&start, &v)).max(0.0);
        self.meters.work += rows.supplied(&start, &v);
        for (held, joint) in self.joints.iter_mut().zip(&rows.joints) {
            joint.rows.iter().for_each(|row| held.react(row));
        }
        for ((joint, _), bounded) in limits.iter().zip(&rows.bounds) {
            self.joints[*joint].react(&bounded.row);
        }
        true
    }
}

/// Impact of the contacts of one pair alone, which adds to their impulses. Returns the energies that it dissipates and that fixed
/// bodies supply [J].
fn bounce(pair: &mut [ClosedContact], rebounds: &[f64], v: &mut BodyVelocities) -> (f64, f64) {
    let before: Vec<_> = pair.iter().map(|each| each.row.slip_of(v)).collect();
    let fastest = pair.iter().map(|each| each.approach(v)).fold(0.0, f64::max);
    for bounces in [true, false] {
        let of_contact = |(each, &rebound): (&ClosedContact, &f64)| each.row.anew(if bounces { rebound } else { 0.0 });
        let mut rows: Vec<ContactRow> = pair.iter().zip(rebounds).map(of_contact).collect();
        settle(&mut rows, v, f64::EPSILON * fastest);
        let lost: f64 = rows.iter().zip(&before).map(|(row, &before)| -row.work(before, row.slip_of(v))).sum();
        let impulses: f64 = rows.iter().map(|row| row.impulse.normal + row.impulse.tangential.length()).sum();
        if !bounces || lost >= -ROUNDING * impulses * fastest {
            pair.iter_mut().zip(&rows).for_each(|(each, row)| each.row.impulse = each.row.impulse.plus(&row.impulse));
            return (lost.max(0.0), rows.iter().map(|row| row.supplied(v)).sum());
        }
        rows.iter().for_each(|row| row.undo(v));
    }
    (0.0, 0.0)
}

/// Solves contacts alone, in alternating order, to a tolerance [m/s].
fn settle(rows: &mut [ContactRow], v: &mut BodyVelocities, tolerance: f64) {
    for iteration in 0..MOST_ITERATIONS {
        let mut change = 0.0_f64;
        let mut relax = |row: &mut ContactRow| change = change.max(row.relax(v));
        if iteration.is_multiple_of(2) {
            rows.iter_mut().for_each(&mut relax);
        } else {
            rows.iter_mut().rev().for_each(&mut relax);
        }
        if change <= tolerance {
            return;
        }
    }
}

/// Row that holds the normal velocity of a contact at 0, by impulses of either sign.
fn equation(row: &ContactRow, v: &BodyVelocities) -> Option<BoundedRow> {
    BoundedRow::new(row.bodies, row.along(row.normal), [f64::NEG_INFINITY, f64::INFINITY], v)
}
