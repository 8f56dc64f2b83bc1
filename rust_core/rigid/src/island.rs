//! Group of bodies that contacts and joints connect, during a step.
//!
//! A step is velocity Verlet with constraint impulses, as in RATTLE. It is taken in pieces of length k:
//!
//!     v½ = v + k/2 a + M⁻¹ Jᵀ(x) λ,   x ← x + k v½    λ so that gaps at the end are ≥ 0, and joints are closed
//!     v ← v½ + k/2 a + M⁻¹ Jᵀ(x) μ                     μ so that no gap closes, with λ + μ ≥ 0
//!
//! Friction acts with both halves. Impulses of contacts that last do no work but that of friction, which is the impulse times
//! the mean of the slips before and after. Sources: H. C. Andersen, J. Comput. Phys. 52, 24 (1983); J. J. Moreau, "Numerical
//! aspects of the sweeping process", Comput. Meth. Appl. Mech. Eng. 177, 329 (1999).

use glam::DVec3;

use crate::collision;
use crate::contact::{ContactPoint, Touch};
use crate::joints::Joint;
use crate::mover::Mover;
use crate::pose::Pose;
use crate::rows::{BoundedRow, ContactImpulse, ContactRow, Friction, JointRows, MOST_ROWS, Row, Rows, Velocities};
use crate::shapes::Shape;
use crate::sweeps::Sweep;

/// Numerical parameters of contacts and joints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Accuracy {
    /// Largest number of iterations over all rows.
    pub iterations: usize,
    /// Change of relative velocities that ends the iterations, over the largest velocity.
    pub velocities: f64,
    /// Largest number of linearizations of gaps and errors of joints.
    pub linearizations: usize,
    /// Error of gaps and joints that ends them, over the size of the bodies.
    pub positions: f64,
}

impl Accuracy {
    /// Parameters of small groups.
    pub const FINE: Self = Self { iterations: 200, velocities: 1e-10, linearizations: 10, positions: 1e-11 };
}

/// Length of a piece whose forces are kept, over the step: those of shorter ones are impulses of impacts.
const LONG: f64 = 0.1;

/// Surface of a mover.
#[derive(Debug, Clone, Copy)]
pub struct Surface {
    /// Index of the shape.
    pub shape: usize,
    /// Friction; None for a particle, which has the friction of the body that it meets.
    pub friction: Option<Friction>,
    pub restitution: f64,
}

/// Identity of a contact: the two bodies, and the features that touch.
pub type ContactKey = (u32, u32, u32);

/// Contact of two bodies of a group.
#[derive(Debug, Clone, Copy)]
pub struct Contact {
    /// Index of the pair.
    pub pair: usize,
    pub bodies: [usize; 2],
    pub key: ContactKey,
    pub point: ContactPoint,
    /// Contact at the present poses.
    pub touch: Touch,
    pub friction: Friction,
    pub restitution: f64,
    /// Mean force and moment of the last piece.
    pub load: ContactImpulse,
    /// Whether a row holds the contact in this piece.
    pub held: bool,
    /// Whether the contact closes fast in this piece, so that its normal impulse dissipates energy.
    pub strikes: bool,
    /// Least normal velocity at the end of the piece [m/s].
    pub rebound: f64,
}

/// Pair of bodies that may touch.
#[derive(Debug, Clone, Copy)]
pub struct Pair {
    pub bodies: [usize; 2],
    /// Indices of the bodies in the world.
    pub key: (u32, u32),
    /// Least size of the two bodies [m].
    pub size: f64,
}

/// Joint of two bodies of a group.
#[derive(Debug, Clone, Copy)]
pub struct HeldJoint {
    /// Index in the world.
    pub index: usize,
    pub bodies: [usize; 2],
    pub joint: Joint,
    /// Mean forces of the rows and of the bounds in the last piece.
    pub loads: [f64; MOST_ROWS],
    pub bounds: [f64; 3],
    /// Impulse on the second body, and angular impulse about its anchor, in this step.
    pub reaction: [DVec3; 2],
}

impl HeldJoint {
    /// Adds the impulse of a row to the reaction.
    pub fn react(&mut self, row: &Row) {
        self.reaction[0] += row.impulse * row.linear;
        // Forces act at the anchor.
        if row.linear == DVec3::ZERO {
            self.reaction[1] += row.impulse * row.angular[1];
        }
    }
}

/// Energies of a group in a step [J].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Meters {
    /// Dissipated by contacts and by the limits of joints.
    pub dissipated: f64,
    /// Dissipated by the damping of springs.
    pub damped: f64,
    /// Supplied by motors, and by bodies that move as prescribed.
    pub work: f64,
}

/// First half of a piece, on which the second depends.
#[derive(Debug, Default)]
pub struct FirstHalf {
    pub rows: Rows,
    /// Contact of each row; joint of each bounded row.
    pub contacts: Vec<usize>,
    bounded: Vec<(usize, usize)>,
    /// Gap of each contact, and error of each joint, that are left at the end of the piece.
    remainders: Vec<f64>,
    errors: Vec<arrayvec::ArrayVec<f64, MOST_ROWS>>,
    /// Velocities after the drift, and velocity and angular velocity of each contact.
    drifted: Velocities,
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

/// Group of bodies during a step.
#[derive(Debug)]
pub struct Island {
    pub movers: Vec<Mover>,
    /// Index of each mover in the world.
    pub members: Vec<usize>,
    pub surfaces: Vec<Surface>,
    pub pairs: Vec<Pair>,
    pub contacts: Vec<Contact>,
    pub joints: Vec<HeldJoint>,
    pub planar: bool,
    pub accuracy: Accuracy,
    pub meters: Meters,
    /// Length of the step, and of the last piece, which is left open [s].
    pub step: f64,
    pub open: f64,
    /// Buffers of a sweep, and whether its last piece is open.
    sweep: Sweep,
    is_swept: bool,
    /// Buffer of contacts.
    known: Vec<Contact>,
    /// Loads of the contacts of the last step.
    past: Vec<(ContactKey, ContactImpulse)>,
    first: FirstHalf,
}

impl Island {
    /// Group without contacts yet.
    pub fn new(planar: bool, accuracy: Accuracy) -> Self {
        Self {
            movers: Vec::new(),
            members: Vec::new(),
            surfaces: Vec::new(),
            pairs: Vec::new(),
            contacts: Vec::new(),
            joints: Vec::new(),
            planar,
            accuracy,
            meters: Meters::default(),
            step: 0.0,
            open: 0.0,
            sweep: Sweep::default(),
            is_swept: false,
            known: Vec::new(),
            past: Vec::new(),
            first: FirstHalf::default(),
        }
    }

    /// Removes all bodies, and keeps the buffers.
    pub fn clear(&mut self) {
        self.movers.clear();
        self.members.clear();
        self.surfaces.clear();
        self.pairs.clear();
        self.contacts.clear();
        self.joints.clear();
        self.past.clear();
        self.meters = Meters::default();
        self.accuracy = Accuracy::FINE;
    }

    /// Largest speed of a surface point [m/s].
    pub fn speed(&self) -> f64 {
        let of = |mover: &Mover| mover.velocity.length() + mover.angular_velocity().length() * mover.arm;
        self.movers.iter().map(of).fold(0.0, f64::max)
    }

    /// Takes over the loads of contacts from the last step, which are in the order of their keys.
    pub fn remember(&mut self, loads: &[(ContactKey, ContactImpulse)]) {
        self.past.clear();
        let mut place = 0;
        for pair in &self.pairs {
            place = seek(loads, place, pair.key);
            let own = loads[place..].iter().take_while(|(key, _)| (key.0, key.1) == pair.key);
            self.past.extend(own);
        }
    }

    /// Finds the contacts within `reach` of each pair [m]. Contacts that were there before keep their loads.
    pub fn find_contacts(&mut self, shapes: &[Shape], reach: impl Fn(&Self, &Pair) -> f64) {
        let poses: Vec<Pose> = self.movers.iter().map(Mover::pose).collect();
        let before = std::mem::replace(&mut self.contacts, std::mem::take(&mut self.known));
        let mut points = Vec::new();
        let (mut known, mut place) = (0, 0);
        for (index, pair) in self.pairs.iter().enumerate() {
            let [one, other] = pair.bodies;
            let [first, second] = pair.bodies.map(|body| &self.surfaces[body]);
            points.clear();
            let dimension = if self.planar { 2 } else { 3 };
            let sides = ((&shapes[first.shape], &poses[one]), (&shapes[second.shape], &poses[other]));
            collision::contacts(sides.0, sides.1, reach(self, pair), dimension, &mut points);
            while known < before.len() && before[known].pair < index {
                known += 1;
            }
            place = seek(&self.past, place, pair.key);
            let past = before[known..].iter().take_while(|contact| contact.pair == index);
            let between = poses[other].position - poses[one].position;
            for &point in &points {
                let last = past.clone().find(|contact| contact.key.2 == point.feature);
                let fallback = last.map_or_else(|| between.try_normalize().unwrap_or(DVec3::X), |contact| contact.touch.normal);
                let touch = point.at([&poses[one], &poses[other]], fallback);
                self.contacts.push(Contact {
                    pair: index,
                    bodies: pair.bodies,
                    key: (pair.key.0, pair.key.1, point.feature),
                    point,
                    touch,
                    friction: combined(first.friction, second.friction),
                    restitution: first.restitution.max(second.restitution),
                    load: last.map_or_else(
                        || {
                            let mut own = self.past[place..].iter().take_while(|(key, _)| (key.0, key.1) == pair.key);
                            own.find(|(key, _)| key.2 == point.feature).map_or_else(ContactImpulse::default, |own| own.1)
                        },
                        |contact| contact.load,
                    ),
                    held: false,
                    strikes: false,
                    rebound: 0.0,
                });
            }
        }
        self.known = before;
        self.known.clear();
    }

    /// Row of a contact at the present poses.
    pub fn row(&self, contact: &Contact, v: &Velocities) -> Option<ContactRow> {
        let arms = contact.bodies.map(|body| contact.touch.point - self.movers[body].position);
        ContactRow::new(contact.bodies, arms, contact.touch.normal, contact.friction, v)
    }

    /// Evaluates all contacts at the present poses.
    pub fn renew_touches(&mut self) {
        let poses: Vec<Pose> = self.movers.iter().map(Mover::pose).collect();
        for contact in &mut self.contacts {
            let [one, other] = contact.bodies.map(|body| &poses[body]);
            contact.touch = contact.point.at([one, other], contact.touch.normal);
        }
    }

    /// Contact evaluated at the present poses.
    fn touch(&self, contact: &Contact) -> Touch {
        let [one, other] = contact.bodies.map(|body| self.movers[body].pose());
        contact.point.at([&one, &other], contact.touch.normal)
    }

    /// Equations of a joint at the present poses.
    pub fn equations(&self, held: &HeldJoint) -> arrayvec::ArrayVec<(Row, f64), MOST_ROWS> {
        held.joint.equations(held.bodies.map(|body| &self.movers[body]))
    }

    /// Tolerance of velocities in iterations [m/s].
    fn tolerance(&self, h: f64) -> f64 {
        let pushed = self.movers.iter().map(|mover| mover.acceleration.length()).fold(0.0, f64::max);
        self.accuracy.velocities * self.speed().max(h * pushed)
    }

    /// Takes the first half of a piece of a step of `h` seconds, and its drift. Gaps and errors of joints that are there at the
    /// start are closed within a step, however short the piece is.
    pub fn begin_piece(&mut self, length: f64, h: f64) {
        let start = Velocities::of(&self.movers);
        let tolerance = self.tolerance(length);
        self.movers.iter_mut().for_each(|mover| mover.kick(0.5 * length));
        let mut v = Velocities::of(&self.movers);
        let mut first = FirstHalf::default();
        first.rows.planar = self.planar;
        self.hold_joints((length, h), &v, &mut first);
        let mut before = Vec::new();
        let mut anchors = Vec::new();
        for (index, contact) in self.contacts.iter().enumerate().filter(|(_, contact)| contact.held) {
            let Some(mut row) = self.row(contact, &v) else { continue };
            row.least = -contact.touch.gap / h;
            first.remainders.push(contact.touch.gap * (1.0 - length / h));
            row.impulse = contact.load.scaled(0.5 * length);
            row.impulse.tangential = row.impulse.tangential.reject_from_normalized(row.normal);
            before.push((row.velocity(&start), row.turning(&start)));
            anchors.push(self.anchors(contact));
            first.rows.contacts.push(row);
            first.contacts.push(index);
        }
        first.rows.start(&mut v);
        let kicked = self.movers.clone();
        for linearization in 0..self.accuracy.linearizations {
            first.rows.solve(&mut v, tolerance, self.accuracy.iterations);
            self.movers.copy_from_slice(&kicked);
            first.rows.apply(&mut self.movers);
            let middle = Velocities::of(&self.movers);
            self.movers.iter_mut().for_each(|mover| mover.drift(length));
            let last = linearization + 1 == self.accuracy.linearizations;
            if last || !self.correct(&mut first, &anchors, (&v, &middle), length) {
                break;
            }
        }
        for ((row, &index), before) in first.rows.contacts.iter().zip(&first.contacts).zip(before) {
            first.lost += lost(row, self.contacts[index].strikes, before, (row.velocity(&v), row.turning(&v)));
        }
        first.lost += first.rows.stopped(&start, &v);
        first.work = first.rows.supplied(&start, &v);
        self.leave_open(first, length, h);
    }

    /// Buffers of a sweep.
    pub fn take_sweep(&mut self) -> Sweep {
        std::mem::take(&mut self.sweep)
    }

    /// Leaves the last piece of a sweep open.
    pub fn open_sweep(&mut self, sweep: Sweep, length: f64, h: f64) {
        (self.sweep, self.is_swept, self.open, self.step) = (sweep, true, length, h);
    }

    /// Leaves a piece open after its drift.
    fn leave_open(&mut self, mut first: FirstHalf, length: f64, h: f64) {
        // Velocities at the new poses, for the second half.
        let v = Velocities::of(&self.movers);
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

    /// Adds the rows of the joints at the start of a piece.
    pub fn hold_joints(&self, (length, h): (f64, f64), v: &Velocities, first: &mut FirstHalf) {
        for (index, held) in self.joints.iter().enumerate() {
            let equations = self.equations(held);
            first.errors.push(equations.iter().map(|(_, error)| error * (1.0 - length / h)).collect());
            let rows = equations.into_iter().zip(held.loads).map(|((row, error), load)| Row {
                target: -error / h,
                impulse: 0.5 * length * load,
                ..row
            });
            first.rows.joints.push(JointRows::new(held.bodies, rows.collect(), v));
            let Some((row, place)) = held.joint.freedom(held.bodies.map(|body| &self.movers[body])) else { continue };
            for (which, bounds, target) in bounds_of(&held.joint, place, (length, h)) {
                let row = Row { target, impulse: (0.5 * length * held.bounds[which]).clamp(bounds[0], bounds[1]), ..row };
                if let Some(bounded) = BoundedRow::new(held.bodies, row, bounds, v) {
                    first.rows.bounds.push(bounded);
                    first.bounded.push((index, which));
                }
            }
        }
        first.rows.link(v);
    }

    /// Points of a contact that friction holds: in the frames of the two bodies, with the arm from there to the contact [m].
    /// A rounded body is held at its core, so that it rolls.
    fn anchors(&self, contact: &Contact) -> [(DVec3, DVec3); 2] {
        std::array::from_fn(|side| {
            let pose = self.movers[contact.bodies[side]].pose();
            let radius = contact.point.radii[side];
            if radius > 0.0 {
                let core = contact.touch.point - radius * if side == 0 { 1.0 } else { -1.0 } * contact.touch.normal;
                (pose.local_point(core), contact.touch.point - core)
            } else {
                (pose.local_point(contact.touch.point), DVec3::ZERO)
            }
        })
    }

    /// Corrects the targets of the rows by what gaps, slips and joints came to; returns whether an error is too large.
    fn correct(
        &self,
        first: &mut FirstHalf,
        anchors: &[[(DVec3, DVec3); 2]],
        (v, middle): (&Velocities, &Velocities),
        length: f64,
    ) -> bool {
        let mut worst = 0.0_f64;
        let mut size = f64::INFINITY;
        let rows = first.rows.contacts.iter_mut().zip(&first.contacts).zip(&first.remainders).zip(anchors);
        for (((row, &index), remainder), anchors) in rows {
            let contact = &self.contacts[index];
            size = size.min(self.pairs[contact.pair].size);
            let gap = self.touch(contact).gap - remainder;
            let relative = row.velocity(v);
            row.least = row.normal.dot(relative) - gap / length;
            if row.impulse.normal > 0.0 || gap < 0.0 {
                worst = worst.max(gap.abs());
            }
            if row.friction.sliding > 0.0 && row.impulse.normal > 0.0 {
                let way = self.way(contact, anchors, middle, length);
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

    /// Way that the second body's point of contact moved against the first's [m].
    fn way(&self, contact: &Contact, anchors: &[(DVec3, DVec3); 2], middle: &Velocities, length: f64) -> DVec3 {
        let [one, other] = std::array::from_fn(|side| {
            let body = contact.bodies[side];
            let (local, arm) = anchors[side];
            let rolled = length * (middle.at(body, arm) - middle.at(body, DVec3::ZERO));
            self.movers[body].pose().point(local) + rolled + arm
        });
        other - one
    }

    /// Adds the rows of the joints at the end of a piece.
    pub fn hold_joint_velocities(&self, first: &FirstHalf, v: &Velocities, rows: &mut Rows) {
        for (held, past) in self.joints.iter().zip(&first.rows.joints) {
            let equations = self.equations(held).into_iter().zip(&past.rows);
            let equations = equations.map(|((row, _), past)| Row { impulse: past.impulse, ..row });
            rows.joints.push(JointRows::new(held.bodies, equations.collect(), v));
        }
        rows.link(v);
        for (past, &(index, which)) in first.rows.bounds.iter().zip(&first.bounded) {
            let held = &self.joints[index];
            let row = held.joint.freedom(held.bodies.map(|body| &self.movers[body])).map_or(past.row, |(row, _)| row);
            let (target, bounds) = if which == MOTOR {
                (past.row.target, past.bounds)
            } else if past.row.impulse == 0.0 {
                // A limit that is not reached.
                (0.0, [0.0; 2])
            } else {
                // Both halves together do not pull.
                (0.0, past.bounds.map(|bound| if bound == 0.0 { -past.row.impulse } else { bound }))
            };
            let row = Row { target, impulse: past.row.impulse.clamp(bounds[0], bounds[1]), ..row };
            rows.bounds.extend(BoundedRow::new(past.bodies, row, bounds, v));
        }
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
        let start = Velocities::of(&self.movers);
        let mut rows = Rows { planar: self.planar, ..Rows::default() };
        self.hold_joint_velocities(&first, &start, &mut rows);
        for (past, &index) in first.rows.contacts.iter().zip(&first.contacts) {
            let contact = &self.contacts[index];
            let Some(mut row) = self.row(contact, &start) else { continue };
            row.before = past.impulse;
            row.before.tangential = row.before.tangential.reject_from_normalized(row.normal);
            row.impulse = row.before;
            row.least = if past.impulse.normal > 0.0 { contact.rebound } else { 0.0 };
            rows.contacts.push(row);
        }
        let mut v = Velocities::of(&self.movers);
        rows.start(&mut v);
        let tolerance = self.tolerance(length);
        rows.solve(&mut v, tolerance, self.accuracy.iterations);
        rows.apply(&mut self.movers);
        let mut losses = first.lost + rows.stopped(&first.drifted, &v);
        for ((row, &index), &middle) in rows.contacts.iter().zip(&first.contacts).zip(&first.middle) {
            losses += lost(row, self.contacts[index].strikes, middle, (row.velocity(&v), row.turning(&v)));
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

    /// Keeps the mean forces of joints in a piece.
    pub fn keep_joint_loads(&mut self, first: &FirstHalf, rows: &Rows, length: f64) {
        for (joint, halves) in self.joints.iter_mut().zip(first.rows.joints.iter().zip(&rows.joints)) {
            for (index, (one, other)) in halves.0.rows.iter().zip(&halves.1.rows).enumerate() {
                joint.loads[index] = (one.impulse + other.impulse) / length;
            }
        }
        for ((one, other), &(joint, which)) in first.rows.bounds.iter().zip(&rows.bounds).zip(&first.bounded) {
            self.joints[joint].bounds[which] = (one.row.impulse + other.row.impulse) / length;
        }
    }

    /// Adds the impulses of joints in a piece.
    pub fn keep_reactions(&mut self, first: &FirstHalf, rows: &Rows) {
        let mut add = |joint: usize, row: &Row| self.joints[joint].react(row);
        for half in [&first.rows, rows] {
            half.joints.iter().enumerate().for_each(|(joint, rows)| rows.rows.iter().for_each(|row| add(joint, row)));
            half.bounds.iter().zip(&first.bounded).for_each(|(bounded, &(joint, _))| add(joint, &bounded.row));
        }
    }
}

/// Place from `place` on of the first load of a pair, or of the next one, in ascending order.
fn seek(loads: &[(ContactKey, ContactImpulse)], place: usize, pair: (u32, u32)) -> usize {
    const NEAR: usize = 8;
    let below = |(key, _): &(ContactKey, ContactImpulse)| (key.0, key.1) < pair;
    let near = loads[place..].iter().take(NEAR).take_while(|load| below(load)).count();
    if near < NEAR { place + near } else { place + loads[place..].partition_point(below) }
}

/// Friction between two surfaces: the geometric mean of Coulomb's coefficients, the larger lever arms.
fn combined(one: Option<Friction>, other: Option<Friction>) -> Friction {
    let (Some(one), Some(other)) = (one, other) else { return one.or(other).unwrap_or_default() };
    Friction {
        sliding: (one.sliding * other.sliding).sqrt(),
        rolling: one.rolling.max(other.rolling),
        torsional: one.torsional.max(other.torsional),
    }
}

/// Energy that a contact dissipates in half a piece [J]: by friction, and by the normal impulse if it strikes.
pub fn lost(row: &ContactRow, strikes: bool, before: (DVec3, DVec3), after: (DVec3, DVec3)) -> f64 {
    let normal = 0.5 * row.impulse.normal * row.normal.dot(before.0 + after.0);
    -row.work(before, after) + if strikes { 0.0 } else { normal }
}

/// Bounded rows of a joint.
pub const LIMITS: [usize; 2] = [0, 1];
const MOTOR: usize = 2;

/// Bounds of the impulse of a lower and of an upper limit.
pub const LIMIT_BOUNDS: [[f64; 2]; 2] = [[0.0, f64::INFINITY], [f64::NEG_INFINITY, 0.0]];

/// Bounded rows of a joint in half a piece of a step of `h` seconds: which of them, bounds of the impulse, and target. A limit
/// that is overrun is reached again within a step, however short the piece is.
fn bounds_of(joint: &Joint, place: f64, (length, h): (f64, f64)) -> Vec<(usize, [f64; 2], f64)> {
    let mut rows = Vec::new();
    for which in LIMITS {
        let way = joint.limit(which) - place;
        let beyond = if which == 0 { way > 0.0 } else { way < 0.0 };
        if way.is_finite() {
            rows.push((which, LIMIT_BOUNDS[which], way / if beyond { h } else { length }));
        }
    }
    if let Some(motor) = joint.motor {
        let most = 0.5 * length * motor.most / joint.unit();
        rows.push((MOTOR, [-most, most], joint.unit() * motor.speed));
    }
    rows
}
