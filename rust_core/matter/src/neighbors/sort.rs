//! Sorting of particles by bucket: a stable counting sort, in parallel.
//!
//! Each part of the particles has a histogram over buckets. Prefix sums over buckets and parts are the first slots of each part
//! in each bucket. A stable sort has one result, for any number of parts.

use std::sync::atomic::{AtomicU32, Ordering};

use super::grid::BucketGrid;
use super::{BLOCK, Positions};
use crate::parallel::{BlockedSlice, Executor};

/// Maximum number of parts, each of which has a count per bucket.
const PARTS: usize = 8;

/// The particles in the order of their buckets.
#[derive(Debug, Default)]
pub struct Sort {
    /// Particle of each slot.
    pub order: Vec<u32>,
    /// Slot of each particle.
    pub slots: Vec<u32>,
    /// First slot of each bucket, first slot of the particles that are not finite, and end.
    pub starts: Vec<u32>,
    /// Bucket of each particle.
    buckets: Vec<u32>,
    /// Histogram of each part; later its next slot per bucket.
    tallies: Vec<u32>,
    /// Atomic copy of `order` while several threads write it. Each slot is written once, so that the result does not depend on
    /// timing.
    scattered: Vec<AtomicU32>,
}

impl Sort {
    /// Buffers for `count` particles.
    #[inline]
    pub fn new(count: usize) -> Self {
        Self {
            order: vec![0; count],
            slots: vec![0; count],
            starts: Vec::new(),
            buckets: vec![0; count],
            tallies: Vec::new(),
            scattered: (0..count).map(|_| AtomicU32::new(0)).collect(),
        }
    }

    /// Memory [bytes].
    #[inline]
    pub fn bytes(&self) -> usize {
        let numbers = [&self.order, &self.slots, &self.starts, &self.buckets, &self.tallies];
        size_of::<u32>() * (numbers.iter().map(|numbers| numbers.capacity()).sum::<usize>() + self.slots.len())
    }

    /// Sorts the particles.
    pub fn sort(&mut self, grid: &BucketGrid, positions: Positions<'_>, executor: &Executor) {
        let count = self.order.len();
        let buckets = grid.buckets() + 1;
        let parts = executor.threads().min(PARTS).min(count.div_ceil(BLOCK)).max(1);
        let part = count.div_ceil(parts).max(1);
        self.tallies.clear();
        self.tallies.resize(parts * buckets, 0);
        executor.for_each_block(
            (BlockedSlice::new(&mut self.buckets, part), BlockedSlice::new(&mut self.tallies, buckets)),
            &|(mine, tally)| {
                for (particle, bucket) in (mine.start..).zip(mine.items) {
                    *bucket = grid.bucket(positions.get(particle));
                    tally.items[*bucket as usize] += 1;
                }
            },
        );
        self.add_up(buckets);
        let (known, scattered) = (&self.buckets, &self.scattered);
        executor.for_each_block(
            (BlockedSlice::new(&mut self.slots, part), BlockedSlice::new(&mut self.tallies, buckets)),
            &|(mine, tally)| {
                for (particle, slot) in (mine.start..).zip(mine.items) {
                    let next = &mut tally.items[known[particle] as usize];
                    *slot = *next;
                    scattered[*next as usize].store(particle as u32, Ordering::Relaxed);
                    *next += 1;
                }
            },
        );
        executor.for_each_block(BlockedSlice::new(&mut self.order, BLOCK), &|mine| {
            for (slot, particle) in (mine.start..).zip(mine.items) {
                *particle = scattered[slot].load(Ordering::Relaxed);
            }
        });
    }

    /// Converts the histograms into the first slot of each part in each bucket.
    fn add_up(&mut self, buckets: usize) {
        self.starts.clear();
        self.starts.resize(buckets + 1, 0);
        let mut next = 0;
        for bucket in 0..buckets {
            self.starts[bucket] = next;
            for tally in self.tallies[bucket..].iter_mut().step_by(buckets) {
                next += std::mem::replace(tally, next);
            }
        }
        self.starts[buckets] = next;
    }
}
