//! Gaps of contacts at other poses than those at which they were found.

use glam::DVec3;
use physcore_base::scene::{Item, Value};
use physcore_rigid::collision::{contacts, separation};
use physcore_rigid::contact::{ContactPoint, Normal};
use physcore_rigid::pose::Pose;
use physcore_rigid::shapes::{SolidShape, WallShape, walls};
use proptest::prelude::*;

use crate::samples::{convex, item, point, pose, rotation, shape};

fn found(first: (&SolidShape, &Pose), second: (&SolidShape, &Pose), dimension: usize) -> Vec<ContactPoint> {
    let mut points = Vec::new();
    contacts(first, second, 3.0, dimension, &mut points);
    points
}

fn round(dimension: usize, radius: f64) -> SolidShape {
    shape(&item(if dimension == 2 { "Disc" } else { "Ball" }, &[("radius", radius)]), dimension)
}

fn hollow(center: DVec3, radius: f64, dimension: usize) -> WallShape {
    let mut item = Item::new(
        "Sphere",
        [
            ("center", Value::Vector(center)),
            ("radius", Value::Number(radius)),
            ("inside", Value::Flag(true)),
            ("friction", Value::Number(0.0)),
            ("restitution", Value::Number(0.0)),
        ],
    );
    "boundaries[0]".clone_into(&mut item.path);
    walls(&item, 0, dimension).unwrap().remove(0)
}

/// Pose turned and moved by a little.
fn nudged(pose: &Pose, turn: &glam::DMat3, shift: DVec3, size: f64) -> Pose {
    let part = glam::DQuat::IDENTITY.lerp(glam::DQuat::from_mat3(turn), size).normalize();
    Pose { position: pose.position + shift * size, rotation: glam::DMat3::from_quat(part) * pose.rotation }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, ..ProptestConfig::default() })]

    /// As long as a ball touches the same face, edge or vertex, the gap is exact at any poses, whoever comes first.
    #[test]
    fn the_gap_of_a_ball_follows_the_motion(
        (dimension, (body, _), poses, turns, shifts) in (2..=3_usize).prop_flat_map(|dimension| (
            Just(dimension), convex(dimension), [pose(dimension, 1.0), pose(dimension, 1.0)],
            [rotation(dimension), rotation(dimension)], [point(dimension), point(dimension)],
        )),
        is_first in any::<bool>(),
    ) {
        let ball = round(dimension, 0.1);
        let shapes = if is_first { [&ball, &body] } else { [&body, &ball] };
        let points = found((shapes[0], &poses[0]), (shapes[1], &poses[1]), dimension);
        prop_assert!(points.len() == 1);
        let moved = [0, 1].map(|index| nudged(&poses[index], &turns[index], shifts[index], 0.05));
        let later = found((shapes[0], &moved[0]), (shapes[1], &moved[1]), dimension);
        let (distance, normal) = separation((shapes[0], &moved[0]), (shapes[1], &moved[1]), dimension);
        // A core that overlaps another has a gap along one of several faces.
        prop_assume!(later.len() == 1 && later[0].feature == points[0].feature && distance > -0.1);
        let is_face = |normal: &Normal| matches!(normal, Normal::First(_) | Normal::Second(_));
        let [before, after] = [points[0].normal, later[0].normal];
        prop_assume!(std::mem::discriminant(&after) == std::mem::discriminant(&before) && (!is_face(&after) || after == before));
        let touch = points[0].at([&moved[0], &moved[1]], normal);
        prop_assert!((touch.gap - distance).abs() < 1e-11 && touch.normal.dot(normal) > 1.0 - 1e-11, "{touch:?} {distance}");
    }

    /// Inside of a sphere the gap of a point is the radius less its distance from the center.
    #[test]
    fn the_gap_in_a_hollow_is_that_of_the_farthest_point(
        (dimension, (body, points), pose) in (2..=3_usize).prop_flat_map(|dimension| {
            (Just(dimension), convex(dimension), pose(dimension, 1.0))
        }),
        is_first in any::<bool>(),
    ) {
        let wall = hollow(DVec3::X, 3.0, dimension);
        let farthest = points.vertices.iter().map(|vertex| pose.point(*vertex).distance(DVec3::X)).fold(0.0, f64::max);
        let gap = 3.0 - farthest - points.radius;
        let sides = if is_first { [(&wall.shape, &wall.pose), (&body, &pose)] } else { [(&body, &pose), (&wall.shape, &wall.pose)] };
        let (distance, normal) = separation(sides[0], sides[1], dimension);
        prop_assert!((distance - gap).abs() < 1e-12);
        let touches = found(sides[0], sides[1], dimension).into_iter().map(|point| point.at([sides[0].1, sides[1].1], DVec3::ZERO));
        let least = touches.reduce(|one, other| if other.gap < one.gap { other } else { one }).unwrap();
        prop_assert!((least.gap - gap).abs() < 1e-12 && least.normal.dot(normal) > 1.0 - 1e-12);
        // The normal leads from the sphere to its center if the sphere is first.
        let inward = (DVec3::X - least.point).dot(least.normal);
        let toward = if is_first { inward } else { -inward };
        prop_assert!(toward > 0.0);
    }
}
