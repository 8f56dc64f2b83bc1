//! Overlaps of rigid bodies in recorded states.

use glam::DVec3;
use physcore_rigid::rotation::Orientation;
use physcore_rigid::world::{CenterMotion, Overlap, RigidWorld};

use super::declaration::{add_bodies, add_joints, add_walls};
use crate::error::Result;
use crate::scene::{RIGID_BODIES, Scene};

/// Center of mass [m] and orientation of a rigid body.
pub type RigidPose = (DVec3, Orientation);

/// Overlaps of the rigid bodies of a scene with each other and with boundaries, in each state. A state has the poses of all
/// bodies in their order. Joined bodies are left out, because they may overlap.
///
/// # Errors
/// If a shape or a joint of the scene is wrong.
pub fn overlaps(scene: &Scene, states: &[Vec<RigidPose>]) -> Result<Vec<Vec<Overlap>>> {
    let mut world = RigidWorld::new(scene.dimension == 2);
    let mut places = vec![None; scene.count()];
    for (index, body) in scene.bodies.iter().enumerate().filter(|(_, body)| body.item.kind == RIGID_BODIES) {
        for row in 0..body.positions.len() {
            places[scene.first(index) + row] = Some(world.bodies.len() + row);
        }
        add_bodies(&mut world, scene, index)?;
    }
    add_walls(&mut world, scene)?;
    add_joints(&mut world, scene, &places, &scene.positions(), &[])?;
    let still = |position: &DVec3| CenterMotion::free(*position, DVec3::ZERO);
    let of = |state: &Vec<RigidPose>| {
        for (body, (_, orientation)) in state.iter().enumerate() {
            world.turn(body, *orientation, DVec3::ZERO);
        }
        world.overlaps(&state.iter().map(|(position, _)| still(position)).collect::<Vec<_>>())
    };
    Ok(states.iter().map(of).collect())
}
