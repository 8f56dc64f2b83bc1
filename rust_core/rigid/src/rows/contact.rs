//! Rows of contacts with friction.

use glam::DVec3;

use super::{BodyVelocities, InSpace, RowSpace, RowVector};
use crate::mover::Mover;
use crate::surface::Friction;

/// Energy that impulses may add, over the work of their parts.
const GAINED: f64 = 1e-6;

/// Impulses of a contact.
#[derive(Debug, Clone, Copy, Default)]
pub struct ContactImpulse<S: RowSpace = InSpace> {
    /// Normal impulse λ [N·s].
    pub normal: f64,
    /// Impulse of friction [N·s].
    pub tangential: S::Vector,
    /// Impulse of the moments of rolling and torsional friction [N·m·s].
    pub turning: S::Turn,
}

impl<S: RowSpace> ContactImpulse<S> {
    /// Impulses times a factor.
    pub fn scaled(&self, factor: f64) -> Self {
        Self { normal: factor * self.normal, tangential: self.tangential * factor, turning: self.turning * factor }
    }

    /// Sum with other impulses.
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            normal: self.normal + other.normal,
            tangential: self.tangential + other.tangential,
            turning: self.turning + other.turning,
        }
    }

    /// Impulses from vectors in space.
    pub fn narrow(impulse: &ContactImpulse) -> Self {
        let ContactImpulse { normal, tangential, turning } = *impulse;
        Self { normal, tangential: S::vector(tangential), turning: S::turn(turning) }
    }

    /// Impulses as vectors in space.
    pub fn widen(&self) -> ContactImpulse {
        ContactImpulse { normal: self.normal, tangential: S::widen(self.tangential), turning: S::widen_turn(self.turning) }
    }
}

/// Contact between two bodies at one point.
#[derive(Debug, Clone, Copy)]
pub struct ContactRow<S: RowSpace = InSpace> {
    pub bodies: [usize; 2],
    /// Arms from the centers to the point [m].
    pub arms: [S::Vector; 2],
    /// Unit normal n, from the first body to the second.
    pub normal: S::Vector,
    /// Least normal velocity b [m/s].
    pub least: f64,
    /// Effective masses along the normal and, at least, along the tangents [kg].
    masses: [f64; 2],
    /// Part of the normal impulse that yields; 0 for a rigid contact.
    pub yields: f64,
    pub impulse: ContactImpulse<S>,
    /// Impulses that bounds on the sum include.
    pub before: ContactImpulse<S>,
    pub friction: Friction,
    /// Slip that friction leaves [m/s].
    pub slip: S::Vector,
    /// Effective moments of inertia about the normal and, at least, about the tangents [kg·m²].
    moments: [f64; 2],
}

impl<S: RowSpace> ContactRow<S> {
    /// Contact without impulse; None if neither body can be moved.
    pub fn new(bodies: [usize; 2], arms: [DVec3; 2], normal: DVec3, friction: Friction, v: &BodyVelocities<S>) -> Option<Self> {
        let (arms, normal) = (arms.map(S::vector), S::vector(normal));
        let [one, other] = bodies.map(|body| &v.bodies[body]);
        let response = |along: S::Vector| one.response(arms[0], along) + other.response(arms[1], along);
        let inverse = normal.dot(response(normal));
        if inverse <= 0.0 {
            return None;
        }
        let mut moments = [0.0; 2];
        if friction.rolling > 0.0 || friction.torsional > 0.0 {
            let inverses = S::inverse_moments(normal, &one.inverse_inertia, &other.inverse_inertia);
            moments = inverses.map(|inverse| if inverse > 0.0 { 1.0 / inverse } else { 0.0 });
        }
        Some(Self {
            bodies,
            arms,
            normal,
            least: 0.0,
            masses: [1.0 / inverse, 1.0 / S::across(normal, response)],
            yields: 0.0,
            impulse: ContactImpulse::default(),
            before: ContactImpulse::default(),
            friction,
            slip: S::Vector::default(),
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
    pub fn velocity(&self, v: &BodyVelocities<S>) -> S::Vector {
        v.bodies[self.bodies[1]].at(self.arms[1]) - v.bodies[self.bodies[0]].at(self.arms[0])
    }

    /// Relative angular velocity [rad/s].
    #[inline(always)]
    pub fn turning(&self, v: &BodyVelocities<S>) -> S::Turn {
        v.bodies[self.bodies[1]].angular - v.bodies[self.bodies[0]].angular
    }

    /// Relative velocity at the point and relative angular velocity.
    #[inline(always)]
    pub fn slip_of(&self, v: &BodyVelocities<S>) -> (S::Vector, S::Turn) {
        (self.velocity(v), self.turning(v))
    }

    /// Sum of the normal impulse and that of friction.
    #[inline(always)]
    fn sum(&self) -> S::Vector {
        self.normal * self.impulse.normal + self.impulse.tangential
    }

    #[inline(always)]
    fn push(&self, impulse: S::Vector, v: &mut BodyVelocities<S>) {
        v.bodies[self.bodies[0]].push(self.arms[0], -impulse);
        v.bodies[self.bodies[1]].push(self.arms[1], impulse);
    }

    #[inline(always)]
    fn twist(&self, moment: S::Turn, v: &mut BodyVelocities<S>) {
        v.bodies[self.bodies[0]].twist(-moment);
        v.bodies[self.bodies[1]].twist(moment);
    }

    /// Whether moments resist rolling or torsion.
    #[inline(always)]
    fn resists_turning(&self) -> bool {
        self.friction.rolling > 0.0 || self.friction.torsional > 0.0
    }

    /// Adds the impulses to the velocities.
    #[inline(always)]
    pub fn start(&self, v: &mut BodyVelocities<S>) {
        self.push(self.sum(), v);
        if self.resists_turning() {
            self.twist(self.impulse.turning, v);
        }
    }

    /// Removes the impulses from the velocities.
    pub fn undo(&self, v: &mut BodyVelocities<S>) {
        self.push(-self.sum(), v);
        if self.resists_turning() {
            self.twist(-self.impulse.turning, v);
        }
    }

    /// Solves this contact alone; returns the largest change of a relative velocity [m/s].
    #[inline(always)]
    pub fn relax(&mut self, v: &mut BodyVelocities<S>) -> f64 {
        let relative = self.velocity(v);
        let along = self.normal.dot(relative);
        let stiff = 1.0 - self.yields;
        let impulse = stiff * (self.impulse.normal + self.masses[0] * (self.least - along));
        let impulse = impulse.max(-self.before.normal);
        let mut push = self.normal * (impulse - self.impulse.normal);
        let mut change = (impulse - self.impulse.normal).abs() / self.masses[0];
        self.impulse.normal = impulse;
        let load = self.before.normal + impulse;
        if self.friction.sliding > 0.0 {
            let slip = relative - self.normal * along - self.slip;
            let wanted = self.before.tangential + self.impulse.tangential - slip * self.masses[1];
            let tangential = wanted.limited(self.friction.sliding * load) - self.before.tangential;
            let difference = tangential - self.impulse.tangential;
            change = change.max(difference.dot(difference).sqrt() / self.masses[1]);
            push += difference;
            self.impulse.tangential = tangential;
        }
        if push != S::Vector::default() {
            self.push(push, v);
        }
        if self.resists_turning() {
            self.relax_turning(load, v);
        }
        change
    }

    /// Solves the moments of rolling and torsional friction under a normal impulse.
    fn relax_turning(&mut self, load: f64, v: &mut BodyVelocities<S>) {
        let turning = self.turning(v);
        let about = S::about(self.normal, turning);
        let [torsion, roll] = self.moments;
        let wanted = self.before.turning + self.impulse.turning - about * torsion - (turning - about) * roll;
        let along = S::about(self.normal, wanted);
        let bounded = along.limited(self.friction.torsional * load) + (wanted - along).limited(self.friction.rolling * load)
            - self.before.turning;
        self.twist(bounded - self.impulse.turning, v);
        self.impulse.turning = bounded;
    }

    /// Energy supplied by fixed bodies, which move as prescribed [J].
    pub fn supplied(&self, v: &BodyVelocities<S>) -> f64 {
        let of = |side: usize, sign: f64| {
            let body = &v.bodies[self.bodies[side]];
            let power = self.sum().dot(body.at(self.arms[side])) + self.impulse.turning.dot(body.angular);
            if body.is_fixed() { sign * power } else { 0.0 }
        };
        of(0, 1.0) + of(1, -1.0)
    }

    /// Work of the impulses on the relative motion, from velocities before to velocities after them [J].
    #[inline(always)]
    pub fn work(&self, before: (S::Vector, S::Turn), after: (S::Vector, S::Turn)) -> f64 {
        0.5 * (self.sum().dot(before.0 + after.0) + self.impulse.turning.dot(before.1 + after.1))
    }
}

impl ContactRow {
    /// Adds the impulses to the velocities and angular momenta of the bodies.
    pub fn apply(&self, movers: &mut [Mover]) {
        let impulse = self.sum();
        for (body, arm, sign) in [(self.bodies[0], self.arms[0], -1.0), (self.bodies[1], self.arms[1], 1.0)] {
            let mover = &mut movers[body];
            if !mover.is_fixed() {
                mover.velocity += sign * mover.inverse_mass * impulse;
                mover.spin += sign * (arm.cross(impulse) + self.impulse.turning);
            }
        }
    }
}

/// Whether impulses of contacts add energy, beyond that of gaps which they open, together with the limits of joints, which
/// dissipate `stopped` [J].
pub fn add_energy<S: RowSpace>(
    contacts: &[ContactRow<S>],
    stopped: f64,
    free: &BodyVelocities<S>,
    v: &BodyVelocities<S>,
) -> bool {
    let (mut sum, mut size) = (-stopped, stopped.abs());
    for row in contacts {
        let work = row.work(row.slip_of(free), row.slip_of(v));
        sum += work - row.impulse.normal * row.least.max(0.0);
        size += work.abs();
    }
    sum > GAINED * size
}
