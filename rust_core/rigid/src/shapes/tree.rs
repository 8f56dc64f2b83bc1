//! Tree of boxes, for parts near a place.

use super::BoundingBox;

/// Largest number of boxes in a leaf.
const LEAF: usize = 4;

/// Binary tree of boxes that do not move.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct PartTree {
    nodes: Vec<PartNode>,
    /// Boxes in the order of the leaves.
    order: Vec<u32>,
}

/// Node with a box around its part of the order.
#[derive(Debug, Clone, PartialEq)]
struct PartNode {
    bounds: BoundingBox,
    start: u32,
    end: u32,
    /// Node of the second half, the first being the next; 0 in a leaf.
    second: u32,
}

impl PartTree {
    /// Tree of boxes, cut at their median along the longest axis.
    pub fn new(boxes: &[BoundingBox]) -> Self {
        let mut tree = Self { nodes: Vec::new(), order: (0..boxes.len() as u32).collect() };
        if !boxes.is_empty() {
            tree.grow(boxes, 0, boxes.len());
        }
        tree
    }

    fn grow(&mut self, boxes: &[BoundingBox], start: usize, end: usize) {
        let part = &mut self.order[start..end];
        let bounds = part.iter().map(|&index| boxes[index as usize]).fold(BoundingBox::NOWHERE, BoundingBox::union);
        let node = self.nodes.len();
        self.nodes.push(PartNode { bounds, start: start as u32, end: end as u32, second: 0 });
        if end - start <= LEAF {
            return;
        }
        let middle = |index: u32| boxes[index as usize].lower + boxes[index as usize].upper;
        let around = part.iter().map(|&index| BoundingBox { lower: middle(index), upper: middle(index) });
        let extent = around.fold(BoundingBox::NOWHERE, BoundingBox::union);
        let axis = (extent.upper - extent.lower).max_position();
        let half = (end - start) / 2;
        part.select_nth_unstable_by(half, |&a, &b| middle(a)[axis].total_cmp(&middle(b)[axis]).then(a.cmp(&b)));
        self.grow(boxes, start, start + half);
        self.nodes[node].second = self.nodes.len() as u32;
        self.grow(boxes, start + half, end);
    }

    /// Box around all boxes; None if there are none.
    pub fn bounds(&self) -> Option<BoundingBox> {
        self.nodes.first().map(|node| node.bounds)
    }

    /// Calls `visit` with boxes that may overlap another, in a fixed order; it checks each itself.
    pub fn near(&self, bounds: &BoundingBox, mut visit: impl FnMut(usize)) {
        let mut open = vec![0];
        while let Some(index) = open.pop() {
            let Some(node) = self.nodes.get(index) else { return };
            if !node.bounds.overlaps(bounds) {
                continue;
            }
            if node.second == 0 {
                self.order[node.start as usize..node.end as usize].iter().for_each(|&one| visit(one as usize));
            } else {
                open.extend([node.second as usize, index + 1]);
            }
        }
    }
}
