//! Height field: the ground below heights over a uniform grid.

use std::sync::Arc;

use glam::DVec3;

use super::{Boundary, Terrain, Wall};
use crate::error::{Error, Result};
use crate::scene::{Array, Item, Value};

/// Steepest permitted slope, whose square is finite.
const STEEPEST: f64 = 1e100;

/// Space above a height field.
#[derive(Debug)]
pub struct HeightField {
    wall: [Wall; 1],
}

impl HeightField {
    /// Ground below the item's `heights` [m] at the nodes of a grid with its `spacing` and `origin` [m].
    pub fn new(item: &Item, dimension: usize, origin: DVec3) -> Result<Self> {
        let axes = dimension - 1;
        let array = match item.values.get("heights") {
            Some(Value::Numbers(array)) if array.shape.len() == axes && array.shape.iter().all(|&count| count >= 2) => array,
            other => return Err(item.wrong("heights", &format!("an array with {axes} axes of at least 2 nodes"), other)),
        };
        let spacing = item.number("spacing")?;
        if spacing <= 0.0 {
            return Err(item.wrong("spacing", "a number > 0", Some(&Value::Number(spacing))));
        }
        let Array { shape, entries } = array;
        let nodes = [shape[0], if axes == 2 { shape[1] } else { 1 }];
        if let Some(height) = entries.iter().find(|height| !height.is_finite()) {
            return Err(Error::parameter(format!("{}.heights", item.path), "finite heights", height));
        }
        let largest = entries.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let range = largest - entries.iter().copied().fold(f64::INFINITY, f64::min);
        if range / spacing > STEEPEST {
            let expected = format!("heights that differ by at most {STEEPEST:e} spacings");
            return Err(Error::parameter(format!("{}.heights", item.path), expected, range / spacing));
        }
        let heights = entries.iter().map(|height| height - origin[axes]).collect();
        let terrain = Terrain::new(heights, nodes, spacing, item.vector("origin")? - origin, dimension);
        Ok(Self { wall: [Wall::Terrain(Arc::new(terrain))] })
    }
}

impl Boundary for HeightField {
    fn name(&self) -> &'static str {
        "height field"
    }

    fn walls(&self) -> &[Wall] {
        &self.wall
    }
}
