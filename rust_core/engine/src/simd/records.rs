//! Reading the records of several particles at once.

use super::{LANES, Lanes};

/// The words of a record: 32 bytes in f32, so that a record is never in two cache lines.
pub const WORDS: usize = 8;

/// What a pair sum reads of one particle.
pub type Record<W> = [W; WORDS];

/// The words of the records at some indices, one lane per record.
///
/// # Panics
/// If an index is past the end.
#[inline(always)]
pub fn transpose<W: Copy + Default>(records: &[Record<W>], indices: &Lanes<u32>) -> Record<Lanes<W>> {
    let mut words = [[W::default(); LANES]; WORDS];
    for lane in 0..LANES {
        let record = &records[indices[lane] as usize];
        for word in 0..WORDS {
            words[word][lane] = record[word];
        }
    }
    words
}
