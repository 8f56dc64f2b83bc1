//! Rows of contacts with friction.

use glam::DVec3;
use physcore_base::simd::Number;

use super::{BodyVelocities, BodyVelocity, InSpace, Linear, Row, RowAlgebra, RowSpace};
use crate::face::{self, FACES, NetFace};
use crate::mover::Mover;
use crate::surface::Friction;

/// Energy that impulses may add, over the work of their parts.
const GAINED: f64 = 1e-6;

/// Impulses of a contact.
#[derive(Debug, Clone, Copy, Default)]
pub struct ContactImpulse<S: RowAlgebra = InSpace> {
    /// Normal impulse λ [N·s].
    pub normal: S::Number,
    /// Impulse of friction [N·s].
    pub tangential: S::Vector,
    /// Impulse of the moments of rolling and torsional friction [N·m·s].
    pub turning: S::Turn,
}

impl<S: RowAlgebra> ContactImpulse<S> {
    /// Impulses times a factor.
    #[inline(always)]
    pub fn scaled(&self, factor: S::Number) -> Self {
        Self { normal: factor * self.normal, tangential: self.tangential * factor, turning: self.turning * factor }
    }

    /// Sum with other impulses.
    #[inline(always)]
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            normal: self.normal + other.normal,
            tangential: self.tangential + other.tangential,
            turning: self.turning + other.turning,
        }
    }
}

impl<S: RowSpace> ContactImpulse<S> {
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
pub struct ContactRow<S: RowAlgebra = InSpace> {
    pub bodies: [usize; 2],
    /// Arms from the centers to the point [m]; coordinates of the point of a face.
    pub arms: [S::Vector; 2],
    /// Unit normal n, from the first body to the second.
    pub normal: S::Vector,
    /// Least normal velocity b [m/s].
    pub least: S::Number,
    /// Effective masses along the normal and, at least, along the tangents [kg].
    pub(super) masses: [S::Number; 2],
    /// Part of the normal impulse that yields; 0 for a rigid contact.
    pub yields: S::Number,
    pub impulse: ContactImpulse<S>,
    /// Impulses that bounds on the sum include.
    pub before: ContactImpulse<S>,
    pub friction: Friction<S::Number>,
    /// Slip that friction leaves [m/s].
    pub slip: S::Vector,
    /// Effective moments of inertia about the normal and, at least, about the tangents [kg·m²].
    pub(super) moments: [S::Number; 2],
}

impl<S: RowAlgebra> ContactRow<S> {
    /// Velocity of the second of two bodies at the point, relative to the first [m/s].
    #[inline(always)]
    pub fn between(&self, [one, other]: [&BodyVelocity<S>; 2]) -> S::Vector {
        other.at(self.arms[1]) - one.at(self.arms[0])
    }

    /// Sum of the normal impulse and that of friction.
    #[inline(always)]
    pub(super) fn sum(&self) -> S::Vector {
        self.normal * self.impulse.normal + self.impulse.tangential
    }

    /// Effective masses and moments of inertia between two bodies; 0 where the inverse is.
    #[inline(always)]
    pub(super) fn weights(&self, bodies: [&BodyVelocity<S>; 2]) -> [[S::Number; 2]; 2] {
        let mut weights = [
            [self.normal.dot(self.response(self.normal, bodies)), S::across(self, bodies)],
            S::inverse_moments(self.normal, [&bodies[0].inverse_inertia, &bodies[1].inverse_inertia]),
        ];
        let (zero, one) = (S::Number::constant(0.0), S::Number::constant(1.0));
        for inverse in weights.as_flattened_mut() {
            *inverse = (one / *inverse).masked(zero.less(*inverse));
        }
        weights
    }

    /// Response of the relative velocity of two bodies at the point to an impulse there.
    #[inline(always)]
    pub(super) fn response(&self, impulse: S::Vector, [one, other]: [&BodyVelocity<S>; 2]) -> S::Vector {
        one.response(self.arms[0], impulse) + other.response(self.arms[1], impulse)
    }

    /// Normal impulse and that of friction which solve this contact alone, at a relative velocity [m/s].
    #[inline(always)]
    pub fn solved(&self, relative: S::Vector) -> (S::Number, S::Vector) {
        let along = self.normal.dot(relative);
        let (zero, one) = (S::Number::constant(0.0), S::Number::constant(1.0));
        let stiff = one - self.yields;
        let normal = stiff * (self.impulse.normal + self.masses[0] * (self.least - along));
        let normal = normal.max(zero - self.before.normal);
        let slip = relative - self.normal * along - self.slip;
        let wanted = self.before.tangential + self.impulse.tangential - slip * self.masses[1];
        let most = self.friction.sliding * (self.before.normal + normal);
        let tangential = S::held(self.normal, wanted, most) - self.before.tangential;
        (normal, S::Vector::select(zero.less(self.friction.sliding), tangential, self.impulse.tangential))
    }

    /// Moments of rolling and torsional friction under a normal impulse, at a relative angular velocity [rad/s].
    #[inline(always)]
    pub fn solved_turning(&self, load: S::Number, turning: S::Turn) -> S::Turn {
        let about = S::about(self.normal, turning);
        let [torsion, roll] = self.moments;
        let wanted = self.before.turning + self.impulse.turning - about * torsion - (turning - about) * roll;
        let along = S::about(self.normal, wanted);
        along.limited(self.friction.torsional * load) + (wanted - along).limited(self.friction.rolling * load)
            - self.before.turning
    }

    /// Work of the impulses on the relative motion, from velocities before to velocities after them [J].
    #[inline(always)]
    pub fn work(&self, before: (S::Vector, S::Turn), after: (S::Vector, S::Turn)) -> S::Number {
        let sum = self.sum().dot(before.0 + after.0) + self.impulse.turning.dot(before.1 + after.1);
        S::Number::constant(0.5) * sum
    }

    /// Impulse under which a contact that yields stays at rest [N·s].
    #[inline(always)]
    pub fn borne(&self) -> S::Number {
        (S::Number::constant(1.0) / self.yields - S::Number::constant(1.0)) * self.masses[0] * self.least
    }

    /// Work beyond that of a gap which the impulses open, and the absolute value of the work [J].
    #[inline(always)]
    pub fn gain(&self, before: (S::Vector, S::Turn), after: (S::Vector, S::Turn)) -> [S::Number; 2] {
        let (work, zero) = (self.work(before, after), S::Number::constant(0.0));
        [work - self.impulse.normal * self.least.max(zero), work.max(zero - work)]
    }
}

impl<S: RowSpace> ContactRow<S> {
    /// Contact without impulse; None if neither body can be moved.
    pub fn new(bodies: [usize; 2], arms: [DVec3; 2], normal: DVec3, friction: Friction, v: &BodyVelocities<S>) -> Option<Self> {
        let row = Self::unweighed(bodies, arms, normal, friction);
        let [one, other] = [0, 1].map(|side| v.body(bodies[side], row.arms[side]));
        let [masses, moments] = row.weights([&one, &other]);
        (masses[0] > 0.0).then_some(Self { masses, moments, ..row })
    }

    /// Contact without impulse and without effective masses.
    pub fn unweighed(bodies: [usize; 2], arms: [DVec3; 2], normal: DVec3, friction: Friction) -> Self {
        Self {
            bodies,
            arms: arms.map(S::vector),
            normal: S::vector(normal),
            least: 0.0,
            masses: [0.0; 2],
            yields: 0.0,
            impulse: ContactImpulse::default(),
            before: ContactImpulse::default(),
            friction,
            slip: S::Vector::default(),
            moments: [0.0; 2],
        }
    }

    /// Copy without impulses, for another least normal velocity [m/s].
    pub fn anew(&self, least: f64) -> Self {
        let (impulse, before) = (ContactImpulse::default(), ContactImpulse::default());
        Self { least, impulse, before, ..*self }
    }

    /// Relative velocity of the second body at the point [m/s].
    #[inline(always)]
    pub fn velocity(&self, v: &BodyVelocities<S>) -> S::Vector {
        v.at(self.bodies[1], self.arms[1]) - v.at(self.bodies[0], self.arms[0])
    }

    /// Relative angular velocity [rad/s].
    #[inline(always)]
    pub fn turning(&self, v: &BodyVelocities<S>) -> S::Turn {
        v.angular(self.bodies[1]) - v.angular(self.bodies[0])
    }

    /// Relative velocity at the point and relative angular velocity.
    #[inline(always)]
    pub fn slip_of(&self, v: &BodyVelocities<S>) -> (S::Vector, S::Turn) {
        (self.velocity(v), self.turning(v))
    }

    #[inline(always)]
    fn push(&self, impulse: S::Vector, v: &mut BodyVelocities<S>) {
        v.push(self.bodies[0], self.arms[0], -impulse);
        v.push(self.bodies[1], self.arms[1], impulse);
    }

    #[inline(always)]
    fn twist(&self, moment: S::Turn, v: &mut BodyVelocities<S>) {
        v.twist(self.bodies[0], -moment);
        v.twist(self.bodies[1], moment);
    }

    /// Whether moments resist rolling or torsion.
    #[inline(always)]
    pub fn resists_turning(&self) -> bool {
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
        let (normal, tangential) = self.solved(self.velocity(v));
        let (pressed, held) = (normal - self.impulse.normal, tangential - self.impulse.tangential);
        (self.impulse.normal, self.impulse.tangential) = (normal, tangential);
        let push = self.normal * pressed + held;
        if push != S::Vector::default() {
            self.push(push, v);
        }
        if self.resists_turning() {
            let turning = self.solved_turning(self.before.normal + normal, self.turning(v));
            self.twist(turning - self.impulse.turning, v);
            self.impulse.turning = turning;
        }
        (pressed.abs() / self.masses[0]).max(held.dot(held).sqrt() / self.masses[1])
    }

    /// Energy supplied by fixed bodies, which move as prescribed [J].
    pub fn supplied(&self, v: &BodyVelocities<S>) -> f64 {
        let of = |side: usize, sign: f64| {
            let Some(body) = v.bodies.get(self.bodies[side]) else {
                return sign * self.sum().dot(v.prescribed(self.bodies[side], self.arms[side]));
            };
            let power = self.sum().dot(body.at(self.arms[side])) + self.impulse.turning.dot(body.angular);
            if body.is_fixed() { sign * power } else { 0.0 }
        };
        of(0, 1.0) + of(1, -1.0)
    }
}

impl ContactRow {
    /// Equation for the relative velocity along a direction.
    pub fn along(&self, direction: DVec3) -> Row {
        let [one, other] = self.arms.map(|arm| arm.cross(direction));
        Row::new(direction, [one, if self.bodies[1] < FACES { other } else { self.arms[1] }])
    }

    /// Adds the impulses to the velocities and angular momenta of the bodies, and of the corners of a face.
    pub fn apply(&self, movers: &mut [Mover], faces: &[NetFace]) {
        let impulse = self.sum();
        for (body, arm, sign) in [(self.bodies[0], self.arms[0], -1.0), (self.bodies[1], self.arms[1], 1.0)] {
            let Some(mover) = movers.get_mut(body) else {
                face::push(body, arm, impulse, movers, faces);
                continue;
            };
            if !mover.is_fixed() {
                mover.velocity += sign * mover.inverse_mass * impulse;
                mover.spin += sign * (arm.cross(impulse) + self.impulse.turning);
            }
        }
    }
}

/// Whether impulses of contacts add energy, beyond that of gaps which they open, together with the limits of joints, which
/// dissipate `stopped` [J].
pub fn add_energy(contacts: &[ContactRow], stopped: f64, free: &BodyVelocities, v: &BodyVelocities) -> bool {
    let (mut sum, mut size) = (-stopped, stopped.abs());
    for row in contacts {
        let [gain, work] = row.gain(row.slip_of(free), row.slip_of(v));
        sum += gain;
        size += work;
    }
    adds_energy(sum, size)
}

/// Whether a sum of energies is positive, given that of their absolute values.
pub fn adds_energy(sum: f64, size: f64) -> bool {
    sum > GAINED * size
}
