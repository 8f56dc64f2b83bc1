//! Unions of convex parts.

use std::f64::consts::TAU;

use glam::DVec3;

use super::tree::PartTree;
use super::{BoundingBox, Part};
use crate::pose::Pose;

/// Number of parts from which on a tree finds those near a place.
const MANY: usize = 8;

/// Convex parts of a shape, at least one.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ConvexParts {
    pub all: Vec<Part>,
    /// Boxes of the parts in the frame of the body, and a tree of them; empty if there are few parts.
    boxes: Vec<BoundingBox>,
    tree: PartTree,
}

impl ConvexParts {
    pub fn new(all: Vec<Part>) -> Self {
        let boxes: Vec<BoundingBox> =
            if all.len() < MANY { Vec::new() } else { all.iter().map(|part| part.bounds(&Pose::WORLD)).collect() };
        let tree = PartTree::new(&boxes);
        Self { all, boxes, tree }
    }

    /// The part, if there is one alone.
    #[inline]
    pub fn single(&self) -> Option<&Part> {
        if let [part] = &self.all[..] { Some(part) } else { None }
    }

    /// Calls `visit` with the parts whose boxes overlap another, in the frame of the body.
    pub fn near(&self, bounds: &BoundingBox, visit: &mut dyn FnMut(&Part)) {
        if self.boxes.is_empty() {
            self.all.iter().for_each(visit);
            return;
        }
        self.tree.near(bounds, |index| {
            if self.boxes[index].overlaps(bounds) {
                visit(&self.all[index]);
            }
        });
    }

    /// Whether the triangles among the parts enclose a point, by the sum of their solid angles (A. van Oosterom and J. Strackee,
    /// 1983).
    pub fn enclose(&self, point: DVec3) -> bool {
        let angle = |[a, b, c]: [DVec3; 3]| {
            let [x, y, z] = [a.length(), b.length(), c.length()];
            2.0 * libm::atan2(a.dot(b.cross(c)), x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y)
        };
        let triangles = self.all.iter().filter_map(Part::leaf_corners);
        triangles.map(|corners| angle(corners.map(|corner| corner - point))).sum::<f64>() > TAU
    }

    /// Box around the parts at a pose: around their own, or around that of their union if they are many.
    pub fn bounds(&self, pose: &Pose) -> BoundingBox {
        match self.tree.bounds() {
            Some(bounds) => bounds.moved(pose),
            None => self.all.iter().map(|part| part.bounds(pose)).fold(BoundingBox::NOWHERE, BoundingBox::union),
        }
    }
}
