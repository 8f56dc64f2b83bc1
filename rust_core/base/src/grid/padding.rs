//! Absorbing layers of cells around a grid.

use std::ops::Range;

use super::{Grid, RowTable};
use crate::math::AXES;

/// Grid embedded in a larger one.
#[derive(Debug, Clone)]
pub struct Padding {
    /// Inner grid: the user's.
    pub inner: Grid,
    /// Outer grid of all cells.
    pub outer: Grid,
    /// Number of additional cells at the lower and at the upper edge of each axis.
    pub layers: [[usize; 2]; AXES],
}

impl Padding {
    /// Surrounds a grid with layers.
    #[inline]
    pub fn new(inner: &Grid, layers: [[usize; 2]; AXES]) -> Self {
        let mut outer = inner.clone();
        for axis in 0..AXES {
            outer.cells[axis] += layers[axis][0] + layers[axis][1];
            outer.origin[axis] -= layers[axis][0] as f64 * inner.spacing;
        }
        Self { inner: inner.clone(), outer, layers }
    }

    /// Range of the cells of the inner grid along an axis.
    #[inline]
    pub fn inside(&self, axis: usize) -> Range<usize> {
        self.layers[axis][0]..self.layers[axis][0] + self.inner.cells[axis]
    }

    /// Whether a row of the outer grid passes through the inner one.
    #[inline]
    pub fn crosses(&self, row: usize) -> bool {
        let place = self.outer.place(row);
        (0..2).all(|axis| self.inside(axis).contains(&place[axis]))
    }

    /// Row of the inner grid nearest to a row of the outer grid.
    #[inline]
    pub fn nearest_row(&self, row: usize) -> usize {
        let place = self.outer.place(row);
        let nearest = |axis: usize| place[axis].saturating_sub(self.layers[axis][0]).min(self.inner.cells[axis] - 1);
        nearest(0) * self.inner.cells[1] + nearest(1)
    }

    /// Column of the inner grid nearest to a column of the outer grid.
    #[inline]
    pub fn nearest_column(&self, column: usize) -> usize {
        column.saturating_sub(self.layers[2][0]).min(self.inner.cells[2] - 1)
    }

    /// Cell of the inner grid nearest to a cell of the outer grid.
    #[inline]
    pub fn nearest(&self, cell: usize) -> usize {
        let length = self.outer.row_length();
        self.nearest_row(cell / length) * self.inner.row_length() + self.nearest_column(cell % length)
    }

    /// Index in the outer grid of a cell of the inner grid.
    #[inline]
    pub fn outward(&self, cell: usize) -> usize {
        let length = self.inner.row_length();
        let place = self.inner.place(cell / length);
        let row = (place[0] + self.layers[0][0]) * self.outer.cells[1] + place[1] + self.layers[1][0];
        row * self.outer.row_length() + cell % length + self.layers[2][0]
    }

    /// Extends coefficients into the layers by their values at the edges.
    #[inline]
    pub fn extend(&self, table: &RowTable<f64>) -> RowTable<f64> {
        RowTable::new(self.outer.rows(), self.outer.row_length(), 0.0, |row, values| {
            let from = table.row(self.nearest_row(row));
            values.iter_mut().enumerate().for_each(|(column, value)| *value = from[self.nearest_column(column)]);
        })
    }
}
