//! Coefficients of the cells, row by row; equal rows are stored once.

/// Table of one number per cell. Equal rows share their memory. Coefficients that vary along few axes therefore take little
/// memory and stay in the cache.
#[derive(Debug, Clone, PartialEq)]
pub struct RowTable<T> {
    length: usize,
    values: Vec<T>,
    /// Index at which the values of each row begin.
    starts: Vec<usize>,
}

/// Number of the latest distinct rows with which a new row is compared.
const COMPARED: usize = 4;

impl<T: Copy + PartialEq> RowTable<T> {
    /// Builds a table of `rows` rows of `length` numbers, each filled by `fill`.
    pub fn new(rows: usize, length: usize, blank: T, mut fill: impl FnMut(usize, &mut [T])) -> Self {
        let mut table = Self { length, values: Vec::new(), starts: Vec::with_capacity(rows) };
        let mut next = vec![blank; length];
        for row in 0..rows {
            next.fill(blank);
            fill(row, &mut next);
            let different = table.values.len() / length.max(1);
            let known = (different.saturating_sub(COMPARED)..different).map(|index| index * length);
            let equal = known.rev().find(|&start| table.values[start..start + length] == next[..]);
            let start = equal.unwrap_or_else(|| {
                table.values.extend_from_slice(&next);
                table.values.len() - length
            });
            table.starts.push(start);
        }
        table
    }

    /// Numbers of a row.
    #[inline(always)]
    pub fn row(&self, row: usize) -> &[T] {
        &self.values[self.starts[row]..self.starts[row] + self.length]
    }

    /// Distinct rows, one after the other.
    #[inline]
    pub fn different(&self) -> &[T] {
        &self.values
    }

    /// Memory [bytes].
    #[inline]
    pub fn bytes(&self) -> usize {
        size_of_val(self.values.as_slice()) + size_of_val(self.starts.as_slice())
    }
}
