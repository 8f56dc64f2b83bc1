//! Rows of contacts with friction.

use glam::DVec3;

use super::BodyVelocities;
use crate::mover::{Mover, perpendicular};
use crate::surface::Friction;

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
    pub fn new(bodies: [usize; 2], arms: [DVec3; 2], normal: DVec3, friction: Friction, v: &BodyVelocities) -> Option<Self> {
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
    pub fn velocity(&self, v: &BodyVelocities) -> DVec3 {
        v.at(self.bodies[1], self.arms[1]) - v.at(self.bodies[0], self.arms[0])
    }

    /// Relative angular velocity [rad/s].
    pub fn turning(&self, v: &BodyVelocities) -> DVec3 {
        v.angular[self.bodies[1]] - v.angular[self.bodies[0]]
    }

    /// Relative velocity at the point and relative angular velocity.
    pub fn slip_of(&self, v: &BodyVelocities) -> (DVec3, DVec3) {
        (self.velocity(v), self.turning(v))
    }

    #[inline(always)]
    pub fn push(&self, impulse: DVec3, v: &mut BodyVelocities) {
        v.push(self.bodies[0], self.arms[0], -impulse);
        v.push(self.bodies[1], self.arms[1], impulse);
    }

    /// Solves this contact alone; returns the largest change of a relative velocity [m/s].
    #[inline(always)]
    pub fn relax(&mut self, v: &mut BodyVelocities) -> f64 {
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

    /// Removes the impulses from the velocities.
    pub fn undo(&self, v: &mut BodyVelocities) {
        self.push(-(self.impulse.normal * self.normal + self.impulse.tangential), v);
        let [one, other] = self.bodies;
        v.angular[one] += v.inverse_inertia[one] * self.impulse.turning;
        v.angular[other] -= v.inverse_inertia[other] * self.impulse.turning;
    }

    /// Solves the moments of rolling and torsional friction under a normal impulse.
    fn relax_turning(&mut self, load: f64, v: &mut BodyVelocities) {
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
    pub fn supplied(&self, v: &BodyVelocities) -> f64 {
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
