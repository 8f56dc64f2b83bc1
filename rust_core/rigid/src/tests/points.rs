//! Particles that are joined to bodies.

use glam::DVec3;
use physcore_base::parallel::SERIAL;

use super::laboratory::{Laboratory, rectangle, round};
use crate::joints::{Joint, JointKind};
use crate::mover::Mover;
use crate::pose::Pose;
use crate::rotation::Orientation;
use crate::shapes::SolidShape;
use crate::surface::Surface;
use crate::world::{CenterMotion, FreeParticles, FreePoint, WorldJoint};

/// A particle that a joint holds in the middle of a box does not touch it, whichever particles take part beside it. The box
/// turns on freely, by 1 rad, exactly but for the rounding of 240 steps.
#[test]
fn a_joined_particle_does_not_touch_its_body() {
    let h = 1.0 / 240.0;
    let mut lab = Laboratory::new(2, DVec3::ZERO);
    let rest = (DVec3::ZERO, Orientation::planar(0.0));
    lab.add(&rectangle(0.4, 0.4), (1.0, 0.5, 0.0), rest, (DVec3::ZERO, DVec3::Z));
    lab.add(&round("Disc", 0.1), (1.0, 0.5, 0.0), (9.0 * DVec3::X, Orientation::planar(0.0)), (DVec3::ZERO, DVec3::ZERO));
    lab.world.shapes.push(SolidShape::round(0.0));
    let surface = Surface { shape: lab.world.shapes.len() - 1, friction: None, restitution: 0.0 };
    let points = [4, 7].map(|index| FreePoint { index, surface, inverse_mass: 10.0 });
    let mut others = [5.0 * DVec3::X, DVec3::ZERO].map(|position| CenterMotion::free(position, DVec3::ZERO));
    let bead = Mover { inverse_mass: 10.0, ..Mover::wall(&Pose::WORLD) };
    let joint = Joint::new(JointKind::Ball, [&lab.mover(0), &bead], [DVec3::ZERO; 2], DVec3::Z, true);
    lab.world.state.joints.push(WorldJoint::new([0, 2 + 7], joint));
    for _ in 0..240 {
        let moved =
            lab.world.drift((h, false), &mut lab.motions, FreeParticles { points: &points, faces: &[] }, &mut others, &SERIAL);
        assert_eq!(moved, [true, false, false, true]);
        lab.world.finish(h, &mut lab.motions, &mut others, &SERIAL);
    }
    assert!((lab.world.state.turns[0].orientation.angle - 1.0).abs() < 1e-13);
    assert!(lab.motions[0].position.length() < 1e-13 && others[1].position.length() < 1e-13);
}
