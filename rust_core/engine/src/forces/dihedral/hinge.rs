//! The angle between two faces at their common edge, with its gradient; the symbols are those of [`super`].

use glam::{DMat3, DVec3};

use crate::forces::StateView;
use crate::math::Vector;
use crate::matter::View;

/// ∂²θ/∂xᵢ∂xⱼ for the corners i < j [1/m²]; those of the other corners follow, for θ is the same in all places.
pub type Hessian = [[DMat3; 4]; 4];

/// An edge with its two faces.
#[derive(Debug)]
pub struct Hinge {
    /// The ends of the edge, x₀ and x₁, and the opposite corners, x₂ and x₃, by their index in the engine's order.
    pub corners: [u32; 4],
    /// cos θ₀ and sin θ₀.
    pub rest: [f64; 2],
    /// Stiffness w B [J].
    pub stiffness: f64,
    /// Damping w c [J·s].
    pub damping: f64,
    /// Whether a side of its faces is torn: it has no energy then, and exerts no force.
    pub torn: bool,
}

/// A hinge in a state.
#[derive(Debug)]
pub struct Bent {
    /// ∇θ by each corner [1/m].
    pub gradient: [DVec3; 4],
    /// The energy U [J].
    pub energy: f64,
    /// The torque τ [N·m].
    pub torque: f64,
    /// The power that is dissipated, w c (dθ/dt)² [W].
    pub dissipated: f64,
}

impl Hinge {
    /// The positions or velocities of its corners.
    fn corners<V: Vector>(&self, columns: &View<'_, V>) -> [DVec3; 4] {
        self.corners.map(|corner| columns.get(corner as usize).widen())
    }

    /// The sides of its faces, by their ends in ascending order.
    pub fn sides(&self) -> [[u32; 2]; 5] {
        let [start, end, one, other] = self.corners;
        [[start, end], [start, one], [end, one], [start, other], [end, other]].map(|[a, b]| [a.min(b), a.max(b)])
    }

    /// Its state; None where it is torn or a face has no area, which then feels no force.
    pub fn bent<V: Vector>(&self, at: &StateView<'_, V>) -> Option<Bent> {
        let velocities = if self.damping == 0.0 { [DVec3::ZERO; 4] } else { self.corners(&at.velocity) };
        self.bent_at(self.corners(&at.position), velocities)
    }

    /// The same, for the positions and velocities of its corners.
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

    /// The inverse height of each face from each corner [1/m]; 0 from that of the other face.
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

/// The second derivatives of θ: those of its gradient, along each axis of the corners from the second on.
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

/// The change of ∇θ where the corners move along `u`, by the rules for products and quotients.
fn change(x: [DVec3; 4], u: [DVec3; 4]) -> [DVec3; 4] {
    let (edge, stretch) = (x[1] - x[0], u[1] - u[0]);
    let (square, length) = (edge.length_squared(), edge.length());
    let mut changes = [DVec3::ZERO; 4];
    // The normal of the second face is that of the first with the opposite sign.
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
