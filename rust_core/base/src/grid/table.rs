//! Coefficients of the cells, row by row, with equal rows held once.

/// One number for each cell. Equal rows share their memory, so that what varies along few axes takes little of it and stays
/// in the cache.
#[derive(Debug, Clone, PartialEq)]
pub struct RowTable<T> {
    length: usize,
    values: Vec<T>,
    /// Where the values of each row begin.
    starts: Vec<usize>,
}

/// How many of the last different rows a new one is compared with.
const COMPARED: usize = 4;

impl<T: Copy + PartialEq> RowTable<T> {
    /// The table of `rows` rows of `length` numbers, each filled by `fill`.
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

    /// The numbers of a row.
    #[inline(always)]
    pub fn row(&self, row: usize) -> &[T] {
        &self.values[self.starts[row]..self.starts[row] + self.length]
    }

    /// Its different rows, one after the other.
    pub fn different(&self) -> &[T] {
        &self.values
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        size_of_val(self.values.as_slice()) + size_of_val(self.starts.as_slice())
    }
}
