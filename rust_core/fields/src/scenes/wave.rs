//! Waves as items.

use physcore_base::math::noise;
use physcore_base::scene::{Array, Item, Value};

use super::grids::{grid, on_edges};

/// Fixed edges on all sides of a plane.
pub const FIXED: [&str; 4] = ["fixed"; 4];

/// Builds a wave on a grid of up to three axes, with speed 1, density 1, and no damping or displacement.
pub fn wave(cells: &[usize], spacing: f64, edges: &[&str]) -> Item {
    let numbers = [("speed", 1.0), ("damping", 0.0), ("displacement", 0.0), ("rate", 0.0), ("density", 1.0), ("order", 2.0)];
    let mut item = Item::new("Wave", numbers.map(|(name, number)| (name, Value::Number(number))));
    "systems[0]".clone_into(&mut item.path);
    item.values.insert("grid".to_owned(), Value::Record(Box::new(grid(cells, spacing, edges))));
    item.values.insert("edges".to_owned(), on_edges(edges));
    item
}

/// Replaces a value of an item.
pub fn with(mut item: Item, name: &str, value: Value) -> Item {
    item.values.insert(name.to_owned(), value);
    item
}

/// Builds a field of this shape from a function of the indices.
pub fn field(cells: &[usize], of: impl Fn([usize; 3]) -> f64) -> Value {
    Value::Numbers(Array { shape: cells.to_vec(), entries: entries(cells, of) })
}

/// Builds a mask of walls from a function of the indices.
pub fn mask(cells: &[usize], of: impl Fn([usize; 3]) -> bool) -> Value {
    let entries = entries(cells, |at| f64::from(u8::from(of(at)))).into_iter().map(|flag| flag != 0.0).collect();
    Value::Flags(Array { shape: cells.to_vec(), entries })
}

/// Values of a function of the indices, cell by cell.
pub fn entries(cells: &[usize], of: impl Fn([usize; 3]) -> f64) -> Vec<f64> {
    let at = |mut index: usize| {
        let mut indices = [0; 3];
        for axis in (0..cells.len()).rev() {
            indices[axis] = index % cells[axis];
            index /= cells[axis];
        }
        indices
    };
    (0..cells.iter().product()).map(|index| of(at(index))).collect()
}

/// Pseudorandom value between −1 and 1 for each cell.
pub fn random([x, y, z]: [usize; 3]) -> f64 {
    noise((x + 1000 * y + 1_000_000 * z) as u64).x
}

/// Builds a source at a point or in cells.
pub fn source(place: Value, amplitude: f64, frequency: f64) -> Item {
    let numbers = [("amplitude", amplitude), ("frequency", frequency), ("phase", 0.0), ("start", 0.0), ("stop", f64::INFINITY)];
    let mut item = Item::new("Source", numbers.map(|(name, number)| (name, Value::Number(number))));
    "systems[0].sources[0]".clone_into(&mut item.path);
    with(item, "where", place)
}

pub const N: usize = 21;
pub const PLANE: [usize; 2] = [N, N];

/// Function that is invariant under mirroring and exchange of the axes.
pub fn symmetric([i, j, _]: [usize; 3]) -> f64 {
    let [x, y] = [i, j].map(|index| index.min(N - 1 - index));
    random([x.min(y), x.max(y), 0])
}

pub fn speed([i, j, k]: [usize; 3]) -> f64 {
    1.0 + 0.5 * symmetric([i, j, k])
}

/// Waves with uniform and variable speed and with walls, of both orders.
pub fn variants(cells: [usize; 2], edges: &[&str], displacement: impl Fn([usize; 3]) -> f64 + Copy) -> Vec<Item> {
    let plain = with(wave(&cells, 0.1, edges), "displacement", field(&cells, displacement));
    let varying = with(plain.clone(), "speed", field(&cells, speed));
    let walled = with(varying.clone(), "walls", mask(&cells, |at| symmetric(at) > 0.8));
    let fourth = |item: &Item| with(item.clone(), "order", Value::Number(4.0));
    vec![fourth(&plain), fourth(&walled), plain, varying, walled]
}
