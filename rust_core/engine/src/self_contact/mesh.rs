//! The meshes of bodies in contact: their vertices, edges and triangles, and which of them may touch.

use std::collections::BTreeMap;

use glam::DVec3;

use super::tree::{Bounds, Tree};
use crate::adjacency::Adjacency;
use crate::parallel::{BlockedSlice, Executor};

/// A triangle, or an edge that belongs to none, whose third vertex is its second.
#[derive(Debug, Clone, Copy)]
pub struct Element {
    /// Vertices, as indices of particles.
    pub vertices: [u32; 3],
    /// Whether it is a triangle.
    pub is_face: bool,
    /// Its body, as an index among those of the meshes.
    pub body: u32,
    /// Of each vertex and each edge, whether this element stands for it.
    owned_vertices: [bool; 3],
    owned_edges: [Option<u32>; 3],
}

/// The contact of two bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rule {
    /// The distance at which it begins [m].
    pub thickness: f64,
    /// Coulomb's coefficient of friction μ.
    pub friction: f64,
    /// The coefficient of restitution e.
    pub restitution: f64,
}

/// Two elements that may touch: a vertex and a triangle, or two edges.
#[derive(Debug, Clone, Copy)]
pub struct Pair {
    /// The particles: a vertex and the corners of a triangle, or the ends of two edges.
    pub nodes: [u32; 4],
    /// The same for a pair in all steps: 0 or 1 for the kind, and the indices of both.
    pub key: u64,
    pub rule: u32,
}

impl Pair {
    /// Whether it is a vertex and a triangle.
    #[inline(always)]
    pub fn has_face(&self) -> bool {
        self.key >> 63 == 1
    }

    /// The number of vertices of the first element.
    #[inline(always)]
    pub fn split(&self) -> usize {
        if self.has_face() { 1 } else { 2 }
    }

    /// The vectors of its particles.
    #[inline(always)]
    pub fn gather(&self, vectors: &[DVec3]) -> [DVec3; 4] {
        self.nodes.map(|node| vectors[node as usize])
    }
}

/// The meshes.
#[derive(Debug, Clone, Default)]
pub struct Mesh {
    pub elements: Vec<Element>,
    /// Ends of each edge, and the vertices opposite to it in up to two triangles; its own end where there is none.
    pub edges: Vec<[u32; 2]>,
    pub opposite: Vec<[u32; 2]>,
    /// The neighbors of each particle along edges.
    neighbors: Adjacency,
    /// The rule of each pair of bodies, as an index, row by row; [`NONE`] for bodies that do not touch.
    rules: Vec<u32>,
    bodies: usize,
    tree: Tree,
    bounds: Vec<Bounds>,
}

/// Bodies that do not touch.
pub const NONE: u32 = u32::MAX;
/// Elements that one thread searches at a time.
const BLOCK: usize = 512;

/// The triangles and the free edges of a body, by their vertices.
pub type Body = (Vec<[u32; 3]>, Vec<[u32; 2]>);

impl Mesh {
    /// The meshes of bodies, each with its triangles and its free edges, of which `rules` has a row and a column each, between
    /// `count` particles.
    pub fn new(bodies: &[Body], rules: Vec<u32>, count: usize, position: impl Fn(u32) -> DVec3) -> Self {
        let mut mesh = Self { rules, bodies: bodies.len(), ..Self::default() };
        let (mut has_vertex, mut numbers) = (vec![false; count], BTreeMap::<[u32; 2], u32>::new());
        for ((faces, edges), body) in bodies.iter().zip(0..) {
            let faces = faces.iter().map(|&face| (face, true));
            for (vertices, is_face) in faces.chain(edges.iter().map(|&[one, other]| ([one, other, other], false))) {
                mesh.add(vertices, is_face, body, (&mut has_vertex, &mut numbers));
            }
        }
        mesh.neighbors = Adjacency::of_graph(count, mesh.edges.iter().copied());
        let center = |element: &Element| element.vertices.iter().map(|&vertex| position(vertex)).sum::<DVec3>() / 3.0;
        mesh.tree = Tree::new(&mesh.elements.iter().map(center).collect::<Vec<_>>());
        mesh
    }

    fn add(
        &mut self,
        vertices: [u32; 3],
        is_face: bool,
        body: u32,
        (has_vertex, numbers): (&mut [bool], &mut BTreeMap<[u32; 2], u32>),
    ) {
        let size = if is_face { 3 } else { 2 };
        let mut element = Element { vertices, is_face, body, owned_vertices: [false; 3], owned_edges: [None; 3] };
        for corner in 0..size {
            let [vertex, next] = [vertices[corner], vertices[(corner + 1) % 3]];
            element.owned_vertices[corner] = !std::mem::replace(&mut has_vertex[vertex as usize], true);
            if !is_face && corner == 1 {
                break;
            }
            let key = [vertex.min(next), vertex.max(next)];
            let opposite = if is_face { vertices[(corner + 2) % 3] } else { vertex };
            if let Some(&edge) = numbers.get(&key) {
                self.opposite[edge as usize][1] = opposite;
            } else {
                let edge = self.edges.len() as u32;
                numbers.insert(key, edge);
                element.owned_edges[corner] = Some(edge);
                self.edges.push(key);
                self.opposite.push([opposite, key[0]]);
            }
        }
        self.elements.push(element);
    }

    /// The vertices, each once.
    pub fn vertices(&self) -> impl Iterator<Item = u32> {
        let owned = |element: &Element| {
            (0..3).filter(|&corner| element.owned_vertices[corner]).map(|corner| element.vertices[corner]).collect::<Vec<u32>>()
        };
        self.elements.iter().flat_map(owned)
    }

    /// The neighbors of a particle along edges, in the order of these.
    #[inline(always)]
    pub fn neighbors(&self, vertex: u32) -> &[u32] {
        self.neighbors.of(vertex as usize)
    }

    /// The pairs of elements without common vertices that may touch where each vertex stays in its box, each larger by `margin`.
    pub fn pairs(&mut self, boxes: &[Bounds], margin: f64, executor: &Executor) -> Vec<Pair> {
        let around = |vertices: &[u32]| {
            let union = vertices.iter().fold(Bounds::EMPTY, |sum, &vertex| sum.union(&boxes[vertex as usize]));
            Bounds { low: union.low - margin, high: union.high + margin }
        };
        self.bounds.clear();
        self.bounds.extend(self.elements.iter().map(|element| around(&element.vertices)));
        self.tree.refit(&self.bounds);
        let mesh = &*self;
        let mut found: Vec<Vec<Pair>> = vec![Vec::new(); mesh.elements.len().div_ceil(BLOCK)];
        let work = BlockedSlice::new(&mut found, 1);
        executor.for_each_block(work, &|work: BlockedSlice<'_, Vec<Pair>>| {
            let (first, mut near) = (work.start * BLOCK, Vec::new());
            for index in first..(first + BLOCK).min(mesh.elements.len()) {
                mesh.search(index, &around, &mut near, &mut work.items[0]);
            }
        });
        found.concat()
    }

    /// Adds the pairs of one element with those after it, in the order of these, so that it does not depend on the tree.
    #[inline]
    fn search(&self, index: usize, around: &impl Fn(&[u32]) -> Bounds, near: &mut Vec<u32>, found: &mut Vec<Pair>) {
        let (one, bounds) = (&self.elements[index], &self.bounds[index]);
        near.clear();
        self.tree.query(bounds, |other| {
            if other as usize > index && self.bounds[other as usize].overlaps(bounds) {
                near.push(other);
            }
        });
        near.sort_unstable();
        for &other in &*near {
            let second = &self.elements[other as usize];
            let rule = self.rules[one.body as usize * self.bodies + second.body as usize];
            if rule == NONE {
                continue;
            }
            self.vertices_on_face((one, second), other, rule, around, found);
            self.vertices_on_face((second, one), index as u32, rule, around, found);
            for (edge, ends) in edges_of(one) {
                let part = around(&ends);
                for (facing, far) in edges_of(second) {
                    let apart = ends.iter().all(|end| !far.contains(end));
                    if apart && part.overlaps(&around(&far)) {
                        let (low, high) = (edge.min(facing), edge.max(facing));
                        let [a, b] = if edge == low { [ends, far] } else { [far, ends] };
                        found.push(Pair { nodes: [a[0], a[1], b[0], b[1]], key: u64::from(low) << 32 | u64::from(high), rule });
                    }
                }
            }
        }
    }

    #[inline]
    fn vertices_on_face(
        &self,
        (one, face): (&Element, &Element),
        index: u32,
        rule: u32,
        around: &impl Fn(&[u32]) -> Bounds,
        found: &mut Vec<Pair>,
    ) {
        if !face.is_face {
            return;
        }
        for corner in 0..3 {
            let vertex = one.vertices[corner];
            if one.owned_vertices[corner]
                && !face.vertices.contains(&vertex)
                && around(&[vertex]).overlaps(&self.bounds[index as usize])
            {
                let [a, b, c] = face.vertices;
                let key = 1 << 63 | u64::from(vertex) << 32 | u64::from(index);
                found.push(Pair { nodes: [vertex, a, b, c], key, rule });
            }
        }
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        let edges = 2 * size_of_val(self.edges.as_slice());
        size_of_val(self.elements.as_slice())
            + edges
            + self.neighbors.bytes()
            + size_of_val(self.bounds.as_slice())
            + self.tree.bytes()
    }
}

/// The edges that an element stands for, with their ends.
fn edges_of(element: &Element) -> impl Iterator<Item = (u32, [u32; 2])> {
    let vertices = element.vertices;
    (0..3)
        .filter_map(move |corner| element.owned_edges[corner].map(|edge| (edge, [vertices[corner], vertices[(corner + 1) % 3]])))
}
