//! Boundaries of scenes as fixed shapes.

use glam::DVec3;
use physcore_base::error::Error;
use physcore_base::scene::{Item, Value};
use physcore_rigid::collision::separation;
use physcore_rigid::pose::Pose;
use physcore_rigid::shapes::{SolidShape, walls};

use crate::samples::{item, rows, shape};

fn boundary(kind: &str, values: Vec<(&'static str, Value)>) -> Item {
    let mut item = item(kind, &[("friction", 0.5), ("restitution", 0.25)]);
    "boundaries[3]".clone_into(&mut item.path);
    item.values.extend(values.into_iter().map(|(name, value)| (name.to_owned(), value)));
    item
}

/// Least distance of a small ball from the walls of a boundary.
fn distance(item: &Item, center: DVec3, dimension: usize) -> f64 {
    let ball = shape(&self::item(if dimension == 2 { "Disc" } else { "Ball" }, &[("radius", 0.01)]), dimension);
    let pose = Pose { position: center, ..Pose::WORLD };
    let walls = walls(item, 3, dimension).unwrap();
    let gaps = walls.iter().map(|wall| {
        assert!(wall.friction == 0.5 && wall.restitution == 0.25 && wall.boundary == 3);
        separation((&ball, &pose), (&wall.shape, &wall.pose), dimension).0
    });
    gaps.fold(f64::INFINITY, f64::min) + 0.01
}

#[test]
fn boundaries_are_where_they_are_declared() {
    let v = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let vector = |x: f64, y: f64, z: f64| Value::Vector(v(x, y, z));
    for dimension in [2, 3] {
        let flat = |at: DVec3| if dimension == 2 { at.with_z(0.0) } else { at };
        let close = |item: &Item, at: DVec3, expected: f64| {
            let found = distance(item, flat(at), dimension);
            assert!((found - expected).abs() < 1e-12, "{} in {dimension}D: {found}, not {expected}", item.kind);
        };
        let plane = boundary("Plane", vec![("point", vector(1.0, 0.0, 0.0)), ("normal", vector(3.0, 4.0, 0.0))]);
        close(&plane, v(2.0, 1.0, 0.0), 1.4);
        close(&plane, v(0.0, 0.0, 0.0), -0.6);
        let corners = |inside| {
            let (lower, upper) = (flat(v(0.0, 1.0, 2.0)), flat(v(4.0, 3.0, 5.0)));
            boundary(
                "Box",
                vec![("lower", Value::Vector(lower)), ("upper", Value::Vector(upper)), ("inside", Value::Flag(inside))],
            )
        };
        close(&corners(true), v(1.0, 2.5, 3.5), 0.5);
        close(&corners(false), v(-3.0, 7.0, 3.0), 5.0);
        let sphere = |inside| {
            let center = Value::Vector(flat(v(1.0, 1.0, 1.0)));
            boundary("Sphere", vec![("center", center), ("radius", Value::Number(2.0)), ("inside", Value::Flag(inside))])
        };
        close(&sphere(true), v(1.0, 2.5, 1.0), 0.5);
        close(&sphere(false), v(4.0, 5.0, 1.0), 3.0);
        let ends = [("start", Value::Vector(v(0.0, 0.0, 0.0))), ("end", Value::Vector(v(0.0, 2.0, 0.0)))];
        let capsule = boundary("Capsule", ends.into_iter().chain([("radius", Value::Number(0.5))]).collect());
        close(&capsule, v(1.5, 1.0, 0.0), 1.0);
        close(&capsule, v(3.0, 6.0, 0.0), 4.5);
        let points = [v(0.0, 0.0, 0.0), v(1.0, 0.0, 0.0), v(0.0, 1.0, 0.0), v(0.1, 0.1, 0.1), v(0.0, 0.0, 1.0)];
        let points: Vec<DVec3> = points.into_iter().map(flat).collect();
        let hull = boundary("ConvexHull", vec![("points", rows(&points, dimension))]);
        close(&hull, v(0.2, -2.0, 0.2), 2.0);
        close(&hull, v(1.0, 1.0, 0.0), 0.5_f64.sqrt());
    }
}

#[test]
fn wrong_values_are_refused_by_name() {
    let refused = |item: &Item, dimension: usize, expected: &str| {
        let error = SolidShape::declared(item, dimension).unwrap_err();
        assert!(matches!(error, Error::Parameter { .. }) && error.to_string().starts_with(expected), "{error}");
    };
    refused(&item("Disc", &[("radius", 0.0)]), 2, "bodies[0].shape.radius: expected a number > 0, got 0");
    refused(&item("Disc", &[("radius", 1.0)]), 3, "bodies[0].shape: expected a shape in 3D: Ball, Cuboid");
    refused(&item("Ball", &[("radius", 1e-200)]), 3, "bodies[0].shape: expected a shape whose size and inertia are finite");
    refused(&item("Capsule", &[("length", -1.0), ("radius", 1.0)]), 2, "bodies[0].shape.length: expected a number > 0");
    let flat = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0], [1.0, 1.0, 1.0]].map(DVec3::from_array);
    refused(
        &crate::samples::pointed("Hull", "points", &flat, 3),
        3,
        "bodies[0].shape.points: expected points that span a volume",
    );
    let line = [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [3.0, 3.0, 0.0]].map(DVec3::from_array);
    refused(&crate::samples::pointed("Polygon", "vertices", &line, 2), 2, "bodies[0].shape.vertices: expected ");
    let mut open = crate::samples::pointed("MeshShape", "vertices", &flat, 3);
    let faces = physcore_base::scene::Array { shape: vec![2, 3], entries: vec![0, 1, 2, 2, 1, 3] };
    open.values.insert("faces".to_owned(), Value::Indices(faces));
    refused(&open, 3, "bodies[0].shape.faces: expected a closed surface");
    let error = walls(&boundary("Moebius", Vec::new()), 0, 3).unwrap_err().to_string();
    assert!(error.starts_with("boundaries[3]: expected a boundary for rigid bodies: Plane, Box"), "{error}");
    let error = walls(&boundary("Sphere", vec![("radius", Value::Number(-1.0))]), 0, 3).unwrap_err().to_string();
    assert!(error.starts_with("boundaries[3].radius: expected a number > 0, got -1"), "{error}");
}
