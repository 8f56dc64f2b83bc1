//! Shapes and poses of the tests.

use glam::{DMat3, DVec3};
use physcore_base::scene::{Array, Item, Value};
use physcore_rigid::pose::Pose;
use physcore_rigid::shapes::Shape;

/// Item of a kind with numbers.
pub fn item(kind: &str, numbers: &[(&'static str, f64)]) -> Item {
    let mut item = Item::new(kind, numbers.iter().map(|&(name, number)| (name, Value::Number(number))));
    item.path = "bodies[0].shape".to_owned();
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
pub fn shape(item: &Item, dimension: usize) -> Shape {
    Shape::declared(item, dimension).unwrap().0
}

/// Pose at a position, turned by an angle about z.
pub fn turned(position: DVec3, angle: f64) -> Pose {
    Pose { position, rotation: DMat3::from_rotation_z(angle) }
}
