//! Fluids of a scene at the start: their bodies, the walls that they meet, and the hydrostatic pressure.

use std::collections::BTreeMap;

use glam::DVec3;

use super::walls::FluidWall;
use crate::boundaries::{self, Wall};
use crate::error::{Error, Result};
use crate::forces::fluid::fluids;
use crate::scene::{Item, Scene};

/// Numerical method of a fluid.
#[inline]
pub fn method(fluid: &Item) -> Result<&Item> {
    fluid.record("method")
}

/// Boundaries that act on fluids, each with its index.
fn met(scene: &Scene) -> impl Iterator<Item = (usize, &Item)> {
    let meets = |item: &Item| fluids(scene).any(|(body, _)| item.acts_on(body));
    scene.boundaries.iter().enumerate().filter(move |(_, item)| meets(item))
}

/// Index of the boundary of each wall.
#[inline]
pub fn boundaries_of_walls(scene: &Scene, origin: DVec3) -> Result<Vec<usize>> {
    let mut found = Vec::new();
    for (index, item) in met(scene) {
        let count = boundaries::build(item, scene.dimension, origin)?.walls().len();
        found.extend(std::iter::repeat_n(index, count));
    }
    Ok(found)
}

/// Walls of the fluids, relative to an origin.
pub fn walls(scene: &Scene, origin: DVec3) -> Result<Vec<FluidWall>> {
    let mut walls = Vec::new();
    for (_, item) in met(scene) {
        let no_slip = if item.values.contains_key("no_slip") { item.flag("no_slip")? } else { false };
        let boundary = boundaries::build(item, scene.dimension, origin)?;
        if boundary.walls().iter().any(|wall| matches!(wall, Wall::Terrain(_))) {
            // Mirror images are behind one plane, and not behind the faces on both sides of an edge.
            let path = format!("{}.on", item.path);
            return Err(Error::parameter(path, "bodies that are no fluids", "a fluid on a height field"));
        }
        walls.extend(boundary.walls().iter().map(|wall| FluidWall { wall: wall.clone(), no_slip }));
    }
    Ok(walls)
}

/// A layer of fluid particles one spacing high.
#[derive(Debug, Clone, Copy, Default)]
struct FluidLayer {
    /// Mean density of the particles [kg/m³].
    density: f64,
    number: f64,
    /// Mass per area of the layers above [kg/m²].
    above: f64,
}

/// Hydrostatic pressure of fluid particles [Pa]: the weight of the column above. Each head is a depth [m] with the density there.
/// Empty parts of a column have no weight, and take no memory for any height.
pub fn pressures(heads: &[(f64, f64)], spacing: f64, gravity: f64) -> Vec<f64> {
    let top = heads.iter().map(|&(head, _)| head).fold(f64::INFINITY, f64::min) - 0.5 * spacing;
    let layer = |head: f64| ((head - top) / spacing) as usize;
    let mut layers: BTreeMap<usize, FluidLayer> = BTreeMap::new();
    for &(head, density) in heads {
        let layer = layers.entry(layer(head)).or_default();
        layer.density += density;
        layer.number += 1.0;
    }
    let mut above = 0.0;
    for layer in layers.values_mut() {
        layer.density /= layer.number;
        layer.above = above;
        above += layer.density * spacing;
    }
    let pressure = |head: f64| {
        let index = layer(head);
        let FluidLayer { density, above, .. } = layers[&index];
        gravity * (above + density * (head - top - index as f64 * spacing))
    };
    heads.iter().map(|&(head, _)| pressure(head)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_weight_above_is_that_of_all_layers() {
        // Half a meter of oil on water has the pressure (800 · 0.5 + 1000 · x) g.
        let heads: Vec<(f64, f64)> =
            (0..20).map(|row| (0.05 + 0.1 * f64::from(row), if row < 5 { 800.0 } else { 1000.0 })).collect();
        let found = pressures(&heads, 0.1, 10.0);
        for (&(head, _), pressure) in heads.iter().zip(found) {
            let expected = 10.0 * if head < 0.5 { 800.0 * head } else { 400.0 + 1000.0 * (head - 0.5) };
            assert!((pressure - expected).abs() < 1e-9 * expected, "{head} {pressure} {expected}");
        }
    }

    #[test]
    fn a_column_with_a_gap_takes_memory_for_its_particles_alone() {
        // A layer of 1e-9 m has 1e15 empty layers below it.
        let found = pressures(&[(0.0, 1000.0), (1e6, 1000.0)], 1e-9, 10.0);
        let expected = [10.0 * 1000.0 * 0.5e-9, 10.0 * 1000.0 * 1.5e-9];
        // Depths of 1e6 m have a rounding error of 1e-10 m.
        assert!(found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e4 * 1e-9), "{found:?}");
    }
}
