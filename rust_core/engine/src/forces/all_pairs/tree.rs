//! The tree of an inverse-square force: a quadtree or octree over Morton keys, and its walk by groups of targets.
//!
//! Cells are stored in depth-first order, each with the number of cells below it, so that a walk is one loop. A cell of side s
//! is taken whole if s < θ d, with d the distance from the bounding box of the group to the cell's center; else its parts are.
//! Source: J. Barnes and P. Hut, Nature 324 (1986) 446; groups: J. E. Barnes, J. Comput. Phys. 87 (1990) 161.

use std::ops::Range;

use glam::DVec3;

use super::expansion::Expansion;
use crate::math::AXES;
use crate::parallel::{BlockedSlice, Executor};

/// Bits of a Morton key per axis: the cells of the lowest level are 2⁻²¹ of the whole.
const BITS: u32 = 21;

/// Bodies of a leaf, unless they have one key.
const LEAF: usize = 16;

/// Bodies of a branch, which one thread builds.
const BRANCH: usize = 4096;

/// Bodies per block of what is done for each of them.
const BLOCK: usize = 4096;

/// A body as a source: its place, its charge, and its velocity.
#[derive(Debug, Clone, Copy, Default)]
pub struct Body {
    pub position: DVec3,
    pub charge: f64,
    pub velocity: DVec3,
}

/// A cell: consecutive bodies in Morton order.
#[derive(Debug, Clone)]
pub struct Cell {
    /// The bodies, in Morton order.
    pub bodies: Range<usize>,
    /// The side s.
    side: f64,
    /// The number of cells in its subtree, itself included.
    cells: usize,
    /// The moments.
    pub moments: Expansion,
}

/// The Morton order of some positions: their indices, sorted by key.
pub fn morton_order(positions: &[DVec3], dimension: usize, executor: &Executor) -> (Vec<(u64, u32)>, f64) {
    let low = positions.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = positions.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    let side = (high - low).max_element();
    let scale = if side > 0.0 { f64::from(1_u32 << BITS) / side } else { 0.0 };
    let mut keys = vec![(0, 0); positions.len()];
    executor.for_each_block(BlockedSlice::new(&mut keys, BLOCK), &|mine| {
        for (index, key) in (mine.start..).zip(mine.items.iter_mut()) {
            let place = ((positions[index] - low) * scale).to_array();
            let cells = place.map(|coordinate| (coordinate as u64).min((1 << BITS) - 1));
            *key = (interleaved(cells, dimension), index as u32);
        }
        mine.items.sort_unstable();
    });
    // A stable sort merges sorted runs.
    keys.sort();
    (keys, side)
}

/// The bits of the cell's coordinates in turn, the highest first.
fn interleaved(cells: [u64; AXES], dimension: usize) -> u64 {
    let mut key = 0;
    for (axis, &cell) in cells.iter().enumerate().take(dimension) {
        let mut bits = cell;
        if dimension == 2 {
            for (shift, mask) in [
                (16, 0xffff_0000_ffff),
                (8, 0xff_00ff_00ff_00ff),
                (4, 0x0f0f_0f0f_0f0f_0f0f),
                (2, 0x3333_3333_3333_3333),
                (1, 0x5555_5555_5555_5555),
            ] {
                bits = (bits | bits << shift) & mask;
            }
        } else {
            for (shift, mask) in [
                (32, 0x1f_0000_0000_ffff),
                (16, 0x1f_0000_ff00_00ff),
                (8, 0x100f_00f0_0f00_f00f),
                (4, 0x10c3_0c30_c30c_30c3),
                (2, 0x1249_2492_4924_9249),
            ] {
                bits = (bits | bits << shift) & mask;
            }
        }
        key |= bits << axis;
    }
    key
}

/// The tree.
#[derive(Debug)]
pub struct Tree {
    /// The sources in Morton order, with the index of each.
    pub bodies: Vec<Body>,
    pub order: Vec<u32>,
    cells: Vec<Cell>,
}

impl Tree {
    /// The tree of some sources.
    pub fn new(sources: &[Body], dimension: usize, executor: &Executor) -> Self {
        let positions: Vec<DVec3> = sources.iter().map(|body| body.position).collect();
        let (keys, side) = morton_order(&positions, dimension, executor);
        let order: Vec<u32> = keys.iter().map(|key| key.1).collect();
        let bodies: Vec<Body> = order.iter().map(|&index| sources[index as usize]).collect();
        let builder = Builder { keys: &keys, bodies: &bodies, dimension: dimension as u32, side };
        let mut branches: Vec<(Range<usize>, Vec<Cell>)> = Vec::new();
        builder.grow(0..keys.len(), BRANCH, &mut Vec::new(), &mut |range, cells| {
            cells.push(builder.cell(range.clone()));
            branches.push((range, Vec::new()));
        });
        executor.for_each_block(BlockedSlice::new(&mut branches, 1), &|mine| {
            for (range, cells) in mine.items {
                builder.grow(range.clone(), LEAF, cells, &mut |range, cells| cells.push(builder.leaf(range)));
            }
        });
        let (mut cells, mut built) = (Vec::new(), branches.into_iter());
        builder.grow(0..keys.len(), BRANCH, &mut cells, &mut |_, cells| {
            cells.extend(built.next().into_iter().flat_map(|branch| branch.1));
        });
        Self { bodies, order, cells }
    }

    /// The cells that are taken whole and the bodies of the others, in order, for targets within a box; `own` are the targets
    /// among the bodies, whose cells are never taken whole.
    pub fn walk<'a>(
        &'a self,
        low: DVec3,
        high: DVec3,
        angle: f64,
        own: &Range<usize>,
        mut whole: impl FnMut(&'a Cell),
        mut parts: impl FnMut(Range<usize>),
    ) {
        let mut next = 0;
        while let Some(cell) = self.cells.get(next) {
            let center = cell.moments.center;
            let gap = (low - center).max(center - high).max(DVec3::ZERO);
            let apart = cell.bodies.end <= own.start || cell.bodies.start >= own.end;
            if apart && cell.side * cell.side < angle * angle * gap.length_squared() {
                whole(cell);
                next += cell.cells;
            } else if cell.cells == 1 {
                parts(cell.bodies.clone());
                next += 1;
            } else {
                next += 1;
            }
        }
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        self.cells.capacity() * size_of::<Cell>() + self.bodies.len() * (size_of::<Body>() + size_of::<u32>())
    }
}

/// What cells are built of.
struct Builder<'a> {
    keys: &'a [(u64, u32)],
    bodies: &'a [Body],
    dimension: u32,
    side: f64,
}

impl Builder<'_> {
    /// The number of lowest bits in which the keys of a range differ, in whole levels.
    fn levels(&self, range: &Range<usize>) -> u32 {
        let differing = self.keys[range.start].0 ^ self.keys[range.end - 1].0;
        (u64::BITS - differing.leading_zeros()).div_ceil(self.dimension)
    }

    /// The smallest cell that contains a range, without its moments.
    fn cell(&self, range: Range<usize>) -> Cell {
        let side = self.side * f64::from(1_u32 << self.levels(&range)) / f64::from(1_u32 << BITS);
        Cell { bodies: range, side, cells: 1, moments: Expansion::default() }
    }

    /// A cell without parts.
    fn leaf(&self, range: Range<usize>) -> Cell {
        let moments = Expansion::of_bodies(&self.bodies[range.clone()]);
        Cell { moments, ..self.cell(range) }
    }

    /// Appends the cells of a range, and `finish` those of its parts of at most `most` bodies or one key.
    fn grow(
        &self,
        range: Range<usize>,
        most: usize,
        cells: &mut Vec<Cell>,
        finish: &mut impl FnMut(Range<usize>, &mut Vec<Cell>),
    ) {
        if range.is_empty() {
            return;
        }
        let levels = self.levels(&range);
        if range.len() <= most || levels == 0 {
            return finish(range, cells);
        }
        let first = cells.len();
        cells.push(self.cell(range.clone()));
        let shift = (levels - 1) * self.dimension;
        let mut start = range.start;
        while start < range.end {
            let part = self.keys[start].0 >> shift;
            let end = start + self.keys[start..range.end].partition_point(|key| key.0 >> shift == part);
            self.grow(start..end, most, cells, finish);
            start = end;
        }
        let mut parts = Vec::with_capacity(8);
        let mut next = first + 1;
        while next < cells.len() {
            parts.push(&cells[next].moments);
            next += cells[next].cells;
        }
        let moments = Expansion::of_parts(&parts);
        cells[first].cells = cells.len() - first;
        cells[first].moments = moments;
    }
}
