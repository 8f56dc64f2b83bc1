//! Fields of rigid bodies, joints and ties.

use glam::DVec3;
use physcore_rigid::rotation::Orientation;

use super::RigidBodies;
use crate::math::AXES;
use crate::systems::{FieldInfo, Location};

impl RigidBodies {
    /// Fields, in the caller's order.
    pub fn listed(&self, dimension: usize) -> Vec<FieldInfo> {
        let (count, joints, planar) = (self.particles.len(), self.world.state.joints.len(), self.world.planar);
        let shape = |count: usize, components: usize| if planar { vec![count] } else { vec![count, components] };
        let info = |name: &str, unit, location, shape, state| FieldInfo {
            name: name.to_owned(),
            unit,
            location,
            shape,
            rate: None,
            state,
        };
        let turn = if planar { ("angles", "rad") } else { ("orientations", "1") };
        let mut fields = vec![
            info(turn.0, turn.1, Location::Bodies, shape(count, 4), true),
            info("angular_velocities", "rad/s", Location::Bodies, shape(count, AXES), true),
        ];
        if self.world.may_sleep() {
            fields.push(info("asleep", "1", Location::Bodies, vec![count], false));
        }
        if joints > 0 {
            fields.push(info("joint_forces", "N", Location::Joints, vec![joints, dimension], false));
            fields.push(info("joint_torques", "N·m", Location::Joints, shape(joints, AXES), false));
        }
        let ties = self.world.state.ties.len();
        if ties > 0 {
            fields.push(info("tie_forces", "N", Location::Ties, vec![ties, dimension], false));
            fields.push(info("tie_torques", "N·m", Location::Ties, shape(ties, AXES), false));
        }
        fields
    }

    /// Values of a field.
    pub fn values(&self, field: &str, dimension: usize) -> Vec<f64> {
        let (state, planar) = (&self.world.state, self.world.planar);
        let forces = |vectors: &mut dyn Iterator<Item = DVec3>| {
            vectors.flat_map(|force| force.to_array().into_iter().take(dimension)).collect()
        };
        let turns = |vectors: &mut dyn Iterator<Item = DVec3>| {
            vectors.flat_map(|turn| turn.to_array().into_iter().skip(if planar { AXES - 1 } else { 0 })).collect()
        };
        match field {
            "angles" => state.turns.iter().map(|turn| turn.orientation.angle).collect(),
            "orientations" => state.turns.iter().flat_map(|turn| turn.orientation.components()).collect(),
            "angular_velocities" => turns(&mut (0..self.particles.len()).map(|body| self.world.angular_velocity(body))),
            "asleep" => (0..self.particles.len()).map(|body| f64::from(u8::from(self.world.is_asleep(body)))).collect(),
            "joint_forces" => forces(&mut state.joints.iter().map(|joint| joint.reaction[0])),
            "joint_torques" => turns(&mut state.joints.iter().map(|joint| joint.reaction[1])),
            "tie_forces" => forces(&mut state.ties.iter().copied()),
            _ => {
                let mut torques = vec![DVec3::ZERO; state.ties.len()];
                let all = self.tied.iter().flat_map(|tied| tied.torques(&self.world, &state.ties));
                all.for_each(|(row, torque)| torques[row] = torque);
                turns(&mut torques.into_iter())
            }
        }
    }

    /// Replaces a field that is a part of the state.
    pub fn replace(&mut self, field: &str, values: &[f64]) {
        for body in 0..self.particles.len() {
            let mut turning = self.world.angular_velocity(body);
            let mut orientation = self.world.state.turns[body].orientation;
            match (field, self.world.planar) {
                ("angles", _) => orientation = Orientation::planar(values[body]),
                ("orientations", _) => {
                    let [w, x, y, z] = std::array::from_fn(|component| values[4 * body + component]);
                    orientation = Orientation::spatial(glam::DQuat::from_xyzw(x, y, z, w).normalize());
                }
                ("angular_velocities", true) => turning = DVec3::new(0.0, 0.0, values[body]),
                ("angular_velocities", false) => turning = DVec3::from_slice(&values[AXES * body..]),
                _ => return,
            }
            self.world.turn(body, orientation, turning);
        }
    }
}
