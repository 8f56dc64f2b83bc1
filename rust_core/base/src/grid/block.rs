//! Output of the stages of a step: rows of cells in blocks, one block per thread.

use crate::parallel::Split;

/// Maximum number of columns besides the two of the field.
pub const COLUMNS: usize = 7;

/// Consecutive rows. Each column has `length` numbers per row, or is empty.
#[derive(Debug)]
pub struct Block<'a, T, Y> {
    /// Index of the first row.
    pub first: usize,
    /// Field at the stage being computed.
    pub field: &'a mut [T],
    /// Field at the previous stage, which neighbors read; empty if all blocks share it.
    pub before: &'a mut [T],
    /// Further quantities of each cell.
    pub columns: [&'a mut [T]; COLUMNS],
    /// Quantities integrated over time, row by row.
    pub tallies: &'a mut [Y],
    /// Activity of each row at each stage.
    pub activity: &'a mut [f64],
    /// Number of stages.
    pub stages: usize,
    /// Number of values of the field in a row.
    pub length: usize,
    /// Number of rows in a block.
    pub rows: usize,
}

impl<T, Y> Block<'_, T, Y> {
    /// Number of rows.
    #[inline]
    pub fn count(&self) -> usize {
        self.field.len() / self.length
    }

    /// Reborrows the block.
    #[inline]
    pub fn reborrow(&mut self) -> Block<'_, T, Y> {
        Block {
            field: &mut *self.field,
            before: &mut *self.before,
            columns: self.columns.each_mut().map(|column| &mut **column),
            tallies: &mut *self.tallies,
            activity: &mut *self.activity,
            ..*self
        }
    }

    /// Splits the block before a row.
    pub fn split_at_row(self, row: usize) -> (Self, Self) {
        let count = self.count();
        let Self { first, field, before, columns, tallies, activity, stages, length, rows } = self;
        let (before, other_before) = split(before, row * length);
        let (field, other_field) = split(field, row * length);
        let (tallies, other_tallies) = split(tallies, row * (tallies.len() / count.max(1)));
        let (activity, other_activity) = split(activity, row * stages);
        let mut pairs = columns.map(|column| split(column, row * length));
        let lower = pairs.each_mut().map(|(lower, _)| std::mem::take(lower));
        let upper = pairs.map(|(_, upper)| upper);
        let others = Self {
            first: first + row,
            field: other_field,
            before: other_before,
            columns: upper,
            tallies: other_tallies,
            activity: other_activity,
            stages,
            length,
            rows,
        };
        (Self { first, field, before, columns: lower, tallies, activity, stages, length, rows }, others)
    }
}

/// Splits a column; an empty column gives two empty ones.
fn split<T>(column: &mut [T], at: usize) -> (&mut [T], &mut [T]) {
    let at = at.min(column.len());
    column.split_at_mut(at)
}

impl<T: Send, Y: Send> Split for Block<'_, T, Y> {
    fn blocks(&self) -> usize {
        self.count().div_ceil(self.rows)
    }

    fn split_at(self, blocks: usize) -> (Self, Self) {
        let row = (blocks * self.rows).min(self.count());
        self.split_at_row(row)
    }
}
