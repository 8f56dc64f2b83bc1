//! Grids and their edges as items.

use glam::DVec3;
use physcore_base::scene::{Item, Value};

/// Builds a grid of up to three axes with its lower corner at the origin, periodic along the axes with periodic edges.
pub fn grid(cells: &[usize], spacing: f64, edges: &[&str]) -> Item {
    let vector = |of: &dyn Fn(usize) -> f64| {
        let mut entries = [0.0; 3];
        (0..cells.len()).for_each(|axis| entries[axis] = of(axis));
        Value::Vector(DVec3::from_array(entries))
    };
    Item::new(
        "Grid",
        [
            ("cells", vector(&|axis| cells[axis] as f64)),
            ("spacing", Value::Number(spacing)),
            ("origin", vector(&|_| 0.0)),
            ("periodic", vector(&|axis| f64::from(u8::from(edges[2 * axis] == "periodic")))),
        ],
    )
}

/// Boundary conditions of a system, two per axis.
pub fn on_edges(words: &[&str]) -> Value {
    Value::Texts(words.iter().map(|&word| word.to_owned()).collect())
}
