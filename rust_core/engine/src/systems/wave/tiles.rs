//! Several stages in one pass over memory.
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
//! Displacements of even and odd stages are in two columns, of which each slab holds the two last stages that it had.

use std::ops::Range;

use super::acceleration::Window;
use super::state::{Block, State};
use super::sweep::{Dynamics, Pass};
use crate::integrators::Integrator;
use crate::math::Real;
use crate::parallel::Executor;

/// The most stages in one pass.
pub const DEEPEST: usize = 16;
/// The memory that the slabs of all stages may take: a core's part of the last cache. Fewer stages that fit into a nearer one
/// were slower, as was one stage at a time by half [bytes].
const CACHE: usize = 1 << 22;

/// The part of a tile that a stage computes, in slabs of the whole.
#[derive(Debug, Clone, Copy)]
enum Shape {
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

impl<T: Real> Dynamics<T> {
    /// The number of rows in a slab.
    fn slab(&self) -> usize {
        if self.medium.grid.dimension == 3 { self.medium.grid.cells[1] } else { 1 }
    }

    /// How many stages one pass over memory takes for an integrator that holds that many numbers for each cell.
    pub fn depth(&self, columns: usize) -> usize {
        let grid = &self.medium.grid;
        let across = usize::from(grid.dimension < 3);
        if grid.dimension == 1 || grid.periodic[across] || self.medium.fourth.is_some() || self.layers.is_some() {
            return 1;
        }
        let slab = columns * self.slab() * grid.row_length() * size_of::<T>();
        (CACHE / slab).saturating_sub(2).clamp(1, DEEPEST)
    }

    /// Runs stages of all slabs, at most [`DEEPEST`].
    pub fn stages<I: Integrator>(&self, passes: &[Pass<'_>], block: Block<'_, T>, saved: Option<&State<T>>, executor: &Executor) {
        let slab = self.slab();
        let slabs = block.tallies.len() / slab;
        // A seam takes as much on both sides as there are stages.
        let bands = executor.threads().min(slabs / (4 * passes.len())).max(1);
        let size = slabs.div_ceil(bands);
        let mut whole = Block { rows: size * slab, ..block };
        executor.for_each_block(whole.reborrow(), &|mut band: Block<'_, T>| {
            self.tile::<I>(passes, &mut band, Shape::Band { last: slabs }, saved, executor);
        });
        if bands > 1 {
            let half = size / 2;
            let (_, seams) = whole.split_at_row(half * slab);
            executor.for_each_block(seams, &|mut seam: Block<'_, T>| {
                let middle = seam.first / slab + size - half;
                if middle < slabs {
                    self.tile::<I>(passes, &mut seam, Shape::Seam(middle), saved, executor);
                }
            });
        }
    }

    /// Runs stages of the slabs of a tile.
    fn tile<I: Integrator>(
        &self,
        passes: &[Pass<'_>],
        block: &mut Block<'_, T>,
        shape: Shape,
        saved: Option<&State<T>>,
        executor: &Executor,
    ) {
        let slab = self.slab();
        let all = block.first / slab..(block.first + block.tallies.len()) / slab;
        T::with_scratch(self.scratch(), |scratch| {
            for front in all.start..all.end + passes.len() {
                if executor.stopped() {
                    return;
                }
                for (stage, &pass) in passes.iter().enumerate().take(front + 1) {
                    let at = front - stage;
                    if shape.slabs(stage, &all).contains(&at) {
                        for row in at * slab..(at + 1) * slab {
                            let index = row - block.first;
                            self.alternate::<I>((pass, stage), block, index, saved, scratch);
                        }
                    }
                }
            }
        });
    }

    /// Runs a stage of a row: even ones read the displacement before and write the other, odd ones the other way round.
    fn alternate<I: Integrator>(
        &self,
        (pass, stage): (Pass<'_>, usize),
        block: &mut Block<'_, T>,
        index: usize,
        saved: Option<&State<T>>,
        scratch: &mut [T],
    ) {
        let exchange = |block: &mut Block<'_, T>| {
            if stage % 2 == 1 {
                std::mem::swap(&mut block.displacement, &mut block.before);
            }
        };
        exchange(block);
        let before = std::mem::take(&mut block.before);
        let rows = Window { values: before, first: block.first, length: block.length };
        self.row::<I>(pass, block, (index, stage), rows, saved, scratch);
        block.before = before;
        exchange(block);
    }
}
