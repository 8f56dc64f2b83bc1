//! Distances and contacts of convex shapes against iteration over all pairs of vertices.

use glam::{DMat3, DVec3};
use physcore_rigid::collision::{contacts, separation};
use physcore_rigid::contact::ContactPoint;
use physcore_rigid::pose::Pose;
use physcore_rigid::shapes::SolidShape;
use proptest::prelude::*;

use crate::reference::{Convex, distance, gap_along};
use crate::samples::{convex, item, point, pointed, pose, ring, rotation};

type Body = (SolidShape, Convex);

fn found(one: (&SolidShape, &Pose), other: (&SolidShape, &Pose), reach: f64, dimension: usize) -> Vec<ContactPoint> {
    let mut points = Vec::new();
    contacts(one, other, reach, dimension, &mut points);
    points
}

/// Two convex bodies at poses at which they overlap, touch, or are apart by up to a few times their size.
fn couple(dimension: usize) -> impl Strategy<Value = (Body, Body, [Pose; 2])> {
    let apart = prop_oneof![0.0..0.7_f64, 0.5..3.0_f64];
    let poses = apart.prop_flat_map(move |reach| [pose(dimension, reach), pose(dimension, reach)]);
    (convex(dimension), convex(dimension), poses)
}

/// Rounding errors of lengths of a few meters, through divisions by areas of at least 1e-3 m².
const ROUNDING: f64 = 1e-11;

/// Checks the distance of two bodies. Returns it with the normal.
fn check_distance(
    one: &Body,
    other: &Body,
    poses: &[Pose; 2],
    samples: &[DVec3],
    dimension: usize,
) -> Result<(f64, DVec3), TestCaseError> {
    let bodies = [(&one.1, &poses[0]), (&other.1, &poses[1])];
    let (gap, normal) = separation((&one.0, &poses[0]), (&other.0, &poses[1]), dimension);
    prop_assert!((normal.length() - 1.0).abs() < 1e-12);
    // The gap along the normal is that of the shadows.
    prop_assert!((gap_along(bodies, normal) - gap).abs() < ROUNDING, "gap {gap}, shadows {}", gap_along(bodies, normal));
    let (upper, lower) = distance(bodies);
    let rounding = one.1.radius + other.1.radius;
    if lower + rounding > 1e-6 {
        prop_assert!(gap <= upper + ROUNDING && gap >= lower - ROUNDING, "{gap} not in {lower}..{upper}");
    } else if upper + rounding < 1e-6 {
        // The cores overlap: no direction has a smaller overlap.
        for direction in samples {
            prop_assert!(gap >= gap_along(bodies, *direction) - ROUNDING);
        }
    }
    Ok((gap, normal))
}

/// Checks the contacts of two bodies at a distance.
fn check_contacts(
    one: &Body,
    other: &Body,
    poses: &[Pose; 2],
    (gap, normal): (f64, DVec3),
    reach: f64,
    dimension: usize,
) -> Result<(), TestCaseError> {
    let points = found((&one.0, &poses[0]), (&other.0, &poses[1]), reach, dimension);
    if gap > reach + ROUNDING {
        prop_assert!(points.is_empty());
        return Ok(());
    }
    if gap > reach - ROUNDING {
        return Ok(());
    }
    prop_assert!(!points.is_empty() && points.len() <= 2 * (dimension - 1), "{} contacts, gap {gap}", points.len());
    let touches: Vec<_> = points.iter().map(|point| point.at([&poses[0], &poses[1]], normal)).collect();
    let least = touches.iter().map(|touch| touch.gap).fold(f64::INFINITY, f64::min);
    prop_assert!((least - gap).abs() < ROUNDING, "least {least}, distance {gap}");
    for (touch, point) in touches.iter().zip(&points) {
        prop_assert!(touch.gap <= reach + ROUNDING);
        prop_assert!(
            touch.normal.dot(normal) > 1.0 - 1e-9 || points.len() > 1 && touch.normal.dot(normal) > 0.99,
            "normal {} of {point:?}, {normal}",
            touch.normal
        );
        // The points are on cores that are apart; a deep vertex may be beside the face that it is behind.
        let is_apart = gap + point.radii[0] + point.radii[1] > 0.0;
        for (body, (shape, pose)) in [(one, poses[0]), (other, poses[1])].into_iter().enumerate().filter(|_| is_apart) {
            let dot = Convex { vertices: vec![point.points[body]], radius: 0.0 };
            let (upper, lower) = distance([(&dot, &pose), (&Convex { radius: 0.0, ..shape.1.clone() }, &pose)]);
            prop_assert!(lower < 1e-9, "{lower} to {upper} from body {body}: {point:?}");
        }
    }
    let mut features: Vec<u32> = points.iter().map(|point| point.feature).collect();
    features.sort_unstable();
    features.dedup();
    prop_assert_eq!(features.len(), points.len());
    Ok(())
}

fn sorted(points: &[ContactPoint], poses: [&Pose; 2]) -> Vec<f64> {
    let mut gaps: Vec<f64> = points.iter().map(|point| point.at(poses, DVec3::ZERO).gap).collect();
    gaps.sort_by(f64::total_cmp);
    gaps
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1000, ..ProptestConfig::default() })]

    #[test]
    fn distances_and_contacts_in_the_plane_are_exact(
        (one, other, poses) in couple(2), samples in prop::collection::vec(0.0..6.3_f64, 64), reach in 0.0..3.0_f64,
    ) {
        let samples: Vec<DVec3> = samples.into_iter().map(|angle| DVec3::new(angle.cos(), angle.sin(), 0.0)).collect();
        let distance = check_distance(&one, &other, &poses, &samples, 2)?;
        check_contacts(&one, &other, &poses, distance, reach, 2)?;
    }

    #[test]
    fn distances_and_contacts_in_space_are_exact(
        (one, other, poses) in couple(3), samples in prop::collection::vec(rotation(3), 64), reach in 0.0..3.0_f64,
    ) {
        let samples: Vec<DVec3> = samples.into_iter().map(|turn| turn.x_axis).collect();
        let distance = check_distance(&one, &other, &poses, &samples, 3)?;
        check_contacts(&one, &other, &poses, distance, reach, 3)?;
    }

    /// Faces are parallel, and neither the edges nor the corners of the larger one are near.
    #[test]
    fn the_distance_of_a_block_from_a_parallel_face_is_exact(
        sizes in prop::array::uniform3(0.1..0.5_f64), beside in prop::array::uniform2(-0.5..0.5_f64), gap in 1e-3..5.0_f64,
        axis in 0..3_usize, turn in rotation(3),
    ) {
        let cuboid = |edges: [f64; 3]| {
            let [a, b, c] = edges;
            SolidShape::declared(&item("Cuboid", &[("a", a), ("b", b), ("c", c)]), 3).unwrap().0
        };
        let (small, mut large) = (cuboid(sizes), [2.0; 3]);
        large[axis] = 1e-3;
        let mut way = [beside[0], beside[1], beside[0]];
        way[axis] = gap + 0.5 * (sizes[axis] + large[axis]);
        let poses = [DVec3::ZERO, turn * DVec3::from_array(way)].map(|position| Pose { position, rotation: turn });
        let normal = turn * DVec3::AXES[axis];
        for (one, other, normal) in [((&cuboid(large), &poses[0]), (&small, &poses[1]), normal), ((&small, &poses[1]), (&cuboid(large), &poses[0]), -normal)] {
            let (found, along) = separation(one, other, 3);
            prop_assert!((found - gap).abs() < ROUNDING && along.distance(normal) < ROUNDING, "{found} for {gap}, {along}");
        }
    }

    /// Contacts do not depend on the order of the bodies, nor on a motion of both, nor on their being seen in a mirror.
    #[test]
    fn contacts_keep_their_gaps_when_bodies_are_exchanged_moved_or_mirrored(
        (dimension, (one, other, poses), turn, shift) in (2..=3_usize).prop_flat_map(|dimension| {
            (Just(dimension), couple(dimension), rotation(dimension), point(dimension))
        }),
    ) {
        let of = |shapes: [&SolidShape; 2], poses: [&Pose; 2]| {
            sorted(&found((shapes[0], poses[0]), (shapes[1], poses[1]), 1.0, dimension), poses)
        };
        let gaps = of([&one.0, &other.0], [&poses[0], &poses[1]]);
        let exchanged = of([&other.0, &one.0], [&poses[1], &poses[0]]);
        let moved = poses.map(|pose| Pose { position: turn * pose.position + shift, rotation: turn * pose.rotation });
        let carried = of([&one.0, &other.0], [&moved[0], &moved[1]]);
        let [a, b] = [&one, &other].map(|body| mirrored(body, dimension));
        let reflected = poses.map(|pose| Pose { position: MIRROR * pose.position, rotation: MIRROR * pose.rotation * MIRROR });
        let seen = of([&a, &b], [&reflected[0], &reflected[1]]);
        // Overlaps may have the same depth along two faces, and clipped corners may coincide: only the least gap is certain.
        for others in [exchanged, carried, seen] {
            prop_assert!(gaps.is_empty() == others.is_empty() || gaps.iter().chain(&others).all(|gap| *gap > 1.0 - ROUNDING));
            prop_assert!((gaps.first().unwrap_or(&1.0) - others.first().unwrap_or(&1.0)).abs() < ROUNDING, "{gaps:?} {others:?}");
        }
    }
}

/// Reflection at the plane x = 0.
const MIRROR: DMat3 = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0));

/// Mirror image of a shape. Capsules and balls are their own.
fn mirrored((shape, points): &Body, dimension: usize) -> SolidShape {
    if points.radius > 0.0 {
        return shape.clone();
    }
    let vertices: Vec<DVec3> = points.vertices.iter().map(|vertex| MIRROR * *vertex).collect();
    let item = match dimension {
        2 => pointed("Polygon", "vertices", &ring(&vertices), 2),
        _ => pointed("Hull", "points", &vertices, 3),
    };
    crate::samples::shape(&item, dimension)
}
