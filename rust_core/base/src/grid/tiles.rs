//! Stages of a step over all rows of a grid: one at a time, or several in one pass over memory.
//!
//! Stage k of a slab (a row of a plane, a plane of a solid) needs stage k − 1 of the adjacent slabs. One thread therefore runs
//! through the slabs with all stages in turn. Each stage is one slab behind the previous one, so the stages meet in the cache:
//!
//! ```text
//!     stage 2   . x                  Two threads: each computes the part of its band that needs no other band (\ /).
//!     stage 1   . . x                Then one thread computes the seam between the bands (/ \).
//!     stage 0   . . . x                  stage 2      \ x x x / s s s s \ x x x x
//!              ─────────▶ slabs          stage 0      x x x x x \ s / x x x x x x x
//! ```
//!
//! Even and odd stages are stored in two columns, so each slab holds its two latest stages.

use std::ops::Range;

use super::{Block, Grid, Window};
use crate::math::Real;
use crate::parallel::Executor;

/// Maximum number of stages in one pass.
pub const DEEPEST: usize = 16;
/// Memory for the slabs of all stages [bytes]: a core's share of the last-level cache. Fewer stages, which fit into a nearer
/// cache, were slower. One stage at a time was slower by half.
const CACHE: usize = 1 << 22;
/// Size of a block in numbers, computed by one thread at a time if each stage is a separate sweep.
const BLOCK: usize = 1 << 15;

/// Part of a tile that a stage computes, in slabs of the whole grid.
#[derive(Debug, Clone, Copy)]
pub enum TileShape {
    /// Band without the margins that depend on adjacent bands.
    Band { last: usize },
    /// Slabs around the one at which two bands meet.
    Seam(usize),
}

impl TileShape {
    fn slabs(self, stage: usize, all: &Range<usize>) -> Range<usize> {
        match self {
            Self::Band { last } => {
                let margin = stage + 1;
                let start = if all.start == 0 { 0 } else { all.start + margin };
                start..if all.end == last { last } else { all.end.saturating_sub(margin) }.max(start)
            }
            Self::Seam(middle) => middle - stage - 1..middle + stage + 1,
        }
    }
}

/// Stages of a step. Each stage needs the field of the previous stage in a row and in the adjacent rows.
pub trait Sweep<T: Real, Y: Send>: Sync {
    /// Size of the scratch memory for a row, in numbers.
    fn scratch(&self) -> usize;

    /// Runs a stage for the row of a block with this index. `before` is the field at the previous stage.
    fn row(&self, stage: usize, block: &mut Block<'_, T, Y>, index: usize, before: Window<'_, T>, scratch: &mut [T]);

    /// Runs one stage of all rows, reading the column `before` of the block.
    fn sweep(&self, block: Block<'_, T, Y>, executor: &Executor) {
        let length = block.length;
        let mut block = Block { rows: (BLOCK / length).max(1), ..block };
        let before = Window::new(&*std::mem::take(&mut block.before), length);
        executor.for_each_block(block, &|mut block: Block<'_, T, Y>| {
            T::with_scratch(self.scratch(), |scratch| {
                (0..block.count()).for_each(|index| self.row(0, &mut block, index, before, scratch));
            });
        });
    }

    /// Runs the first `stages` stages of all rows of a grid in one pass; `stages` is at most [`depth`].
    fn pass(&self, grid: &Grid, stages: usize, block: Block<'_, T, Y>, executor: &Executor) {
        let slab = slab(grid);
        let slabs = block.count() / slab;
        // A seam extends over as many slabs on each side as there are stages.
        let bands = executor.threads().min(slabs / (4 * stages)).max(1);
        let size = slabs.div_ceil(bands);
        let mut whole = Block { rows: size * slab, ..block };
        executor.for_each_block(whole.reborrow(), &|mut band: Block<'_, T, Y>| {
            self.tile(stages, slab, &mut band, TileShape::Band { last: slabs }, executor);
        });
        if bands > 1 {
            let half = size / 2;
            let (_, seams) = whole.split_at_row(half * slab);
            executor.for_each_block(seams, &|mut seam: Block<'_, T, Y>| {
                let middle = seam.first / slab + size - half;
                if middle < slabs {
                    self.tile(stages, slab, &mut seam, TileShape::Seam(middle), executor);
                }
            });
        }
    }

    /// Runs stages for the slabs of a tile.
    fn tile(&self, stages: usize, slab: usize, block: &mut Block<'_, T, Y>, shape: TileShape, executor: &Executor) {
        let all = block.first / slab..(block.first + block.count()) / slab;
        T::with_scratch(self.scratch(), |scratch| {
            for front in all.start..all.end + stages {
                if executor.stopped() {
                    return;
                }
                for stage in 0..stages.min(front + 1) {
                    let at = front - stage;
                    if shape.slabs(stage, &all).contains(&at) {
                        for row in at * slab..(at + 1) * slab {
                            let index = row - block.first;
                            self.alternate(stage, block, index, scratch);
                        }
                    }
                }
            }
        });
    }

    /// Runs a stage of a row. Even stages read the column `before` and write the other; odd stages do the reverse.
    fn alternate(&self, stage: usize, block: &mut Block<'_, T, Y>, index: usize, scratch: &mut [T]) {
        let exchange = |block: &mut Block<'_, T, Y>| {
            if stage % 2 == 1 {
                std::mem::swap(&mut block.field, &mut block.before);
            }
        };
        exchange(block);
        let before = std::mem::take(&mut block.before);
        let rows = Window { first: block.first, ..Window::new(&*before, block.length) };
        self.row(stage, block, index, rows, scratch);
        block.before = before;
        exchange(block);
    }
}

/// Number of rows in a slab.
fn slab(grid: &Grid) -> usize {
    if grid.dimension == 3 { grid.cells[1] } else { 1 }
}

/// Number of stages in one pass over memory, for systems that hold `bytes` bytes per cell.
#[inline]
pub fn depth(grid: &Grid, bytes: usize) -> usize {
    let across = usize::from(grid.dimension < 3);
    if grid.dimension == 1 || grid.periodic[across] {
        return 1;
    }
    (CACHE / (bytes * slab(grid) * grid.row_length())).saturating_sub(2).clamp(1, DEEPEST)
}
