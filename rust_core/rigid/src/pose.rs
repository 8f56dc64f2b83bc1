//! Place and orientation of a body.

use glam::{DMat3, DVec3};

/// Place and orientation of a body's frame in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Position of the origin [m].
    pub position: DVec3,
    /// Rotation from the body's frame to the world's.
    pub rotation: DMat3,
}

impl Pose {
    /// Frame of the world.
    pub const WORLD: Self = Self { position: DVec3::ZERO, rotation: DMat3::IDENTITY };

    /// Point of the body in the world [m].
    #[inline(always)]
    pub fn point(&self, local: DVec3) -> DVec3 {
        self.position + self.rotation * local
    }

    /// Point of the world in the body's frame [m].
    #[inline(always)]
    pub fn local_point(&self, point: DVec3) -> DVec3 {
        self.local_vector(point - self.position)
    }

    /// Direction of the world in the body's frame.
    #[inline(always)]
    pub fn local_vector(&self, vector: DVec3) -> DVec3 {
        DVec3::new(self.rotation.x_axis.dot(vector), self.rotation.y_axis.dot(vector), self.rotation.z_axis.dot(vector))
    }

    /// Bound on the way of a point at a distance of 1 from the origin, by turning from an earlier pose.
    pub fn turn_from(&self, before: &Self) -> f64 {
        let [x, y, z] = [0, 1, 2].map(|axis| self.rotation.col(axis) - before.rotation.col(axis));
        // The squares of a rotation by an angle φ sum to 8 sin²(φ/2).
        (0.5 * (x.length_squared() + y.length_squared() + z.length_squared())).sqrt()
    }

    /// Pose of a frame given in this one.
    #[must_use]
    pub fn compose(&self, inner: &Self) -> Self {
        Self { position: self.point(inner.position), rotation: self.rotation * inner.rotation }
    }

    /// Another pose, given in this frame.
    #[must_use]
    #[inline]
    pub fn relative(&self, other: &Self) -> Self {
        let columns = [other.rotation.x_axis, other.rotation.y_axis, other.rotation.z_axis].map(|axis| self.local_vector(axis));
        Self { position: self.local_point(other.position), rotation: DMat3::from_cols(columns[0], columns[1], columns[2]) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A point at a distance of 1 across the axis moves by the chord of the angle.
    #[test]
    fn a_turn_moves_points_by_its_chord() {
        let before = Pose { position: DVec3::X, rotation: DMat3::from_rotation_y(0.7) };
        for angle in [0.0, 1e-9, 0.3, 3.0] {
            let turn = DMat3::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), angle);
            let after = Pose { position: DVec3::Y, rotation: turn * before.rotation };
            let across = DVec3::Y;
            let chord = (turn * across - across).length();
            // Entries of matrices are rounded.
            assert!((after.turn_from(&before) - chord).abs() < 1e-15, "{angle}");
        }
    }
}
