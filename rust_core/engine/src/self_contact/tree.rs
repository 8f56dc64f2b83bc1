//! A binary tree of boxes around the elements of a mesh: its topology follows from where they are at the start, its boxes from where
//! they are now.

use glam::DVec3;

/// Elements in a leaf.
const LEAF: usize = 4;

/// A box along the axes.
#[derive(Debug, Clone, Copy)]
pub struct Bounds {
    /// Its corners [m].
    pub low: DVec3,
    pub high: DVec3,
}

impl Bounds {
    pub const EMPTY: Self = Self { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY };

    #[inline(always)]
    pub fn union(&self, other: &Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    #[inline(always)]
    pub fn overlaps(&self, other: &Self) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }

    #[inline(always)]
    pub fn contains(&self, point: DVec3) -> bool {
        self.low.cmple(point).all() && point.cmple(self.high).all()
    }
}

/// A node: its box, and two nodes or the elements of a leaf.
#[derive(Debug, Clone, Copy)]
struct Node {
    bounds: Bounds,
    /// The first element in the tree's order, and their number in a leaf; the right child of an inner node, and 0. Its left child
    /// follows it.
    start: u32,
    count: u32,
}

/// The tree.
#[derive(Debug, Clone, Default)]
pub struct Tree {
    nodes: Vec<Node>,
    /// The elements, leaf by leaf.
    order: Vec<u32>,
}

impl Tree {
    /// A tree of elements with these centers.
    pub fn new(centers: &[DVec3]) -> Self {
        let mut tree = Self { nodes: Vec::new(), order: (0..centers.len() as u32).collect() };
        if !centers.is_empty() {
            tree.split(centers, 0, centers.len());
        }
        tree
    }

    /// Adds the node of a part of the elements, halved along the longest axis.
    fn split(&mut self, centers: &[DVec3], start: usize, end: usize) {
        let at = self.nodes.len();
        let count = if end - start <= LEAF { (end - start) as u32 } else { 0 };
        self.nodes.push(Node { bounds: Bounds::EMPTY, start: start as u32, count });
        if count > 0 {
            return;
        }
        let part = &mut self.order[start..end];
        let center = |element: &u32| centers[*element as usize];
        let low = part.iter().map(center).fold(DVec3::INFINITY, DVec3::min);
        let size = (part.iter().map(center).fold(DVec3::NEG_INFINITY, DVec3::max) - low).to_array();
        let axis = (1..3).fold(0, |axis, other| if size[other] > size[axis] { other } else { axis });
        let half = (end - start) / 2;
        let key = |element: &u32| centers[*element as usize].to_array()[axis];
        part.select_nth_unstable_by(half, |one, other| key(one).total_cmp(&key(other)).then(one.cmp(other)));
        self.split(centers, start, start + half);
        self.nodes[at].start = self.nodes.len() as u32;
        self.split(centers, start + half, end);
    }

    /// Takes boxes of the elements.
    pub fn refit(&mut self, bounds: &[Bounds]) {
        for at in (0..self.nodes.len()).rev() {
            let node = self.nodes[at];
            let part = if node.count > 0 {
                let elements = &self.order[node.start as usize..(node.start + node.count) as usize];
                elements.iter().fold(Bounds::EMPTY, |sum, &element| sum.union(&bounds[element as usize]))
            } else {
                self.nodes[at + 1].bounds.union(&self.nodes[node.start as usize].bounds)
            };
            self.nodes[at].bounds = part;
        }
    }

    /// Calls `each` with every element whose leaf's box overlaps a box, in the tree's order.
    #[inline]
    pub fn query(&self, bounds: &Bounds, mut each: impl FnMut(u32)) {
        let mut stack = [0_u32; 64];
        let mut depth = usize::from(!self.nodes.is_empty());
        while depth > 0 {
            depth -= 1;
            let at = stack[depth] as usize;
            let node = &self.nodes[at];
            if !node.bounds.overlaps(bounds) {
                continue;
            }
            if node.count > 0 {
                self.order[node.start as usize..(node.start + node.count) as usize].iter().for_each(|&element| each(element));
            } else {
                (stack[depth], stack[depth + 1]) = (node.start, at as u32 + 1);
                depth += 2;
            }
        }
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        size_of_val(self.nodes.as_slice()) + size_of_val(self.order.as_slice())
    }
}
