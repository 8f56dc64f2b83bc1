//! Reading a column at indices that are checked once, when they are built, instead of at every read.

use super::{LANES, Lanes};

/// Indices into columns of a known length.
#[derive(Debug, Clone, Default)]
pub struct Gather {
    indices: Vec<u32>,
    length: usize,
}

impl Gather {
    /// Indices for columns of at least `length` elements.
    ///
    /// # Panics
    /// If an index is not below `length`, or their number is not a whole number of lanes.
    pub fn new(indices: Vec<u32>, length: usize) -> Self {
        assert!(indices.iter().all(|&index| (index as usize) < length), "an index lies outside its column");
        assert!(indices.len().is_multiple_of(LANES), "indices come in whole groups of lanes");
        Self { indices, length }
    }

    /// The number of groups of lanes.
    pub fn groups(&self) -> usize {
        self.indices.len() / LANES
    }

    /// The memory that the indices take [bytes].
    pub fn bytes(&self) -> usize {
        std::mem::size_of_val(self.indices.as_slice())
    }

    /// The elements of `column` at the indices of one group.
    ///
    /// # Panics
    /// If the column is shorter than promised or there is no such group.
    #[inline(always)]
    pub fn read<T: Copy>(&self, group: usize, column: &[T]) -> Lanes<T> {
        assert!(column.len() >= self.length);
        let indices = &self.indices[group * LANES..][..LANES];
        // SAFETY: every index is below `self.length` (checked in `new`), which is at most the column's length.
        std::array::from_fn(|lane| unsafe { *column.get_unchecked(indices[lane] as usize) })
    }
}
