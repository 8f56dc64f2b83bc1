//! Orientations and moments of inertia.

use glam::{DMat3, DQuat, DVec3};
use physcore_base::error::Result;
use physcore_base::scene::{Item, Value};

use crate::splitting::{FreeTurn, Quaternion};

/// Orientation of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Orientation {
    /// Rotation from the body's frame to the world's.
    pub quaternion: DQuat,
    /// Angle of a body in the plane, in all its turns [rad].
    pub angle: f64,
}

impl Orientation {
    /// Orientation of a body in the plane.
    pub fn planar(angle: f64) -> Self {
        Self { quaternion: rotation(DVec3::Z, angle), angle }
    }

    /// Orientation of a body in space.
    pub fn spatial(quaternion: DQuat) -> Self {
        Self { quaternion, angle: 0.0 }
    }

    /// Orientations of the `count` bodies of an item: by its `angles` in 2D, and by its `orientations` (w, x, y, z) in 3D.
    ///
    /// # Errors
    /// If they are not that many numbers or quaternions.
    pub fn declared(item: &Item, count: usize, dimension: usize) -> Result<Vec<Self>> {
        if dimension == 2 {
            return Ok(item.numbers("angles", count)?.iter().map(|&angle| Self::planar(angle)).collect());
        }
        match item.values.get("orientations") {
            Some(Value::Numbers(array)) if array.shape == [count, 4] => {
                let rows = array.entries.as_chunks::<4>().0.iter();
                Ok(rows.map(|&[w, x, y, z]| Self::spatial(DQuat::from_xyzw(x, y, z, w).normalize())).collect())
            }
            other => Err(item.wrong("orientations", &format!("{count} quaternions"), other)),
        }
    }

    /// Orientation after a turn by the vector `angle` [rad] in the world.
    #[must_use]
    pub fn turned(&self, angle: DVec3) -> Self {
        let quaternion = (rotation_by(angle) * self.quaternion).normalize();
        Self { quaternion, angle: self.angle + angle.z }
    }

    /// Components of the quaternion (w, x, y, z).
    pub fn components(&self) -> [f64; 4] {
        let [x, y, z, w] = self.quaternion.to_array();
        [w, x, y, z]
    }

    /// Rotation matrix.
    pub fn matrix(&self) -> DMat3 {
        DMat3::from_quat(self.quaternion)
    }
}

/// Rotation about a unit axis.
fn rotation(axis: DVec3, angle: f64) -> DQuat {
    let (sin, cos) = libm::sincos(0.5 * angle);
    DQuat::from_xyzw(sin * axis.x, sin * axis.y, sin * axis.z, cos)
}

/// Rotation by a vector of rotation [rad].
pub fn rotation_by(vector: DVec3) -> DQuat {
    let angle = vector.length();
    if angle == 0.0 { DQuat::IDENTITY } else { rotation(vector / angle, angle) }
}

/// Moments of inertia of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inertia {
    /// Principal moments [kg·m²]; in the plane the third, about z, alone counts.
    pub moments: DVec3,
    /// Inverse moments; 0 where the body does not turn.
    inverse: DVec3,
    /// Rotation from the principal axes to the body's frame.
    axes: DQuat,
    /// Axis of reference r.
    reference: usize,
    planar: bool,
}

impl Inertia {
    /// Body that does not turn of itself: a particle, or a fixed body.
    pub const NONE: Self =
        Self { moments: DVec3::INFINITY, inverse: DVec3::ZERO, axes: DQuat::IDENTITY, reference: 0, planar: false };

    /// Moment of inertia of a body in the plane [kg·m² per meter of depth].
    pub fn planar(moment: f64) -> Self {
        let moments = DVec3::new(f64::INFINITY, f64::INFINITY, moment);
        Self { moments, inverse: DVec3::new(0.0, 0.0, 1.0 / moment), planar: true, ..Self::NONE }
    }

    /// Inertia tensor in the body's frame [kg·m²].
    pub fn spatial(tensor: DMat3) -> Self {
        let (moments, axes) = principal(tensor);
        let inverse = moments.recip();
        let spread = |reference: usize| {
            let [a, b] = [(reference + 1) % 3, (reference + 2) % 3];
            ((inverse[a] - inverse[reference]) * (inverse[b] - inverse[reference])).abs()
        };
        let reference = (0..3).fold(0, |best, axis| if spread(axis) < spread(best) { axis } else { best });
        Self { moments, inverse, axes, reference, planar: false }
    }

    /// Moments with point masses [kg] at places about the same center [m], in the frame of the body.
    #[must_use]
    pub fn with(&self, masses: &[(f64, DVec3)]) -> Self {
        let across = |place: DVec3| DMat3::from_cols(place * place.x, place * place.y, place * place.z);
        let of =
            |&(mass, place): &(f64, DVec3)| mass * (DMat3::from_diagonal(DVec3::splat(place.length_squared())) - across(place));
        let added = masses.iter().map(of).fold(DMat3::ZERO, |sum, one| sum + one);
        if self.planar {
            return Self::planar(self.moments.z + added.z_axis.z);
        }
        let axes = DMat3::from_quat(self.axes);
        Self::spatial(axes * DMat3::from_diagonal(self.moments) * axes.transpose() + added)
    }

    /// Whether the moment is that of a body in the plane.
    #[inline]
    pub(crate) fn is_planar(&self) -> bool {
        self.planar
    }

    /// Largest inverse moment [1/(kg·m²)]; 0 for a body that does not turn.
    pub fn largest_inverse(&self) -> f64 {
        self.inverse.max_element()
    }

    /// Inverse of the inertia tensor in the world [1/(kg·m²)].
    pub fn inverse(&self, orientation: &Orientation) -> DMat3 {
        let [x, y, z] = self.inverse.to_array();
        if self.planar || (x == y && y == z) {
            return DMat3::from_diagonal(self.inverse);
        }
        let axes = DMat3::from_quat(orientation.quaternion * self.axes);
        DMat3::from_cols(x * axes.x_axis, y * axes.y_axis, z * axes.z_axis) * axes.transpose()
    }

    /// Magnitude of the angular velocity at an angular momentum [rad/s].
    #[inline]
    pub fn rate(&self, orientation: &Orientation, spin: DVec3) -> f64 {
        if self.planar { (self.inverse.z * spin.z).abs() } else { self.free_turn(orientation, spin, 1.0).angle() }
    }

    /// Angular momentum at an angular velocity [kg·m²/s], both in the world.
    pub fn spin(&self, orientation: &Orientation, angular_velocity: DVec3) -> DVec3 {
        if self.planar {
            return DVec3::new(0.0, 0.0, self.moments.z * angular_velocity.z);
        }
        let axes = orientation.quaternion * self.axes;
        axes * (self.moments * (axes.inverse() * angular_velocity))
    }

    /// Orientation after a free rotation of `h` seconds with the angular momentum `spin` [kg·m²/s].
    pub fn turned(&self, start: &Orientation, spin: DVec3, h: f64) -> Orientation {
        if self.planar {
            return Orientation::planar(start.angle + h * spin.z * self.inverse.z);
        }
        self.orientation_of(self.free_turn(start, spin, h).turned())
    }

    /// Free rotation of `h` seconds of a body in space, with the axes renamed.
    #[inline(always)]
    pub(crate) fn free_turn(&self, start: &Orientation, spin: DVec3, h: f64) -> FreeTurn {
        let inverse = self.renamed(self.inverse);
        let rates = [h * inverse[0], h * (inverse[1] - inverse[0]), h * (inverse[2] - inverse[0])];
        let (orientation, spin) = self.free_state(start, spin);
        let [x, y, z] = self.renamed(self.axes.xyz());
        FreeTurn { orientation, axes: [self.axes.w, x, y, z], spin, rates }
    }

    /// Orientation and angular momentum with the axes renamed.
    #[inline(always)]
    pub(crate) fn free_state(&self, start: &Orientation, spin: DVec3) -> (Quaternion, [f64; 3]) {
        let [x, y, z] = self.renamed(start.quaternion.xyz());
        ([start.quaternion.w, x, y, z], self.renamed(spin))
    }

    /// Components in the order of the axes with the axis of reference first.
    #[inline(always)]
    fn renamed(&self, vector: DVec3) -> [f64; 3] {
        let [x, y, z] = vector.to_array();
        match self.reference {
            0 => [x, y, z],
            1 => [y, z, x],
            _ => [z, x, y],
        }
    }

    /// Orientation from a quaternion with renamed axes.
    #[inline(always)]
    pub(crate) fn orientation_of(&self, [w, x, y, z]: Quaternion) -> Orientation {
        let [x, y, z] = match self.reference {
            0 => [x, y, z],
            1 => [z, x, y],
            _ => [y, z, x],
        };
        Orientation { quaternion: DQuat::from_xyzw(x, y, z, w), angle: 0.0 }
    }
}

/// Largest number of sweeps of Jacobi's method; each squares the off-diagonal part.
const SWEEPS: usize = 16;

/// Principal moments of a symmetric tensor, and the rotation from the principal axes, by Jacobi's method.
fn principal(tensor: DMat3) -> (DVec3, DQuat) {
    let (mut tensor, mut axes) = (tensor, DMat3::IDENTITY);
    for _ in 0..SWEEPS {
        let scale = tensor.x_axis.x.abs() + tensor.y_axis.y.abs() + tensor.z_axis.z.abs();
        for [p, q] in [[0, 1], [0, 2], [1, 2]] {
            let off = tensor.col(q)[p];
            if off.abs() <= 1e-17 * scale {
                continue;
            }
            let theta = 0.5 * (tensor.col(q)[q] - tensor.col(p)[p]) / off;
            let tangent = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
            let cos = 1.0 / (tangent * tangent + 1.0).sqrt();
            let sin = tangent * cos;
            let mut turn = DMat3::IDENTITY;
            (turn.col_mut(p)[p], turn.col_mut(q)[q]) = (cos, cos);
            (turn.col_mut(q)[p], turn.col_mut(p)[q]) = (sin, -sin);
            tensor = turn.transpose() * tensor * turn;
            axes *= turn;
        }
    }
    let moments = DVec3::new(tensor.x_axis.x, tensor.y_axis.y, tensor.z_axis.z);
    (moments, DQuat::from_mat3(&axes).normalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tensor() -> DMat3 {
        let axes = DMat3::from_quat(rotation_by(DVec3::new(0.3, -0.7, 0.4)));
        axes * DMat3::from_diagonal(DVec3::new(1.0, 2.0, 3.5)) * axes.transpose()
    }

    fn energy(inertia: &Inertia, orientation: &Orientation, spin: DVec3) -> f64 {
        0.5 * spin.dot(inertia.inverse(orientation) * spin)
    }

    #[test]
    fn principal_axes_diagonalize() {
        let (moments, axes) = principal(tensor());
        let axes = DMat3::from_quat(axes);
        let again = axes * DMat3::from_diagonal(moments) * axes.transpose();
        assert!((again - tensor()).to_cols_array().iter().all(|entry| entry.abs() < 1e-14));
    }

    /// A dumbbell of two point masses and a body between them has the sum of their moments.
    #[test]
    fn point_masses_add_their_moments() {
        let place = DVec3::new(0.3, -0.4, 1.2);
        let inertia = Inertia::spatial(tensor()).with(&[(2.0, place), (2.0, -place)]);
        let turning = DVec3::new(0.5, 1.0, -2.0);
        let still = Orientation::spatial(DQuat::IDENTITY);
        let expected = tensor() * turning + 4.0 * place.cross(turning.cross(place));
        assert!((inertia.spin(&still, turning) - expected).length() < 1e-13);
        let planar = Inertia::planar(0.7).with(&[(2.0, DVec3::new(0.3, 0.4, 0.0))]);
        assert!((planar.moments.z - 1.2).abs() < 1e-15);
    }

    /// The error of an orientation after one second falls by 4 for half the step, and the energy does not drift.
    #[test]
    fn free_rotation_is_of_order_2() {
        let inertia = Inertia::spatial(tensor());
        let start = Orientation::spatial(rotation_by(DVec3::new(0.1, 0.2, -0.5)));
        let spin = DVec3::new(3.0, -2.0, 4.0);
        let at = |steps: u32| {
            let h = 1.0 / f64::from(steps);
            (0..steps).fold(start, |orientation, _| inertia.turned(&orientation, spin, h))
        };
        let reference = at(20_000).quaternion;
        let error = |steps| (at(steps).quaternion - reference).length();
        let ratio = error(50) / error(100);
        assert!((ratio - 4.0).abs() < 0.05, "{ratio}");
        let before = energy(&inertia, &start, spin);
        assert!((energy(&inertia, &at(100), spin) / before - 1.0).abs() < 1e-3);
    }

    /// A step back with −L undoes a step, to rounding.
    #[test]
    fn free_rotation_is_reversible() {
        let inertia = Inertia::spatial(tensor());
        let start = Orientation::spatial(rotation_by(DVec3::new(0.1, 0.2, -0.5)));
        let spin = DVec3::new(3.0, -2.0, 4.0);
        let there = inertia.turned(&start, spin, 0.1);
        let back = inertia.turned(&there, spin, -0.1);
        assert!((back.quaternion - start.quaternion).length() < 1e-15);
    }

    /// A symmetric body precesses about L by |L|/I₁ per second, exactly.
    #[test]
    fn symmetric_bodies_are_exact() {
        let inertia = Inertia::spatial(DMat3::from_diagonal(DVec3::new(2.0, 2.0, 3.0)));
        let start = Orientation::spatial(rotation_by(DVec3::new(0.4, 0.0, 0.0)));
        let spin = DVec3::new(0.0, 0.0, 5.0);
        let axis = inertia.turned(&start, spin, 1.0).quaternion * DVec3::Z;
        let expected = rotation(DVec3::Z, 2.5) * (start.quaternion * DVec3::Z);
        assert!((axis - expected).length() < 1e-15);
    }
}
