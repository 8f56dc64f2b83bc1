//! Impulses between bodies, by projected Gauss–Seidel iteration over blocks: joints, bounds and contacts with friction.
//!
//! A block acts between two bodies. Joints hold relative velocities J v = b and are solved exactly, block by block. Contacts
//! hold n·u ≥ b with an impulse λ ≥ 0, and Coulomb's friction |t| ≤ μ λ, which opposes the slip. All impulses are pairs of
//! opposite impulses at one point, so that momentum and angular momentum are kept to rounding. Sources: M. Jean, Comput. Meth.
//! Appl. Mech. Eng. 177, 235 (1999); V. Acary, B. Brogliato, "Numerical Methods for Nonsmooth Dynamical Systems", 2008.

mod bundle;
mod contact;
mod joint;
mod lanes;
mod space;

use glam::{DMat3, DVec3};

use crate::face::{FACES, NetFace, weights};
use crate::joint_system::JointSystem;
use crate::mover::Mover;

pub use bundle::{Bundles, Pass, RowBundle};
pub use contact::{ContactImpulse, ContactRow, add_energy, adds_energy};
pub(crate) use joint::inverted;
pub use joint::{BoundedRow, JointRows, Row};
pub use lanes::{ImpulseLanes, LanesOf, Loaded, SIDE};
pub use space::{InPlane, InSpace, Linear, RowAlgebra, RowSpace};

/// Largest number of rows of a joint.
pub const MOST_ROWS: usize = 6;

/// Velocities of a body during a solve, with its inverse mass and inertia.
#[derive(Debug, Clone, Copy, Default)]
pub struct BodyVelocity<S: RowAlgebra = InSpace> {
    pub linear: S::Vector,
    pub angular: S::Turn,
    pub inverse_mass: S::Number,
    pub inverse_inertia: S::Inverse,
}

impl<S: RowSpace> BodyVelocity<S> {
    /// Whether impulses leave the body as it is.
    #[inline(always)]
    pub fn is_fixed(&self) -> bool {
        self.inverse_mass == 0.0
    }
}

impl<S: RowAlgebra> BodyVelocity<S> {
    /// Velocity of a point at an arm from the center [m/s].
    #[inline(always)]
    pub fn at(&self, arm: S::Vector) -> S::Vector {
        self.linear + S::swept(self.angular, arm)
    }

    /// Adds an impulse at an arm from the center.
    #[inline(always)]
    pub fn push(&mut self, arm: S::Vector, impulse: S::Vector) {
        self.linear = self.linear + impulse * self.inverse_mass;
        self.twist(S::moment(arm, impulse));
    }

    /// Adds an angular impulse.
    #[inline(always)]
    pub fn twist(&mut self, moment: S::Turn) {
        self.angular = self.angular + S::turned(&self.inverse_inertia, moment);
    }

    /// Response of the velocity at an arm to an impulse there.
    #[inline(always)]
    pub fn response(&self, arm: S::Vector, impulse: S::Vector) -> S::Vector {
        impulse * self.inverse_mass + S::swept(S::turned(&self.inverse_inertia, S::moment(arm, impulse)), arm)
    }
}

/// Velocities of all bodies of a group during a solve. Numbers from [`FACES`] on are those of its faces.
#[derive(Debug, Clone, Default)]
pub struct BodyVelocities<S: RowSpace = InSpace> {
    pub bodies: Vec<BodyVelocity<S>>,
    pub faces: Vec<NetFace>,
}

impl BodyVelocities {
    /// Velocities of movers in their present orientations, without faces.
    pub fn of(movers: &[Mover]) -> Self {
        let mut velocities = Self::default();
        velocities.fill(movers, &[]);
        velocities
    }

    /// Response of one row of a body to the impulse of another one, each given with its side.
    pub fn coupling(&self, body: usize, (row, side): (&Row, usize), (other, across): (&Row, usize)) -> f64 {
        let body = &self.bodies[body];
        body.inverse_mass * row.linear.dot(other.linear) + row.angular[side].dot(body.inverse_inertia * other.angular[across])
    }
}

impl<S: RowSpace> BodyVelocities<S> {
    /// Body of a row, or the particle that is the point of a face at coordinates.
    #[inline(always)]
    pub fn body(&self, index: usize, arm: S::Vector) -> BodyVelocity<S> {
        self.bodies.get(index).copied().unwrap_or_else(|| self.point(index, arm))
    }

    /// Point of a face at coordinates, as a particle.
    #[cold]
    fn point(&self, index: usize, at: S::Vector) -> BodyVelocity<S> {
        // A particle does not turn; the default of a matrix is the identity.
        let mut point = BodyVelocity::<S> { inverse_inertia: S::inverse(&DMat3::ZERO), ..BodyVelocity::default() };
        for (corner, weight) in self.corners(index, at) {
            point.linear += self.bodies[corner].linear * weight;
            point.inverse_mass += weight * weight * self.bodies[corner].inverse_mass;
        }
        point
    }

    /// Corners of a face with their weights at coordinates.
    pub fn corners(&self, index: usize, at: S::Vector) -> [(usize, f64); 3] {
        let (corners, weights) = (self.faces[index - FACES].corners, weights(S::widen(at)));
        std::array::from_fn(|corner| (corners[corner] as usize, weights[corner]))
    }

    /// Part of the velocity of the point of a face that its fixed corners have, which move as prescribed [m/s].
    pub fn prescribed(&self, index: usize, at: S::Vector) -> S::Vector {
        let corners = self.corners(index, at).map(|(corner, weight)| (&self.bodies[corner], weight));
        let fixed = corners.into_iter().filter(|(corner, _)| corner.is_fixed());
        fixed.fold(S::Vector::default(), |sum, (corner, weight)| sum + corner.linear * weight)
    }

    /// Velocity of a body at an arm, or of the point of a face at coordinates [m/s].
    #[inline(always)]
    pub fn at(&self, index: usize, arm: S::Vector) -> S::Vector {
        self.bodies.get(index).map_or_else(|| self.point(index, arm).linear, |body| body.at(arm))
    }

    /// Angular velocity of a body [rad/s]; 0 of a face.
    #[inline(always)]
    pub fn angular(&self, index: usize) -> S::Turn {
        self.bodies.get(index).map_or_else(S::Turn::default, |body| body.angular)
    }

    /// Adds an impulse at an arm of a body, or at coordinates of a face.
    #[inline(always)]
    pub fn push(&mut self, index: usize, arm: S::Vector, impulse: S::Vector) {
        match self.bodies.get_mut(index) {
            Some(body) => body.push(arm, impulse),
            None => self.push_point(index, arm, impulse),
        }
    }

    /// Adds an impulse at coordinates of a face.
    #[cold]
    pub fn push_point(&mut self, index: usize, at: S::Vector, impulse: S::Vector) {
        for (corner, weight) in self.corners(index, at) {
            let corner = &mut self.bodies[corner];
            corner.linear += impulse * (weight * corner.inverse_mass);
        }
    }

    /// Gives the point of a face at coordinates a velocity [m/s], by an impulse.
    #[cold]
    pub fn move_point(&mut self, index: usize, at: S::Vector, velocity: S::Vector) {
        let point = self.point(index, at);
        if point.inverse_mass > 0.0 {
            self.push_point(index, at, (velocity - point.linear) * (1.0 / point.inverse_mass));
        }
    }

    /// Movers that an impulse on a body, or at coordinates of a face, acts on.
    pub fn movers(&self, index: usize, arm: S::Vector) -> impl Iterator<Item = usize> + Clone {
        let (corners, count) = if index < FACES { ([(index, 1.0); 3], 1) } else { (self.corners(index, arm), 3) };
        corners.into_iter().take(count).map(|(mover, _)| mover)
    }

    /// Adds an angular impulse; a face takes none.
    #[inline(always)]
    pub fn twist(&mut self, index: usize, moment: S::Turn) {
        if let Some(body) = self.bodies.get_mut(index) {
            body.twist(moment);
        }
    }

    /// Replaces all velocities, inverse masses and inertias by those of movers.
    pub fn fill(&mut self, movers: &[Mover], faces: &[NetFace]) {
        faces.clone_into(&mut self.faces);
        self.bodies.clear();
        self.bodies.extend(movers.iter().map(|mover| {
            let inverse_inertia = S::inverse(&mover.inverse_inertia());
            let (linear, spin) = (S::vector(mover.velocity), S::turn(mover.spin));
            let angular = if mover.is_fixed() { spin } else { S::turned(&inverse_inertia, spin) };
            BodyVelocity { linear, angular, inverse_mass: mover.inverse_mass, inverse_inertia }
        }));
    }

    /// Applies the forces on movers for `h` seconds.
    pub fn kick(&mut self, movers: &[Mover], h: f64) {
        for (body, mover) in self.bodies.iter_mut().zip(movers).filter(|(_, mover)| !mover.is_fixed()) {
            body.linear += S::vector(h * mover.acceleration);
            if mover.torque != DVec3::ZERO {
                body.twist(S::turn(h * mover.torque));
            }
        }
    }
}

/// Rows of all joints and contacts of a group of bodies.
#[derive(Debug, Clone, Default)]
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
        self.contacts.iter().for_each(|contact| contact.start(v));
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

    /// Adds all impulses to the velocities and angular momenta of the bodies, and of the corners of faces.
    pub fn apply(&self, movers: &mut [Mover], faces: &[NetFace]) {
        for joint in &self.joints {
            joint.rows.iter().for_each(|row| row.apply(joint.bodies, movers, faces));
        }
        self.bounds.iter().for_each(|bounded| bounded.row.apply(bounded.bodies, movers, faces));
        self.contacts.iter().for_each(|contact| contact.apply(movers, faces));
    }
}
