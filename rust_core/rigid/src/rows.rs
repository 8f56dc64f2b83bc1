//! Impulses between bodies, by projected Gauss–Seidel iteration over blocks: joints, bounds and contacts with friction.
//!
//! A block acts between two bodies. Joints hold relative velocities J v = b and are solved exactly, block by block. Contacts
//! hold n·u ≥ b with an impulse λ ≥ 0, and Coulomb's friction |t| ≤ μ λ, which opposes the slip. All impulses are pairs of
//! opposite impulses at one point, so that momentum and angular momentum are kept to rounding. Sources: M. Jean, Comput. Meth.
//! Appl. Mech. Eng. 177, 235 (1999); V. Acary, B. Brogliato, "Numerical Methods for Nonsmooth Dynamical Systems", 2008.

use arrayvec::ArrayVec;
use glam::{DMat3, DVec3};

use crate::joint_system::JointSystem;
use crate::mover::{Mover, perpendicular};

/// Iterations between Newton steps.
const SWEEPS: usize = 4;
/// Largest number of rows of a joint.
pub const MOST_ROWS: usize = 6;

/// Velocities during a solve, with the inverse masses and inertias.
#[derive(Debug, Clone, Default)]
pub struct Velocities {
    linear: Vec<DVec3>,
    angular: Vec<DVec3>,
    inverse_mass: Vec<f64>,
    inverse_inertia: Vec<DMat3>,
}

impl Velocities {
    /// Velocities of movers in their present orientations.
    pub fn of(movers: &[Mover]) -> Self {
        let mut velocities = Self::default();
        velocities.fill(movers);
        velocities
    }

    /// Replaces all velocities, inverse masses and inertias by those of movers.
    pub fn fill(&mut self, movers: &[Mover]) {
        self.linear.clear();
        self.angular.clear();
        self.inverse_mass.clear();
        self.inverse_inertia.clear();
        for mover in movers {
            let inverse_inertia = mover.inverse_inertia();
            self.linear.push(mover.velocity);
            self.angular.push(if mover.is_fixed() { mover.spin } else { inverse_inertia * mover.spin });
            self.inverse_mass.push(mover.inverse_mass);
            self.inverse_inertia.push(inverse_inertia);
        }
    }

    /// Applies the forces on movers for `h` seconds.
    pub fn kick(&mut self, movers: &[Mover], h: f64) {
        for (body, mover) in movers.iter().enumerate().filter(|(_, mover)| !mover.is_fixed()) {
            self.linear[body] += h * mover.acceleration;
            if mover.torque != DVec3::ZERO {
                self.angular[body] += self.inverse_inertia[body] * (h * mover.torque);
            }
        }
    }

    /// Whether impulses leave a body as it is.
    pub fn is_fixed(&self, body: usize) -> bool {
        self.inverse_mass[body] == 0.0
    }

    /// Velocity [m/s] and angular velocity [rad/s] of a body.
    pub fn of_body(&self, body: usize) -> [DVec3; 2] {
        [self.linear[body], self.angular[body]]
    }

    /// Velocity of a point of a body at an arm from its center [m/s].
    #[inline(always)]
    pub fn at(&self, body: usize, arm: DVec3) -> DVec3 {
        self.linear[body] + self.angular[body].cross(arm)
    }

    /// Response of one row of a body to the impulse of another one, each given with its side.
    pub fn coupling(&self, body: usize, (row, side): (&Row, usize), (other, across): (&Row, usize)) -> f64 {
        self.inverse_mass[body] * row.linear.dot(other.linear)
            + row.angular[side].dot(self.inverse_inertia[body] * other.angular[across])
    }

    #[inline(always)]
    fn push(&mut self, body: usize, arm: DVec3, impulse: DVec3) {
        self.linear[body] += self.inverse_mass[body] * impulse;
        self.angular[body] += self.inverse_inertia[body] * arm.cross(impulse);
    }

    /// Response of the velocity at an arm to an impulse there.
    fn response(&self, body: usize, arm: DVec3, impulse: DVec3) -> DVec3 {
        self.inverse_mass[body] * impulse + (self.inverse_inertia[body] * arm.cross(impulse)).cross(arm)
    }
}

/// Equation J v = b between two bodies, J v = l·(v₂ − v₁) + a₂·ω₂ − a₁·ω₁.
#[derive(Debug, Clone, Copy)]
pub struct Row {
    /// Direction l.
    pub linear: DVec3,
    /// Vectors a₁ and a₂.
    pub angular: [DVec3; 2],
    /// Relative velocity b.
    pub target: f64,
    /// Impulse.
    pub impulse: f64,
}

impl Row {
    /// Row without impulse.
    pub fn new(linear: DVec3, angular: [DVec3; 2]) -> Self {
        Self { linear, angular, target: 0.0, impulse: 0.0 }
    }

    /// Relative velocity J v.
    pub fn velocity(&self, [one, other]: [usize; 2], v: &Velocities) -> f64 {
        self.linear.dot(v.linear[other] - v.linear[one]) + self.angular[1].dot(v.angular[other])
            - self.angular[0].dot(v.angular[one])
    }

    /// J M⁻¹ Jᵀ of this row and another one of the same bodies.
    fn coupling(&self, row: &Self, [one, other]: [usize; 2], v: &Velocities) -> f64 {
        let masses = v.inverse_mass[one] + v.inverse_mass[other];
        masses * self.linear.dot(row.linear)
            + self.angular[0].dot(v.inverse_inertia[one] * row.angular[0])
            + self.angular[1].dot(v.inverse_inertia[other] * row.angular[1])
    }

    /// Adds an impulse to the velocities.
    pub fn push(&self, impulse: f64, [one, other]: [usize; 2], v: &mut Velocities) {
        v.linear[one] -= v.inverse_mass[one] * impulse * self.linear;
        v.linear[other] += v.inverse_mass[other] * impulse * self.linear;
        v.angular[one] -= v.inverse_inertia[one] * (impulse * self.angular[0]);
        v.angular[other] += v.inverse_inertia[other] * (impulse * self.angular[1]);
    }

    /// Energy supplied by fixed bodies, which move as prescribed [J].
    fn supplied(&self, bodies: [usize; 2], v: &Velocities) -> f64 {
        let of = |side: usize, sign: f64| {
            let body = bodies[side];
            let fixed = v.inverse_mass[body] == 0.0;
            if fixed { sign * (self.linear.dot(v.linear[body]) + self.angular[side].dot(v.angular[body])) } else { 0.0 }
        };
        self.impulse * (of(0, 1.0) + of(1, -1.0))
    }

    /// Adds the impulse to the velocities and angular momenta of the bodies.
    fn apply(&self, [one, other]: [usize; 2], movers: &mut [Mover]) {
        for (body, sign, arm) in [(one, -1.0, self.angular[0]), (other, 1.0, self.angular[1])] {
            let mover = &mut movers[body];
            if !mover.is_fixed() {
                mover.velocity += sign * self.impulse * mover.inverse_mass * self.linear;
                mover.spin += sign * self.impulse * arm;
            }
        }
    }
}

/// Rows of a joint.
#[derive(Debug)]
pub struct JointRows {
    pub bodies: [usize; 2],
    pub rows: ArrayVec<Row, MOST_ROWS>,
    /// Inverse of J M⁻¹ Jᵀ.
    inverse: [[f64; MOST_ROWS]; MOST_ROWS],
}

impl JointRows {
    /// Prepares the rows of a joint.
    pub fn new(bodies: [usize; 2], rows: ArrayVec<Row, MOST_ROWS>, v: &Velocities) -> Self {
        let mut matrix = [[0.0; MOST_ROWS]; MOST_ROWS];
        for (i, row) in rows.iter().enumerate() {
            for (j, other) in rows.iter().enumerate() {
                matrix[i][j] = row.coupling(other, bodies, v);
            }
        }
        Self { bodies, inverse: inverted(matrix, rows.len()), rows }
    }

    /// Velocities that the rows lack.
    pub fn lacks(&self, v: &Velocities) -> [f64; MOST_ROWS] {
        let mut lacks = [0.0; MOST_ROWS];
        self.rows.iter().zip(&mut lacks).for_each(|(row, lack)| *lack = row.target - row.velocity(self.bodies, v));
        lacks
    }

    /// Adds impulses to the rows and to the velocities.
    pub fn push(&mut self, impulses: &[f64; MOST_ROWS], v: &mut Velocities) {
        for (row, impulse) in self.rows.iter_mut().zip(impulses) {
            row.impulse += impulse;
            row.push(*impulse, self.bodies, v);
        }
    }

    /// Solves the rows of this joint; returns the largest change of a relative velocity.
    fn relax(&mut self, v: &mut Velocities) -> f64 {
        let lacks = self.lacks(v);
        let of = |weights: &[f64; MOST_ROWS]| weights.iter().zip(&lacks).map(|(weight, lack)| weight * lack).sum();
        let impulses = self.inverse.each_ref().map(of);
        self.push(&impulses, v);
        lacks.iter().fold(0.0, |largest, lack| largest.max(lack.abs()))
    }
}

/// Inverse of the leading block of a symmetric positive definite matrix, by Gauss–Jordan elimination. Rows that depend on
/// those before them get no weight.
pub(crate) fn inverted(mut matrix: [[f64; MOST_ROWS]; MOST_ROWS], size: usize) -> [[f64; MOST_ROWS]; MOST_ROWS] {
    let mut inverse = [[0.0; MOST_ROWS]; MOST_ROWS];
    let scale: [f64; MOST_ROWS] = std::array::from_fn(|i| matrix[i][i]);
    (0..size).for_each(|i| inverse[i][i] = 1.0);
    for pivot in 0..size {
        let value = matrix[pivot][pivot];
        if value <= 1e-12 * scale[pivot] || value <= 0.0 {
            (0..size).for_each(|j| (inverse[pivot][j], matrix[pivot][j]) = (0.0, 0.0));
            continue;
        }
        for j in 0..size {
            matrix[pivot][j] /= value;
            inverse[pivot][j] /= value;
        }
        for i in (0..size).filter(|&i| i != pivot) {
            let factor = matrix[i][pivot];
            for j in 0..size {
                matrix[i][j] -= factor * matrix[pivot][j];
                inverse[i][j] -= factor * inverse[pivot][j];
            }
        }
    }
    inverse
}

/// Row with bounds on its impulse: a limit of a joint, or a motor.
#[derive(Debug, Clone, Copy)]
pub struct BoundedRow {
    pub bodies: [usize; 2],
    pub row: Row,
    /// Least and largest impulse.
    pub bounds: [f64; 2],
    mass: f64,
}

impl BoundedRow {
    /// Prepares a row; None if neither body can be moved along it.
    pub fn new(bodies: [usize; 2], row: Row, bounds: [f64; 2], v: &Velocities) -> Option<Self> {
        let inverse = row.coupling(&row, bodies, v);
        (inverse > 0.0).then_some(Self { bodies, row, bounds, mass: 1.0 / inverse })
    }

    /// Whether the row is a motor.
    pub fn drives(&self) -> bool {
        self.bounds.iter().all(|bound| bound.is_finite())
    }

    /// Work of the impulse on the relative motion [J].
    fn work(&self, before: &Velocities, after: &Velocities) -> f64 {
        0.5 * self.row.impulse * (self.row.velocity(self.bodies, before) + self.row.velocity(self.bodies, after))
    }

    fn relax(&mut self, v: &mut Velocities) -> f64 {
        let lack = self.row.target - self.row.velocity(self.bodies, v);
        let [least, most] = self.bounds;
        let impulse = (self.row.impulse + self.mass * lack).clamp(least, most);
        let change = impulse - self.row.impulse;
        self.row.impulse = impulse;
        self.row.push(change, self.bodies, v);
        change.abs() / self.mass
    }
}

/// Friction of a contact.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Friction {
    /// Coulomb's coefficient μ.
    pub sliding: f64,
    /// Lever arms of the moments of friction about the tangents and about the normal [m].
    pub rolling: f64,
    pub torsional: f64,
}

/// Impulses of a contact.
#[derive(Debug, Clone, Copy, Default)]
pub struct ContactImpulse {
    /// Normal impulse λ [N·s].
    pub normal: f64,
    /// Impulse of friction [N·s].
    pub tangential: DVec3,
    /// Impulse of the moments of rolling and torsional friction [N·m·s].
    pub turning: DVec3,
}

impl ContactImpulse {
    /// Impulses times a factor.
    pub fn scaled(&self, factor: f64) -> Self {
        Self { normal: factor * self.normal, tangential: factor * self.tangential, turning: factor * self.turning }
    }

    /// Sum with other impulses.
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            normal: self.normal + other.normal,
            tangential: self.tangential + other.tangential,
            turning: self.turning + other.turning,
        }
    }
}

/// Contact between two bodies at one point.
#[derive(Debug, Clone, Copy)]
pub struct ContactRow {
    pub bodies: [usize; 2],
    /// Arms from the centers to the point [m].
    pub arms: [DVec3; 2],
    /// Unit normal n, from the first body to the second.
    pub normal: DVec3,
    /// Least normal velocity b [m/s].
    pub least: f64,
    /// Slip that friction leaves [m/s].
    pub slip: DVec3,
    pub friction: Friction,
    pub impulse: ContactImpulse,
    /// Part of the normal impulse that yields; 0 for a rigid contact.
    pub yields: f64,
    /// Impulses that bounds on the sum include.
    pub before: ContactImpulse,
    /// Effective masses along the normal and, at least, along the tangents [kg].
    masses: [f64; 2],
    /// Effective moments of inertia about the normal and, at least, about the tangents [kg·m²].
    moments: [f64; 2],
}

impl ContactRow {
    /// Contact without impulse; None if neither body can be moved.
    pub fn new(bodies: [usize; 2], arms: [DVec3; 2], normal: DVec3, friction: Friction, v: &Velocities) -> Option<Self> {
        let response = |along: DVec3| v.response(bodies[0], arms[0], along) + v.response(bodies[1], arms[1], along);
        let inverse = normal.dot(response(normal));
        if inverse <= 0.0 {
            return None;
        }
        let [first, second] = perpendicular(normal);
        let [a, b] = [response(first), response(second)];
        let [xx, yy, xy] = [first.dot(a), second.dot(b), first.dot(b)];
        let largest = 0.5 * (xx + yy) + (0.25 * (xx - yy) * (xx - yy) + xy * xy).sqrt();
        let mut moments = [0.0; 2];
        if friction.rolling > 0.0 || friction.torsional > 0.0 {
            let sum = v.inverse_inertia[bodies[0]] + v.inverse_inertia[bodies[1]];
            let about = normal.dot(sum * normal);
            let across = sum.x_axis.x + sum.y_axis.y + sum.z_axis.z - about;
            moments = [about, across].map(|inverse| if inverse > 0.0 { 1.0 / inverse } else { 0.0 });
        }
        let (impulse, before) = (ContactImpulse::default(), ContactImpulse::default());
        let masses = [1.0 / inverse, 1.0 / largest];
        Some(Self {
            bodies,
            arms,
            normal,
            least: 0.0,
            slip: DVec3::ZERO,
            friction,
            impulse,
            yields: 0.0,
            before,
            masses,
            moments,
        })
    }

    /// Copy without impulses, for another least normal velocity [m/s].
    pub fn anew(&self, least: f64) -> Self {
        let (impulse, before) = (ContactImpulse::default(), ContactImpulse::default());
        Self { least, impulse, before, ..*self }
    }

    /// Relative velocity of the second body at the point [m/s].
    #[inline(always)]
    pub fn velocity(&self, v: &Velocities) -> DVec3 {
        v.at(self.bodies[1], self.arms[1]) - v.at(self.bodies[0], self.arms[0])
    }

    /// Relative angular velocity [rad/s].
    pub fn turning(&self, v: &Velocities) -> DVec3 {
        v.angular[self.bodies[1]] - v.angular[self.bodies[0]]
    }

    #[inline(always)]
    fn push(&self, impulse: DVec3, v: &mut Velocities) {
        v.push(self.bodies[0], self.arms[0], -impulse);
        v.push(self.bodies[1], self.arms[1], impulse);
    }

    /// Solves this contact alone; returns the largest change of a relative velocity [m/s].
    #[inline(always)]
    fn relax(&mut self, v: &mut Velocities) -> f64 {
        let relative = self.velocity(v);
        let along = self.normal.dot(relative);
        let stiff = 1.0 - self.yields;
        let impulse = stiff * (self.impulse.normal + self.masses[0] * (self.least - along));
        let impulse = impulse.max(-self.before.normal);
        let mut push = (impulse - self.impulse.normal) * self.normal;
        let mut change = (impulse - self.impulse.normal).abs() / self.masses[0];
        self.impulse.normal = impulse;
        let load = self.before.normal + impulse;
        if self.friction.sliding > 0.0 {
            let slip = relative - along * self.normal - self.slip;
            let wanted = self.before.tangential + self.impulse.tangential - self.masses[1] * slip;
            let tangential = wanted.clamp_length_max(self.friction.sliding * load) - self.before.tangential;
            let difference = tangential - self.impulse.tangential;
            change = change.max(difference.length() / self.masses[1]);
            push += difference;
            self.impulse.tangential = tangential;
        }
        if push != DVec3::ZERO {
            self.push(push, v);
        }
        if self.friction.rolling > 0.0 || self.friction.torsional > 0.0 {
            self.relax_turning(load, v);
        }
        change
    }

    /// Solves this contact alone to a tolerance [m/s].
    pub fn settle(&mut self, v: &mut Velocities, tolerance: f64, most: usize) {
        for _ in 0..most {
            if self.relax(v) <= tolerance {
                return;
            }
        }
    }

    /// Removes the impulses from the velocities.
    pub fn undo(&self, v: &mut Velocities) {
        self.push(-(self.impulse.normal * self.normal + self.impulse.tangential), v);
        let [one, other] = self.bodies;
        v.angular[one] += v.inverse_inertia[one] * self.impulse.turning;
        v.angular[other] -= v.inverse_inertia[other] * self.impulse.turning;
    }

    /// Solves the moments of rolling and torsional friction under a normal impulse.
    fn relax_turning(&mut self, load: f64, v: &mut Velocities) {
        let turning = self.turning(v);
        let about = self.normal.dot(turning) * self.normal;
        let [torsion, roll] = self.moments;
        let wanted = self.before.turning + self.impulse.turning - torsion * about - roll * (turning - about);
        let along = self.normal.dot(wanted) * self.normal;
        let bounded = along.clamp_length_max(self.friction.torsional * load)
            + (wanted - along).clamp_length_max(self.friction.rolling * load)
            - self.before.turning;
        let difference = bounded - self.impulse.turning;
        self.impulse.turning = bounded;
        let [one, other] = self.bodies;
        v.angular[one] -= v.inverse_inertia[one] * difference;
        v.angular[other] += v.inverse_inertia[other] * difference;
    }

    /// Energy supplied by fixed bodies, which move as prescribed [J].
    pub fn supplied(&self, v: &Velocities) -> f64 {
        let impulse = self.impulse.normal * self.normal + self.impulse.tangential;
        let of = |side: usize, sign: f64| {
            let body = self.bodies[side];
            let fixed = v.inverse_mass[body] == 0.0;
            if fixed {
                sign * (impulse.dot(v.at(body, self.arms[side])) + self.impulse.turning.dot(v.angular[body]))
            } else {
                0.0
            }
        };
        of(0, 1.0) + of(1, -1.0)
    }

    /// Work of the impulses on the relative motion, from velocities before to velocities after them [J].
    pub fn work(&self, before: (DVec3, DVec3), after: (DVec3, DVec3)) -> f64 {
        let impulse = self.impulse.normal * self.normal + self.impulse.tangential;
        0.5 * (impulse.dot(before.0 + after.0) + self.impulse.turning.dot(before.1 + after.1))
    }

    /// Adds the impulses to the velocities and angular momenta of the bodies.
    pub fn apply(&self, movers: &mut [Mover]) {
        let impulse = self.impulse.normal * self.normal + self.impulse.tangential;
        for (body, arm, sign) in [(self.bodies[0], self.arms[0], -1.0), (self.bodies[1], self.arms[1], 1.0)] {
            let mover = &mut movers[body];
            if !mover.is_fixed() {
                mover.velocity += sign * mover.inverse_mass * impulse;
                mover.spin += sign * (arm.cross(impulse) + self.impulse.turning);
            }
        }
    }
}

/// Rows of all joints and contacts of a group of bodies.
#[derive(Debug, Default)]
pub struct Rows {
    /// Whether the bodies move in the plane.
    pub planar: bool,
    pub joints: Vec<JointRows>,
    /// Factorization for the joints; None if they are relaxed one by one.
    pub(crate) system: Option<JointSystem>,
    pub bounds: Vec<BoundedRow>,
    pub contacts: Vec<ContactRow>,
}

impl Rows {
    /// Factorizes the rows of the joints.
    pub fn link(&mut self, v: &Velocities) {
        self.system = JointSystem::new(&self.joints, v);
    }

    /// Adds the initial impulses to the velocities.
    pub fn start(&self, v: &mut Velocities) {
        for joint in &self.joints {
            joint.rows.iter().for_each(|row| row.push(row.impulse, joint.bodies, v));
        }
        self.bounds.iter().for_each(|bounded| bounded.row.push(bounded.row.impulse, bounded.bodies, v));
        for contact in &self.contacts {
            contact.push(contact.impulse.normal * contact.normal + contact.impulse.tangential, v);
            let [one, other] = contact.bodies;
            v.angular[one] -= v.inverse_inertia[one] * contact.impulse.turning;
            v.angular[other] += v.inverse_inertia[other] * contact.impulse.turning;
        }
    }

    /// Iterates in alternating order until no relative velocity changes by more than `tolerance` [m/s]; returns whether it
    /// came to that. A Newton step for the rows that hold follows some of the iterations. If it does not pay, it is undone.
    pub fn solve(&mut self, v: &mut Velocities, tolerance: f64, most: usize) -> bool {
        let mut before: Option<(f64, Vec<f64>, Velocities)> = None;
        // Iterations from one Newton step to the next, and to the next decision.
        let (mut wait, mut next) = (SWEEPS, SWEEPS);
        for iteration in 0..most {
            let change = self.relax_all(iteration, v);
            if change <= tolerance {
                return true;
            }
            if iteration + 1 < next {
                continue;
            }
            if let Some((change_before, impulses, velocities)) = before.take()
                && change > change_before
            {
                self.set_impulses(&impulses);
                *v = velocities;
                wait *= 2;
                next += wait;
                continue;
            }
            next += SWEEPS;
            if next <= most {
                let saved = (change, self.impulses(), v.clone());
                before = self.solve_held(v).then_some(saved);
            }
        }
        false
    }

    /// Relaxes all rows once; returns the largest change of a relative velocity [m/s].
    pub fn relax_all(&mut self, iteration: usize, v: &mut Velocities) -> f64 {
        let mut change = 0.0_f64;
        match &self.system {
            Some(system) => change = system.relax(&mut self.joints, v),
            None => self.joints.iter_mut().for_each(|joint| change = change.max(joint.relax(v))),
        }
        self.bounds.iter_mut().for_each(|bounded| change = change.max(bounded.relax(v)));
        let mut relax = |contact: &mut ContactRow| change = change.max(contact.relax(v));
        if iteration.is_multiple_of(2) {
            self.contacts.iter_mut().for_each(&mut relax);
        } else {
            self.contacts.iter_mut().rev().for_each(&mut relax);
        }
        change
    }

    /// All impulses, row by row.
    fn impulses(&self) -> Vec<f64> {
        let joints = self.joints.iter().flat_map(|joint| joint.rows.iter().map(|row| row.impulse));
        let bounds = self.bounds.iter().map(|bounded| bounded.row.impulse);
        let of = |contact: &ContactRow| {
            let ContactImpulse { normal, tangential, turning } = contact.impulse;
            [normal, tangential.x, tangential.y, tangential.z, turning.x, turning.y, turning.z]
        };
        joints.chain(bounds).chain(self.contacts.iter().flat_map(of)).collect()
    }

    /// Sets all impulses.
    fn set_impulses(&mut self, values: &[f64]) {
        let mut values = values.iter().copied();
        let joints = self.joints.iter_mut().flat_map(|joint| joint.rows.iter_mut().map(|row| &mut row.impulse));
        let bounds = self.bounds.iter_mut().map(|bounded| &mut bounded.row.impulse);
        joints.chain(bounds).zip(&mut values).for_each(|(impulse, value)| *impulse = value);
        for contact in &mut self.contacts {
            let mut next = || values.next().unwrap_or(0.0);
            let normal = next();
            let tangential = DVec3::new(next(), next(), next());
            contact.impulse = ContactImpulse { normal, tangential, turning: DVec3::new(next(), next(), next()) };
        }
    }

    /// Energy that motors, and bodies that move as prescribed, supply by the impulses [J], from velocities before to
    /// velocities after them.
    pub fn supplied(&self, before: &Velocities, after: &Velocities) -> f64 {
        let of_joint = |joint: &JointRows| joint.rows.iter().map(|row| row.supplied(joint.bodies, after)).sum::<f64>();
        let of_bound = |bounded: &BoundedRow| {
            let drive = if bounded.drives() { bounded.work(before, after) } else { 0.0 };
            drive + bounded.row.supplied(bounded.bodies, after)
        };
        self.joints.iter().map(of_joint).sum::<f64>()
            + self.bounds.iter().map(of_bound).sum::<f64>()
            + self.contacts.iter().map(|contact| contact.supplied(after)).sum::<f64>()
    }

    /// Energy that the limits of joints dissipate [J].
    pub fn stopped(&self, before: &Velocities, after: &Velocities) -> f64 {
        let limits = self.bounds.iter().filter(|bounded| !bounded.drives());
        -limits.map(|bounded| bounded.work(before, after)).sum::<f64>()
    }

    /// Adds all impulses to the velocities and angular momenta of the bodies.
    pub fn apply(&self, movers: &mut [Mover]) {
        for joint in &self.joints {
            joint.rows.iter().for_each(|row| row.apply(joint.bodies, movers));
        }
        self.bounds.iter().for_each(|bounded| bounded.row.apply(bounded.bodies, movers));
        self.contacts.iter().for_each(|contact| contact.apply(movers));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverse_of_a_matrix() {
        let mut matrix = [[0.0; MOST_ROWS]; MOST_ROWS];
        for i in 0..3 {
            for j in 0..3 {
                matrix[i][j] = [[4.0, 1.0, 0.5], [1.0, 3.0, 0.2], [0.5, 0.2, 2.0]][i][j];
            }
        }
        let inverse = inverted(matrix, 3);
        for i in 0..3 {
            for j in 0..3 {
                let entry: f64 = (0..3).map(|k| matrix[i][k] * inverse[k][j]).sum();
                assert!((entry - f64::from(u8::from(i == j))).abs() < 1e-15);
            }
        }
    }
}
