//! Records: the input of a pair sum for each particle, in a layout for interleaved reads.

use std::ops::{Deref, DerefMut};

/// The words of a record: 32 bytes in f32.
pub const WORDS: usize = 8;

/// The input of a pair sum for one particle.
pub type Record<W> = [W; WORDS];

/// Records one after the other in whole cache lines: one that straddles two of them costs twice.
#[derive(Debug)]
pub struct Table<W> {
    lines: Vec<Line<W>>,
    length: usize,
}

/// Two records: a cache line of single numbers, two of double ones.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
struct Line<W>([Record<W>; 2]);

impl<W> Line<W> {
    const HAS_NO_GAPS: () = assert!(size_of::<Self>() == 2 * size_of::<Record<W>>(), "lines have gaps");
}

impl<W: Copy + Default> Table<W> {
    /// `length` records of zeros.
    pub fn zeros(length: usize) -> Self {
        Self { lines: vec![Line([[W::default(); WORDS]; 2]); length.div_ceil(2)], length }
    }
}

impl<W> Deref for Table<W> {
    type Target = [Record<W>];

    #[inline(always)]
    fn deref(&self) -> &[Record<W>] {
        let () = Line::<W>::HAS_NO_GAPS;
        // SAFETY: a line is two records without gaps, and there are at least `length` of them.
        unsafe { std::slice::from_raw_parts(self.lines.as_ptr().cast(), self.length) }
    }
}

impl<W> DerefMut for Table<W> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [Record<W>] {
        let () = Line::<W>::HAS_NO_GAPS;
        // SAFETY: as above, and the borrow is exclusive.
        unsafe { std::slice::from_raw_parts_mut(self.lines.as_mut_ptr().cast(), self.length) }
    }
}
