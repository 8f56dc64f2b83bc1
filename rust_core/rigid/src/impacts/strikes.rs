//! Changes of velocities by impacts.

use super::{CLOSED, REST};
use crate::island::Island;
use crate::mover::Mover;
use crate::rows::{BodyVelocities, ContactRow, JointRows, Rows};

/// Velocity of a contact at rest, over that which forces give in a step.
const RESTING: f64 = 1e-4;
/// Largest numbers of passes over all pairs, and of iterations for one of them.
const MOST_PASSES: usize = 2000;
const MOST_ITERATIONS: usize = 200;

impl Island {
    /// Resolves the impacts at contacts that are closed.
    pub(super) fn strike(&mut self, h: f64) {
        let pushed = self.movers.iter().map(|mover| mover.acceleration.length()).fold(0.0, f64::max);
        let still = REST * self.speed() + RESTING * h * pushed;
        let mut v = BodyVelocities::of(&self.movers);
        let mut rows = Vec::new();
        for contact in &self.contacts {
            if contact.touch.gap <= CLOSED * self.pairs[contact.pair].size {
                let Some(row) = self.row(contact, &v) else { continue };
                // Bounces of less than a step are contacts at rest.
                let least = 0.5 * h * self.pressing(contact);
                rows.push((row, contact.restitution, least.max(still)));
            }
        }
        let approach = |row: &ContactRow, v: &BodyVelocities| -row.normal.dot(row.velocity(v));
        if !rows.iter().any(|(row, _, _)| approach(row, &v) > still) && !self.strikes_limit(&v, still) {
            return;
        }
        for _ in 0..MOST_PASSES {
            let mut struck = false;
            for each in &mut rows {
                let (row, restitution, least) = each;
                let rebound = *restitution * approach(row, &v);
                if rebound <= *least {
                    continue;
                }
                struck = true;
                if self.joints.is_empty() {
                    let (lost, supplied) = bounce(row, *restitution, &mut v);
                    self.meters.dissipated += lost;
                    self.meters.work += supplied;
                } else {
                    // Joints pass impulses on, and take part in each impact.
                    let one = std::slice::from_ref(each);
                    if !self.strike_together(one, &[rebound]) {
                        self.strike_together(one, &[0.0]);
                    }
                    v = BodyVelocities::of(&self.movers);
                }
            }
            if !struck {
                break;
            }
        }
        let bounces = rows.iter().map(|(row, restitution, least)| {
            let approach = approach(row, &v);
            if *restitution * approach > *least { *restitution * approach } else { 0.0 }
        });
        let targets: Vec<f64> = bounces.collect();
        rows.iter().for_each(|(row, _, _)| row.apply(&mut self.movers));
        let bounce = self.strike_together(&rows, &targets);
        if !bounce {
            self.strike_together(&rows, &vec![0.0; rows.len()]);
        }
    }

    /// Resolves the impacts of all contacts together, with these velocities after them. Returns false, and changes nothing, if
    /// that would add energy.
    fn strike_together(&mut self, struck: &[(ContactRow, f64, f64)], targets: &[f64]) -> bool {
        let start = BodyVelocities::of(&self.movers);
        let mut v = start.clone();
        let mut rows = Rows { planar: self.planar, ..Rows::default() };
        for held in &self.joints {
            let equations = self.equations(held).into_iter().map(|(row, _)| row);
            rows.joints.push(JointRows::new(held.bodies, equations.collect(), &v));
        }
        rows.link(&v);
        let limits = self.closed_limits(&v);
        rows.bounds.extend(limits.iter().map(|(_, row)| *row));
        for ((row, _, _), &target) in struck.iter().zip(targets) {
            rows.contacts.push(row.anew(target));
        }
        rows.solve(&mut v, self.accuracy.velocities * self.speed(), self.accuracy.iterations);
        let of = |row: &ContactRow, v: &BodyVelocities| (row.velocity(v), row.turning(v));
        let lost: f64 = rows.contacts.iter().map(|row| -row.work(of(row, &start), of(row, &v))).sum();
        // The error of the solve.
        let impulses: f64 = rows.contacts.iter().map(|row| row.impulse.normal + row.impulse.tangential.length()).sum();
        let error = impulses * self.accuracy.velocities * self.speed();
        if lost < -error && targets.iter().any(|&target| target > 0.0) {
            return false;
        }
        rows.apply(&mut self.movers);
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

/// Impact of one contact alone, which adds to its impulses; returns the energy that it dissipates and the energy that fixed
/// bodies supply [J].
fn bounce(row: &mut ContactRow, restitution: f64, v: &mut BodyVelocities) -> (f64, f64) {
    let before = (row.velocity(v), row.turning(v));
    let approach = -row.normal.dot(before.0);
    for restitution in [restitution, 0.0] {
        let mut one = row.anew(restitution * approach);
        one.settle(v, f64::EPSILON * approach, MOST_ITERATIONS);
        let lost = -one.work(before, (one.velocity(v), one.turning(v)));
        if lost >= 0.0 || restitution == 0.0 || one.friction.sliding == 0.0 {
            row.impulse = row.impulse.plus(&one.impulse);
            return (lost.max(0.0), one.supplied(v));
        }
        one.undo(v);
    }
    (0.0, 0.0)
}
