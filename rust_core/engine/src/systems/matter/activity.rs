//! The activity of a batch of steps: the kinetic energy [J] at the last evaluation of forces in each of them, or at its end,
//! which wakes the divergence monitor.
//!
//! It is the same to the bit however steps are cut into batches, so what follows from it is a function of the trajectory.

use crate::parallel::BlockedSlice;

/// The most steps, and the most numbers, that a batch may record.
const MOST_STEPS: usize = 1 << 12;
const MOST: usize = 1 << 19;

/// The activity after each step of the last batch.
#[derive(Debug, Default)]
pub struct Activity {
    /// Of every block after every step, block by block.
    blocks: Vec<f64>,
    /// Of all blocks, after every step.
    steps: Vec<f64>,
}

impl Activity {
    /// The largest number of steps in a batch of so many blocks.
    pub fn most_steps(blocks: usize) -> u64 {
        (MOST / blocks.max(1)).clamp(1, MOST_STEPS) as u64
    }

    /// Room for batches of up to `steps` steps of `blocks` blocks.
    pub fn new(blocks: usize, steps: u64) -> Self {
        Self { blocks: Vec::with_capacity(blocks * steps as usize), steps: Vec::with_capacity(steps as usize) }
    }

    /// Forgets the batch before.
    pub fn clear(&mut self) {
        self.steps.clear();
    }

    /// Room for `steps` numbers of each of `blocks` blocks, to be written and then [added up](Activity::add_up).
    pub fn record(&mut self, blocks: usize, steps: usize) -> BlockedSlice<'_, f64> {
        self.blocks.clear();
        self.blocks.resize(blocks * steps, 0.0);
        BlockedSlice::new(&mut self.blocks, steps)
    }

    /// Sums what was recorded over all blocks, in their order.
    pub fn add_up(&mut self, steps: usize) {
        let Self { blocks, steps: sums } = self;
        sums.extend((0..steps).map(|step| blocks.iter().skip(step).step_by(steps).sum::<f64>()));
    }

    /// Adds that of all blocks after one more step.
    pub fn push(&mut self, activity: f64) {
        self.steps.push(activity);
    }

    /// The activity after each recorded step; after the last one alone where only that was asked for.
    pub fn steps(&self) -> &[f64] {
        &self.steps
    }

    /// The memory that it takes [bytes].
    pub fn bytes(&self) -> usize {
        (self.blocks.capacity() + self.steps.capacity()) * size_of::<f64>()
    }
}
