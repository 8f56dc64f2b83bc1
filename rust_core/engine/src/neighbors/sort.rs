//! The order of the particles by bucket: a stable counting sort, in parallel.
//!
//! Each part of the particles counts its own per bucket; sums of the counts over buckets and parts say where each part
//! begins to place the particles of each bucket. A stable sort has one result, however many parts there are.

use std::sync::atomic::{AtomicU32, Ordering};

use super::grid::Grid;
use super::{BLOCK, Positions};
use crate::parallel::{BlockedSlice, Executor};

/// The most parts: each has a count per bucket.
const PARTS: usize = 8;

/// The particles in the order of their buckets.
#[derive(Debug, Default)]
pub struct Sort {
    /// Slot → particle.
    pub order: Vec<u32>,
    /// Particle → slot.
    pub slots: Vec<u32>,
    /// The first slot of each bucket, of those that are nowhere, and the end.
    pub starts: Vec<u32>,
    /// Particle → bucket.
    buckets: Vec<u32>,
    /// The counts of each part, which become its next slot per bucket.
    tallies: Vec<u32>,
    /// `order` while many write to it: each slot once, so that what is written does not depend on when.
    scattered: Vec<AtomicU32>,
}

impl Sort {
    /// Room for `count` particles.
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

    /// The memory that it takes [bytes].
    pub fn bytes(&self) -> usize {
        let numbers = [&self.order, &self.slots, &self.starts, &self.buckets, &self.tallies];
        size_of::<u32>() * (numbers.iter().map(|numbers| numbers.capacity()).sum::<usize>() + self.slots.len())
    }

    /// Sorts the particles.
    pub fn sort(&mut self, grid: &Grid, positions: Positions<'_>, executor: &Executor) {
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

    /// Turns counts into the first slot of each part in each bucket.
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
