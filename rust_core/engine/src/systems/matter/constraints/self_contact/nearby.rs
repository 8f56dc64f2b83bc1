//! Pairs that may touch in a step, for all paths on which impulses lead the vertices.

use std::cmp::Ordering;

use glam::DVec3;

use super::distance::Closest;
use super::mesh::{ContactRule, ElementPair, Mesh};
use super::tree::{AxisAlignedBox, SweptBox};
use crate::parallel::Executor;

/// Displacement of a vertex beyond its path, by impulses, that triggers a new search of its pairs; in thicknesses.
const SLACK: f64 = 0.25;

/// Pair that may come nearer than the thickness, at the start of the step.
#[derive(Debug, Clone, Copy)]
pub struct Near {
    pub pair: ElementPair,
    /// Direction from the closest point of the second element to the closest point of the first.
    pub normal: DVec3,
    /// Distance of the closest points [m].
    pub distance: f64,
}

impl Near {
    /// Pair with its closest points.
    #[inline(always)]
    pub fn new(pair: ElementPair, closest: &Closest) -> Self {
        let distance = closest.separation.length();
        let normal = if distance > 0.0 { closest.separation / distance } else { DVec3::ZERO };
        Self { pair, normal, distance }
    }

    /// Order of distances, and of keys for equal distances. Neither the axes nor the numbers of the particles change distances.
    pub fn order(&self, other: &Self) -> Ordering {
        self.distance.total_cmp(&other.distance).then(self.pair.key.cmp(&other.pair.key))
    }

    /// Lower bound of the distance [m] at all times of a step of `h` seconds. Consider the planes across the normal through
    /// the closest points. At the start the elements are on their outer sides. Between straight paths the width of such a
    /// slab is concave in time.
    #[inline(always)]
    pub fn least(&self, velocities: &[DVec3], h: f64) -> f64 {
        let along = self.pair.nodes.map(|node| self.normal.dot(velocities[node as usize]));
        self.distance + h * self.slab(along)
    }

    /// Lower bound of the distance [m] at the end of the displacements, from each vertex's own position along the normal.
    pub fn least_of_vertices(&self, x: &[DVec3; 4], ways: &[DVec3; 4]) -> f64 {
        let along = std::array::from_fn(|node| self.normal.dot(x[node] - x[0] + ways[node]));
        self.slab(along)
    }

    /// Width between the first element and the second, from the coordinates of their vertices along the normal.
    #[inline(always)]
    fn slab(&self, [a, b, c, d]: [f64; 4]) -> f64 {
        let (low, high) = if self.pair.has_face() { (a, b.max(c)) } else { (a.min(b), c) };
        low - high.max(d)
    }
}

/// Pairs near each other on the paths of all vertices.
#[derive(Debug, Clone, Default)]
pub struct Nearby {
    /// Pairs found so far.
    pub pairs: Vec<Near>,
    /// Pairs that each block of a search has found.
    found: Vec<Vec<Near>>,
    /// Particles at the start of the step, and the displacements that the search covers [m].
    boxes: Vec<SweptBox>,
    /// Vertices with new displacements.
    changed: Vec<bool>,
    /// Common velocity of all vertices: their mean [m/s].
    drift: DVec3,
    slack: f64,
    searched: bool,
}

impl Nearby {
    /// Starts a step of `h` seconds, in which vertices have about these velocities.
    pub fn begin(&mut self, vertices: &[u32], (start, velocities): (&[DVec3], &[DVec3]), h: f64, thickness: f64) {
        self.pairs.clear();
        self.slack = SLACK * thickness;
        self.drift = vertices.iter().map(|&vertex| velocities[vertex as usize]).sum::<DVec3>() / vertices.len() as f64;
        self.boxes.clear();
        self.boxes.resize(start.len(), SweptBox::EMPTY);
        self.changed.clear();
        self.changed.resize(start.len(), true);
        self.searched = false;
        for vertex in vertices.iter().map(|&vertex| vertex as usize) {
            let way = AxisAlignedBox::around(h * (velocities[vertex] - self.drift), self.slack);
            self.boxes[vertex] = SweptBox { from: AxisAlignedBox::around(start[vertex], 0.5 * thickness), way };
        }
    }

    /// Searches again the pairs of vertices that leave their paths with these velocities.
    pub fn cover(
        &mut self,
        (mesh, rules): (&mut Mesh, &[ContactRule]),
        vertices: &[u32],
        (start, velocities): (&[DVec3], &[DVec3]),
        h: f64,
        executor: &Executor,
    ) {
        if self.searched {
            for vertex in vertices.iter().map(|&vertex| vertex as usize) {
                let (to, way) = (h * (velocities[vertex] - self.drift), &mut self.boxes[vertex].way);
                self.changed[vertex] = !way.contains(&AxisAlignedBox::around(to, 0.0));
                if self.changed[vertex] {
                    // Up to twice the slack, for a vertex that others push repeatedly.
                    *way = AxisAlignedBox::around(to, self.slack + way.distance(to).min(self.slack));
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
            // Coincident closest points do not tell the direction in which elements approach each other.
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
