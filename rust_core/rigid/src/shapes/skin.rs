//! Parts of a larger surface: which of their faces, edges and vertices are on it, and with which normals.
//!
//! A body that slides from one part to the next must feel no edge between them. A contact counts only if its normal is one of
//! the surface at the feature that touches. A face has its normal, an edge all between those of its two faces. A vertex has
//! all above which none of its edges rises.

use glam::{DMat3, DVec3};

use super::Part;

/// Error of a normal, within which it counts as one of the surface.
const LEVEL: f64 = 1e-6;

/// Surface around the features of a part.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Skin {
    /// Whether each face is on the surface.
    pub faces: Vec<bool>,
    /// Normals of the surface on the left and on the right of each edge on it; empty in 2D.
    pub edges: Vec<Option<[DVec3; 2]>>,
    /// Surroundings of each vertex on the surface.
    pub vertices: Vec<Option<Corner>>,
}

/// Surface around a vertex.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Corner {
    /// Unit directions of the edges from it.
    pub ways: Vec<DVec3>,
    /// Sum of the normals of the faces around it, each times its angle. Of the points to which the vertex is nearest, those outside
    /// are on the side to which it points (J. A. Bærentzen and H. Aanæs, 2005).
    pub outward: DVec3,
}

impl Corner {
    /// Surroundings to which faces are added.
    pub fn new() -> Self {
        Self { ways: Vec::new(), outward: DVec3::ZERO }
    }

    /// Adds a face between two unit directions.
    pub fn add(&mut self, ways: [DVec3; 2], normal: DVec3) {
        let [one, other] = ways;
        self.ways.extend(ways);
        self.outward += normal * libm::atan2(one.cross(other).length(), one.dot(other));
    }
}

impl Skin {
    /// Turns the surface.
    pub fn turn(&mut self, rotation: &DMat3) {
        self.edges.iter_mut().flatten().flatten().for_each(|normal| *normal = *rotation * *normal);
        for corner in self.vertices.iter_mut().flatten() {
            corner.ways.iter_mut().for_each(|way| *way = *rotation * *way);
            corner.outward = *rotation * corner.outward;
        }
    }
}

impl Part {
    /// Whether a direction is a normal of the surface at a face.
    pub fn shows_face(&self, face: usize) -> bool {
        self.skin.as_ref().is_none_or(|skin| skin.faces[face])
    }

    /// Whether a unit direction is a normal of the surface at a vertex.
    pub fn shows_vertex(&self, vertex: usize, direction: DVec3) -> bool {
        let Some(skin) = &self.skin else { return true };
        skin.vertices[vertex].as_ref().is_some_and(|corner| {
            direction.dot(corner.outward) > 0.0 && corner.ways.iter().all(|way| direction.dot(*way) <= LEVEL)
        })
    }

    /// Whether a unit direction is a normal of the surface at an edge.
    pub fn shows_edge(&self, edge: usize, direction: DVec3) -> bool {
        let Some(skin) = &self.skin else { return true };
        let [from, to] = self.edge(edge);
        skin.edges[edge].is_some_and(|[left, right]| {
            let limit = -LEVEL * (to - from).length();
            let turn = |one: DVec3, other: DVec3| one.cross(other).dot(to - from);
            direction.dot(left + right) > 0.0 && turn(left, direction) >= limit && turn(direction, right) >= limit
        })
    }
}
