//! Joints of a group.

use arrayvec::ArrayVec;
use glam::DVec3;

use super::{FirstHalf, Island};
use crate::joints::{Joint, JointEquation};
use crate::rows::{BodyVelocities, BoundedRow, JointRows, MOST_ROWS, Row, Rows};

/// Bounded rows of a joint.
pub const LIMITS: [usize; 2] = [0, 1];
const MOTOR: usize = 2;

/// Bounds of the impulse of a lower and of an upper limit.
pub const LIMIT_BOUNDS: [[f64; 2]; 2] = [[0.0, f64::INFINITY], [f64::NEG_INFINITY, 0.0]];

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
    /// Whether a row holds the lower and the upper limit in this piece.
    pub held: [bool; 2],
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

impl Island {
    /// Equations of a joint at the present poses.
    pub fn equations(&self, held: &HeldJoint) -> ArrayVec<JointEquation, MOST_ROWS> {
        held.joint.equations(held.bodies.map(|body| &self.movers[body]))
    }

    /// Adds the rows of the joints at the start of a piece.
    pub fn hold_joints(&self, (length, h): (f64, f64), v: &BodyVelocities, first: &mut FirstHalf) {
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
            let bounds = bounds_of(&held.joint, place, (length, h)).into_iter();
            for (which, bounds, target) in bounds.filter(|(which, _, _)| held.held.get(*which) != Some(&false)) {
                let row = Row { target, impulse: (0.5 * length * held.bounds[which]).clamp(bounds[0], bounds[1]), ..row };
                if let Some(bounded) = BoundedRow::new(held.bodies, row, bounds, v) {
                    first.rows.bounds.push(bounded);
                    first.bounded.push((index, which));
                }
            }
        }
        first.rows.link(v);
    }

    /// Adds the rows of the joints at the end of a piece.
    pub fn hold_joint_velocities(&self, first: &FirstHalf, v: &BodyVelocities, rows: &mut Rows) {
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
