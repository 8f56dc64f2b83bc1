//! Neighbor lists of all particles, in blocks of slots.
//!
//! A neighbor at a distance r at the build stays beyond the cutoff while the displacements of both particles differ by less than
//! r − cutoff. A list begins with the neighbors near enough to come within the cutoff soon ([`NEAR`]). Pair sums omit the others
//! while displacements around the particle differ by less. This is nearly always so, because the lists must be renewed where
//! displacements differ most. The omitted terms are 0, so that sums have the same bits with them.

use std::ops::Range;

use super::displacements::Displacements;
use super::grid::{BucketGrid, BucketRows, Runs};
use super::{BLOCK, Metric};
use crate::adjacency::Adjacency;
use crate::error::Result;
use crate::math::{AXES, Coordinate};
use crate::memory;
use crate::parallel::{BlockedSlice, Executor};
use crate::simd::{Isa, Kernel, LANES, Selection, at_most, dispatch};

/// Difference of displacements up to which pair sums take the near neighbors alone, in units of the skin.
pub const NEAR: f64 = 0.2;

/// Neighbors of one particle, as slots.
#[derive(Debug, Clone)]
pub struct List<'a> {
    /// Storage of the slots.
    pub segment: &'a Selection,
    /// Range of the neighbors in the storage.
    pub range: Range<usize>,
}

/// Ends of the list of a slot in the segment of its block.
#[derive(Debug, Clone, Copy, Default)]
pub struct Ends {
    /// End of the near neighbors.
    near: usize,
    /// End of all neighbors.
    pub all: usize,
}

/// Lists of all slots.
#[derive(Debug)]
pub struct Lists {
    /// Lists of each block, one after the other.
    segments: Vec<ListSegment>,
    ends: Vec<Ends>,
    /// Whether pair sums take all neighbors of a slot at present.
    whole: Vec<bool>,
}

/// Lists of consecutive slots, one after the other.
#[derive(Debug)]
pub struct ListSegment {
    lists: Selection,
    /// Neighbors of one slot that are not near, during its search.
    far: Selection,
}

impl ListSegment {
    /// Empty segment for lists of `count` slots.
    #[inline]
    pub fn new(count: usize) -> Self {
        let empty = || Selection::new(count + LANES);
        Self { lists: empty(), far: empty() }
    }

    /// Neighbors from `start` to `end`.
    #[inline(always)]
    pub fn list(&self, start: usize, end: usize) -> &[u32] {
        self.lists.list(start, end)
    }
}

/// Sorted particles from which lists are built.
#[derive(Debug, Clone, Copy)]
pub struct Candidates<'a> {
    /// Table of buckets.
    pub grid: &'a BucketGrid,
    /// First slot of each bucket, first slot of the particles that are not finite, and end.
    pub starts: &'a [u32],
    /// Coordinates in the order of slots, longer than the number of slots by at least a group of lanes.
    pub columns: [&'a [f64]; AXES],
    /// Metric of distances.
    pub metric: &'a Metric,
    /// Particle at each slot, and the excluded pairs of particles.
    pub order: &'a [u32],
    pub excluded: &'a Adjacency,
}

impl Lists {
    /// Empty lists for `count` slots.
    #[inline]
    pub fn new(count: usize) -> Self {
        let segments = (0..count.div_ceil(BLOCK)).map(|_| ListSegment::new(count)).collect();
        Self { segments, ends: vec![Ends::default(); count], whole: vec![false; count] }
    }

    /// Memory [bytes].
    #[inline]
    pub fn bytes(&self) -> usize {
        let segments = self.segments.iter().map(|segment| segment.lists.bytes() + segment.far.bytes()).sum::<usize>();
        segments + std::mem::size_of_val(self.ends.as_slice()) + self.whole.len()
    }

    /// List of one slot.
    #[inline(always)]
    pub fn of(&self, slot: usize) -> &[u32] {
        self.segments[slot / BLOCK].list(self.start(slot), self.ends[slot].all)
    }

    /// Neighbors of one slot that pair sums take at present.
    #[inline(always)]
    pub fn at(&self, slot: usize) -> List<'_> {
        let end = if self.needs_far(slot) { self.ends[slot].all } else { self.ends[slot].near };
        List { segment: &self.segments[slot / BLOCK].lists, range: self.start(slot)..end }
    }

    /// Whether pair sums of a slot take far neighbors at present.
    #[inline(always)]
    pub fn needs_far(&self, slot: usize) -> bool {
        self.whole[slot]
    }

    #[inline(always)]
    fn start(&self, slot: usize) -> usize {
        if slot.is_multiple_of(BLOCK) { 0 } else { self.ends[slot - 1].all }
    }

    /// Selects the neighbors that pair sums take with these displacements.
    #[inline]
    pub fn serve(&mut self, displacements: &Displacements, executor: &Executor) {
        executor.for_each_block(BlockedSlice::new(&mut self.whole, BLOCK), &|mine| {
            let mut start = 0;
            for (end, are_near) in displacements.are_near(mine.start / BLOCK) {
                let end = end - mine.start;
                mine.items[start..end].fill(!are_near);
                start = end;
            }
        });
    }

    /// Builds all lists.
    ///
    /// # Errors
    /// [`Error::Memory`](crate::error::Error::Memory) if the lists do not fit. They are then empty.
    pub fn build(&mut self, candidates: Candidates<'_>, dimension: usize, executor: &Executor) -> Result<()> {
        self.check(candidates, dimension, executor)?;
        let work = (BlockedSlice::new(&mut self.ends, BLOCK), BlockedSlice::new(&mut self.segments, 1));
        executor.for_each_block(work, &|(ends, segments)| {
            let Some(segment) = segments.items.first_mut() else { return };
            list(candidates, dimension, ends.start, ends.items, segment, executor);
            segment.lists.spare();
            segment.far.spare();
        });
        if self.segments.iter().any(|segment| segment.lists.has_overflowed()) {
            // The estimate was too low, or the memory was taken by another process.
            let held = self.bytes();
            *self = Self::new(self.ends.len());
            let available = memory::available().unwrap_or(0);
            return Err(memory::refusal(LISTS, held.max(available as usize + 1), available, || hint(candidates.metric)));
        }
        Ok(())
    }

    /// Rejects lists that do not fit into memory. If there are enough particles for this, the length of the lists is estimated
    /// from a sample. Neighboring lengths vary little.
    fn check(&mut self, candidates: Candidates<'_>, dimension: usize, executor: &Executor) -> Result<()> {
        let (count, held) = (self.ends.len(), self.bytes());
        if room(count.saturating_mul(count)) <= held + memory::HEADROOM {
            return Ok(());
        }
        let work = (BlockedSlice::new(&mut self.ends, BLOCK), BlockedSlice::new(&mut self.segments, 1));
        executor.for_each_block(work, &|(ends, segments)| {
            let Some(segment) = segments.items.first_mut() else { return };
            let (mut listed, mut samples) = (0, 0);
            for offset in (0..ends.items.len()).step_by(SAMPLE) {
                list(candidates, dimension, ends.start + offset, &mut ends.items[offset..=offset], segment, executor);
                (listed, samples) = (listed + segment.lists.len(), samples + 1);
            }
            ends.items[0].all = listed * ends.items.len() / samples;
        });
        let needed = room(self.ends.iter().step_by(BLOCK).map(|ends| ends.all).sum());
        let refused = memory::check(LISTS, needed + count * AFTER, held, || hint(candidates.metric));
        if refused.is_err() {
            *self = Self::new(count);
        }
        refused
    }
}

/// Name of the allocation in errors.
const LISTS: &str = "neighbors";

/// Memory that a particle takes after its first list: records, and what limits and energies need [bytes].
const AFTER: usize = 150;

/// Slots per sampled list.
const SAMPLE: usize = 64;

/// Maximum memory of lists with this number of neighbors [bytes].
fn room(neighbors: usize) -> usize {
    neighbors.saturating_mul(size_of::<u32>()) / 4 * 5
}

/// Remedy for lists that do not fit.
fn hint(metric: &Metric) -> String {
    let reach = metric.square.sqrt();
    format!("everything within {reach:.3e} m of each particle is listed: take a smaller cutoff, or sizes that differ less")
}

/// Lists the neighbors of consecutive slots from `start` on, one list after the other in `segment`, with the ends of each.
#[inline]
pub fn list(
    candidates: Candidates<'_>,
    dimension: usize,
    start: usize,
    ends: &mut [Ends],
    segment: &mut ListSegment,
    executor: &Executor,
) {
    let search = Search { candidates, start, ends, segment, executor };
    match (dimension, candidates.metric.periodic) {
        (2, false) => dispatch(Flat::<2, false>(search)),
        (2, true) => dispatch(Flat::<2, true>(search)),
        (_, false) => dispatch(Flat::<3, false>(search)),
        (_, true) => dispatch(Flat::<3, true>(search)),
    }
}

/// Search for the lists of one block.
struct Search<'a> {
    candidates: Candidates<'a>,
    start: usize,
    ends: &'a mut [Ends],
    segment: &'a mut ListSegment,
    executor: &'a Executor,
}

/// Search specialized to the number of dimensions and to periodicity.
struct Flat<'a, const DIMENSION: usize, const PERIODIC: bool>(Search<'a>);

impl<const DIMENSION: usize, const PERIODIC: bool> Kernel for Flat<'_, DIMENSION, PERIODIC> {
    type Output = ();

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) {
        let Search { candidates, start, ends, segment, executor } = self.0;
        let Candidates { grid, starts, columns, order, excluded, .. } = candidates;
        let nowhere = starts[starts.len() - 2] as usize;
        let ListSegment { lists, far } = segment;
        lists.clear();
        let (mut last, mut rows, mut runs) = (u32::MAX, BucketRows::NONE, Runs::NONE);
        for (slot, ends) in (start..).zip(ends) {
            let from = lists.len();
            far.clear();
            // After an interrupt the lists are incomplete.
            if slot < nowhere && !executor.stopped() {
                let point = std::array::from_fn(|axis| if axis < DIMENSION { columns[axis][slot] } else { 0.0 });
                let bucket = grid.bucket(point);
                if bucket != last {
                    (last, rows) = (bucket, grid.rows(bucket));
                }
                grid.runs(&rows, point, candidates.metric.square, starts, &mut runs);
                for run in runs.iter() {
                    for first in run.clone().step_by(LANES) {
                        add_group::<I, DIMENSION, PERIODIC>(isa, &candidates, slot, first, run.end, point, [lists, far]);
                    }
                }
                let left_out = excluded.of(order[slot] as usize);
                if !left_out.is_empty() {
                    let is_left_in = |other: u32| !left_out.contains(&order[other as usize]);
                    lists.retain(from, is_left_in);
                    far.retain(0, is_left_in);
                }
            }
            ends.near = lists.len();
            lists.append(far);
            ends.all = lists.len();
        }
    }
}

/// Adds the neighbors of one group of candidates.
#[inline(always)]
fn add_group<I: Isa, const DIMENSION: usize, const PERIODIC: bool>(
    isa: I,
    candidates: &Candidates<'_>,
    slot: usize,
    first: usize,
    end: usize,
    point: [f64; AXES],
    [near, far]: [&mut Selection; 2],
) {
    let Metric { encodings, square, near_square, .. } = candidates.metric;
    let mut squares = [0.0; LANES];
    for axis in 0..DIMENSION {
        let others = &candidates.columns[axis][first..first + LANES];
        for lane in 0..LANES {
            let separation = f64::separation::<PERIODIC, _>(point[axis], others[lane], encodings[axis]);
            squares[lane] += separation * separation;
        }
    }
    // Mask of the lanes within the run, except the particle itself.
    let mut valid = if end - first < LANES { (1 << (end - first)) - 1 } else { u16::MAX };
    if let Some(own) = slot.checked_sub(first).filter(|&own| own < LANES) {
        valid &= !(1 << own);
    }
    let close = valid & at_most(isa, &squares, *near_square);
    near.add(isa, first, close);
    if near_square < square {
        far.add(isa, first, valid & at_most(isa, &squares, *square) & !close);
    }
}
