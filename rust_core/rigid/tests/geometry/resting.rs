//! Shapes that rest on each other.

use glam::DVec3;
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
