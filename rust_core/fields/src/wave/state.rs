//! State of a wave, and the buffers of its steps.

use std::ops::Range;

use crate::error::Result;
use crate::grid::Block;
use crate::history::{Archive, TALLIES};
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

/// Name of a persistent register in archives.
pub fn register(index: usize) -> String {
    format!("registers[{index}]")
}

/// Fills a column of numbers from an archive.
pub fn fill<T: Real>(name: &str, column: &mut [T], archive: &mut Archive) -> Result<()> {
    let numbers = archive.read_exactly(name, column.len())?;
    column.iter_mut().zip(numbers).for_each(|(slot, &number)| *slot = T::from_f64(number));
    Ok(())
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
    /// Writes the columns and the tallies to an archive.
    pub fn capture(&self, archive: &mut Archive) {
        let mut write = |name: &str, column: &[T]| archive.write(name, column.iter().map(|number| number.to_f64()));
        write("displacement", &self.displacement);
        write("rate", &self.rate);
        self.persistent.iter().enumerate().for_each(|(index, column)| write(&register(index), column));
        archive.write(TALLIES, self.tallies.iter().flat_map(|tally| tally.energy.into_iter().chain(tally.last)));
    }

    /// Reads the columns and the tallies from an archive.
    ///
    /// # Errors
    /// If an array is missing or of another size.
    pub fn restore(&mut self, archive: &mut Archive) -> Result<()> {
        fill("displacement", &mut self.displacement, archive)?;
        fill("rate", &mut self.rate, archive)?;
        self.persistent.iter_mut().enumerate().try_for_each(|(index, column)| fill(&register(index), column, archive))?;
        let numbers = archive.read_exactly(TALLIES, 2 * SINKS * self.tallies.len())?;
        for (tally, numbers) in self.tallies.iter_mut().zip(numbers.chunks_exact(2 * SINKS)) {
            tally.energy.copy_from_slice(&numbers[..SINKS]);
            tally.last.copy_from_slice(&numbers[SINKS..]);
        }
        Ok(())
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        let columns = [&self.displacement, &self.rate].into_iter().chain(&self.persistent);
        columns.map(|column| size_of_val(column.as_slice())).sum::<usize>() + size_of_val(self.tallies.as_slice())
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
