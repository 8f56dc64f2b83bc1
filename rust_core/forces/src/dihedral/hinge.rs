//! Angle between two faces at their common edge, with its gradient; for the symbols see [`super`].

use glam::{DMat3, DVec3};

use crate::StateView;
use crate::math::Vector;
use crate::matter::View;

/// Second derivatives ∂²θ/∂xᵢ∂xⱼ for the corners i < j [1/m²]. The others follow, because θ is invariant to translation.
pub type Hessian = [[DMat3; 4]; 4];

/// An edge with its two faces.
#[derive(Debug)]
pub struct Hinge {
    /// Particle indices of the corners in the engine's order: the ends of the edge, x₀ and x₁, and the opposite corners, x₂ and
    /// x₃.
    pub corners: [u32; 4],
    /// Rest angle as cos θ₀ and sin θ₀.
    pub rest: [f64; 2],
    /// Stiffness w B [J].
    pub stiffness: f64,
    /// Damping w c [J·s].
    pub damping: f64,
    /// Whether a side of a face is torn. A torn hinge has no energy and exerts no force.
    pub torn: bool,
}

/// State of a hinge.
#[derive(Debug)]
pub struct Bent {
    /// Gradient ∇θ by the position of each corner [1/m].
    pub gradient: [DVec3; 4],
    /// Energy U [J].
    pub energy: f64,
    /// Torque τ [N·m].
    pub torque: f64,
    /// Dissipated power w c (dθ/dt)² [W].
    pub dissipated: f64,
}

impl Hinge {
    /// Positions or velocities of the corners.
    fn corners<V: Vector>(&self, columns: &View<'_, V>) -> [DVec3; 4] {
        self.corners.map(|corner| columns.get(corner as usize).widen())
    }

    /// Sides of the two faces, by their ends in ascending order.
    #[inline]
    pub fn sides(&self) -> [[u32; 2]; 5] {
        let [start, end, one, other] = self.corners;
        [[start, end], [start, one], [end, one], [start, other], [end, other]].map(|[a, b]| [a.min(b), a.max(b)])
    }

    /// State of the hinge. None if the hinge is torn or a face has no area; it then exerts no force.
    pub fn bent<V: Vector>(&self, at: &StateView<'_, V>) -> Option<Bent> {
        let velocities = if self.damping == 0.0 { [DVec3::ZERO; 4] } else { self.corners(&at.velocity) };
        self.bent_at(self.corners(&at.position), velocities)
    }

    /// State of the hinge at given positions and velocities of its corners.
    pub fn bent_at(&self, x: [DVec3; 4], velocities: [DVec3; 4]) -> Option<Bent> {
        if self.torn {
            return None;
        }
        let (edge, arms) = (x[1] - x[0], [x[2] - x[0], x[3] - x[0]]);
        let (square, length) = (edge.length_squared(), edge.length());
        let normals = [edge.cross(arms[0]), arms[1].cross(edge)];
        let squares = normals.map(DVec3::length_squared);
        if squares.contains(&0.0) {
            return None;
        }
        let (cosine, sine) = (normals[0].dot(normals[1]), length * normals[0].dot(arms[1]));
        let [rest_cosine, rest_sine] = self.rest;
        let angle = libm::atan2(sine * rest_cosine - cosine * rest_sine, cosine * rest_cosine + sine * rest_sine);
        let opposite = [0, 1].map(|face| normals[face] * (length / squares[face]));
        let feet = arms.map(|arm| arm.dot(edge) / square);
        let at_end = |share: fn(f64) -> f64| -(opposite[0] * share(feet[0]) + opposite[1] * share(feet[1]));
        let gradient = [at_end(|foot| 1.0 - foot), at_end(|foot| foot), opposite[0], opposite[1]];
        let rate: f64 = gradient.iter().zip(velocities).map(|(gradient, velocity)| gradient.dot(velocity)).sum();
        Some(Bent {
            gradient,
            energy: 0.5 * self.stiffness * angle * angle,
            torque: self.stiffness * angle + self.damping * rate,
            dissipated: self.damping * rate * rate,
        })
    }

    /// Inverse height of each face from each corner [1/m]; 0 for the corner of the other face.
    pub fn inverse_heights<V: Vector>(&self, at: &StateView<'_, V>) -> [[f64; 4]; 2] {
        let x = self.corners(&at.position);
        [2, 3].map(|opposite| {
            let double_area = (x[1] - x[0]).cross(x[opposite] - x[0]).length();
            let mut sides = [(x[opposite] - x[1]).length(), (x[opposite] - x[0]).length(), 0.0, 0.0];
            sides[opposite] = (x[1] - x[0]).length();
            sides.map(|side| side / double_area)
        })
    }
}

/// Second derivatives of θ: derivatives of its gradient along each axis of the corners from the second on.
pub fn hessian(x: [DVec3; 4]) -> Hessian {
    let mut hessian = [[DMat3::ZERO; 4]; 4];
    for corner in 1..4 {
        for (axis, direction) in DVec3::AXES.into_iter().enumerate() {
            let mut way = [DVec3::ZERO; 4];
            way[corner] = direction;
            let change = change(x, way);
            (0..corner).for_each(|other| *hessian[other][corner].col_mut(axis) = change[other]);
        }
    }
    hessian
}

/// Change of ∇θ for displacements `u` of the corners, by the product and quotient rules.
fn change(x: [DVec3; 4], u: [DVec3; 4]) -> [DVec3; 4] {
    let (edge, stretch) = (x[1] - x[0], u[1] - u[0]);
    let (square, length) = (edge.length_squared(), edge.length());
    let mut changes = [DVec3::ZERO; 4];
    // The normal of the second face has the opposite sign.
    for (corner, sign) in [(2, 1.0), (3, -1.0)] {
        let (arm, way) = (x[corner] - x[0], u[corner] - u[0]);
        let (normal, turned) = (sign * edge.cross(arm), sign * (stretch.cross(arm) + edge.cross(way)));
        let normal_square = normal.length_squared();
        let opposite = normal * (length / normal_square);
        let changed = turned * (length / normal_square) + opposite * (edge.dot(stretch) / square)
            - opposite * (2.0 * normal.dot(turned) / normal_square);
        let foot = arm.dot(edge) / square;
        let slid = (way.dot(edge) + arm.dot(stretch) - 2.0 * foot * edge.dot(stretch)) / square;
        changes[0] -= changed * (1.0 - foot) - opposite * slid;
        changes[1] -= changed * foot + opposite * slid;
        changes[corner] = changed;
    }
    changes
}
