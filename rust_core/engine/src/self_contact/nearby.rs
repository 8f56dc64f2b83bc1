//! The pairs that may touch in a step, wherever impulses lead the vertices.

use std::cmp::Ordering;

use glam::DVec3;

use super::distance::Closest;
use super::mesh::{Mesh, Pair, Rule};
use super::tree::{Bounds, Swept};
use crate::parallel::Executor;

/// By how much impulses may lead a vertex beyond its way before its pairs are searched again, in units of the thickness.
const SLACK: f64 = 0.25;

/// A pair that may come nearer than the thickness, and its closest points at the start of the step.
#[derive(Debug, Clone, Copy)]
pub struct Near {
    pub pair: Pair,
    pub closest: Closest,
    /// [m]
    pub distance: f64,
}

impl Near {
    /// The order of distances, which neither the axes nor the numbers of the particles change.
    pub fn order(&self, other: &Self) -> Ordering {
        self.distance.total_cmp(&other.distance).then(self.pair.key.cmp(&other.pair.key))
    }
}

/// The pairs near each other on the ways of all vertices.
#[derive(Debug, Clone, Default)]
pub struct Nearby {
    /// The pairs.
    pub pairs: Vec<Near>,
    /// Those that each block of a search has found.
    found: Vec<Vec<Near>>,
    /// The particles at the start of the step, and the displacements that were looked at [m].
    boxes: Vec<Swept>,
    /// The vertices whose displacements are new.
    changed: Vec<bool>,
    /// A velocity that all have in common [m/s].
    drift: DVec3,
    slack: f64,
    searched: bool,
}

impl Nearby {
    /// Takes the start of a step of `h` seconds: vertices either move freely or go on with their velocities, or something between.
    pub fn begin(&mut self, vertices: &[u32], start: &[DVec3], [free, before]: [&[DVec3]; 2], h: f64, thickness: f64) {
        self.pairs.clear();
        self.slack = SLACK * thickness;
        self.drift = vertices.iter().map(|&vertex| free[vertex as usize]).sum::<DVec3>() / vertices.len() as f64;
        self.boxes.clear();
        self.boxes.resize(start.len(), Swept::EMPTY);
        self.changed.clear();
        self.changed.resize(start.len(), true);
        self.searched = false;
        for vertex in vertices.iter().map(|&vertex| vertex as usize) {
            let [one, other] = [free, before].map(|velocity| Bounds::around(h * (velocity[vertex] - self.drift), self.slack));
            self.boxes[vertex] = Swept { from: Bounds::around(start[vertex], 0.5 * thickness), way: one.union(&other) };
        }
    }

    /// Searches the pairs anew of the vertices that leave their ways with these velocities.
    pub fn cover(
        &mut self,
        (mesh, rules): (&mut Mesh, &[Rule]),
        vertices: &[u32],
        (start, velocities): (&[DVec3], &[DVec3]),
        h: f64,
        executor: &Executor,
    ) {
        if self.searched {
            for vertex in vertices.iter().map(|&vertex| vertex as usize) {
                let (to, way) = (h * (velocities[vertex] - self.drift), &mut self.boxes[vertex].way);
                self.changed[vertex] = !way.contains(&Bounds::around(to, 0.0));
                if self.changed[vertex] {
                    // As far again as it went too far, for a vertex that others push on and on.
                    *way = way.union(&Bounds::around(to, self.slack + way.distance(to)));
                }
            }
            if !vertices.iter().any(|&vertex| self.changed[vertex as usize]) {
                return;
            }
            let changed = &self.changed;
            self.pairs.retain(|near| !near.pair.nodes.iter().any(|&node| changed[node as usize]));
        }
        self.searched = true;
        mesh.pairs(&self.boxes, &self.changed, executor, &mut self.found, &|pair, one, other| {
            let closest = pair.measure(&pair.gather(start));
            let (distance, reach) = (closest.separation.length(), one.relative(other).reach());
            (distance < rules[pair.rule as usize].thickness + reach).then_some(Near { pair, closest, distance })
        });
        self.found.iter().for_each(|found| self.pairs.extend_from_slice(found));
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        let found: usize = self.found.iter().map(|found| size_of_val(found.as_slice())).sum();
        found + size_of_val(self.pairs.as_slice()) + size_of_val(self.boxes.as_slice()) + size_of_val(self.changed.as_slice())
    }
}
