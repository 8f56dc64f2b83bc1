//! Records: the input of a pair sum for each particle, in a layout for interleaved reads.

use crate::aligned::Aligned;

/// The words of a record: 32 bytes in f32.
pub const WORDS: usize = 8;

/// The input of a pair sum for one particle.
pub type Record<W> = [W; WORDS];

/// Records one after the other in whole cache lines: one that straddles two of them costs twice.
pub type Table<W> = Aligned<Record<W>>;
