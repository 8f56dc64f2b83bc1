//! State of rigid bodies and their joints from step to step, as numbers for files.

use glam::DVec3;

use crate::island::ContactKey;
use crate::joints::Joint;
use crate::rotation::Orientation;
use crate::rows::{ContactImpulse, MOST_ROWS};

use super::sleep::BodyRest;

/// Rotation of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turn {
    /// Orientation.
    pub orientation: Orientation,
    /// Angular momentum about the center [kg·m²/s]; of a fixed body, the angular velocity [rad/s].
    pub spin: DVec3,
}

/// Joint between two bodies or particles, by their indices in the world.
#[derive(Debug, Clone)]
pub struct WorldJoint {
    /// Indices of the two ends: bodies, then particles, or [`super::WORLD`].
    pub ends: [usize; 2],
    /// Joint.
    pub joint: Joint,
    /// Whether the joint is broken.
    pub broken: bool,
    pub(super) loads: [f64; MOST_ROWS],
    pub(super) bounds: [f64; 3],
    /// Mean force on the second body [N], and torque about its anchor [N·m], in the last step; 0 if broken.
    pub reaction: [DVec3; 2],
}

impl WorldJoint {
    /// Joint without load.
    pub fn new(ends: [usize; 2], joint: Joint) -> Self {
        Self { ends, joint, broken: false, loads: [0.0; MOST_ROWS], bounds: [0.0; 3], reaction: [DVec3::ZERO; 2] }
    }
}

/// State that persists from step to step.
#[derive(Debug, Clone, Default)]
pub struct RigidState {
    /// Rotations of the bodies.
    pub turns: Vec<Turn>,
    /// Forces of the contacts of the last step, in the order of their keys.
    pub loads: Vec<(ContactKey, ContactImpulse)>,
    /// Joints, in the order of the scene.
    pub joints: Vec<WorldJoint>,
    /// Energy of the springs that broke [J].
    pub torn: f64,
    /// Torques of the forces on the bodies at the end of the last step [N·m].
    pub torques: Vec<DVec3>,
    /// Mean forces of tied particles on the bodies in the last step [N].
    pub ties: Vec<DVec3>,
    /// Rests of the bodies; empty if none may sleep.
    pub rests: Vec<BodyRest>,
    /// Kinetic energy of the groups that fell asleep [J].
    pub slept: f64,
    /// Number of steps of groups that were taken again because impulses would have added energy, since the start or since a
    /// checkpoint was read.
    pub retaken: u64,
    /// Number of steps of groups in which bodies waited because of too many impacts, since then.
    pub waits: u64,
    /// Energy gained so far by pushing overlapping bodies apart [J].
    pub pushed: f64,
}

/// Numbers of a joint in a file.
const JOINT_NUMBERS: usize = MOST_ROWS + 3 + 8;

impl RigidState {
    /// Loads of contacts as numbers, for files.
    pub fn packed_loads(&self) -> Vec<f64> {
        let row = |(key, load): &(ContactKey, ContactImpulse)| {
            let (one, other, feature) = *key;
            let key = [f64::from(one), f64::from(other), f64::from(feature), load.normal];
            [key.as_slice(), &load.tangential.to_array(), &load.turning.to_array()].concat()
        };
        self.loads.iter().flat_map(row).collect()
    }

    /// Loads and breakage of joints as numbers, for files.
    pub fn packed_joints(&self) -> Vec<f64> {
        let row = |joint: &WorldJoint| {
            let [force, torque] = joint.reaction.map(|reaction| reaction.to_array());
            [joint.loads.as_slice(), &joint.bounds, &force, &torque, &[f64::from(u8::from(joint.broken)), joint.joint.last]]
                .concat()
        };
        self.joints.iter().flat_map(row).collect()
    }

    /// Reads the numbers of [`RigidState::packed_loads`] and [`RigidState::packed_joints`]; returns whether they fit.
    pub fn unpack(&mut self, loads: &[f64], joints: &[f64]) -> bool {
        if !loads.len().is_multiple_of(10) || joints.len() != JOINT_NUMBERS * self.joints.len() {
            return false;
        }
        let load = |row: &[f64]| {
            let [one, other, feature] = [0, 1, 2].map(|index| row[index] as u32);
            let (tangential, turning) = (DVec3::from_slice(&row[4..]), DVec3::from_slice(&row[7..]));
            ((one, other, feature), ContactImpulse { normal: row[3], tangential, turning })
        };
        self.loads = loads.chunks_exact(10).map(load).collect();
        for (joint, row) in self.joints.iter_mut().zip(joints.chunks_exact(JOINT_NUMBERS)) {
            joint.loads.copy_from_slice(&row[..MOST_ROWS]);
            joint.bounds.copy_from_slice(&row[MOST_ROWS..MOST_ROWS + 3]);
            let reactions = &row[MOST_ROWS + 3..];
            joint.reaction = [DVec3::from_slice(reactions), DVec3::from_slice(&reactions[3..])];
            (joint.broken, joint.joint.last) = (reactions[6] != 0.0, reactions[7]);
        }
        true
    }
}
