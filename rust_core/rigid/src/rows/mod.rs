//! Impulses between bodies, by projected Gauss–Seidel iteration over blocks: joints, bounds and contacts with friction.
//!
//! A block acts between two bodies. Joints hold relative velocities J v = b and are solved exactly, block by block. Contacts
//! hold n·u ≥ b with an impulse λ ≥ 0, and Coulomb's friction |t| ≤ μ λ, which opposes the slip. All impulses are pairs of
//! opposite impulses at one point, so that momentum and angular momentum are kept to rounding. Sources: M. Jean, Comput. Meth.
//! Appl. Mech. Eng. 177, 235 (1999); V. Acary, B. Brogliato, "Numerical Methods for Nonsmooth Dynamical Systems", 2008.

mod contact;
mod joint;

use glam::{DMat3, DVec3};

use crate::joint_system::JointSystem;
use crate::mover::Mover;

pub use contact::{ContactImpulse, ContactRow};
pub(crate) use joint::inverted;
pub use joint::{BoundedRow, JointRows, Row};

/// Largest number of rows of a joint.
pub const MOST_ROWS: usize = 6;

/// Velocities during a solve, with the inverse masses and inertias.
#[derive(Debug, Clone, Default)]
pub struct BodyVelocities {
    linear: Vec<DVec3>,
    angular: Vec<DVec3>,
    inverse_mass: Vec<f64>,
    inverse_inertia: Vec<DMat3>,
}

impl BodyVelocities {
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
    pub fn push(&mut self, body: usize, arm: DVec3, impulse: DVec3) {
        self.linear[body] += self.inverse_mass[body] * impulse;
        self.angular[body] += self.inverse_inertia[body] * arm.cross(impulse);
    }

    /// Response of the velocity at an arm to an impulse there.
    pub fn response(&self, body: usize, arm: DVec3, impulse: DVec3) -> DVec3 {
        self.inverse_mass[body] * impulse + (self.inverse_inertia[body] * arm.cross(impulse)).cross(arm)
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
    pub fn link(&mut self, v: &BodyVelocities) {
        self.system = JointSystem::new(&self.joints, v);
    }

    /// Adds the initial impulses to the velocities.
    pub fn start(&self, v: &mut BodyVelocities) {
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

    /// Relaxes all rows once; returns the largest change of a relative velocity [m/s].
    pub fn relax_all(&mut self, iteration: usize, v: &mut BodyVelocities) -> f64 {
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

    /// Energy that motors, and bodies that move as prescribed, supply by the impulses [J], from velocities before to
    /// velocities after them.
    pub fn supplied(&self, before: &BodyVelocities, after: &BodyVelocities) -> f64 {
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
    pub fn stopped(&self, before: &BodyVelocities, after: &BodyVelocities) -> f64 {
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
