//! Activity of a batch of steps, the input of the divergence monitor: the kinetic energy [J] in each step. In every step it
//! is taken at the last evaluation of forces, or at the end.
//!
//! The activity has the same bits for any division of steps into batches. Its consequences are therefore a function of the
//! trajectory.

use crate::parallel::BlockedSlice;

/// Maximum number of steps, and of numbers, that a batch records.
const MOST_STEPS: usize = 1 << 12;
const MOST: usize = 1 << 19;

/// Activity after each step of the last batch.
#[derive(Debug, Default)]
pub struct Activity {
    /// Activity of every block after every step [J], block by block.
    blocks: Vec<f64>,
    /// Total activity after every step [J].
    steps: Vec<f64>,
}

impl Activity {
    /// Maximum number of steps in a batch of this number of blocks.
    pub fn most_steps(blocks: usize) -> u64 {
        (MOST / blocks.max(1)).clamp(1, MOST_STEPS) as u64
    }

    /// Buffers for batches of up to `steps` steps of `blocks` blocks.
    pub fn new(blocks: usize, steps: u64) -> Self {
        Self { blocks: Vec::with_capacity(blocks * steps as usize), steps: Vec::with_capacity(steps as usize) }
    }

    /// Clears the previous batch.
    pub fn clear(&mut self) {
        self.steps.clear();
    }

    /// Buffer for `steps` numbers of each of `blocks` blocks, to be written and then [summed](Activity::add_up).
    pub fn record(&mut self, blocks: usize, steps: usize) -> BlockedSlice<'_, f64> {
        self.blocks.clear();
        self.blocks.resize(blocks * steps, 0.0);
        BlockedSlice::new(&mut self.blocks, steps)
    }

    /// Sums the records over all blocks, in their order.
    pub fn add_up(&mut self, steps: usize) {
        let Self { blocks, steps: sums } = self;
        sums.extend((0..steps).map(|step| blocks.iter().skip(step).step_by(steps).sum::<f64>()));
    }

    /// Appends the total activity after one more step [J].
    pub fn push(&mut self, activity: f64) {
        self.steps.push(activity);
    }

    /// Activity after each recorded step [J]; after the last step alone if only that was recorded.
    pub fn steps(&self) -> &[f64] {
        &self.steps
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        (self.blocks.capacity() + self.steps.capacity()) * size_of::<f64>()
    }
}
