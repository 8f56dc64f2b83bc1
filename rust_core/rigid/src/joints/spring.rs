//! Damped linear springs between two anchors.

use glam::DVec3;

use super::{Joint, JointKind};
use crate::mover::Mover;

/// Law of a spring: k (l − l₀) + c dl/dt along the line between its anchors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DampedSpring {
    /// Stiffness k [N/m].
    pub stiffness: f64,
    /// Damping c [N·s/m].
    pub damping: f64,
    /// Rest length l₀ [m].
    pub rest_length: f64,
}

/// Force of a spring in a state, with its energy.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SpringForce {
    /// Force on the second body [N].
    pub force: DVec3,
    /// Arms from the centers to the anchors [m].
    pub arms: [DVec3; 2],
    /// Power that the damping dissipates [W].
    pub loss: f64,
    /// Power that fixed bodies supply, which move as prescribed [W].
    pub supply: f64,
    /// Potential energy [J].
    pub energy: f64,
}

impl SpringForce {
    /// Force on one of the bodies [N].
    pub fn on(&self, side: usize) -> DVec3 {
        if side == 0 { -self.force } else { self.force }
    }
}

impl Joint {
    /// Law of a spring; None for other joints.
    pub fn spring(&self) -> Option<DampedSpring> {
        match self.kind {
            JointKind::Spring(spring) => Some(spring),
            _ => None,
        }
    }

    /// Force of a spring on its bodies. Anchors that coincide exert none, because they have no direction.
    pub(crate) fn spring_force(&self, spring: DampedSpring, bodies: [&Mover; 2]) -> SpringForce {
        let arms = [0, 1].map(|side| bodies[side].orientation.matrix() * self.anchors[side]);
        let velocities = [0, 1].map(|side| bodies[side].velocity + bodies[side].angular_velocity().cross(arms[side]));
        let way = (bodies[1].position + arms[1]) - (bodies[0].position + arms[0]);
        let length = way.length();
        let along = if length > 0.0 { way / length } else { DVec3::ZERO };
        let (stretch, rate) = (length - spring.rest_length, along.dot(velocities[1] - velocities[0]));
        let force = -(spring.stiffness * stretch + spring.damping * rate) * along;
        let supplied = |side: usize, sign: f64| if bodies[side].is_fixed() { sign * force.dot(velocities[side]) } else { 0.0 };
        SpringForce {
            force,
            arms,
            loss: spring.damping * rate * rate,
            supply: supplied(0, 1.0) + supplied(1, -1.0),
            energy: 0.5 * spring.stiffness * stretch * stretch,
        }
    }

    /// Bounds on the squares of the angular frequencies [1/s²] and on the decay rates [1/s] by a spring, for each body. The part
    /// that both bodies share comes first.
    ///
    /// A displacement u and a rotation θ of a body move the anchor by u + θ × r, up to second order with r. The spring is as
    /// stiff as k along its direction and k (1 − l₀/l) across it, and its tension T resists a rotation with T |r|.
    pub(crate) fn spring_rates(&self, spring: DampedSpring, bodies: [&Mover; 2], ahead: bool) -> [SpringRates; 2] {
        let arms = [0, 1].map(|side| bodies[side].orientation.matrix() * self.anchors[side]);
        let way = (bodies[1].position + arms[1]) - (bodies[0].position + arms[0]);
        let length = way.length();
        let along = way.try_normalize();
        let slack = if length > 0.0 { 1.0 - spring.rest_length / length } else { -1.0 };
        [0, 1].map(|side| {
            let (body, arm) = (bodies[side], arms[side]);
            let turning = body.inertia.largest_inverse();
            // Effective inverse masses: the largest of all directions, and along the spring.
            let most = body.inverse_mass + arm.length_squared() * turning;
            let across = spring.stiffness * slack.abs();
            let mut stiffness = spring.stiffness.max(across) * most;
            let mut damping = spring.damping * most;
            if let (false, Some(along)) = (ahead, along) {
                let lever = arm.cross(along);
                let inverse = body.inverse_mass + lever.dot(body.inverse_inertia() * lever);
                stiffness = stiffness.min(spring.stiffness * inverse + across * most);
                damping = spring.damping * inverse;
            }
            let tension = spring.stiffness * (length - spring.rest_length).abs();
            SpringRates { shared: [stiffness, damping], own: tension * arm.length() * turning }
        })
    }
}

/// Bounds of a spring at one of its bodies.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SpringRates {
    /// Square of the angular frequency [1/s²] and decay rate [1/s] with the other body at rest.
    pub shared: [f64; 2],
    /// Square of the angular frequency by the tension [1/s²].
    pub own: f64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pose::Pose;
    use crate::rotation::{Inertia, Orientation, rotation_by};
    use glam::DMat3;

    /// The powers of both forces, the damping and the energy add up to nothing: central differences over ±ε err by ε².
    #[test]
    fn the_work_of_a_spring_is_its_energy_and_its_loss() {
        let wall = Mover::wall(&Pose::WORLD);
        let free = Mover {
            position: DVec3::new(1.0, 0.5, -0.2),
            velocity: DVec3::new(-0.1, 0.4, 0.2),
            orientation: Orientation::spatial(rotation_by(DVec3::new(-0.4, 0.3, 0.1))),
            spin: DVec3::new(0.1, -0.3, 0.2),
            inverse_mass: 0.5,
            inertia: Inertia::spatial(DMat3::from_diagonal(DVec3::new(0.3, 0.4, 0.6))),
            ..wall
        };
        let driven = Mover { velocity: DVec3::new(0.3, -0.2, 0.5), ..wall };
        let spring = DampedSpring { stiffness: 30.0, damping: 2.0, rest_length: 0.6 };
        let points = [DVec3::new(0.2, 0.1, 0.0), DVec3::new(1.1, 0.3, 0.1)];
        let joint = Joint::new(JointKind::Spring(spring), [&driven, &free], points, DVec3::Z, false);
        let energy = |h: f64| {
            let mut bodies = [driven, free];
            bodies.iter_mut().for_each(|body| body.drift(h));
            joint.spring_force(spring, [&bodies[0], &bodies[1]]).energy
        };
        let now = joint.spring_force(spring, [&driven, &free]);
        let power = now.force.dot(free.velocity) + now.arms[1].cross(now.force).dot(free.angular_velocity());
        let stored = (energy(1e-5) - energy(-1e-5)) / 2e-5;
        assert!((now.supply - power - now.loss - stored).abs() < 1e-8, "{now:?} {power} {stored}");
        assert!(now.loss > 1e-3 && now.supply.abs() > 1e-3);
    }
}
