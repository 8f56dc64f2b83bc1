//! Shapes that rest on each other.

use std::f64::consts::{PI, SQRT_2};

use glam::{DMat3, DVec3};
use physcore_rigid::collision::{contacts, separation};
use physcore_rigid::pose::Pose;
use physcore_rigid::shapes::SolidShape;

use crate::samples::{item, shape, turned};

fn gaps(first: (&SolidShape, &Pose), second: (&SolidShape, &Pose), reach: f64, dimension: usize) -> Vec<(f64, DVec3)> {
    let mut points = Vec::new();
    contacts(first, second, reach, dimension, &mut points);
    let touches = points.iter().map(|point| point.at([first.1, second.1], DVec3::ZERO));
    touches.map(|touch| (touch.gap, touch.normal)).collect()
}

#[test]
fn a_body_rests_on_a_plane_and_on_a_copy_of_itself_by_its_corners() {
    let square = shape(&item("Rectangle", &[("width", 0.4), ("height", 0.2)]), 2);
    let cuboid = shape(&item("Cuboid", &[("a", 0.4), ("b", 0.3), ("c", 0.2)]), 3);
    for (body, up, dimension, corners) in [(&square, DVec3::Y, 2, 2), (&cuboid, DVec3::Z, 3, 4)] {
        let pose = |height: f64| turned(up * height, 0.0);
        let ground = SolidShape::half_space(up);
        for (below, top) in [(&ground, 0.1), (body, 0.2)] {
            let found = gaps((below, &Pose::WORLD), (body, &pose(top + 0.01)), 0.1, dimension);
            assert_eq!(found.len(), corners);
            for (gap, normal) in found {
                assert!((gap - 0.01).abs() < 1e-15 && (normal - up).length() < 1e-15, "{gap} {normal}");
            }
            let (distance, normal) = separation((body, &pose(top + 0.01)), (below, &Pose::WORLD), dimension);
            assert!((distance - 0.01).abs() < 1e-15 && (normal + up).length() < 1e-15, "{distance} {normal}");
        }
    }
}

/// A cuboid stands on an edge, across the border of the face below, and leans a little inward or outward. Whichever end is lower,
/// both ends of what lies on the face are contacts, with the same features.
#[test]
fn an_edge_that_lies_across_the_border_of_a_face_touches_it_at_both_ends() {
    let body = shape(&item("Cuboid", &[("a", 0.4), ("b", 0.3), ("c", 0.3)]), 3);
    let upright = DMat3::from_rotation_x(0.25 * PI);
    let features = [-1e-3, 1e-3].map(|angle| {
        let tilt = DMat3::from_rotation_y(angle);
        // The middle of the lowest edge is 0.02 within the border at x = 0.2, at a depth of 1e-5.
        let middle = DVec3::new(0.18, 0.0, 0.15 - 1e-5);
        let above = Pose { position: middle + tilt * DVec3::new(0.0, 0.0, 0.15 * SQRT_2), rotation: tilt * upright };
        let mut points = Vec::new();
        contacts((&body, &Pose::WORLD), (&body, &above), 0.01, 3, &mut points);
        let mut ends: Vec<(f64, u32)> = points
            .iter()
            .map(|point| {
                let touch = point.at([&Pose::WORLD, &above], DVec3::ZERO);
                // The normal of the edges leans by the angle at most.
                let gap = -1e-5 - (touch.point.x - 0.18) * angle.tan();
                assert!(touch.gap < 0.01 && (touch.gap - gap).abs() < 1e-8, "{angle}: {} for {gap}", touch.gap);
                (touch.point.x, point.feature)
            })
            .collect();
        ends.sort_by(|one, other| one.0.total_cmp(&other.0));
        assert_eq!(ends.len(), 2, "{angle}");
        assert!((ends[0].0 - -0.02).abs() < 1e-3 && (ends[1].0 - 0.2).abs() < 1e-3, "{angle}: {ends:?}");
        ends.into_iter().map(|end| end.1).collect::<Vec<_>>()
    });
    assert_eq!(features[0], features[1]);
}
