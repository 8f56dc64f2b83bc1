//! The angle between two faces at their common edge, with its gradient; the symbols are those of [`super`].

use glam::DVec3;

use crate::forces::StateView;
use crate::math::Vector;
use crate::matter::View;

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
        if self.torn {
            return None;
        }
        let x = self.corners(&at.position);
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
        let velocities = if self.damping == 0.0 { [DVec3::ZERO; 4] } else { self.corners(&at.velocity) };
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
