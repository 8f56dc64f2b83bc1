//! Gathers: reads of a column at indices that are checked once, when they are built, not at every read.

use std::ops::Range;

use super::{LANES, Lanes};

/// Indices into columns of a known length. They are signed, as hardware gathers require.
#[derive(Debug, Clone, Default)]
pub struct Gather {
    indices: Vec<Lanes<i32>>,
    length: usize,
}

impl Gather {
    /// Builds indices for columns of at least `length` elements; `length` must be below 2³¹.
    ///
    /// # Panics
    /// If an index is not below `length`, or the number of indices is not a multiple of the lanes.
    #[inline]
    pub fn new(indices: &[u32], length: usize) -> Self {
        assert!(i32::try_from(length).is_ok(), "a column is too long to be indexed");
        assert!(indices.iter().all(|&index| (index as usize) < length), "an index lies outside its column");
        let (groups, rest) = indices.as_chunks::<LANES>();
        assert!(rest.is_empty(), "indices come in whole groups of lanes");
        Self { indices: groups.iter().map(|group| group.map(u32::cast_signed)).collect(), length }
    }

    /// Memory [bytes].
    #[inline]
    pub fn bytes(&self) -> usize {
        std::mem::size_of_val(self.indices.as_slice())
    }

    /// Indices of one group.
    #[inline(always)]
    pub fn indices(&self, group: usize) -> &Lanes<i32> {
        &self.indices[group]
    }

    /// Copies the elements of `column` at the indices of some groups. This is a separate loop, because compilers emit gathers for
    /// no other form.
    ///
    /// # Panics
    /// If the column is shorter than promised, the groups do not exist, or `out` has another number of groups.
    #[inline(always)]
    pub fn read<T: Copy>(&self, groups: Range<usize>, column: &[T], out: &mut [Lanes<T>]) {
        let (indices, out) = (self.indices[groups].as_flattened(), out.as_flattened_mut());
        assert!(column.len() >= self.length && out.len() == indices.len());
        for (out, &index) in out.iter_mut().zip(indices) {
            // SAFETY: every index is at least 0 and below `self.length` (checked in `new`), the least length of a column.
            *out = unsafe { *column.get_unchecked(index as usize) };
        }
    }
}
