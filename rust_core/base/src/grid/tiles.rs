//! Stages of a step over all rows of a grid: one at a time, or several in one pass over memory.
//!
//! Stage k of a slab (a row of a plane, a plane of a solid) needs stage k − 1 of the slabs beside it. One thread therefore runs
//! through the slabs with all stages in turn, each one slab behind the one before, so that they meet in the cache:
//!
//! ```text
//!     stage 2   . x                  Two threads: first each takes of its band what needs no other band (\ /), then
//!     stage 1   . . x                one the seam between them (/ \).
//!     stage 0   . . . x                  stage 2      \ x x x / s s s s \ x x x x
//!              ─────────▶ slabs          stage 0      x x x x x \ s / x x x x x x x
//! ```
//!
//! Fields of even and odd stages are in two columns, of which each slab holds the two last stages that it had.

use std::ops::Range;

use super::{Block, Grid, Window};
use crate::math::Real;
use crate::parallel::Executor;

/// The most stages in one pass.
pub const DEEPEST: usize = 16;
/// The memory that the slabs of all stages may take: a core's part of the last cache. Fewer stages that fit into a nearer one
/// were slower, as was one stage at a time by half [bytes].
const CACHE: usize = 1 << 22;
/// Numbers of a block, which one thread computes at a time where each stage is a sweep of its own.
const BLOCK: usize = 1 << 15;

/// The part of a tile that a stage computes, in slabs of the whole.
#[derive(Debug, Clone, Copy)]
pub enum Shape {
    /// A band, less what the bands beside it reach.
    Band { last: usize },
    /// Around the slab at which two bands meet.
    Seam(usize),
}

impl Shape {
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

/// Stages of a step, each of which needs the field of the one before in a row and in those beside it.
pub trait Sweep<T: Real, Y: Send>: Sync {
    /// Numbers of scratch memory for a row.
    fn scratch(&self) -> usize;

    /// Runs a stage of the row of a block that has that index in it. `before` is the field at the stage before.
    fn row(&self, stage: usize, block: &mut Block<'_, T, Y>, index: usize, before: Window<'_, T>, scratch: &mut [T]);

    /// Runs one stage of all rows, which reads the column `before` of the block.
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

    /// Runs the first `stages` stages of all rows of a grid in one pass, at most as many as [`depth`] says.
    fn pass(&self, grid: &Grid, stages: usize, block: Block<'_, T, Y>, executor: &Executor) {
        let slab = slab(grid);
        let slabs = block.count() / slab;
        // A seam takes as much on both sides as there are stages.
        let bands = executor.threads().min(slabs / (4 * stages)).max(1);
        let size = slabs.div_ceil(bands);
        let mut whole = Block { rows: size * slab, ..block };
        executor.for_each_block(whole.reborrow(), &|mut band: Block<'_, T, Y>| {
            self.tile(stages, slab, &mut band, Shape::Band { last: slabs }, executor);
        });
        if bands > 1 {
            let half = size / 2;
            let (_, seams) = whole.split_at_row(half * slab);
            executor.for_each_block(seams, &|mut seam: Block<'_, T, Y>| {
                let middle = seam.first / slab + size - half;
                if middle < slabs {
                    self.tile(stages, slab, &mut seam, Shape::Seam(middle), executor);
                }
            });
        }
    }

    /// Runs stages of the slabs of a tile.
    fn tile(&self, stages: usize, slab: usize, block: &mut Block<'_, T, Y>, shape: Shape, executor: &Executor) {
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

    /// Runs a stage of a row: even ones read the column `before` and write the other, odd ones the other way round.
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

/// The number of rows in a slab.
fn slab(grid: &Grid) -> usize {
    if grid.dimension == 3 { grid.cells[1] } else { 1 }
}

/// How many stages one pass over memory takes, of systems that hold that many bytes for each cell.
pub fn depth(grid: &Grid, bytes: usize) -> usize {
    let across = usize::from(grid.dimension < 3);
    if grid.dimension == 1 || grid.periodic[across] {
        return 1;
    }
    (CACHE / (bytes * slab(grid) * grid.row_length())).saturating_sub(2).clamp(1, DEEPEST)
}
