//! The list of neighbors of every particle, one after the other in blocks of places.

use super::grid::{Grid, Runs};
use super::{BLOCK, Metric};
use crate::math::{AXES, Stored};
use crate::parallel::{Chunks, Crew};
use crate::simd::{Kernel, LANES, dispatch, select};

/// The lists of the places of one block.
#[derive(Debug, Default)]
struct Segment {
    /// Places, list after list; at least a group of lanes longer than what is used, so that groups are read whole.
    entries: Vec<u32>,
    used: usize,
}

impl Segment {
    /// Makes room for `more` entries, and for what is read and written past them.
    #[inline(always)]
    fn reserve(&mut self, more: usize) {
        if self.entries.len() < self.used + more + LANES {
            self.grow(more);
        }
    }

    /// Ends the last list: what is read past it has to be places too, and a few more neighbors next time find room.
    fn close(&mut self) {
        self.reserve(self.used / 8);
        self.entries[self.used..self.used + LANES].fill(0);
    }

    #[cold]
    fn grow(&mut self, more: usize) {
        self.entries.resize((self.used + more + LANES) * 5 / 4, 0);
    }
}

/// The lists of all places.
#[derive(Debug, Default)]
pub struct Lists {
    segments: Vec<Segment>,
    /// Where the list of each place ends in the segment of its block.
    ends: Vec<usize>,
}

/// The places that lists are made from.
#[derive(Debug, Clone, Copy)]
pub struct Candidates<'a> {
    /// The table of buckets.
    pub grid: &'a Grid,
    /// The first place of each bucket, of those that are nowhere, and the end.
    pub starts: &'a [u32],
    /// Coordinates in the order of places, at least a group of lanes longer than there are places.
    pub columns: [&'a [f64]; AXES],
    /// What distances are measured with.
    pub metric: &'a Metric,
}

impl Lists {
    /// Empty lists for `count` places.
    pub fn new(count: usize) -> Self {
        let empty = || Segment { entries: vec![0; LANES], used: 0 };
        Self { segments: (0..count.div_ceil(BLOCK)).map(|_| empty()).collect(), ends: vec![0; count] }
    }

    /// The memory that they take [bytes].
    pub fn bytes(&self) -> usize {
        let entries: usize = self.segments.iter().map(|segment| segment.entries.capacity() * size_of::<u32>()).sum();
        entries + std::mem::size_of_val(self.ends.as_slice())
    }

    /// The list of one place.
    #[inline(always)]
    pub fn of(&self, place: usize) -> &[u32] {
        let (entries, length) = self.with_rest(place);
        &entries[..length]
    }

    /// The list of one place with whatever follows it, at least a group of lanes, and its length.
    #[inline(always)]
    pub fn with_rest(&self, place: usize) -> (&[u32], usize) {
        let start = if place.is_multiple_of(BLOCK) { 0 } else { self.ends[place - 1] };
        (&self.segments[place / BLOCK].entries[start..], self.ends[place] - start)
    }

    /// Makes all lists anew.
    pub fn build(&mut self, candidates: Candidates<'_>, dimension: usize, crew: &Crew) {
        let work = (Chunks::new(&mut self.ends, BLOCK), Chunks::new(&mut self.segments, 1));
        crew.sweep(work, &|(ends, segments)| {
            let Some(segment) = segments.items.first_mut() else { return };
            let search = Search { candidates, start: ends.start, ends: ends.items, segment };
            match (dimension, candidates.metric.periodic) {
                (2, false) => dispatch(Flat::<2, false>(search)),
                (2, true) => dispatch(Flat::<2, true>(search)),
                (_, false) => dispatch(Flat::<3, false>(search)),
                (_, true) => dispatch(Flat::<3, true>(search)),
            }
        });
    }
}

/// The lists of one block in the making.
struct Search<'a> {
    candidates: Candidates<'a>,
    start: usize,
    ends: &'a mut [usize],
    segment: &'a mut Segment,
}

/// The search in some number of dimensions, with or without periods.
struct Flat<'a, const DIMENSION: usize, const PERIODIC: bool>(Search<'a>);

impl<const DIMENSION: usize, const PERIODIC: bool> Kernel for Flat<'_, DIMENSION, PERIODIC> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Search { candidates, start, ends, segment } = self.0;
        let Candidates { grid, starts, columns, .. } = candidates;
        let nowhere = starts[starts.len() - 2] as usize;
        segment.used = 0;
        let (mut last, mut runs) = (u32::MAX, Runs::NONE);
        for (place, end) in (start..).zip(ends) {
            if place < nowhere {
                let point = std::array::from_fn(|axis| if axis < DIMENSION { columns[axis][place] } else { 0.0 });
                let bucket = grid.bucket(point);
                if bucket != last {
                    (last, runs) = (bucket, grid.runs(bucket, starts));
                }
                for run in runs.iter() {
                    segment.reserve(run.len());
                    for first in run.clone().step_by(LANES) {
                        look::<DIMENSION, PERIODIC>(&candidates, place, first, run.end, point, segment);
                    }
                }
            }
            *end = segment.used;
        }
        segment.close();
    }
}

/// Looks at one group of candidates.
#[inline(always)]
fn look<const DIMENSION: usize, const PERIODIC: bool>(
    candidates: &Candidates<'_>,
    place: usize,
    first: usize,
    end: usize,
    point: [f64; AXES],
    segment: &mut Segment,
) {
    let Metric { rulers, square: limit, .. } = candidates.metric;
    let mut squares = [0.0; LANES];
    for axis in 0..DIMENSION {
        let others = &candidates.columns[axis][first..first + LANES];
        for lane in 0..LANES {
            let apart = f64::apart::<PERIODIC>(point[axis], others[lane], rulers[axis]);
            squares[lane] += apart * apart;
        }
    }
    let accepted = std::array::from_fn(|lane| {
        let other = first + lane;
        squares[lane] <= *limit && other < end && other != place
    });
    let out = &mut segment.entries[segment.used..segment.used + LANES];
    if let Some(out) = out.first_chunk_mut() {
        segment.used += select(first as u32, &accepted, out);
    }
}
