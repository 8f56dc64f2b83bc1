//! Bodies and particles during a step.

use glam::{DMat3, DVec3};
use physcore_base::simd::{Isa, Kernel, dispatch_wide};

use crate::pose::Pose;
use crate::rotation::{Inertia, Orientation};
use crate::splitting::{Quaternion, TurnQueue};

/// Body, particle or wall during a step.
#[derive(Debug, Clone, Copy)]
pub struct Mover {
    /// Position of the center of mass [m].
    pub position: DVec3,
    /// Velocity of the center of mass [m/s].
    pub velocity: DVec3,
    /// Orientation.
    pub orientation: Orientation,
    /// Angular momentum about the center of mass [kg·m²/s]; of a fixed body, the angular velocity [rad/s].
    pub spin: DVec3,
    /// Acceleration by forces, constant during a step [m/s²].
    pub acceleration: DVec3,
    /// Torque of forces, constant during a step [N·m].
    pub torque: DVec3,
    /// Inverse mass [1/kg]; 0 for a fixed body.
    pub inverse_mass: f64,
    /// Moments of inertia.
    pub inertia: Inertia,
    /// Largest distance of a surface point from the center [m]; 0 for a ball or disc, whose surface does not change by turning.
    pub arm: f64,
}

impl Mover {
    /// Wall at rest.
    pub fn wall(pose: &Pose) -> Self {
        Self {
            position: pose.position,
            velocity: DVec3::ZERO,
            orientation: Orientation::spatial(glam::DQuat::from_mat3(&pose.rotation)),
            spin: DVec3::ZERO,
            acceleration: DVec3::ZERO,
            torque: DVec3::ZERO,
            inverse_mass: 0.0,
            inertia: Inertia::NONE,
            arm: 0.0,
        }
    }

    /// Whether impulses leave the body as it is.
    #[inline(always)]
    pub fn is_fixed(&self) -> bool {
        self.inverse_mass == 0.0
    }

    /// Pose.
    pub fn pose(&self) -> Pose {
        Pose { position: self.position, rotation: self.orientation.matrix() }
    }

    /// Inverse of the inertia tensor in the world [1/(kg·m²)].
    pub fn inverse_inertia(&self) -> DMat3 {
        self.inertia.inverse(&self.orientation)
    }

    /// Angular velocity [rad/s].
    pub fn angular_velocity(&self) -> DVec3 {
        if self.is_fixed() { self.spin } else { self.inverse_inertia() * self.spin }
    }

    /// Bound on the speed of surface points [m/s].
    pub fn speed(&self) -> f64 {
        let rate = if self.is_fixed() { self.spin.length() } else { self.inertia.rate(&self.orientation, self.spin) };
        self.velocity.length() + rate * self.arm
    }

    /// Applies the forces for `h` seconds.
    pub fn kick(&mut self, h: f64) {
        if !self.is_fixed() {
            self.velocity += h * self.acceleration;
            self.spin += h * self.torque;
        }
    }

    /// Orientation after `h` seconds without torque.
    pub fn turned(&self, h: f64) -> Orientation {
        if self.is_fixed() {
            self.orientation.turned(h * self.spin)
        } else if self.inertia == Inertia::NONE {
            self.orientation
        } else {
            self.inertia.turned(&self.orientation, self.spin, h)
        }
    }

    /// Moves the body for `h` seconds without forces.
    pub fn drift(&mut self, h: f64) {
        self.orientation = self.turned(h);
        self.position += h * self.velocity;
    }

    /// Energy of rotation [J]; 0 of a fixed body.
    pub fn rotational_energy(&self) -> f64 {
        if self.is_fixed() { 0.0 } else { 0.5 * self.spin.dot(self.angular_velocity()) }
    }
}

/// Moves bodies for `h` seconds without forces, side by side; the bits are those of [`Mover::drift`].
pub fn drift_all(movers: &mut [Mover], h: f64) {
    dispatch_wide(Drifting { movers, h });
}

/// Drift of bodies side by side.
struct Drifting<'a> {
    movers: &'a mut [Mover],
    h: f64,
}

impl Kernel for Drifting<'_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Isa>(mut self, _isa: I) {
        let mut queue = TurnQueue::new();
        for index in 0..self.movers.len() {
            let mover = &mut self.movers[index];
            if mover.is_fixed() || mover.inertia.is_planar() || mover.inertia == Inertia::NONE {
                mover.drift(self.h);
                continue;
            }
            queue.lanes.set(queue.count, &mover.inertia.free_turn(&mover.orientation, mover.spin, self.h));
            queue.push(index, |index, orientation| self.take(index, orientation));
        }
        queue.finish(|index, orientation| self.take(index, orientation));
    }
}

impl Drifting<'_> {
    /// Takes the orientation of a body, and moves it.
    #[inline(always)]
    fn take(&mut self, index: usize, orientation: Quaternion) {
        let mover = &mut self.movers[index];
        mover.orientation = mover.inertia.orientation_of(orientation);
        mover.position += self.h * mover.velocity;
    }
}

/// Two unit vectors across an axis, the first in the plane for an axis in it.
pub fn perpendicular(axis: DVec3) -> [DVec3; 2] {
    let away = if axis.z.abs() < 0.9 { DVec3::Z } else { DVec3::X };
    let first = axis.cross(away).normalize();
    [first, axis.cross(first)]
}
