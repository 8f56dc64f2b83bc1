//! Morton order: points in the order of a curve that passes through one cell of a quadtree or octree after the other, at each
//! level. So the points of a cell follow each other.
//!
//! Source: G. M. Morton, A computer oriented geodetic data base, IBM (1966).

use std::ops::Range;

use glam::DVec3;

use crate::math::AXES;
use crate::parallel::{BlockedSlice, Executor};

/// Points per block of work.
const BLOCK: usize = 4096;

/// Some points in Morton order.
#[derive(Debug)]
pub struct MortonOrder {
    /// The key of each point and its index, ascending.
    pub keys: Vec<(u64, u32)>,
    /// The side of the root cell.
    side: f64,
    dimension: u32,
}

impl MortonOrder {
    /// The order of `count` points. Those that are not finite are anywhere in it.
    pub fn new(count: usize, dimension: usize, place: &(impl Fn(usize) -> DVec3 + Sync), executor: &Executor) -> Self {
        let (low, high) = bounds(count, place, executor);
        let side = (high - low).max_element().max(0.0);
        let mut order = Self { keys: vec![(0, 0); count], side, dimension: dimension as u32 };
        let cells = f64::from(1_u32 << order.levels());
        let scale = if side > 0.0 { (cells / side).min(f64::MAX) } else { 0.0 };
        executor.for_each_block(BlockedSlice::new(&mut order.keys, BLOCK), &|mine| {
            for (index, key) in (mine.start..).zip(mine.items) {
                let cell = ((place(index) - low) * scale).to_array().map(|coordinate| coordinate.min(cells - 1.0) as u64);
                *key = (interleaved(cell, dimension), index as u32);
            }
        });
        executor.sort(&mut order.keys);
        order
    }

    /// The number of levels below the root: as many bits of a key per axis.
    fn levels(&self) -> u32 {
        (u64::BITS - 1) / self.dimension
    }

    /// Whether the points of a range are not told apart.
    pub fn have_one_key(&self, range: &Range<usize>) -> bool {
        self.depth(range) == 0
    }

    /// The number of levels in the smallest cell that contains a range of points; 0 if they have one key.
    fn depth(&self, range: &Range<usize>) -> u32 {
        let differing = self.keys[range.start].0 ^ self.keys[range.end - 1].0;
        (u64::BITS - differing.leading_zeros()).div_ceil(self.dimension)
    }

    /// The side of the smallest cell that contains a range of points.
    pub fn side(&self, range: &Range<usize>) -> f64 {
        self.side * f64::from(1_u32 << self.depth(range)) / f64::from(1_u32 << self.levels())
    }

    /// The ranges in the parts of the smallest cell that contains a range of points: all of it if they have one key.
    pub fn parts(&self, range: Range<usize>) -> impl Iterator<Item = Range<usize>> {
        let shift = self.depth(&range).saturating_sub(1) * self.dimension;
        let mut start = range.start;
        std::iter::from_fn(move || {
            let part = self.keys[start..range.end].first()?.0 >> shift;
            let first = start;
            start += self.keys[first..range.end].partition_point(|key| key.0 >> shift == part);
            Some(first..start)
        })
    }

    /// The place of each point in this order.
    pub fn slots(&self) -> Vec<u32> {
        let mut slots = vec![0; self.keys.len()];
        self.keys.iter().enumerate().for_each(|(slot, key)| slots[key.1 as usize] = slot as u32);
        slots
    }
}

/// The bounding box of the points that are finite.
fn bounds(count: usize, place: &(impl Fn(usize) -> DVec3 + Sync), executor: &Executor) -> (DVec3, DVec3) {
    let empty = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let grown = |(low, high): (DVec3, DVec3), (other_low, other_high): (DVec3, DVec3)| (low.min(other_low), high.max(other_high));
    let mut boxes = vec![empty; count.div_ceil(BLOCK)];
    executor.for_each_block(BlockedSlice::new(&mut boxes, 1), &|mine| {
        for (block, slot) in (mine.start..).zip(mine.items) {
            let points = (block * BLOCK..count.min((block + 1) * BLOCK)).map(place).filter(|point| point.is_finite());
            *slot = points.fold(empty, |all, point| grown(all, (point, point)));
        }
    });
    boxes.into_iter().fold(empty, grown)
}

/// The bits of a cell's coordinates in turn, the highest first.
fn interleaved(cell: [u64; AXES], dimension: usize) -> u64 {
    // Steps that move the upper half of each run of bits by as many places as make room for the other axes.
    const PLANE: [(u32, u64); 5] = [
        (16, 0x0000_ffff_0000_ffff),
        (8, 0x00ff_00ff_00ff_00ff),
        (4, 0x0f0f_0f0f_0f0f_0f0f),
        (2, 0x3333_3333_3333_3333),
        (1, 0x5555_5555_5555_5555),
    ];
    const SPACE: [(u32, u64); 5] = [
        (32, 0x001f_0000_0000_ffff),
        (16, 0x001f_0000_ff00_00ff),
        (8, 0x100f_00f0_0f00_f00f),
        (4, 0x10c3_0c30_c30c_30c3),
        (2, 0x1249_2492_4924_9249),
    ];
    let steps = if dimension == 2 { PLANE } else { SPACE };
    let spread = |bits: u64| steps.iter().fold(bits, |bits, (shift, mask)| (bits | bits << shift) & mask);
    (0..dimension).fold(0, |key, axis| key | spread(cell[axis]) << axis)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parallel::SERIAL;

    #[test]
    fn the_points_of_each_part_of_a_cell_follow_each_other() {
        for dimension in [2_usize, 3] {
            let side = 8_usize;
            let count = side.pow(dimension as u32);
            let axis = |index: usize, axis: usize| (index / side.pow(axis as u32) % side) as f64;
            let place = |index: usize| {
                let index = index * 12_345 % count;
                DVec3::new(axis(index, 0), axis(index, 1), if dimension == 3 { axis(index, 2) } else { 0.0 })
            };
            let order = MortonOrder::new(count, dimension, &place, &SERIAL);
            let parts: Vec<_> = order.parts(0..count).collect();
            assert_eq!(parts.len(), 1 << dimension);
            assert!((order.side(&(0..count)) - 7.0).abs() < 1e-12);
            for part in parts {
                assert_eq!(part.len(), count >> dimension);
                assert!(order.side(&part) <= 3.5);
                let places = || order.keys[part.clone()].iter().map(|key| place(key.1 as usize));
                let low = places().fold(DVec3::INFINITY, DVec3::min);
                let high = places().fold(DVec3::NEG_INFINITY, DVec3::max);
                assert!((high - low).max_element() <= 3.0);
            }
            let slots = order.slots();
            assert!(order.keys.iter().enumerate().all(|(slot, key)| slots[key.1 as usize] as usize == slot));
        }
    }

    #[test]
    fn points_in_one_place_and_none_are_sorted() {
        let order = MortonOrder::new(5, 3, &|_| DVec3::ONE, &SERIAL);
        assert!(order.have_one_key(&(0..5)));
        assert_eq!((order.parts(0..5).count(), order.side(&(0..5))), (1, 0.0));
        assert!(MortonOrder::new(0, 2, &|_| DVec3::ONE, &SERIAL).keys.is_empty());
        let order = MortonOrder::new(3, 3, &|index| DVec3::splat([0.0, f64::NAN, 1.0][index]), &SERIAL);
        assert_eq!(order.keys.len(), 3);
    }
}
