//! Poses of a diverged motion: nothing panics, and every box of a body that is nowhere is alone.

use glam::DVec3;
use physcore_rigid::broad::pairs;
use physcore_rigid::collision::{contacts, separation, separations};
use physcore_rigid::pose::Pose;
use physcore_rigid::shapes::SolidShape;
use proptest::prelude::*;

use crate::samples::{convex, pointed, pose};
use crate::surfaces::ground;

/// Coordinates that are not finite, or whose squares are not.
fn extreme() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), Just(f64::NAN), Just(f64::INFINITY), Just(-1e300), Just(1e-310), Just(1e200), -1.0..1.0_f64]
}

/// Poses at extreme positions, with proper rotations or with those of a diverged motion.
fn extreme_pose(dimension: usize) -> impl Strategy<Value = Pose> {
    (prop::array::uniform3(extreme()), pose(dimension, 1.0), extreme(), any::<bool>()).prop_map(
        |(position, pose, scale, is_turned)| Pose {
            position: DVec3::from_array(position),
            rotation: if is_turned { pose.rotation } else { pose.rotation * scale },
        },
    )
}

/// Letter L, which has two parts.
fn angle() -> SolidShape {
    let corners = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]].map(|[x, y]| DVec3::new(x, y, 0.0));
    SolidShape::declared(&pointed("Polygon", "vertices", &corners, 2), 2).unwrap().0
}

proptest! {
    #[test]
    fn extreme_poses_do_no_harm(
        (dimension, (one, _), (other, _), poses) in (2..=3_usize).prop_flat_map(|dimension| {
            (Just(dimension), convex(dimension), convex(dimension), [extreme_pose(dimension), extreme_pose(dimension)])
        }),
        reach in prop_oneof![Just(f64::INFINITY), Just(f64::NAN), 0.0..10.0_f64],
    ) {
        let nodes = if dimension == 2 { vec![3] } else { vec![3, 3] };
        let heights: Vec<f64> = (0..nodes.iter().product()).map(|node: usize| 0.3 * (node % 4) as f64).collect();
        let mut others = vec![other, ground(&heights, &nodes).0, SolidShape::half_space(DVec3::Y)];
        if dimension == 2 {
            others.push(angle());
        }
        for other in others {
            let (first, second) = ((&one, &poses[0]), (&other, &poses[1]));
            let (mut points, mut found) = (Vec::new(), Vec::new());
            contacts(first, second, reach, dimension, &mut points);
            contacts(second, first, reach, dimension, &mut points);
            separations(first, second, reach, dimension, &mut found);
            separation(first, second, dimension);
            let bounds = [one.bounds(&poses[0]), other.bounds(&poses[1])];
            let mut near = Vec::new();
            pairs(&bounds, &[true, true], &mut near);
            if bounds.iter().any(|one| one.lower.is_nan() || one.upper.is_nan()) {
                prop_assert!(near.is_empty());
            }
        }
    }
}
