//! The state of a wave, and the buffers of its steps.

use std::ops::Range;

use crate::integrators::Integrator;
use crate::math::Real;
use crate::matter::REGISTERS;
use crate::parallel::Split;

/// The number of sinks and sources of energy, and which they are.
pub const SINKS: usize = 3;
pub const DAMPING: usize = 0;
pub const SOURCE: usize = 1;
pub const EDGES: usize = 2;

/// The energy through each sink in one row.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Tally {
    /// Time integral of the power [J].
    pub energy: [f64; SINKS],
    /// Power at the last evaluation [W].
    pub last: [f64; SINKS],
}

/// Displacement and rate of all cells, the persistent registers of the integrator, and the tallies of all rows.
#[derive(Debug, Clone)]
pub struct State<T> {
    pub displacement: Vec<T>,
    pub rate: Vec<T>,
    pub persistent: Vec<Vec<T>>,
    pub tallies: Vec<Tally>,
}

impl<T: Real> State<T> {
    /// The columns of numbers, in a fixed order.
    pub fn columns(&self) -> impl Iterator<Item = &Vec<T>> {
        [&self.displacement, &self.rate].into_iter().chain(&self.persistent)
    }

    /// The same, to be changed.
    pub fn columns_mut(&mut self) -> impl Iterator<Item = &mut Vec<T>> {
        [&mut self.displacement, &mut self.rate].into_iter().chain(&mut self.persistent)
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        self.columns().map(|column| size_of_val(column.as_slice())).sum::<usize>() + size_of_val(self.tallies.as_slice())
    }
}

/// What stages need besides the state.
#[derive(Debug)]
pub struct Workspace<T> {
    /// The displacement at the stage before, which the neighbors still read.
    pub before: Vec<T>,
    /// The registers that do not persist.
    pub registers: Vec<Vec<T>>,
    /// Kinetic energy of each row at each stage of a pass [J].
    pub kinetic: Vec<f64>,
    /// The amplitudes of the sources at each stage of a batch.
    pub amplitudes: Vec<f64>,
}

impl<T: Real> Workspace<T> {
    /// Buffers for an integrator.
    pub fn new<I: Integrator>(cells: usize, rows: usize, stages: usize) -> Self {
        let registers = vec![vec![T::ZERO; cells]; I::REGISTERS - I::PERSISTENT];
        Self { before: vec![T::ZERO; cells], registers, kinetic: vec![0.0; rows * stages], amplitudes: Vec::new() }
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        let columns = self.registers.iter().chain([&self.before]).map(|column| size_of_val(column.as_slice())).sum::<usize>();
        columns + size_of_val(self.kinetic.as_slice()) + size_of::<f64>() * self.amplitudes.capacity()
    }
}

/// What a stage writes, of rows that follow each other, in blocks of some rows.
#[derive(Debug)]
pub struct Block<'a, T> {
    /// The number of the first row.
    pub first: usize,
    pub displacement: &'a mut [T],
    /// The displacement of the stage before; empty where all blocks share it.
    pub before: &'a mut [T],
    pub rate: &'a mut [T],
    pub registers: [&'a mut [T]; REGISTERS],
    pub tallies: &'a mut [Tally],
    /// Kinetic energy of each row at each stage [J].
    pub kinetic: &'a mut [f64],
    /// The number of stages.
    pub stages: usize,
    /// The number of cells in a row, and of rows in a block.
    pub length: usize,
    pub rows: usize,
}

impl<'a, T> Block<'a, T> {
    /// All rows of a state.
    pub fn all(state: &'a mut State<T>, workspace: &'a mut Workspace<T>, length: usize, stages: usize) -> Self {
        let state_rows = state.tallies.len();
        let mut columns = state.persistent.iter_mut().chain(&mut workspace.registers).map(Vec::as_mut_slice);
        let registers = std::array::from_fn(|_| columns.next().unwrap_or_default());
        Self {
            first: 0,
            displacement: &mut state.displacement,
            before: &mut workspace.before,
            rate: &mut state.rate,
            registers,
            tallies: &mut state.tallies,
            kinetic: &mut workspace.kinetic,
            rows: state_rows,
            length,
            stages,
        }
    }

    /// Some cells of the row `row` of this block.
    #[inline(always)]
    pub fn cells(&mut self, row: usize, range: Range<usize>) -> Cells<'_, T> {
        let range = row * self.length + range.start..row * self.length + range.end;
        Cells {
            displacement: &mut self.displacement[range.clone()],
            rate: &mut self.rate[range.clone()],
            registers: self
                .registers
                .each_mut()
                .map(|column| if column.is_empty() { &mut [] } else { &mut column[range.clone()] }),
        }
    }
}

/// Neighboring cells of a row, as a stage writes them.
#[derive(Debug)]
pub struct Cells<'a, T> {
    pub displacement: &'a mut [T],
    pub rate: &'a mut [T],
    pub registers: [&'a mut [T]; REGISTERS],
}

impl<T: Send> Split for Block<'_, T> {
    fn blocks(&self) -> usize {
        self.tallies.len().div_ceil(self.rows)
    }

    fn split_at(self, blocks: usize) -> (Self, Self) {
        let row = (blocks * self.rows).min(self.tallies.len());
        self.split_at_row(row)
    }
}

impl<T> Block<'_, T> {
    /// A reborrow.
    pub fn reborrow(&mut self) -> Block<'_, T> {
        Block {
            displacement: &mut *self.displacement,
            before: &mut *self.before,
            rate: &mut *self.rate,
            registers: self.registers.each_mut().map(|column| &mut **column),
            tallies: &mut *self.tallies,
            kinetic: &mut *self.kinetic,
            ..*self
        }
    }

    /// Splits before a row.
    pub fn split_at_row(self, split: usize) -> (Self, Self) {
        let Self { first, displacement, before, rate, registers, tallies, kinetic, stages, length, rows } = self;
        let cells = split * length;
        let middle = cells.min(before.len());
        let (before, other_before) = before.split_at_mut(middle);
        let (displacement, other_displacement) = displacement.split_at_mut(cells);
        let (rate, other_rate) = rate.split_at_mut(cells);
        let (tallies, other_tallies) = tallies.split_at_mut(split);
        let (kinetic, other_kinetic) = kinetic.split_at_mut(split * stages);
        let mut pairs = registers.map(|column| {
            let middle = cells.min(column.len());
            column.split_at_mut(middle)
        });
        let lower = pairs.each_mut().map(|(lower, _)| std::mem::take(lower));
        let upper = pairs.map(|(_, upper)| upper);
        let others = Self {
            first: first + split,
            displacement: other_displacement,
            before: other_before,
            rate: other_rate,
            registers: upper,
            tallies: other_tallies,
            kinetic: other_kinetic,
            stages,
            length,
            rows,
        };
        (Self { first, displacement, before, rate, registers: lower, tallies, kinetic, stages, length, rows }, others)
    }
}
