//! Joints between two bodies: equations between their poses, limits, motors and springs.

mod spring;

use std::f64::consts::TAU;

use arrayvec::ArrayVec;
use glam::{DQuat, DVec3};

use crate::mover::{Mover, perpendicular};
use crate::rows::{MOST_ROWS, Row};

pub use spring::DampedSpring;
pub(crate) use spring::SpringForce;

/// Kind of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum JointKind {
    /// Points coincide.
    Ball,
    /// Points coincide, and an axis in the first body's frame coincides with one in the second's.
    Hinge,
    /// A point of the second body moves along an axis of the first; orientations are fixed to each other.
    Prismatic,
    /// Points coincide, and orientations are fixed to each other.
    Weld,
    /// Points keep their distance [m].
    Rod(f64),
    /// Points attract or repel each other.
    Spring(DampedSpring),
}

/// Motor of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motor {
    /// Relative velocity [rad/s] or [m/s].
    pub speed: f64,
    /// Largest moment [N·m] or force [N].
    pub most: f64,
}

/// Joint between two bodies. Its force, torque, angle, way and speed are those of the second body relative to the first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Joint {
    /// Kind, with its numbers.
    pub kind: JointKind,
    /// Anchors in the frames of the bodies [m].
    pub anchors: [DVec3; 2],
    /// Axis in the frames of the bodies.
    pub axes: [DVec3; 2],
    /// Orientation of the second body in the first's frame.
    pub relative: DQuat,
    /// Difference of the angles in the plane [rad].
    pub angle: f64,
    /// Angle of a hinge in space after the last step, in all its turns [rad].
    pub last: f64,
    /// Least and largest angle [rad] or way [m].
    pub limits: [f64; 2],
    /// Motor, if there is one.
    pub motor: Option<Motor>,
    /// Size of the force at which the joint breaks [N].
    pub breaking_force: f64,
    /// Radius of gyration of the bodies, the lever of rows about angles [m]: they have the units of the others.
    pub lever: f64,
    /// Whether the bodies move in the plane.
    pub planar: bool,
}

/// Row of a joint and its error [m].
pub(crate) type JointEquation = (Row, f64);

impl Joint {
    /// Joint of two bodies at their present poses.
    pub fn new(kind: JointKind, bodies: [&Mover; 2], points: [DVec3; 2], axis: DVec3, planar: bool) -> Self {
        let [one, other] = bodies.map(Mover::pose);
        Self {
            kind,
            anchors: [one.local_point(points[0]), other.local_point(points[1])],
            axes: [one.local_vector(axis), other.local_vector(axis)],
            relative: bodies[0].orientation.quaternion.inverse() * bodies[1].orientation.quaternion,
            angle: bodies[1].orientation.angle - bodies[0].orientation.angle,
            last: 0.0,
            limits: [f64::NEG_INFINITY, f64::INFINITY],
            motor: None,
            breaking_force: f64::INFINITY,
            lever: lever(bodies),
            planar,
        }
    }

    /// Length of a unit of the coordinate of the joint: the lever for an angle, 1 for a way.
    pub fn unit(&self) -> f64 {
        if self.kind == JointKind::Prismatic { 1.0 } else { self.lever }
    }

    /// Lower or upper limit of the coordinate [m].
    pub fn limit(&self, which: usize) -> f64 {
        self.unit() * self.limits[which]
    }

    /// Number of equations of the joint.
    pub(crate) fn count(&self) -> usize {
        match (self.kind, self.planar) {
            (JointKind::Spring(_), _) => 0,
            (JointKind::Rod(_), _) => 1,
            (JointKind::Ball | JointKind::Hinge | JointKind::Prismatic, true) => 2,
            (JointKind::Ball, false) | (JointKind::Weld, true) => 3,
            (JointKind::Hinge | JointKind::Prismatic, false) => 5,
            (JointKind::Weld, false) => 6,
        }
    }

    /// Equations of the joint at the poses of its bodies.
    pub(crate) fn equations(&self, bodies: [&Mover; 2]) -> ArrayVec<JointEquation, MOST_ROWS> {
        let [one, other] = bodies.map(|body| body.orientation.matrix());
        let arms = [one * self.anchors[0], other * self.anchors[1]];
        let way = (bodies[1].position + arms[1]) - (bodies[0].position + arms[0]);
        let mut rows = ArrayVec::new();
        match self.kind {
            JointKind::Spring(_) => {}
            JointKind::Rod(length) => {
                let distance = way.length();
                let along = if distance > 0.0 { way / distance } else { DVec3::X };
                rows.push((Row::new(along, arms.map(|arm| arm.cross(along))), distance - length));
            }
            JointKind::Prismatic => {
                let across = perpendicular(self.axes[0]);
                for direction in &across[..if self.planar { 1 } else { 2 }] {
                    let direction = one * *direction;
                    let angular = [(arms[0] + way).cross(direction), arms[1].cross(direction)];
                    rows.push((Row::new(direction, angular), direction.dot(way)));
                }
            }
            JointKind::Ball | JointKind::Hinge | JointKind::Weld => {
                // Both impulses act at one point, so that they keep the angular momentum where the joint has opened too.
                let arms = [arms[0] + 0.5 * way, arms[1] - 0.5 * way];
                for direction in &DVec3::AXES[..if self.planar { 2 } else { 3 }] {
                    let angular = arms.map(|arm| arm.cross(*direction));
                    rows.push((Row::new(*direction, angular), direction.dot(way)));
                }
            }
        }
        match self.kind {
            JointKind::Weld | JointKind::Prismatic => self.hold_orientation(bodies, &mut rows),
            JointKind::Hinge if !self.planar => {
                let axis = other * self.axes[1];
                for across in perpendicular(self.axes[0]) {
                    let across = one * across;
                    rows.push((Row::new(DVec3::ZERO, [self.lever * axis.cross(across); 2]), self.lever * across.dot(axis)));
                }
            }
            _ => {}
        }
        rows
    }

    /// Adds equations that fix the orientations to each other.
    fn hold_orientation(&self, bodies: [&Mover; 2], rows: &mut ArrayVec<JointEquation, MOST_ROWS>) {
        if self.planar {
            let error = bodies[1].orientation.angle - bodies[0].orientation.angle - self.angle;
            rows.push((Row::new(DVec3::ZERO, [self.lever * DVec3::Z; 2]), self.lever * error));
            return;
        }
        let first = bodies[0].orientation.quaternion;
        let error = bodies[1].orientation.quaternion * self.relative.inverse() * first.inverse();
        let vector = 2.0 * DVec3::new(error.x, error.y, error.z) * if error.w < 0.0 { -1.0 } else { 1.0 };
        for axis in DVec3::AXES {
            rows.push((Row::new(DVec3::ZERO, [self.lever * axis; 2]), self.lever * axis.dot(vector)));
        }
    }

    /// Row of the motion that the joint allows, and its coordinate [m]: the angle of a hinge times the lever, or the way of a
    /// prismatic joint.
    pub(crate) fn freedom(&self, bodies: [&Mover; 2]) -> Option<JointEquation> {
        let [one, other] = bodies.map(|body| body.orientation.matrix());
        let axis = one * self.axes[0];
        match self.kind {
            JointKind::Hinge if self.planar => {
                let angle = bodies[1].orientation.angle - bodies[0].orientation.angle - self.angle;
                Some((Row::new(DVec3::ZERO, [self.lever * DVec3::Z; 2]), self.lever * angle))
            }
            JointKind::Hinge => {
                let relative = bodies[0].orientation.quaternion.inverse() * bodies[1].orientation.quaternion;
                let turn = relative * self.relative.inverse();
                let along = DVec3::new(turn.x, turn.y, turn.z).dot(self.axes[0]);
                let angle = 2.0 * libm::atan2(along, turn.w);
                let turns = ((self.last - angle) / TAU).round();
                Some((Row::new(DVec3::ZERO, [self.lever * axis; 2]), self.lever * (angle + TAU * turns)))
            }
            JointKind::Prismatic => {
                let arms = [one * self.anchors[0], other * self.anchors[1]];
                let way = (bodies[1].position + arms[1]) - (bodies[0].position + arms[0]);
                let angular = [(arms[0] + way).cross(axis), arms[1].cross(axis)];
                Some((Row::new(axis, angular), axis.dot(way)))
            }
            _ => None,
        }
    }

    /// Whether the motion that the joint allows is limited or driven.
    pub fn is_bounded(&self) -> bool {
        self.motor.is_some() || self.limits.iter().any(|limit| limit.is_finite())
    }
}

/// Radius of gyration of two bodies by their inverse masses and moments [m]; 1 if both are fixed.
fn lever(bodies: [&Mover; 2]) -> f64 {
    let [mut masses, mut moments] = [0.0; 2];
    for body in bodies {
        let inverse = body.inverse_inertia();
        masses += body.inverse_mass;
        moments += inverse.x_axis.x + inverse.y_axis.y + inverse.z_axis.z;
    }
    if masses > 0.0 && moments > 0.0 { (masses / moments).sqrt() } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use glam::DMat3;

    use super::*;
    use crate::pose::Pose;
    use crate::rotation::{Inertia, Orientation, rotation_by};
    use crate::rows::BodyVelocities;

    fn mover(position: DVec3, turn: DVec3, velocity: DVec3, spin: DVec3) -> Mover {
        Mover {
            position,
            velocity,
            orientation: Orientation::spatial(rotation_by(turn)),
            spin,
            inverse_mass: 0.5,
            inertia: Inertia::spatial(DMat3::from_diagonal(DVec3::new(0.3, 0.4, 0.6))),
            ..Mover::wall(&Pose::WORLD)
        }
    }

    /// The rate of each error is J v where the joint is closed: central differences over ±ε err by ε².
    #[test]
    fn rates_of_errors() {
        let start = [
            mover(DVec3::new(0.1, 0.0, 0.2), DVec3::new(0.2, 0.1, -0.3), DVec3::new(0.3, -0.2, 0.1), DVec3::new(0.5, 0.2, -0.1)),
            mover(DVec3::new(1.0, 0.5, -0.2), DVec3::new(-0.4, 0.3, 0.1), DVec3::new(-0.1, 0.4, 0.2), DVec3::new(0.1, -0.3, 0.2)),
        ];
        let axis = DVec3::new(0.6, 0.0, 0.8);
        for kind in [JointKind::Ball, JointKind::Hinge, JointKind::Prismatic, JointKind::Weld, JointKind::Rod(0.7)] {
            let apart = matches!(kind, JointKind::Rod(_) | JointKind::Prismatic);
            let points = [DVec3::new(0.5, 0.3, 0.1), DVec3::new(0.5, 0.3, 0.1) + if apart { 0.3 * axis } else { DVec3::ZERO }];
            let joint = Joint::new(kind, [&start[0], &start[1]], points, axis, false);
            let after = |h: f64| {
                let mut bodies = start;
                bodies.iter_mut().for_each(|body| body.drift(h));
                joint.equations([&bodies[0], &bodies[1]]).iter().map(|(_, error)| *error).collect::<Vec<_>>()
            };
            let (plus, minus) = (after(1e-5), after(-1e-5));
            let velocities = BodyVelocities::of(&start);
            for (index, (row, error)) in joint.equations([&start[0], &start[1]]).iter().enumerate() {
                let rate = (plus[index] - minus[index]) / 2e-5;
                let expected = row.velocity([0, 1], &velocities);
                assert!((rate - expected).abs() < 1e-8, "{kind:?} {index}: {rate} {expected} {error}");
            }
        }
    }
}
