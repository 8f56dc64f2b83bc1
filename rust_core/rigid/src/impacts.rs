//! Impacts of the bodies of a group, at their times and in sequence.
//!
//! A step is cut where a gap closes on the path of a trial piece. The impact then acts on the velocities at that time. Pairs
//! with restitution come first, one after another until none approaches. All contacts together without restitution follow.
//! Bounces that last less than a step are contacts at rest. Sources for the times: B. Mirtich, "Impulse-based dynamic
//! simulation of rigid body systems", 1996; of the law: W. J. Stronge, "Impact Mechanics", 2000.

use glam::DVec3;

use crate::collision;
use crate::direct;
use crate::island::{Accuracy, BodyPair, CLOSED, GroupContact, Island};
use crate::mover::Mover;
use crate::pose::Pose;
use crate::rows::{BodyVelocities, ContactRow, JointRows, Rows};
use crate::shapes::SolidShape;

/// Gap at which a contact has closed, over the size of the bodies.
pub(crate) const HIT: f64 = 1e-9;
/// Velocity that is no motion, over the largest speed.
const REST: f64 = 1e-10;
/// Velocity of a contact at rest, over that which forces give in a step.
const RESTING: f64 = 1e-4;
/// Part of the energy that a step may gain by errors of its impulses.
const GAINED: f64 = 1e-2;
/// Largest numbers of steps towards a time of impact, of passes over all pairs, and of iterations for one of them.
const MOST_ADVANCES: usize = 100;
const MOST_PASSES: usize = 2000;
const MOST_ITERATIONS: usize = 200;
/// Length of a piece that is not taken, over the step.
const SHORTEST: f64 = 1e-9;
/// Number of pieces of a step: these, and so many for each body.
const PIECES: usize = 8;
const PIECES_PER_BODY: usize = 1;

/// Path of a body during a piece: a parabola that begins with the velocity at the start, and a free rotation.
pub(crate) struct BodyPath<'a> {
    start: &'a Mover,
    end: &'a Mover,
    length: f64,
}

impl BodyPath<'_> {
    /// Body after a time.
    pub fn mover(&self, time: f64) -> Mover {
        let position = self.start.position + time * (self.start.velocity + time * self.bend());
        let mover = Mover { position, spin: self.end.spin, ..*self.start };
        Mover { orientation: mover.turned(time), ..mover }
    }

    /// Pose after a time.
    fn at(&self, time: f64) -> Pose {
        self.mover(time).pose()
    }

    /// Half the acceleration [m/s²].
    fn bend(&self) -> DVec3 {
        (self.end.position - self.start.position - self.length * self.start.velocity) / (self.length * self.length)
    }

    fn velocity(&self, time: f64) -> DVec3 {
        self.start.velocity + 2.0 * time * self.bend()
    }

    /// Largest speed of surface points by rotation [m/s].
    fn turning(&self) -> f64 {
        self.end.angular_velocity().length() * self.end.arm
    }
}

impl Island {
    /// Advances the group by `h` seconds, with each impact at its time. The last piece is left open. A step whose impulses would
    /// add energy, because iterations did not converge, is taken in equal pieces instead.
    pub fn advance(&mut self, shapes: &[SolidShape], h: f64, rest: (usize, Accuracy)) {
        let (movers, meters, joints) = (self.movers.clone(), self.meters, self.joints.clone());
        self.take_impacts(shapes, h, rest);
        if self.gain(&movers, h) > self.meters.work - meters.work + self.open_work() {
            (self.movers, self.meters, self.joints) = (movers, meters, joints);
            self.contacts.clear();
            self.sweep(shapes, h, rest);
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
        }
        gain - GAINED * scale
    }

    /// Advances the group by `h` seconds, with each impact at its time. After many impacts, or
    /// where many contacts bear, the rest of the step is taken in equal pieces.
    fn take_impacts(&mut self, shapes: &[SolidShape], h: f64, rest: (usize, Accuracy)) {
        let most = PIECES + PIECES_PER_BODY * self.movers.len();
        let mut time = 0.0;
        for _ in 0..most {
            let reach = |island: &Self, pair: &BodyPair| {
                let of = |&body: &usize| {
                    let mover = &island.movers[body];
                    h * (mover.velocity.length()
                        + mover.angular_velocity().length() * mover.arm
                        + h * mover.acceleration.length())
                };
                pair.bodies.iter().map(of).sum::<f64>() + CLOSED * pair.size
            };
            self.find_contacts(shapes, reach);
            self.strike(h);
            self.hold_resting(h);
            if !self.is_small() {
                break;
            }
            let start = self.movers.clone();
            let remaining = h - time;
            self.begin_piece(remaining, h);
            let impact = self.first_impact(shapes, &start, remaining);
            let Some(after) = impact.filter(|&after| after < remaining) else { return };
            self.movers.copy_from_slice(&start);
            self.renew_touches();
            // An impact at the very start takes a piece of no length.
            if after > SHORTEST * h {
                self.begin_piece(after, h);
                self.movers.iter_mut().for_each(|mover| mover.kick(0.5 * after));
                self.end_piece();
                time += after;
            }
        }
        self.sweep(shapes, h - time, rest);
    }

    /// Whether the rows that hold are few enough to be solved by Newton steps.
    fn is_small(&self) -> bool {
        let tangents = if self.planar { 1 } else { 2 };
        let contacts = self.contacts.iter().filter(|contact| contact.held).count() * (1 + tangents);
        let joints: usize = self.joints.iter().map(|held| self.equations(held).len()).sum();
        contacts <= direct::MOST_OF_CONTACTS && contacts + joints <= direct::MOST
    }

    /// Holds the contacts that are closed and do not open in this step, and the limits that joints have reached.
    fn hold_resting(&mut self, h: f64) {
        let v = BodyVelocities::of(&self.movers);
        let still = REST * self.speed();
        for index in 0..self.contacts.len() {
            let contact = self.contacts[index];
            let closed = contact.touch.gap <= CLOSED * self.pairs[contact.pair].size;
            let opening = self.row(&contact, &v).map_or(f64::INFINITY, |row| row.normal.dot(row.velocity(&v)));
            self.contacts[index].held = closed && opening <= (0.5 * h * self.pressing(&contact)).max(still);
        }
        self.hold_closed_limits();
    }

    /// Bound on the acceleration that presses a contact [m/s²].
    pub fn pressing(&self, contact: &GroupContact) -> f64 {
        contact.bodies.iter().map(|&body| self.movers[body].acceleration.length()).sum()
    }

    /// Resolves the impacts at contacts that are closed.
    fn strike(&mut self, h: f64) {
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
        let mut v = BodyVelocities::of(&self.movers);
        let mut rows = Rows { planar: self.planar, ..Rows::default() };
        for held in &self.joints {
            let equations = held.joint.equations(held.bodies.map(|body| &self.movers[body]));
            rows.joints.push(JointRows::new(held.bodies, equations.into_iter().map(|(row, _)| row).collect(), &v));
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

    /// Time of the first impact on the paths of a piece.
    fn first_impact(&self, shapes: &[SolidShape], start: &[Mover], length: f64) -> Option<f64> {
        let paths: Vec<BodyPath<'_>> =
            start.iter().zip(&self.movers).map(|(start, end)| BodyPath { start, end, length }).collect();
        let mut first = None;
        let mut known = 0;
        for (index, pair) in self.pairs.iter().enumerate() {
            let count = self.contacts[known..].iter().take_while(|contact| contact.pair == index).count();
            let contacts = &self.contacts[known..known + count];
            known += count;
            let closed = |contact: &&GroupContact| contact.held || contact.start_gap(&paths) <= CLOSED * pair.size;
            let until = first.unwrap_or(length);
            let time = if contacts.iter().any(|contact| closed(&contact)) {
                let open = contacts.iter().filter(|contact| !contact.held);
                open.filter_map(|contact| contact.closes(&paths, until, HIT * pair.size)).reduce(f64::min)
            } else {
                self.approach(pair, &paths, shapes, until)
            };
            first = time.or(first);
        }
        let limit = self.first_limit(&paths, first.unwrap_or(length));
        limit.or(first)
    }

    /// Time until `until` at which the gap of a pair closes, by conservative advancement. Each pair of convex parts has a gap along
    /// its own normal.
    fn approach(&self, pair: &BodyPair, paths: &[BodyPath<'_>], shapes: &[SolidShape], until: f64) -> Option<f64> {
        let [one, other] = pair.bodies.map(|body| &paths[body]);
        let [first, second] = pair.bodies.map(|body| &shapes[self.surfaces[body].shape]);
        let dimension = if self.planar { 2 } else { 3 };
        let turning = one.turning() + other.turning();
        let bend = one.bend() - other.bend();
        let mut found = Vec::new();
        let mut time = 0.0;
        for _ in 0..MOST_ADVANCES {
            let velocity = one.velocity(time) - other.velocity(time);
            let left = until - time;
            let reach = (velocity.length() + turning + bend.length() * left) * left + HIT * pair.size;
            collision::separations((first, &one.at(time)), (second, &other.at(time)), reach, dimension, &mut found);
            let mut wait = f64::INFINITY;
            for &(gap, normal) in &found {
                if gap <= HIT * pair.size {
                    return Some(time);
                }
                // The gap is at least gap − speed·t − bend·t² after a time t.
                let speed = normal.dot(velocity) + turning;
                let bend = normal.dot(bend).max(0.0);
                let denominator = speed + (speed * speed + 4.0 * bend * gap).sqrt();
                if denominator > 0.0 {
                    wait = wait.min(2.0 * gap / denominator);
                }
            }
            time += wait;
            if time >= until {
                return None;
            }
        }
        Some(time)
    }
}

impl GroupContact {
    fn gap(&self, paths: &[BodyPath<'_>], time: f64) -> f64 {
        let [one, other] = self.bodies.map(|body| paths[body].at(time));
        self.point.at([&one, &other], self.touch.normal).gap
    }

    fn start_gap(&self, paths: &[BodyPath<'_>]) -> f64 {
        self.gap(paths, 0.0)
    }

    /// Time until `until` at which the gap of an open contact of a pair falls to `least`, if it is below at the end.
    fn closes(&self, paths: &[BodyPath<'_>], until: f64, least: f64) -> Option<f64> {
        let end = self.gap(paths, until) - least;
        if end >= 0.0 {
            return None;
        }
        let mut low = (0.0, self.gap(paths, 0.0) - least);
        if low.1 <= 0.0 {
            // The contact opens first: begin at the top of the parabola through its ends.
            let step = 1e-3 * until;
            let rate = (self.gap(paths, step) - least - low.1) / step;
            let top = 0.5 * rate * until * until / (rate * until - (end - low.1));
            low = (top, self.gap(paths, top) - least);
            if !(top > 0.0 && top < until && low.1 > 0.0) {
                return None;
            }
        }
        Some(first_zero(low, (until, end), 0.1 * least, |time| self.gap(paths, time) - least))
    }
}

/// Time at which a gap falls to 0, to a tolerance [m], between times with their gaps, by the Illinois method.
pub(crate) fn first_zero(mut low: (f64, f64), mut high: (f64, f64), tolerance: f64, gap: impl Fn(f64) -> f64) -> f64 {
    let until = high.0;
    let mut side = 0;
    for _ in 0..MOST_ADVANCES {
        let time = (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1);
        let gap = gap(time);
        if gap.abs() <= tolerance || high.0 - low.0 <= f64::EPSILON * until {
            return time;
        }
        if gap > 0.0 {
            low = (time, gap);
            high.1 *= if side == 1 { 0.5 } else { 1.0 };
            side = 1;
        } else {
            high = (time, gap);
            low.1 *= if side == -1 { 0.5 } else { 1.0 };
            side = -1;
        }
    }
    low.0
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
