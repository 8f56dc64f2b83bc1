//! Shapes and poses of the tests.

use glam::{DMat3, DQuat, DVec3};
use physcore_base::scene::{Array, Item, Value};
use physcore_rigid::pose::Pose;
use physcore_rigid::shapes::SolidShape;
use proptest::prelude::*;

use crate::reference::Convex;

/// Item of a kind with numbers.
pub fn item(kind: &str, numbers: &[(&'static str, f64)]) -> Item {
    let mut item = Item::new(kind, numbers.iter().map(|&(name, number)| (name, Value::Number(number))));
    "bodies[0].shape".clone_into(&mut item.path);
    item
}

/// Rows of `dimension` numbers.
pub fn rows(points: &[DVec3], dimension: usize) -> Value {
    let entries = points.iter().flat_map(|point| point.to_array()[..dimension].to_vec()).collect();
    Value::Numbers(Array { shape: vec![points.len(), dimension], entries })
}

/// Item with points.
pub fn pointed(kind: &str, name: &'static str, points: &[DVec3], dimension: usize) -> Item {
    let mut item = item(kind, &[]);
    item.values.insert(name.to_owned(), rows(points, dimension));
    item
}

/// Shape of an item that is right.
pub fn shape(item: &Item, dimension: usize) -> SolidShape {
    SolidShape::declared(item, dimension).unwrap().0
}

/// Pose at a position, turned by an angle about z.
pub fn turned(position: DVec3, angle: f64) -> Pose {
    Pose { position, rotation: DMat3::from_rotation_z(angle) }
}

/// Points in a cube of half the edge 1 m, in 2D a square.
pub fn point(dimension: usize) -> impl Strategy<Value = DVec3> {
    let z = if dimension == 2 { 0.0..=0.0 } else { -1.0..=1.0 };
    (-1.0..1.0_f64, -1.0..1.0_f64, z).prop_map(|(x, y, z)| DVec3::new(x, y, z))
}

/// Rotations, in 2D about z; some by quarter turns, so that faces of two bodies are parallel.
pub fn rotation(dimension: usize) -> impl Strategy<Value = DMat3> {
    let any = prop::array::uniform4(-1.0..1.0_f64).prop_filter_map("zero", move |[x, y, z, w]| {
        let turn = if dimension == 2 { DQuat::from_xyzw(0.0, 0.0, z, w) } else { DQuat::from_xyzw(x, y, z, w) };
        (turn.length() > 0.1).then(|| DMat3::from_quat(turn.normalize()))
    });
    let quarter = DMat3::from_cols(DVec3::Y, -DVec3::X, DVec3::Z);
    let cycle = DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X);
    let aligned = (0..4, 0..3, 0..4).prop_map(move |(first, axis, second)| {
        let turns = |count: i32| (0..count).fold(DMat3::IDENTITY, |turn, _| turn * quarter);
        let about = if dimension == 2 { DMat3::IDENTITY } else { (0..axis).fold(DMat3::IDENTITY, |turn, _| turn * cycle) };
        turns(first) * about * turns(second)
    });
    prop_oneof![any, aligned]
}

/// Poses with a position within a distance of the origin along each axis.
pub fn pose(dimension: usize, reach: f64) -> impl Strategy<Value = Pose> {
    (point(dimension), rotation(dimension)).prop_map(move |(at, rotation)| Pose { position: at * reach, rotation })
}

/// Convex shapes of sizes about 1 m, as declared and as points with a radius about the center of mass.
pub fn convex(dimension: usize) -> BoxedStrategy<(SolidShape, Convex)> {
    let with = move |item: Item, vertices: Vec<DVec3>, radius: f64| {
        let (shape, mass) = SolidShape::declared(&item, dimension).unwrap();
        (shape, Convex { vertices: vertices.into_iter().map(|vertex| vertex - mass.center).collect(), radius })
    };
    let size = || 0.1..1.0_f64;
    let round = if dimension == 2 { "Disc" } else { "Ball" };
    let round = size().prop_map(move |radius| with(item(round, &[("radius", radius)]), vec![DVec3::ZERO], radius));
    let capsule = (size(), size()).prop_map(move |(length, radius)| {
        let end = DVec3::AXES[2 * (dimension - 2)] * (0.5 * length);
        with(item("Capsule", &[("length", length), ("radius", radius)]), vec![-end, end], radius)
    });
    let block = prop::array::uniform3(size()).prop_map(move |edges| {
        let half = 0.5 * DVec3::from_array(edges);
        let corner = |bits: usize| half * DVec3::from_array([0, 1, 2].map(|axis| (bits >> axis & 1) as f64 * 2.0 - 1.0));
        let vertices = (0..1 << dimension).map(corner).map(|at| if dimension == 2 { at.with_z(0.0) } else { at }).collect();
        let [a, b, c] = edges;
        let item = match dimension {
            2 => item("Rectangle", &[("width", a), ("height", b)]),
            _ => item("Cuboid", &[("a", a), ("b", b), ("c", c)]),
        };
        with(item, vertices, 0.0)
    });
    let count = if dimension == 2 { 3..8_usize } else { 4..20 };
    let hull = prop::collection::vec(point(dimension), count).prop_filter_map("flat", move |points| {
        let item = if dimension == 2 {
            pointed("Polygon", "vertices", &ring(&points), 2)
        } else {
            pointed("Hull", "points", &points, 3)
        };
        SolidShape::declared(&item, dimension).ok()?;
        let vertices = if dimension == 2 { ring(&points) } else { points };
        Some(with(item, vertices, 0.0))
    });
    prop_oneof![round, capsule, block, hull].boxed()
}

/// Convex polygon around points in the plane, by gift wrapping.
pub fn ring(points: &[DVec3]) -> Vec<DVec3> {
    let left = |a: DVec3, b: DVec3, c: DVec3| (b - a).cross(c - a).z;
    let start = points.iter().copied().min_by(|a, b| a.x.total_cmp(&b.x)).unwrap();
    let mut ring = vec![start];
    loop {
        let here = ring[ring.len() - 1];
        let others = points.iter().copied().filter(|point| *point != here);
        let next = others.reduce(|a, b| if left(here, a, b) < 0.0 { b } else { a }).unwrap();
        if next == start || ring.len() > points.len() {
            return ring;
        }
        ring.push(next);
    }
}
