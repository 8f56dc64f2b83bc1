//! State of a wave, and the buffers of its steps.

use std::ops::Range;

use crate::grid::Block;
use crate::integrators::Facts;
use crate::integrators::REGISTERS;
use crate::math::Real;

/// Number of sinks and sources of energy, and their indices.
pub const SINKS: usize = 4;
pub const DAMPING: usize = 0;
pub const SOURCE: usize = 1;
pub const EDGES: usize = 2;
pub const HELD: usize = 3;

/// Energy through each sink in one row.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct WaveTally {
    /// Time integral of the power [J].
    pub energy: [f64; SINKS],
    /// Power at the last evaluation [W].
    pub last: [f64; SINKS],
}

/// Displacement and rate of all cells, the persistent registers of the integrator, and the tallies of all rows.
#[derive(Debug, Clone)]
pub struct WaveState<T> {
    pub displacement: Vec<T>,
    pub rate: Vec<T>,
    pub persistent: Vec<Vec<T>>,
    pub tallies: Vec<WaveTally>,
}

impl<T: Real> WaveState<T> {
    /// Columns of numbers, in a fixed order.
    pub fn columns(&self) -> impl Iterator<Item = &Vec<T>> {
        [&self.displacement, &self.rate].into_iter().chain(&self.persistent)
    }

    /// Mutable columns of numbers, in the order of [`Self::columns`].
    pub fn columns_mut(&mut self) -> impl Iterator<Item = &mut Vec<T>> {
        [&mut self.displacement, &mut self.rate].into_iter().chain(&mut self.persistent)
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        self.columns().map(|column| size_of_val(column.as_slice())).sum::<usize>() + size_of_val(self.tallies.as_slice())
    }
}

/// Buffers of the stages.
#[derive(Debug)]
pub struct WaveWorkspace<T> {
    /// Displacement at the previous stage, which neighbors still read.
    pub before: Vec<T>,
    /// Registers that do not persist.
    pub registers: Vec<Vec<T>>,
    /// Kinetic energy of each row at each stage of a pass [J].
    pub kinetic: Vec<f64>,
    /// Amplitudes of the sources at each stage of a batch.
    pub amplitudes: Vec<f64>,
    /// Values at the edges at each stage of a batch, or once if they are constant.
    pub edges: Vec<f64>,
}

impl<T: Real> WaveWorkspace<T> {
    /// Allocates buffers for an integrator.
    pub fn new(method: &Facts, cells: usize, rows: usize, stages: usize) -> Self {
        let registers = vec![vec![T::ZERO; cells]; method.registers - method.persistent];
        let (amplitudes, edges) = (Vec::new(), Vec::new());
        Self { before: vec![T::ZERO; cells], registers, kinetic: vec![0.0; rows * stages], amplitudes, edges }
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        let columns = self.registers.iter().chain([&self.before]).map(|column| size_of_val(column.as_slice())).sum::<usize>();
        columns + size_of_val(self.kinetic.as_slice()) + size_of::<f64>() * (self.amplitudes.capacity() + self.edges.capacity())
    }
}

/// Block of all rows of a state, for writing by stages. The first column is the rate; the registers follow.
pub fn block<'a, T>(
    state: &'a mut WaveState<T>,
    workspace: &'a mut WaveWorkspace<T>,
    length: usize,
    stages: usize,
) -> Block<'a, T, WaveTally> {
    let rows = state.tallies.len();
    let mut columns =
        std::iter::once(&mut state.rate).chain(&mut state.persistent).chain(&mut workspace.registers).map(Vec::as_mut_slice);
    Block {
        first: 0,
        field: &mut state.displacement,
        before: &mut workspace.before,
        columns: std::array::from_fn(|_| columns.next().unwrap_or_default()),
        tallies: &mut state.tallies,
        activity: &mut workspace.kinetic,
        rows,
        length,
        stages,
    }
}

/// Adjacent cells of a row, for writing by a stage.
#[derive(Debug)]
pub struct WaveCells<'a, T> {
    pub displacement: &'a mut [T],
    pub rate: &'a mut [T],
    pub registers: [&'a mut [T]; REGISTERS],
}

impl<'a, T> WaveCells<'a, T> {
    /// Returns cells of the row `row` of a block.
    #[inline(always)]
    pub fn of(block: &'a mut Block<'_, T, WaveTally>, row: usize, range: Range<usize>) -> Self {
        let range = row * block.length + range.start..row * block.length + range.end;
        let [rate, registers @ ..] = &mut block.columns;
        Self {
            displacement: &mut block.field[range.clone()],
            rate: &mut rate[range.clone()],
            registers: registers.each_mut().map(|column| if column.is_empty() { &mut [] } else { &mut column[range.clone()] }),
        }
    }
}
