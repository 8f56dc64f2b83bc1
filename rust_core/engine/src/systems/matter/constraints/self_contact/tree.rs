//! Binary tree of boxes around the elements of a mesh. Its topology follows from the positions of the elements at the start,
//! its boxes from their present positions.

use std::ops::Range;

use glam::{DVec3, Vec3A};

/// Maximum number of elements in a leaf.
const LEAF: usize = 8;

/// Margin of a box for the rounding of its corners and of sums of a few corners, relative to these: 8 half units of the last
/// place.
const ROUNDING: f32 = 4.0 * f32::EPSILON;

/// Axis-aligned box in single precision, rounded outward.
#[derive(Debug, Clone, Copy)]
pub struct AxisAlignedBox {
    low: Vec3A,
    high: Vec3A,
}

impl AxisAlignedBox {
    pub const EMPTY: Self = Self { low: Vec3A::INFINITY, high: Vec3A::NEG_INFINITY };

    /// Box around a point, with a `margin` [m] on all sides.
    #[inline(always)]
    pub fn around(point: DVec3, margin: f64) -> Self {
        let (low, high) = (Vec3A::from((point - margin).as_vec3()), Vec3A::from((point + margin).as_vec3()));
        Self { low: low - ROUNDING * low.abs(), high: high + ROUNDING * high.abs() }
    }

    #[inline(always)]
    pub fn union(&self, other: &Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    #[inline(always)]
    pub fn overlaps(&self, other: &Self) -> bool {
        (self.low.cmple(other.high) & other.low.cmple(self.high)).all()
    }

    /// Whether another box is within this one.
    #[inline(always)]
    pub fn contains(&self, other: &Self) -> bool {
        (self.low.cmple(other.low) & other.high.cmple(self.high)).all()
    }

    /// Distance of a point from the box [m].
    pub fn distance(&self, point: DVec3) -> f64 {
        let point = Vec3A::from(point.as_vec3());
        f64::from((self.low - point).max(point - self.high).max(Vec3A::ZERO).length())
    }

    /// Largest component of a point in the box along a direction [m].
    #[inline(always)]
    pub fn support(&self, direction: DVec3) -> f64 {
        let (low, high) = (direction * self.low.as_dvec3(), direction * self.high.as_dvec3());
        low.max(high).element_sum()
    }
}

/// Box around an element at the start of a step, and box around the displacements of its points.
#[derive(Debug, Clone, Copy)]
pub struct SweptBox {
    pub from: AxisAlignedBox,
    pub way: AxisAlignedBox,
}

impl SweptBox {
    pub const EMPTY: Self = Self { from: AxisAlignedBox::EMPTY, way: AxisAlignedBox::EMPTY };

    #[inline(always)]
    pub fn union(&self, other: &Self) -> Self {
        Self { from: self.from.union(&other.from), way: self.way.union(&other.way) }
    }

    /// Box around the element on its path.
    #[inline(always)]
    pub fn hull(&self) -> AxisAlignedBox {
        let (low, high) = (self.way.low.min(Vec3A::ZERO), self.way.high.max(Vec3A::ZERO));
        AxisAlignedBox { low: self.from.low + low, high: self.from.high + high }
    }

    /// Displacements of another element relative to this one.
    #[inline(always)]
    pub fn relative(&self, other: &Self) -> AxisAlignedBox {
        AxisAlignedBox { low: other.way.low - self.way.high, high: other.way.high - self.way.low }
    }

    /// Whether the elements may touch. A common displacement does not bring them together.
    #[inline(always)]
    pub fn overlaps(&self, other: &Self) -> bool {
        self.from.overlaps(&Self { from: other.from, way: self.relative(other) }.hull())
    }
}

/// Node in depth-first order: its box, and the next node that is not below it.
#[derive(Debug, Clone, Copy)]
struct TreeNode {
    bounds: AxisAlignedBox,
    skip: u32,
    /// Elements of a leaf, in the tree's order; an inner node has none.
    start: u32,
    count: u32,
    /// Whether an element in the node has changed.
    changed: bool,
}

impl TreeNode {
    /// Places of the node's elements in the tree's order.
    #[inline(always)]
    fn elements(&self) -> Range<usize> {
        self.start as usize..(self.start + self.count) as usize
    }
}

/// Bounding-volume tree of elements.
#[derive(Debug, Clone, Default)]
pub struct BoundingVolumeTree {
    nodes: Vec<TreeNode>,
    /// Elements, leaf by leaf.
    order: Vec<u32>,
}

impl BoundingVolumeTree {
    /// Builds the tree of elements with these centers.
    pub fn build(&mut self, centers: &[Vec3A]) {
        self.nodes.clear();
        self.order.clear();
        self.order.extend(0..centers.len() as u32);
        if !centers.is_empty() {
            self.split(centers, 0, centers.len());
        }
    }

    /// Adds the node of a part of the elements, halved along the longest axis.
    fn split(&mut self, centers: &[Vec3A], start: usize, end: usize) {
        let at = self.nodes.len();
        let count = if end - start <= LEAF { (end - start) as u32 } else { 0 };
        self.nodes.push(TreeNode { bounds: AxisAlignedBox::EMPTY, skip: 0, start: start as u32, count, changed: false });
        if count == 0 {
            let part = &mut self.order[start..end];
            let center = |element: &u32| centers[*element as usize];
            let low = part.iter().map(center).fold(Vec3A::INFINITY, Vec3A::min);
            let size = (part.iter().map(center).fold(Vec3A::NEG_INFINITY, Vec3A::max) - low).to_array();
            let axis = (1..3).fold(0, |axis, other| if size[other] > size[axis] { other } else { axis });
            let half = (end - start) / 2;
            let key = |element: &u32| centers[*element as usize].to_array()[axis];
            part.select_nth_unstable_by(half, |one, other| key(one).total_cmp(&key(other)).then(one.cmp(other)));
            self.split(centers, start, start + half);
            self.split(centers, start + half, end);
        }
        self.nodes[at].skip = self.nodes.len() as u32;
    }

    /// Updates the boxes of the tree from the boxes of its elements, in the tree's order, and whether these have changed.
    pub fn refit(&mut self, element: impl Fn(usize) -> (AxisAlignedBox, bool)) {
        for at in (0..self.nodes.len()).rev() {
            let node = self.nodes[at];
            let (bounds, changed) = if node.count > 0 {
                let join = |sum: (AxisAlignedBox, bool), part: (AxisAlignedBox, bool)| (sum.0.union(&part.0), sum.1 || part.1);
                node.elements().map(&element).fold((AxisAlignedBox::EMPTY, false), join)
            } else {
                let [left, right] = [at + 1, self.nodes[at + 1].skip as usize].map(|child| &self.nodes[child]);
                (left.bounds.union(&right.bounds), left.changed || right.changed)
            };
            (self.nodes[at].bounds, self.nodes[at].changed) = (bounds, changed);
        }
    }

    /// Elements in the tree's order.
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// Number of nodes.
    pub fn nodes(&self) -> usize {
        self.nodes.len()
    }

    /// Finds the leaves whose boxes overlap the box of a node, from this node on; an inner node finds none. One of the two
    /// leaves has a changed element. Calls `each` with the elements of both, by their places in the tree's order, and the box
    /// of the second leaf.
    #[inline]
    pub fn query(&self, node: usize, mut each: impl FnMut(Range<usize>, Range<usize>, &AxisAlignedBox)) {
        let leaf = &self.nodes[node];
        let mut at = node;
        while at < self.nodes.len() && leaf.count > 0 {
            let other = &self.nodes[at];
            let touches = (leaf.changed || other.changed) && leaf.bounds.overlaps(&other.bounds);
            if touches && other.count > 0 {
                each(leaf.elements(), other.elements(), &other.bounds);
            }
            at = if touches { at + 1 } else { other.skip as usize };
        }
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        size_of_val(self.nodes.as_slice()) + size_of_val(self.order.as_slice())
    }
}
