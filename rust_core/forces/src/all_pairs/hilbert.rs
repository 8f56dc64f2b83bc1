//! Hilbert order: the order of points along a Hilbert curve. At each level, the curve visits one cell of a quadtree or octree
//! after the other, and passes only between adjacent cells. The points of a cell are therefore consecutive, and consecutive
//! points are near each other.
//!
//! Source: J. Skilling, Programming the Hilbert curve, AIP Conf. Proc. 707 (2004) 381.

use std::ops::Range;

use glam::DVec3;

use crate::math::AXES;
use crate::parallel::{BlockedSlice, Executor};
use crate::simd::{Isa, Kernel, LANES, Lanes, dispatch};

/// Points per block of work: whole groups of lanes.
const BLOCK: usize = 4096;

/// Maximum number of points that share a key without a finer order.
const CROWD: usize = 32;

/// Points in Hilbert order.
#[derive(Debug)]
pub struct HilbertOrder {
    /// Key and index of each point, ascending by key.
    pub keys: Vec<(u64, u32)>,
    dimension: u32,
    /// Crowds of points that share a key, such as a cluster beside a distant point. Each has the index of its first point in this
    /// order, and an order in its own bounding box.
    crowds: Vec<(usize, HilbertOrder)>,
}

impl HilbertOrder {
    /// Sorts `count` points. Points that are not finite have an arbitrary position in the order.
    pub fn new(count: usize, dimension: usize, place: &(impl Fn(usize) -> DVec3 + Sync), executor: &Executor) -> Self {
        let (low, high) = bounds(count, place, executor);
        let side = (high - low).max_element();
        let levels = levels(dimension);
        let cells = f64::from(1_u32 << levels);
        let scale = if side > 0.0 { (cells / side).min(f64::MAX) } else { 0.0 };
        let mut keys = vec![(0, 0); count];
        executor.for_each_block(BlockedSlice::new(&mut keys, BLOCK), &|mine| {
            for (group, keys) in mine.items.chunks_mut(LANES).enumerate() {
                let first = mine.start + LANES * group;
                let mut cell = [[0; LANES]; AXES];
                for lane in 0..keys.len() {
                    let scaled = ((place(first + lane) - low) * scale).to_array();
                    (0..AXES).for_each(|axis| cell[axis][lane] = scaled[axis].min(cells - 1.0) as u64);
                }
                let found = if dimension == 2 { dispatch(Keys([cell[0], cell[1]])) } else { dispatch(Keys(cell)) };
                keys.iter_mut().enumerate().for_each(|(lane, key)| *key = (found[lane], (first + lane) as u32));
            }
        });
        executor.sort(&mut keys);
        let mut order = Self { keys, dimension: dimension as u32, crowds: Vec::new() };
        for crowd in order.crowded() {
            let keys = &mut order.keys[crowd.clone()];
            let points: Vec<u32> = keys.iter().map(|key| key.1).collect();
            let places: Vec<DVec3> = points.iter().map(|&point| place(point as usize)).collect();
            let finer = Self::of_places(&places, dimension, executor);
            keys.iter_mut().zip(&finer.keys).for_each(|(key, finer)| key.1 = points[finer.1 as usize]);
            order.crowds.push((crowd.start, finer));
        }
        order
    }

    /// Sorts points at these positions. The concrete type of `place` permits recursion.
    fn of_places(places: &[DVec3], dimension: usize, executor: &Executor) -> Self {
        Self::new(places.len(), dimension, &|index| places[index], executor)
    }

    /// Ranges of more than [`CROWD`] points that share a key. A range of all points is excluded, because they then coincide.
    fn crowded(&self) -> Vec<Range<usize>> {
        let (mut crowds, mut start) = (Vec::new(), 0);
        for crowd in self.keys.chunk_by(|one, other| one.0 == other.0) {
            if crowd.len() > CROWD && crowd.len() < self.keys.len() {
                crowds.push(start..start + crowd.len());
            }
            start += crowd.len();
        }
        crowds
    }

    /// Number of levels in the smallest cell that contains a range of points; 0 if they share a key.
    fn depth(&self, range: &Range<usize>) -> u32 {
        let differing = self.keys[range.start].0 ^ self.keys[range.end - 1].0;
        (u64::BITS - differing.leading_zeros()).div_ceil(self.dimension)
    }

    /// The order whose keys distinguish the points of a range, and the index of its first point in this order.
    fn finest(&self, range: &Range<usize>) -> (&Self, usize) {
        let before = self.crowds.partition_point(|crowd| crowd.0 <= range.start);
        match self.crowds[..before].last() {
            Some((start, crowd)) if range.end <= start + crowd.keys.len() => {
                let (order, first) = crowd.finest(&(range.start - start..range.end - start));
                (order, start + first)
            }
            _ => (self, 0),
        }
    }

    /// Whether no key distinguishes the points of a range.
    #[inline]
    pub fn have_one_key(&self, range: &Range<usize>) -> bool {
        let (order, first) = self.finest(range);
        order.depth(&(range.start - first..range.end - first)) == 0
    }

    /// The subranges in the parts of the smallest cell that contains a range of points; the whole range if they share a key.
    pub fn parts(&self, range: Range<usize>) -> impl Iterator<Item = Range<usize>> {
        let (order, first) = self.finest(&range);
        let (mut start, end) = (range.start - first, range.end - first);
        let shift = order.depth(&(start..end)).saturating_sub(1) * order.dimension;
        std::iter::from_fn(move || {
            let part = order.keys[start..end].first()?.0 >> shift;
            let begin = start;
            start += order.keys[begin..end].partition_point(|key| key.0 >> shift == part);
            Some(first + begin..first + start)
        })
    }

    /// Index of each point in this order.
    #[inline]
    pub fn slots(&self) -> Vec<u32> {
        let mut slots = vec![0; self.keys.len()];
        self.keys.iter().enumerate().for_each(|(slot, key)| slots[key.1 as usize] = slot as u32);
        slots
    }
}

/// Number of levels below the root, which is the number of key bits per axis.
fn levels(dimension: usize) -> usize {
    63 / dimension
}

/// Keys of cells with these coordinates along each axis.
struct Keys<const DIMENSION: usize>([Lanes<u64>; DIMENSION]);

impl<const DIMENSION: usize> Kernel for Keys<DIMENSION> {
    type Output = Lanes<u64>;

    #[inline(always)]
    fn run<S: Isa>(self, _isa: S) -> Lanes<u64> {
        let Self(mut x) = self;
        // Rotate and mirror the frame of each level as the curve enters its cell.
        for level in (1..levels(DIMENSION)).rev() {
            let below = (1 << level) - 1;
            for axis in 0..DIMENSION {
                for lane in 0..LANES {
                    let mirrored = (x[axis][lane] >> level & 1).wrapping_neg() & below;
                    let swapped = (x[0][lane] ^ x[axis][lane]) & (below ^ mirrored);
                    x[0][lane] ^= swapped ^ mirrored;
                    x[axis][lane] ^= swapped;
                }
            }
        }
        // Compute the Gray code, and interleave its bits.
        for axis in 1..DIMENSION {
            for lane in 0..LANES {
                x[axis][lane] ^= x[axis - 1][lane];
            }
        }
        let mut keys = [0; LANES];
        for lane in 0..LANES {
            let last = x[DIMENSION - 1][lane];
            let turned =
                (1..levels(DIMENSION)).fold(0, |turned, level| turned ^ (last >> level & 1).wrapping_neg() & ((1 << level) - 1));
            for axis in 0..DIMENSION {
                keys[lane] |= spread::<DIMENSION>(x[axis][lane] ^ turned) << (DIMENSION - 1 - axis);
            }
        }
        keys
    }
}

/// Spreads the bits of a number to make room for those of the other axes.
#[inline(always)]
fn spread<const DIMENSION: usize>(bits: u64) -> u64 {
    // Each step moves the upper half of every run of bits.
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
    let steps = if DIMENSION == 2 { PLANE } else { SPACE };
    steps.iter().fold(bits, |bits, (shift, mask)| (bits | bits << shift) & mask)
}

/// Bounding box of the finite points.
fn bounds(count: usize, place: &(impl Fn(usize) -> DVec3 + Sync), executor: &Executor) -> (DVec3, DVec3) {
    let empty = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let union = |one: (DVec3, DVec3), other: (DVec3, DVec3)| (one.0.min(other.0), one.1.max(other.1));
    let mut boxes = vec![empty; count.div_ceil(BLOCK)];
    executor.for_each_block(BlockedSlice::new(&mut boxes, 1), &|mine| {
        for (block, slot) in (mine.start..).zip(mine.items) {
            let points = (block * BLOCK..count.min((block + 1) * BLOCK)).map(place).filter(|point| point.is_finite());
            *slot = points.fold(empty, |all, point| union(all, (point, point)));
        }
    });
    boxes.into_iter().fold(empty, union)
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;
    use crate::parallel::SERIAL;

    /// A point of a lattice of 8 per axis, in a shuffled order.
    fn site(index: usize, dimension: usize) -> DVec3 {
        let index = index * 12_345 % 8_usize.pow(dimension as u32);
        DVec3::new((index % 8) as f64, (index / 8 % 8) as f64, (index / 64) as f64)
    }

    #[test]
    fn the_curve_goes_from_each_point_of_a_lattice_to_one_beside_it() {
        for dimension in [2, 3] {
            let count = 8_usize.pow(dimension as u32);
            let order = HilbertOrder::new(count, dimension, &|index| site(index, dimension), &SERIAL);
            let places: Vec<DVec3> = order.keys.iter().map(|key| site(key.1 as usize, dimension)).collect();
            assert!(places.windows(2).all(|pair| (pair[0] - pair[1]).length() == 1.0));
            let slots = order.slots();
            assert!(order.keys.iter().enumerate().all(|(slot, key)| slots[key.1 as usize] as usize == slot));
        }
    }

    #[test]
    fn the_parts_of_a_cell_are_its_halves_along_each_axis() {
        for dimension in [2, 3] {
            let count = 8_usize.pow(dimension as u32);
            let order = HilbertOrder::new(count, dimension, &|index| site(index, dimension), &SERIAL);
            let parts: Vec<_> = order.parts(0..count).collect();
            assert_eq!(parts.len(), 1 << dimension);
            for part in parts {
                let places = || order.keys[part.clone()].iter().map(|key| site(key.1 as usize, dimension));
                let low = places().fold(DVec3::INFINITY, DVec3::min);
                let high = places().fold(DVec3::NEG_INFINITY, DVec3::max);
                assert_eq!((part.len(), (high - low).max_element()), (count >> dimension, 3.0));
            }
        }
    }

    #[test]
    fn points_in_one_place_and_those_that_are_not_finite_are_sorted_too() {
        let order = HilbertOrder::new(50, 3, &|_| DVec3::ONE, &SERIAL);
        assert!(order.have_one_key(&(0..50)));
        assert_eq!(order.parts(0..50).count(), 1);
        assert!(HilbertOrder::new(0, 2, &|_| DVec3::ONE, &SERIAL).keys.is_empty());
        let places = [0.0, f64::NAN, 1.0, f64::INFINITY];
        assert_eq!(HilbertOrder::new(4, 3, &|index| DVec3::splat(places[index]), &SERIAL).keys.len(), 4);
    }

    #[test]
    fn points_beside_some_far_away_are_in_the_order_that_they_have_without_them() {
        for dimension in [2, 3] {
            let count = 8_usize.pow(dimension as u32);
            let far = [1e20, 1e40, 1e60];
            let place = |index: usize| if index < count { site(index, dimension) } else { far[index - count] * DVec3::X };
            let alone = HilbertOrder::new(count, dimension, &place, &SERIAL);
            let order = HilbertOrder::new(count + 3, dimension, &place, &SERIAL);
            assert_eq!(order.keys.iter().map(|key| key.1).collect::<HashSet<_>>().len(), count + 3);
            let crowd = (0..order.keys.len()).find(|&start| (order.keys[start].1 as usize) < count).expect("all are there");
            let range = crowd..crowd + count;
            assert!(order.keys[range.clone()].iter().zip(&alone.keys).all(|(one, other)| one.1 == other.1));
            assert!(!order.have_one_key(&range));
            let shifted = |part: Range<usize>| part.start + crowd..part.end + crowd;
            assert!(order.parts(range).eq(alone.parts(0..count).map(shifted)));
        }
    }
}
