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

/// Iterations between Newton steps.
const SWEEPS: usize = 4;
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

    /// Iterates in alternating order until no relative velocity changes by more than `tolerance` [m/s]; returns whether it
    /// came to that. A Newton step for the rows that hold follows some of the iterations. If it does not pay, it is undone.
    /// Without convergence, the iterations begin anew without impulses and Newton steps: these approach the solution from below.
    pub fn solve(&mut self, v: &mut BodyVelocities, tolerance: f64, most: usize) -> bool {
        let (impulses, velocities) = (self.impulses(), v.clone());
        if self.iterate(v, tolerance, most) {
            return true;
        }
        *v = velocities;
        let opposite: Vec<f64> = impulses.iter().map(|impulse| -impulse).collect();
        self.set_impulses(&opposite);
        self.start(v);
        self.set_impulses(&vec![0.0; impulses.len()]);
        (0..most).any(|iteration| self.relax_all(iteration, v) <= tolerance)
    }

    /// Iterates with Newton steps.
    fn iterate(&mut self, v: &mut BodyVelocities, tolerance: f64, most: usize) -> bool {
        let mut before: Option<(f64, Vec<f64>, BodyVelocities)> = None;
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
                && !change.le(&change_before)
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
