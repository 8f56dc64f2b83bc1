//! Overlaps of rigid bodies at the start and in recorded states.

use glam::DVec3;
use physcore_rigid::rotation::Orientation;
use physcore_rigid::world::{CenterMotion, Overlap, RigidWorld};

use super::RigidBodies;
use super::declaration::{add_bodies, add_joints, add_walls};
use crate::error::{Error, Result};
use crate::scene::{RIGID_BODIES, Scene};

/// Overlap at the start that is refused, and of which is warned, over the size of the smaller body.
const REFUSED: f64 = 1e-2;
const MENTIONED: f64 = 1e-6;

impl RigidBodies {
    /// Warning of the deepest overlap at the recorded start, of bodies or of particles that may meet them; empty without.
    ///
    /// # Errors
    /// If one is too deep.
    pub(super) fn start_overlap(&mut self) -> Result<String> {
        self.motions.clear();
        self.motions.extend(self.starts.iter().map(|&[position, velocity]| CenterMotion::free(position, velocity)));
        self.choose(0.0);
        let near = self.near.iter().map(|&point| (self.points[point].1, self.others[point], self.point_path(point)));
        let found = self.world.overlaps(&self.motions, &near.collect::<Vec<_>>());
        let part = |overlap: &Overlap| overlap.depth / overlap.size;
        let deepest = found.into_iter().reduce(|one, other| if part(&other) > part(&one) { other } else { one });
        let Some(overlap) = deepest.filter(|overlap| part(overlap) > MENTIONED) else { return Ok(String::new()) };
        let (refused, Overlap { depth, names: [one, other], is_of_particle, .. }) = (part(&overlap) > REFUSED, overlap);
        if !refused {
            return Ok(format!(
                "{other}: overlaps {one} at the start by {depth:.2e} m; the first steps push them apart, which adds energy; place \
                 them {depth:.2e} m farther apart: they may touch"
            ));
        }
        Err(if is_of_particle {
            let found = format!("one that is {depth:.3e} m within {one}");
            let error = Error::parameter(other, "a particle outside of rigid bodies", found);
            error.with_hint("move it out; Anchor(…) ties particles of a spring network to a body")
        } else {
            let found = format!("{one} and {other}, which overlap by {depth:.3e} m");
            let error = Error::parameter(&self.path, "bodies that do not overlap at the start", found);
            error.with_hint("place them farther apart; they may touch")
        })
    }

    /// Path of a particle in the scene.
    fn point_path(&self, point: usize) -> String {
        let particle = self.points[point].1.index;
        let body = self.firsts.partition_point(|&first| first <= particle) - 1;
        format!("bodies[{body}].positions[{}]", particle - self.firsts[body])
    }
}

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
        world.overlaps(&state.iter().map(|(position, _)| still(position)).collect::<Vec<_>>(), &[])
    };
    Ok(states.iter().map(of).collect())
}
