//! Built-in kinetics whose parameters are numbers or fields.

use std::ops::Range;

use super::kinetics::RateLaw;
use crate::error::Result;
use crate::grid::{Grid, RowTable};
use crate::math::Real;
use crate::memory;
use crate::scene::{Item, Value};
use crate::simd::{Isa, Kernel, dispatch};

/// Maximum number of parameters of built-in kinetics.
pub const PARAMETERS: usize = 4;

/// Kinetics `L` with parameters in each cell.
#[derive(Debug, Clone)]
pub struct CellKinetics<T, L> {
    /// Kinetics in all cells; None if a parameter is a field.
    pub uniform: Option<L>,
    /// Parameters of all cells; empty if they are uniform.
    fields: Vec<RowTable<T>>,
}

/// Kinetics `L` in the cells of a row.
#[derive(Debug, Clone, Copy)]
pub struct RowKinetics<'a, T, L> {
    uniform: Option<L>,
    parameters: [&'a [T]; PARAMETERS],
}

impl<T: Real, L: RateLaw<T>> CellKinetics<T, L> {
    /// Reads parameters, each a number or a field, by `read`. `derive` turns the given values of a cell into those of
    /// [`RateLaw::new`].
    ///
    /// # Errors
    /// If a parameter is missing, of another shape, or not finite.
    pub fn declared(
        item: &Item,
        grid: &Grid,
        names: &[&str],
        read: fn(&Grid, &Item, &str) -> Result<RowTable<f64>>,
        derive: fn([f64; PARAMETERS]) -> [f64; PARAMETERS],
    ) -> Result<Self> {
        let varies = names.iter().any(|&name| matches!(item.values.get(name), Some(Value::Numbers(_))));
        let bytes = PARAMETERS * (size_of::<f64>() + size_of::<T>()) * grid.count();
        memory::check("the parameters of the reaction", if varies { bytes } else { 0 }, 0, || "a coarser grid".to_owned())?;
        let given = names.iter().map(|name| read(grid, item, name)).collect::<Result<Vec<_>>>()?;
        let values = |row: usize, column: usize| {
            let mut values = [0.0; PARAMETERS];
            values.iter_mut().zip(&given).for_each(|(value, table)| *value = table.row(row)[column]);
            derive(values).map(T::from_f64)
        };
        if !varies {
            return Ok(Self { uniform: Some(L::new(values(0, 0))), fields: Vec::new() });
        }
        let table = |parameter: usize| {
            RowTable::new(grid.rows(), grid.row_length(), T::ZERO, |row, slots| {
                slots.iter_mut().enumerate().for_each(|(column, slot)| *slot = values(row, column)[parameter]);
            })
        };
        Ok(Self { uniform: None, fields: (0..PARAMETERS).map(table).collect() })
    }

    /// Kinetics in the cells of a row.
    pub fn row(&self, row: usize) -> RowKinetics<'_, T, L> {
        let parameters = std::array::from_fn(|index| self.fields.get(index).map_or(&[][..], |table| table.row(row)));
        RowKinetics { uniform: self.uniform, parameters }
    }

    /// Memory of the parameters [bytes].
    pub fn bytes(&self) -> usize {
        self.fields.iter().map(RowTable::bytes).sum()
    }
}

impl<T: Real, L: RateLaw<T>> RowKinetics<'_, T, L> {
    /// Kinetics in a cell.
    #[inline(always)]
    pub fn at(&self, cell: usize) -> L {
        self.uniform.unwrap_or_else(|| L::new(self.parameters.map(|values| values[cell])))
    }

    /// Computes the rates of both species in the cells `range` of the row, one species after the other.
    pub fn rates(self, range: Range<usize>, values: [&[T]; 2], out: &mut [T]) {
        dispatch(RowRates { kinetics: self, range, values, out });
    }
}

struct RowRates<'a, T, L> {
    kinetics: RowKinetics<'a, T, L>,
    range: Range<usize>,
    values: [&'a [T]; 2],
    out: &'a mut [T],
}

impl<T: Real, L: RateLaw<T>> Kernel for RowRates<'_, T, L> {
    type Output = ();

    #[inline(always)]
    fn run<S: Isa>(self, _isa: S) {
        let Self { kinetics, range, values, out } = self;
        let count = range.len();
        let (one, other) = out.split_at_mut(count);
        let [u, v] = values.map(|row| &row[range.clone()]);
        let parameters = kinetics.parameters.map(|row| &row[range.clone()]);
        for cell in 0..count {
            [one[cell], other[cell]] = L::new(parameters.map(|values| values[cell])).rates([u[cell], v[cell]]);
        }
    }
}
