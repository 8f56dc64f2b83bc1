//! The pairs that may touch in a step, wherever impulses lead the vertices.

use std::cmp::Ordering;

use glam::DVec3;

use super::distance::Closest;
use super::mesh::{Mesh, Pair, Rule};
use super::tree::{Bounds, Swept};
use crate::parallel::Executor;

/// By how much impulses may lead a vertex beyond its way before its pairs are searched again, in units of the thickness.
const SLACK: f64 = 0.25;

/// A pair that may come nearer than the thickness, at the start of the step.
#[derive(Debug, Clone, Copy)]
pub struct Near {
    pub pair: Pair,
    /// The direction from the closest point of the second element to that of the first.
    pub normal: DVec3,
    /// The distance of the closest points [m].
    pub distance: f64,
}

impl Near {
    /// A pair with its closest points.
    #[inline(always)]
    pub fn new(pair: Pair, closest: &Closest) -> Self {
        let distance = closest.separation.length();
        let normal = if distance > 0.0 { closest.separation / distance } else { DVec3::ZERO };
        Self { pair, normal, distance }
    }

    /// The order of distances, which neither the axes nor the numbers of the particles change.
    pub fn order(&self, other: &Self) -> Ordering {
        self.distance.total_cmp(&other.distance).then(self.pair.key.cmp(&other.pair.key))
    }

    /// A lower bound of the distance [m] at all times of a step of `h` seconds: planes across the normal through the closest points have
    /// the elements on their outer sides at the start, and the width of such a slab between straight paths is concave in time.
    #[inline(always)]
    pub fn least(&self, velocities: &[DVec3], h: f64) -> f64 {
        let along = self.pair.nodes.map(|node| self.normal.dot(velocities[node as usize]));
        self.distance + h * self.slab(along)
    }

    /// The same with each vertex's own place along the normal, for positions and ways [m].
    pub fn least_of_vertices(&self, x: &[DVec3; 4], ways: &[DVec3; 4]) -> f64 {
        let along = std::array::from_fn(|node| self.normal.dot(x[node] - x[0] + ways[node]));
        self.slab(along)
    }

    /// The width between the first element and the second, whose vertices are at these places.
    #[inline(always)]
    fn slab(&self, [a, b, c, d]: [f64; 4]) -> f64 {
        let (low, high) = if self.pair.has_face() { (a, b.max(c)) } else { (a.min(b), c) };
        low - high.max(d)
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
    /// Takes the start of a step of `h` seconds, in which vertices have about these velocities.
    pub fn begin(&mut self, vertices: &[u32], (start, velocities): (&[DVec3], &[DVec3]), h: f64, thickness: f64) {
        self.pairs.clear();
        self.slack = SLACK * thickness;
        self.drift = vertices.iter().map(|&vertex| velocities[vertex as usize]).sum::<DVec3>() / vertices.len() as f64;
        self.boxes.clear();
        self.boxes.resize(start.len(), Swept::EMPTY);
        self.changed.clear();
        self.changed.resize(start.len(), true);
        self.searched = false;
        for vertex in vertices.iter().map(|&vertex| vertex as usize) {
            let way = Bounds::around(h * (velocities[vertex] - self.drift), self.slack);
            self.boxes[vertex] = Swept { from: Bounds::around(start[vertex], 0.5 * thickness), way };
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
                    // Up to twice as far for a vertex that others push on and on.
                    *way = Bounds::around(to, self.slack + way.distance(to).min(self.slack));
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
            let near = Near::new(pair, &pair.measure(&pair.gather(start)));
            let approach = one.relative(other).support(near.normal);
            // Where closest points coincide, no direction tells how elements approach each other.
            let reached = near.distance - approach < rules[pair.rule as usize].thickness || near.distance <= 0.0;
            reached.then_some(near)
        });
        self.found.iter().for_each(|found| self.pairs.extend_from_slice(found));
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        let found: usize = self.found.iter().map(|found| size_of_val(found.as_slice())).sum();
        found + size_of_val(self.pairs.as_slice()) + size_of_val(self.boxes.as_slice()) + size_of_val(self.changed.as_slice())
    }
}
