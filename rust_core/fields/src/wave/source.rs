//! Sources: accelerations s(t) that do not depend on the field.

use std::f64::consts::{PI, TAU};
use std::ops::Range;
use std::sync::Arc;

use crate::error::Result;
use crate::grid::{Grid, Padding};
use crate::scene::{Argument, Callback, Item, Value};

/// Time dependence of a source.
#[derive(Clone)]
enum Signal {
    /// Sine sin(2πft + φ).
    Sine { frequency: f64, phase: f64 },
    /// Ricker wavelet (1 − 2π²f²τ²) exp(−π²f²τ²) with τ = t − 1.5/f; at the start it is 0 within 2e-8 of its peak.
    Ricker { frequency: f64 },
    /// User-defined function, with its path.
    Function { function: Arc<dyn Callback>, path: String },
}

/// Source: amplitude · signal(t) for start ≤ t < stop.
#[derive(Clone)]
struct Source {
    amplitude: f64,
    start: f64,
    stop: f64,
    signal: Signal,
}

/// Cells of a source in one row.
#[derive(Debug, Clone)]
pub struct SourceCells {
    /// Index of the source.
    pub source: usize,
    row: usize,
    /// First of these cells in the row.
    pub first: usize,
    /// Factors from the amplitude to s, cell by cell.
    pub weights: Vec<f64>,
}

/// All sources of a wave.
#[derive(Default)]
pub struct Sources {
    all: Vec<Source>,
    /// Patches of all sources, row by row.
    patches: Vec<SourceCells>,
    /// Range of the patches of each row.
    rows: Vec<Range<usize>>,
}

impl Sources {
    /// Reads the sources that an item declares. None acts on walls.
    ///
    /// # Errors
    /// If a value is missing, of the wrong shape or out of range.
    pub fn declared(item: &Item, padding: &Padding, walls: Option<&[bool]>) -> Result<Self> {
        let records = item.records("sources")?;
        let all = records.iter().map(Source::declared).collect::<Result<_>>()?;
        let mut patches = Vec::new();
        for (source, record) in records.iter().enumerate() {
            let mut cells = cells(record, &padding.inner)?;
            cells.iter_mut().for_each(|(cell, _)| *cell = padding.outward(*cell));
            cells.retain(|&(cell, weight)| weight != 0.0 && !walls.is_some_and(|walls| walls[cell]));
            cells.sort_by_key(|&(cell, _)| cell);
            let length = padding.outer.row_length();
            for cells in cells.chunk_by(|one, other| one.0 / length == other.0 / length) {
                let (first, last) = (cells[0].0, cells[cells.len() - 1].0);
                let mut weights = vec![0.0; last - first + 1];
                cells.iter().for_each(|&(cell, weight)| weights[cell - first] += weight);
                patches.push(SourceCells { source, row: first / length, first: first % length, weights });
            }
        }
        patches.sort_by_key(|patch| patch.row);
        let mut rows = vec![0..0; if patches.is_empty() { 0 } else { padding.outer.rows() }];
        for (index, patch) in patches.iter().enumerate() {
            let range = &mut rows[patch.row];
            *range = if range.start == range.end { index..index + 1 } else { range.start..index + 1 };
        }
        Ok(Self { all, patches, rows })
    }

    /// Number of sources.
    pub fn count(&self) -> usize {
        self.all.len()
    }

    /// Whether any source is a user-defined function.
    pub fn calls_back(&self) -> bool {
        self.all.iter().any(|source| matches!(source.signal, Signal::Function { .. }))
    }

    /// Appends the amplitudes of all sources at a time to a list.
    ///
    /// # Errors
    /// If a user-defined function fails.
    pub fn amplitudes(&self, time: f64, list: &mut Vec<f64>) -> Result<()> {
        for source in &self.all {
            list.push(source.at(time)?);
        }
        Ok(())
    }

    /// Largest amplitudes of the sources, as far as they are known.
    pub fn largest(&self) -> impl Iterator<Item = f64> {
        self.all.iter().map(|source| source.amplitude.abs())
    }

    /// Patches in a row.
    pub fn in_row(&self, row: usize) -> &[SourceCells] {
        self.rows.get(row).map_or(&[], |range| &self.patches[range.clone()])
    }

    /// Calls `each` for the cells of a range in a row that sources drive. The arguments are the index within the range and the
    /// added acceleration [m/s²].
    #[inline(always)]
    pub fn for_each(&self, row: usize, range: Range<usize>, amplitudes: &[f64], mut each: impl FnMut(usize, f64)) {
        for patch in self.in_row(row) {
            let (from, to) = (patch.first.max(range.start), (patch.first + patch.weights.len()).min(range.end));
            for cell in from..to {
                each(cell - range.start, amplitudes[patch.source] * patch.weights[cell - patch.first]);
            }
        }
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        let weights: usize = self.patches.iter().map(|patch| size_of_val(patch.weights.as_slice())).sum();
        weights + size_of_val(self.patches.as_slice()) + size_of_val(self.rows.as_slice())
    }
}

impl Source {
    fn declared(item: &Item) -> Result<Self> {
        let signal = match item.values.get("signal") {
            None => Signal::Sine { frequency: item.number("frequency")?, phase: item.number("phase")? },
            Some(Value::Callback(function)) => {
                Signal::Function { function: Arc::clone(function), path: format!("{}.signal", item.path) }
            }
            Some(Value::Record(record)) if record.kind == "Ricker" => match record.non_negative("frequency")? {
                0.0 => return Err(record.wrong("frequency", "a number > 0", record.values.get("frequency"))),
                frequency => Signal::Ricker { frequency },
            },
            other => return Err(item.wrong("signal", "a Ricker or a function", other)),
        };
        let stop = match item.values.get("stop") {
            Some(Value::Number(stop)) if !stop.is_nan() => *stop,
            other => return Err(item.wrong("stop", "a number", other)),
        };
        Ok(Self { amplitude: item.number("amplitude")?, start: item.number("start")?, stop, signal })
    }

    fn at(&self, time: f64) -> Result<f64> {
        if !(self.start..self.stop).contains(&time) {
            return Ok(0.0);
        }
        let signal = match &self.signal {
            // Whole periods are removed before the multiplication by 2π.
            Signal::Sine { frequency, phase } => {
                let periods = frequency * time;
                libm::sin(TAU * (periods - libm::floor(periods)) + phase)
            }
            Signal::Ricker { frequency } => {
                let square = (PI * (frequency * time - 1.5)).powi(2);
                (1.0 - 2.0 * square) * libm::exp(-square)
            }
            Signal::Function { function, path } => {
                let numbers = function.call(&[Argument::Number(time)], "a number", &[]);
                numbers.map_err(|failure| failure.at(path.clone()))?.first().copied().unwrap_or(f64::NAN)
            }
        };
        Ok(self.amplitude * signal)
    }
}

/// Cells in which a source acts, with the factors from its amplitude to s.
fn cells(item: &Item, grid: &Grid) -> Result<Vec<(usize, f64)>> {
    match item.values.get("where") {
        Some(Value::Vector(point)) if point.is_finite() => {
            let mut inside = [0.0; 3];
            (0..grid.dimension).for_each(|axis| inside[grid.axis(axis)] = point.to_array()[axis]);
            Ok(grid.nearest(inside).into_iter().map(|(cell, weight)| (cell, weight / grid.content())).collect())
        }
        Some(Value::Flags(_)) => {
            let mask = grid.mask(item, "where")?.unwrap_or_default();
            Ok(mask.iter().enumerate().map(|(cell, &flag)| (cell, f64::from(u8::from(flag)))).collect())
        }
        Some(Value::Numbers(_)) => {
            let table = grid.field(item, "where")?;
            let rows = (0..grid.rows()).flat_map(|row| table.row(row));
            Ok(rows.copied().enumerate().collect())
        }
        other => Err(item.wrong("where", "a point, a mask or a field", other)),
    }
}
