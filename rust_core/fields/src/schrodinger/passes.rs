//! Passes over lines of cells along one axis after the other.
//!
//! A pass gathers lines along an axis from one copy of the field into another, in which they are contiguous, and processes them
//! there. The axis is then the last one of the layout. After passes along all axes in order, the layout is the initial one again.

use super::fourier::{Complex, product};
use crate::math::{AXES, Real};
use crate::parallel::{BlockedSlice, Executor};

/// Number of lines in a block. Their cells are adjacent, and as many are read in order for each cell of the axis.
const LINES: usize = 64;
/// Number of cells of each line that are gathered at a time.
const CELLS: usize = 16;

/// Field with a second copy, and the order of its axes in memory.
#[derive(Debug)]
pub struct Field<'a, T> {
    cells: [usize; AXES],
    layout: [usize; AXES],
    pub values: &'a mut Vec<Complex<T>>,
    pub other: &'a mut Vec<Complex<T>>,
    pub scratch: &'a mut Vec<Complex<T>>,
}

/// Factors of the cells.
type CellFactors<'a, T> = Option<&'a [Complex<T>]>;

/// Adjacent lines, their scratch memory, and a number for each line.
type LineBlock<'a, T> = ((BlockedSlice<'a, Complex<T>>, BlockedSlice<'a, Complex<T>>), BlockedSlice<'a, f64>);

/// Positions of lines in the initial layout: index of the first cell of each, and distance between neighbors.
#[derive(Debug, Clone, Copy)]
pub struct Place {
    counts: [usize; 2],
    strides: [usize; 2],
    pub stride: usize,
}

impl Place {
    /// Index of the first cell of a line.
    pub fn start(&self, line: usize) -> usize {
        line / self.counts[1] * self.strides[0] + line % self.counts[1] * self.strides[1]
    }
}

impl<'a, T: Real> Field<'a, T> {
    /// Returns a field with the memory of its passes.
    pub fn new(
        cells: [usize; AXES],
        values: &'a mut Vec<Complex<T>>,
        other: &'a mut Vec<Complex<T>>,
        scratch: &'a mut Vec<Complex<T>>,
    ) -> Self {
        Self { cells, layout: [0, 1, 2], values, other, scratch }
    }

    /// Positions of lines along an axis after a pass along it.
    fn place(&self, rest: [usize; 2], axis: usize) -> Place {
        let stride = |axis: usize| self.cells[axis + 1..].iter().product();
        Place { counts: rest.map(|axis| self.cells[axis]), strides: rest.map(stride), stride: stride(axis) }
    }

    /// Gathers the lines along an axis and calls `work` on each, with scratch memory of this length. Cells are multiplied by the
    /// first factors if the layout is the initial one. Results are multiplied by the second factors if the layout is then the
    /// initial one. Returns the sum over all lines.
    pub fn pass(
        &mut self,
        axis: usize,
        [before, after]: [CellFactors<'_, T>; 2],
        length: usize,
        executor: &Executor,
        work: &(impl Fn(Place, usize, &mut [Complex<T>], &mut [Complex<T>]) -> f64 + Sync),
    ) -> f64 {
        let position = self.layout.iter().position(|&own| own == axis).unwrap_or(0);
        let count = self.cells[axis];
        let post: usize = self.layout[position + 1..].iter().map(|&axis| self.cells[axis]).product();
        let rest: Vec<usize> = self.layout.iter().copied().filter(|&own| own != axis).collect();
        let place = self.place([rest[0], rest[1]], axis);
        let blocks = (self.values.len() / count).div_ceil(LINES);
        let blank = Complex { re: T::ZERO, im: T::ZERO };
        let length = length.max(1);
        if self.scratch.len() < blocks * length {
            self.scratch.resize(blocks * length, blank);
        }
        let from = self.values.as_slice();
        let mut sums = vec![0.0; self.values.len() / count];
        let output = BlockedSlice::new(self.other.as_mut_slice(), LINES * count);
        let scratch = BlockedSlice::new(&mut self.scratch[..blocks * length], length);
        let tally = BlockedSlice::new(&mut sums, LINES);
        let each = |((block, scratch), tally): LineBlock<'_, T>| {
            let first = block.start / count;
            gather(from, before, [count, post], first, block.items);
            for (index, line) in block.items.chunks_exact_mut(count).enumerate() {
                tally.items[index] = work(place, first + index, line, scratch.items);
            }
            if let Some(factors) = after {
                block.items.iter_mut().zip(&factors[block.start..]).for_each(|(value, &factor)| *value = product(*value, factor));
            }
        };
        executor.for_each_block(((output, scratch), tally), &each);
        std::mem::swap(self.values, self.other);
        self.layout = [rest[0], rest[1], axis];
        sums.into_iter().sum()
    }
}

/// Copies lines of `count` cells one after the other, times factors. The cells of each line are `post` apart, and the lines are
/// adjacent. The copy runs tile by tile: whole lines are often a power of two apart and would share few cache lines.
fn gather<T: Real>(
    from: &[Complex<T>],
    factors: CellFactors<'_, T>,
    [count, post]: [usize; 2],
    first: usize,
    lines: &mut [Complex<T>],
) {
    let mut tile = [[Complex { re: T::ZERO, im: T::ZERO }; CELLS]; LINES];
    let last = first + lines.len() / count;
    let mut line = first;
    while line < last {
        let (group, offset) = (line / post, line % post);
        let together = (post - offset).min(last - line);
        for start in (0..count).step_by(CELLS) {
            let cells = CELLS.min(count - start);
            for cell in 0..cells {
                let at = (group * count + start + cell) * post + offset;
                let values = from[at..at + together].iter();
                match factors {
                    None => tile.iter_mut().zip(values).for_each(|(row, &value)| row[cell] = value),
                    Some(factors) => {
                        let values = values.zip(&factors[at..at + together]);
                        tile.iter_mut().zip(values).for_each(|(row, (&value, &factor))| row[cell] = product(value, factor));
                    }
                }
            }
            for (row, index) in tile.iter().zip(line - first..line - first + together) {
                lines[index * count + start..][..cells].copy_from_slice(&row[..cells]);
            }
        }
        line += together;
    }
}
