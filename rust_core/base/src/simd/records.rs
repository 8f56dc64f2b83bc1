//! Records: input of a pair sum for each particle, in a layout for interleaved reads.

use crate::aligned::Aligned;

/// Number of words of a record: 32 bytes in f32.
pub const WORDS: usize = 8;

/// Input of a pair sum for one particle.
pub type ParticleRecord<W> = [W; WORDS];

/// Table of consecutive records, aligned to cache lines: reading a record that straddles two lines costs twice as much.
pub type RecordTable<W> = Aligned<ParticleRecord<W>>;
