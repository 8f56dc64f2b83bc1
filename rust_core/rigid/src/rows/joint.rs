//! Rows of joints: equations between relative velocities, and bounded rows of limits and motors.

use arrayvec::ArrayVec;
use glam::DVec3;

use super::{BodyVelocities, MOST_ROWS};
use crate::face::{self, NetFace};
use crate::mover::Mover;

/// Equation J v = b between two bodies, J v = l·(v₂ − v₁) + a₂·ω₂ − a₁·ω₁. A face has coordinates in place of a₂.
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
    pub fn velocity(&self, [one, other]: [usize; 2], v: &BodyVelocities) -> f64 {
        let [one, other] = [v.body(one, self.angular[0]), v.body(other, self.angular[1])];
        self.linear.dot(other.linear - one.linear) + self.angular[1].dot(other.angular) - self.angular[0].dot(one.angular)
    }

    /// J M⁻¹ Jᵀ of this row and another one of the same bodies.
    pub fn coupling(&self, row: &Self, [one, other]: [usize; 2], v: &BodyVelocities) -> f64 {
        let [one, other] = [v.body(one, self.angular[0]), v.body(other, self.angular[1])];
        (one.inverse_mass + other.inverse_mass) * self.linear.dot(row.linear)
            + self.angular[0].dot(one.inverse_inertia * row.angular[0])
            + self.angular[1].dot(other.inverse_inertia * row.angular[1])
    }

    /// Adds an impulse to the velocities.
    pub fn push(&self, impulse: f64, [one, other]: [usize; 2], v: &mut BodyVelocities) {
        let first = &mut v.bodies[one];
        first.linear -= first.inverse_mass * impulse * self.linear;
        first.twist(-(impulse * self.angular[0]));
        let Some(second) = v.bodies.get_mut(other) else {
            return v.push_point(other, self.angular[1], impulse * self.linear);
        };
        second.linear += second.inverse_mass * impulse * self.linear;
        second.twist(impulse * self.angular[1]);
    }

    /// Energy supplied by fixed bodies, which move as prescribed [J].
    pub fn supplied(&self, bodies: [usize; 2], v: &BodyVelocities) -> f64 {
        let of = |side: usize, sign: f64| {
            let Some(body) = v.bodies.get(bodies[side]) else {
                return sign * self.linear.dot(v.prescribed(bodies[side], self.angular[side]));
            };
            let velocity = self.linear.dot(body.linear) + self.angular[side].dot(body.angular);
            if body.is_fixed() { sign * velocity } else { 0.0 }
        };
        self.impulse * (of(0, 1.0) + of(1, -1.0))
    }

    /// Adds the impulse to the velocities and angular momenta of the bodies.
    pub fn apply(&self, [one, other]: [usize; 2], movers: &mut [Mover], faces: &[NetFace]) {
        for (body, sign, arm) in [(one, -1.0, self.angular[0]), (other, 1.0, self.angular[1])] {
            let Some(mover) = movers.get_mut(body) else {
                face::push(body, arm, self.impulse * self.linear, movers, faces);
                continue;
            };
            if !mover.is_fixed() {
                mover.velocity += sign * self.impulse * mover.inverse_mass * self.linear;
                mover.spin += sign * self.impulse * arm;
            }
        }
    }
}

/// Rows of a joint.
#[derive(Debug, Clone)]
pub struct JointRows {
    pub bodies: [usize; 2],
    pub rows: ArrayVec<Row, MOST_ROWS>,
    /// Inverse of J M⁻¹ Jᵀ.
    inverse: [[f64; MOST_ROWS]; MOST_ROWS],
}

impl JointRows {
    /// Prepares the rows of a joint.
    pub fn new(bodies: [usize; 2], rows: ArrayVec<Row, MOST_ROWS>, v: &BodyVelocities) -> Self {
        let mut matrix = [[0.0; MOST_ROWS]; MOST_ROWS];
        for (i, row) in rows.iter().enumerate() {
            for (j, other) in rows.iter().enumerate() {
                matrix[i][j] = row.coupling(other, bodies, v);
            }
        }
        Self { bodies, inverse: inverted(matrix, rows.len()), rows }
    }

    /// Velocities that the rows lack.
    pub fn lacks(&self, v: &BodyVelocities) -> [f64; MOST_ROWS] {
        let mut lacks = [0.0; MOST_ROWS];
        self.rows.iter().zip(&mut lacks).for_each(|(row, lack)| *lack = row.target - row.velocity(self.bodies, v));
        lacks
    }

    /// Adds impulses to the rows and to the velocities.
    pub fn push(&mut self, impulses: &[f64; MOST_ROWS], v: &mut BodyVelocities) {
        for (row, impulse) in self.rows.iter_mut().zip(impulses) {
            row.impulse += impulse;
            row.push(*impulse, self.bodies, v);
        }
    }

    /// Solves the rows of this joint; returns the largest change of a relative velocity.
    pub fn relax(&mut self, v: &mut BodyVelocities) -> f64 {
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
    pub fn new(bodies: [usize; 2], row: Row, bounds: [f64; 2], v: &BodyVelocities) -> Option<Self> {
        let inverse = row.coupling(&row, bodies, v);
        (inverse > 0.0).then_some(Self { bodies, row, bounds, mass: 1.0 / inverse })
    }

    /// Whether the row is a motor.
    pub fn drives(&self) -> bool {
        self.bounds.iter().all(|bound| bound.is_finite())
    }

    /// Work of the impulse on the relative motion [J].
    pub fn work(&self, before: &BodyVelocities, after: &BodyVelocities) -> f64 {
        0.5 * self.row.impulse * (self.row.velocity(self.bodies, before) + self.row.velocity(self.bodies, after))
    }

    pub fn relax(&mut self, v: &mut BodyVelocities) -> f64 {
        let lack = self.row.target - self.row.velocity(self.bodies, v);
        let [least, most] = self.bounds;
        let impulse = (self.row.impulse + self.mass * lack).clamp(least, most);
        let change = impulse - self.row.impulse;
        self.row.impulse = impulse;
        self.row.push(change, self.bodies, v);
        change.abs() / self.mass
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
