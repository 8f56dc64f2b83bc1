//! Mass properties against closed forms, and their invariances.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};
use physcore_base::scene::{Array, Item, Value};
use physcore_rigid::shapes::{MassProperties, SolidShape};
use proptest::prelude::*;

use crate::samples::{item, point, pointed, rotation};

fn mass(item: &Item, dimension: usize) -> MassProperties {
    SolidShape::declared(item, dimension).unwrap().1
}

fn diagonal(tensor: DMat3) -> DVec3 {
    DVec3::new(tensor.x_axis.x, tensor.y_axis.y, tensor.z_axis.z)
}

/// Largest difference of size, center and inertia.
fn difference(one: &MassProperties, other: &MassProperties) -> f64 {
    let inertia = (one.inertia - other.inertia).to_cols_array().into_iter().map(f64::abs).fold(0.0, f64::max);
    (one.size - other.size).abs().max((one.center - other.center).length()).max(inertia)
}

#[test]
fn round_and_straight_shapes_have_the_figures_of_textbooks() {
    let (r, length) = (0.3, 0.7);
    let disc = mass(&item("Disc", &[("radius", r)]), 2);
    assert!((disc.size - PI * r * r).abs() < 1e-15 && (disc.inertia.z_axis.z / disc.size - 0.5 * r * r).abs() < 1e-15);
    let rectangle = mass(&item("Rectangle", &[("width", 0.4), ("height", 0.2)]), 2);
    assert!((rectangle.size - 0.08).abs() < 1e-15 && (rectangle.inertia.z_axis.z / 0.08 - 0.2 / 12.0).abs() < 1e-15);
    let ball = mass(&item("Ball", &[("radius", r)]), 3);
    assert!((diagonal(ball.inertia) / ball.size - 0.4 * r * r).abs().max_element() < 1e-15);
    assert!((ball.size - 4.0 / 3.0 * PI * r * r * r).abs() < 1e-15);
    let cuboid = mass(&item("Cuboid", &[("a", 0.4), ("b", 0.3), ("c", 0.2)]), 3);
    let expected = DVec3::new(0.09 + 0.04, 0.16 + 0.04, 0.16 + 0.09) / 12.0;
    assert!((diagonal(cuboid.inertia) / 0.024 - expected).abs().max_element() < 1e-15 && (cuboid.size - 0.024).abs() < 1e-16);
    // Cylinder and two half balls, each with the theorem of Steiner from its own center of mass, 3 r / 8 from its flat side.
    let capsule = mass(&item("Capsule", &[("length", length), ("radius", r)]), 3);
    let (tube, cap) = (PI * r * r * length, 2.0 / 3.0 * PI * r * r * r);
    let about_own = 0.4 * r * r - (0.375 * r) * (0.375 * r);
    let across = tube * (length * length / 12.0 + 0.25 * r * r) + 2.0 * cap * (about_own + (0.5 * length + 0.375 * r).powi(2));
    assert!((capsule.size - tube - 2.0 * cap).abs() < 1e-15);
    assert!((capsule.inertia.x_axis.x - across).abs() < 1e-15 && (capsule.inertia.y_axis.y - across).abs() < 1e-15);
    assert!((capsule.inertia.z_axis.z - 0.5 * tube * r * r - 0.8 * cap * r * r).abs() < 1e-15);
    // Regular tetrahedron of edge a: volume a³ / 6√2, inertia a² / 20 per unit of mass.
    let corners = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]].map(DVec3::from_array);
    let tetrahedron = mass(&pointed("Hull", "points", &corners, 3), 3);
    assert!((tetrahedron.size - 8.0 / 3.0).abs() < 1e-14);
    assert!((diagonal(tetrahedron.inertia) / tetrahedron.size - 8.0 / 20.0).abs().max_element() < 1e-14);
}

#[test]
fn a_capsule_in_the_plane_is_the_limit_of_polygons() {
    let (r, length, count) = (0.3, 0.7, 2000);
    let vertex = |index: i32| {
        let angle = PI * (f64::from(index) + 0.5) / f64::from(count) - 0.5 * PI;
        let side = if index < count { 0.5 } else { -0.5 };
        DVec3::new(side * length + r * angle.cos(), r * angle.sin(), 0.0)
    };
    let polygon = mass(&pointed("Polygon", "vertices", &(0..2 * count).map(vertex).collect::<Vec<_>>(), 2), 2);
    let capsule = mass(&item("Capsule", &[("length", length), ("radius", r)]), 2);
    // An inscribed polygon lacks the part (π / n)² / 6 of the area of each sector of the discs.
    assert!((polygon.size / capsule.size - 1.0).abs() < 1e-6);
    assert!((polygon.inertia.z_axis.z / capsule.inertia.z_axis.z - 1.0).abs() < 1e-6);
}

proptest! {
    /// A hull that is turned and moved has the same size, a center that moves along, and an inertia that turns along.
    #[test]
    fn a_hull_turns_and_moves_with_its_points(
        points in prop::collection::vec(point(3), 4..30), turn in rotation(3), shift in point(3), far in 0.0..100.0_f64,
    ) {
        let moved: Vec<DVec3> = points.iter().map(|point| turn * *point + shift * far).collect();
        let hulls = [points, moved].map(|points| SolidShape::declared(&pointed("Hull", "points", &points, 3), 3));
        let [Ok((_, one)), Ok((_, other))] = hulls else { return Ok(()) };
        let expected = MassProperties {
            center: turn * one.center + shift * far, inertia: turn * one.inertia * turn.transpose(), ..one
        };
        // Coordinates of up to 200 m are rounded. The center of a flat hull is a quotient of small numbers.
        prop_assert!(difference(&other, &expected) < 1e-12 + 1e-13 / one.size);
    }

    /// A polygon cut in two along a diagonal is a compound of its halves, whatever the order of its vertices.
    #[test]
    fn a_quadrilateral_is_the_sum_of_its_halves(sizes in prop::array::uniform4(0.2..1.0_f64), turn in 0.0..6.0_f64, shift in point(2)) {
        let corners: Vec<DVec3> = (0..4).map(|quarter| {
            let angle = 0.5 * PI * f64::from(quarter);
            DVec3::new(angle.cos(), angle.sin(), 0.0) * sizes[quarter as usize] + shift
        }).collect();
        let polygon = |corners: &[DVec3]| pointed("Polygon", "vertices", corners, 2);
        let rotation = DMat3::from_rotation_z(turn);
        let halves = [[0, 1, 2], [2, 3, 0]].map(|half| polygon(&half.map(|corner: usize| corners[corner])));
        let mut compound = Item::new("Compound", [
            ("shapes", Value::Records(halves.to_vec())),
            ("positions", Value::Numbers(Array { shape: vec![2, 2], entries: vec![0.0; 4] })),
            ("angles", Value::Numbers(vec![turn; 2].into())),
        ]);
        compound.path = "bodies[0].shape".to_owned();
        let turned: Vec<DVec3> = corners.iter().map(|corner| rotation * *corner).collect();
        // The diagonal cuts a convex quadrilateral only.
        prop_assume!(SolidShape::declared(&polygon(&turned), 2).is_ok());
        let reversed: Vec<DVec3> = turned.iter().rev().copied().collect();
        for corners in [turned, reversed] {
            prop_assert!(difference(&mass(&polygon(&corners), 2), &mass(&compound, 2)) < 1e-14);
        }
    }
}
