//! Meshes of bodies in contact: vertices, edges and triangles, and which of them may touch.

use std::collections::BTreeMap;

use glam::{DVec3, Vec3, Vec3A};

use super::distance::{Closest, edge_edge, vertex_face};
use super::tree::{BoundingVolumeTree, SweptBox};
use crate::adjacency::Adjacency;
use crate::parallel::{BlockedSlice, Executor};

/// A triangle, or an edge without a triangle. The third vertex of an edge is its second.
#[derive(Debug, Clone, Copy)]
pub struct MeshElement {
    /// Vertices, as indices of particles.
    pub vertices: [u32; 3],
    /// Whether the element is a triangle.
    pub is_face: bool,
    /// Body of the element, as an index among the bodies of the meshes.
    pub body: u32,
    /// Vertices and edges assigned to this element.
    own_vertices: FewNumbers,
    own_edges: FewNumbers,
}

/// Up to three numbers.
#[derive(Debug, Clone, Copy, Default)]
struct FewNumbers {
    numbers: [u32; 3],
    count: u32,
}

impl FewNumbers {
    fn push(&mut self, number: u32) {
        self.numbers[self.count as usize] = number;
        self.count += 1;
    }

    #[inline(always)]
    fn as_slice(&self) -> &[u32] {
        &self.numbers[..self.count as usize]
    }
}

/// Contact rule of two bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactRule {
    /// Thickness: the distance at which contact begins [m].
    pub thickness: f64,
    /// Coulomb's coefficient of friction μ.
    pub friction: f64,
    /// Coefficient of restitution e.
    pub restitution: f64,
}

/// Two elements that may touch: a vertex and a triangle, or two edges.
#[derive(Debug, Clone, Copy)]
pub struct ElementPair {
    /// Particles: a vertex and the corners of a triangle, or the ends of two edges.
    pub nodes: [u32; 4],
    /// Identifier of the pair in all steps: 0 or 1 for the kind, and the indices of both elements.
    pub key: u64,
    pub rule: u32,
}

impl ElementPair {
    /// Whether the pair is a vertex and a triangle.
    #[inline(always)]
    pub fn has_face(&self) -> bool {
        self.key >> 63 == 1
    }

    /// Number of vertices of the first element.
    #[inline(always)]
    pub fn split(&self) -> usize {
        if self.has_face() { 1 } else { 2 }
    }

    /// Closest points of the pair at these positions.
    #[inline(always)]
    pub fn measure(&self, x: &[DVec3; 4]) -> Closest {
        if self.has_face() { vertex_face(x) } else { edge_edge(x) }
    }

    /// Vectors of the pair's particles.
    #[inline(always)]
    pub fn gather(&self, vectors: &[DVec3]) -> [DVec3; 4] {
        self.nodes.map(|node| vectors[node as usize])
    }
}

/// Meshes of all bodies.
#[derive(Debug, Clone, Default)]
pub struct Mesh {
    pub elements: Vec<MeshElement>,
    /// Ends of each edge, and the vertices opposite to it in up to two triangles. An end of the edge stands for a missing
    /// vertex.
    pub edges: Vec<[u32; 2]>,
    pub opposite: Vec<[u32; 2]>,
    /// Neighbors of each particle along edges.
    neighbors: Adjacency,
    /// Rule of each pair of bodies, as an index, row by row; [`NONE`] for bodies that do not touch.
    rules: Vec<u32>,
    bodies: usize,
    /// Body of each particle.
    body_of: Vec<u32>,
    tree: BoundingVolumeTree,
    /// Boxes around the elements in the tree's order; whether a vertex of the element has changed; boxes around the edges.
    boxes: Vec<SweptBox>,
    changed: Vec<bool>,
    edge_boxes: Vec<SweptBox>,
}

/// Flag of a vertex and a triangle in the higher half of a key.
const HAS_FACE: u32 = 1 << 31;
/// Index of the rule for bodies that do not touch.
pub const NONE: u32 = u32::MAX;
/// Number of tree nodes that one thread searches at a time.
const BLOCK: usize = 512;

/// Triangles and free edges of a body, by their vertices.
pub type BodyMesh = (Vec<[u32; 3]>, Vec<[u32; 2]>);

impl Mesh {
    /// Builds the meshes of bodies from their triangles and free edges, between `count` particles. `rules` has a row and a
    /// column for each body.
    pub fn new(bodies: &[BodyMesh], rules: Vec<u32>, count: usize) -> Self {
        let mut mesh = Self { rules, bodies: bodies.len(), body_of: vec![0; count], ..Self::default() };
        let (mut has_vertex, mut numbers) = (vec![false; count], BTreeMap::<[u32; 2], u32>::new());
        for ((faces, edges), body) in bodies.iter().zip(0..) {
            let faces = faces.iter().map(|&face| (face, true));
            for (vertices, is_face) in faces.chain(edges.iter().map(|&[one, other]| ([one, other, other], false))) {
                mesh.add(vertices, is_face, body, (&mut has_vertex, &mut numbers));
            }
        }
        mesh.neighbors = Adjacency::of_graph(count, mesh.edges.iter().copied());
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
        let mut element =
            MeshElement { vertices, is_face, body, own_vertices: FewNumbers::default(), own_edges: FewNumbers::default() };
        for corner in 0..size {
            let [vertex, next] = [vertices[corner], vertices[(corner + 1) % 3]];
            if !std::mem::replace(&mut has_vertex[vertex as usize], true) {
                element.own_vertices.push(vertex);
                self.body_of[vertex as usize] = body;
            }
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
                element.own_edges.push(edge);
                self.edges.push(key);
                self.opposite.push([opposite, key[0]]);
            }
        }
        self.elements.push(element);
    }

    /// Vertices of the meshes, each once.
    pub fn vertices(&self) -> impl Iterator<Item = u32> {
        self.elements.iter().flat_map(|element| element.own_vertices.as_slice()).copied()
    }

    /// Neighbors of a particle along edges, in the order of the edges.
    #[inline(always)]
    pub fn neighbors(&self, vertex: u32) -> &[u32] {
        self.neighbors.of(vertex as usize)
    }

    /// Pair with a key; None if there is no such pair any more.
    pub fn pair(&self, key: u64) -> Option<ElementPair> {
        let (high, low) = ((key >> 32) as u32 & !HAS_FACE, key as u32);
        let nodes = if key >> 63 == 1 {
            let [a, b, c] = self.elements.get(low as usize).filter(|element| element.is_face)?.vertices;
            [high, a, b, c]
        } else {
            let [[a, b], [c, d]] = [*self.edges.get(high as usize)?, *self.edges.get(low as usize)?];
            [a, b, c, d]
        };
        let [one, other] = [nodes[0], nodes[3]].map(|node| self.body_of.get(node as usize).copied());
        let rule = self.rules[one? as usize * self.bodies + other? as usize];
        let apart =
            if key >> 63 == 1 { !nodes[1..].contains(&high) } else { !nodes[2..].iter().any(|end| nodes[..2].contains(end)) };
        (rule != NONE && apart).then_some(ElementPair { nodes, key, rule })
    }

    /// Sorts the elements in space, for the searches of a step.
    pub fn sort(&mut self, position: impl Fn(u32) -> DVec3) {
        let center =
            |element: &MeshElement| Vec3A::from(element.vertices.iter().map(|&vertex| position(vertex).as_vec3()).sum::<Vec3>());
        self.tree.build(&self.elements.iter().map(center).collect::<Vec<_>>());
    }

    /// Calls `each` with the pairs of elements whose boxes overlap; `boxes` are those of all particles. The elements have no
    /// common vertices, and one of them has a vertex with `changed`. Results of `each` are collected in `found`, block by
    /// block.
    pub fn pairs<T: Send + Clone>(
        &mut self,
        boxes: &[SweptBox],
        changed: &[bool],
        executor: &Executor,
        found: &mut Vec<Vec<T>>,
        each: &(impl Fn(ElementPair, &SweptBox, &SweptBox) -> Option<T> + Sync),
    ) {
        let around = |vertices: &[u32]| vertices.iter().fold(SweptBox::EMPTY, |sum, &vertex| sum.union(&boxes[vertex as usize]));
        let has_changed = |nodes: &[u32]| nodes.iter().any(|&node| changed[node as usize]);
        let elements = self.tree.order().iter().map(|&element| &self.elements[element as usize].vertices);
        self.boxes.clear();
        self.boxes.extend(elements.clone().map(|vertices| around(vertices)));
        self.changed.clear();
        self.changed.extend(elements.map(|vertices| has_changed(vertices)));
        self.edge_boxes.clear();
        self.edge_boxes.extend(self.edges.iter().map(|ends| around(ends)));
        self.tree.refit(|place| (self.boxes[place].hull(), self.changed[place]));
        let mesh = &*self;
        found.resize(mesh.tree.nodes().div_ceil(BLOCK), Vec::new());
        found.iter_mut().for_each(Vec::clear);
        let work = BlockedSlice::new(found, 1);
        executor.for_each_block(work, &|work: BlockedSlice<'_, Vec<T>>| {
            let first = work.start * BLOCK;
            let mut take = |pair: ElementPair, one: &SweptBox, other: &SweptBox| {
                if has_changed(&pair.nodes) {
                    work.items[0].extend(each(pair, one, other));
                }
            };
            for node in first..(first + BLOCK).min(mesh.tree.nodes()) {
                mesh.tree.query(node, |some, others, around| {
                    for one in some.clone() {
                        let part = &mesh.boxes[one];
                        // Among the elements of one leaf, each pair once.
                        let rest = if some == others { one + 1..others.end } else { others.clone() };
                        if !part.hull().overlaps(around) {
                            continue;
                        }
                        for other in rest {
                            if (mesh.changed[one] || mesh.changed[other]) && part.overlaps(&mesh.boxes[other]) {
                                mesh.pairs_of([one, other], boxes, &mut take);
                            }
                        }
                    }
                });
            }
        });
    }

    /// Calls `found` with the pairs of two elements, given by their places in the tree's order.
    #[inline]
    fn pairs_of(&self, places: [usize; 2], boxes: &[SweptBox], found: &mut impl FnMut(ElementPair, &SweptBox, &SweptBox)) {
        let [one, other] = places.map(|place| self.tree.order()[place]);
        let (first, second) = (&self.elements[one as usize], &self.elements[other as usize]);
        let rule = self.rules[first.body as usize * self.bodies + second.body as usize];
        if rule == NONE {
            return;
        }
        vertices_on_face((first, second), (other, &self.boxes[places[1]]), rule, boxes, found);
        vertices_on_face((second, first), (one, &self.boxes[places[0]]), rule, boxes, found);
        for &edge in first.own_edges.as_slice() {
            let (ends, part) = (self.edges[edge as usize], &self.edge_boxes[edge as usize]);
            for &facing in second.own_edges.as_slice() {
                let (far, opposite) = (self.edges[facing as usize], &self.edge_boxes[facing as usize]);
                if ends.iter().any(|end| far.contains(end)) || !part.overlaps(opposite) {
                    continue;
                }
                let key = |low: u32, high: u32| u64::from(low) << 32 | u64::from(high);
                let ([a, b], [c, d]) = (ends, far);
                if edge < facing {
                    found(ElementPair { nodes: [a, b, c, d], key: key(edge, facing), rule }, part, opposite);
                } else {
                    found(ElementPair { nodes: [c, d, a, b], key: key(facing, edge), rule }, opposite, part);
                }
            }
        }
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        let edges = 2 * size_of_val(self.edges.as_slice());
        size_of_val(self.elements.as_slice())
            + edges
            + self.neighbors.bytes()
            + size_of_val(self.boxes.as_slice())
            + size_of_val(self.edge_boxes.as_slice())
            + self.tree.bytes()
    }
}

/// Calls `found` with the vertices of one element that may touch a face.
#[inline]
fn vertices_on_face(
    (one, face): (&MeshElement, &MeshElement),
    (index, around): (u32, &SweptBox),
    rule: u32,
    boxes: &[SweptBox],
    found: &mut impl FnMut(ElementPair, &SweptBox, &SweptBox),
) {
    if !face.is_face {
        return;
    }
    for &vertex in one.own_vertices.as_slice() {
        let point = &boxes[vertex as usize];
        if !face.vertices.contains(&vertex) && point.overlaps(around) {
            let [a, b, c] = face.vertices;
            let key = 1 << 63 | u64::from(vertex) << 32 | u64::from(index);
            found(ElementPair { nodes: [vertex, a, b, c], key, rule }, point, around);
        }
    }
}
