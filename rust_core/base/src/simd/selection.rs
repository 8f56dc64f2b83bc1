//! Selections: indices of the lanes that pass a test, which need no bounds check when they are read.

use super::{Isa, LANES, Lanes};

/// Indices below a bound, in groups. After [`Selection::spare`] the storage exceeds the selection by a group of lanes, so groups
/// are read whole.
#[derive(Debug)]
pub struct Selection {
    /// Indices. All are below the bound, including those past the end of the selection.
    entries: Vec<u32>,
    length: usize,
    bound: usize,
    /// Whether memory ran out.
    overflowed: bool,
}

/// Group of indices of a [`Selection`].
#[derive(Debug, Clone, Copy)]
pub struct Group<'a> {
    indices: &'a Lanes<u32>,
    bound: usize,
}

impl<'a> Group<'a> {
    /// Indices, all below the bound.
    #[inline(always)]
    pub fn indices(&self) -> &'a Lanes<u32> {
        self.indices
    }

    /// Bound of all indices.
    #[inline(always)]
    pub fn bound(&self) -> usize {
        self.bound
    }
}

impl Selection {
    /// Returns an empty selection of indices below `bound`.
    ///
    /// # Panics
    /// If the bound is less than a group of lanes.
    #[inline]
    pub fn new(bound: usize) -> Self {
        assert!(bound >= LANES && u32::try_from(bound).is_ok(), "a bound that is too small or too large");
        Self { entries: vec![0; LANES], length: 0, bound, overflowed: false }
    }

    /// Memory [bytes].
    #[inline]
    pub fn bytes(&self) -> usize {
        self.entries.capacity() * size_of::<u32>()
    }

    /// Number of indices.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.length
    }

    /// Whether there are no indices.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.length == 0
    }

    /// Empties the selection.
    #[inline]
    pub fn clear(&mut self) {
        self.length = 0;
        self.overflowed = false;
    }

    /// Retains the indices from `start` on for which `keep` holds, in their order.
    pub fn retain(&mut self, start: usize, keep: impl Fn(u32) -> bool) {
        let mut end = start;
        for at in start..self.length {
            self.entries[end] = self.entries[at];
            end += usize::from(keep(self.entries[at]));
        }
        self.length = end;
    }

    /// Whether memory ran out since the last clear; the beginning of the selection is then overwritten.
    #[inline]
    pub fn has_overflowed(&self) -> bool {
        self.overflowed
    }

    /// Reserves an eighth more than the present length. The next selection of similar length then needs no allocation.
    #[inline]
    pub fn spare(&mut self) {
        if self.entries.len() < self.length + self.length / 8 + LANES {
            self.grow(0);
        }
    }

    /// Indices from `start` to `end`.
    #[inline(always)]
    pub fn list(&self, start: usize, end: usize) -> &[u32] {
        &self.entries[start..end]
    }

    /// Indices from `start` to `end` in groups; the last group may extend beyond `end`.
    #[inline(always)]
    pub fn groups(&self, start: usize, end: usize) -> impl Iterator<Item = Group<'_>> + Clone {
        let bound = self.bound;
        let whole = self.entries[start..][..(end - start).next_multiple_of(LANES)].as_chunks().0;
        whole.iter().map(move |indices| Group { indices, bound })
    }

    /// Makes room for at least `more` further indices.
    #[cold]
    fn grow(&mut self, more: usize) {
        let length = self.length + self.length / 8 + more + 4 * LANES;
        if self.entries.try_reserve_exact(length - self.entries.len()).is_ok() {
            self.entries.resize(length, 0);
        } else {
            // Further indices overwrite the beginning.
            (self.length, self.overflowed) = (0, true);
        }
    }

    /// Adds an index if `counts` holds.
    ///
    /// # Panics
    /// If the index is not below the bound.
    #[inline(always)]
    pub fn push(&mut self, index: u32, counts: bool) {
        assert!((index as usize) < self.bound, "an index past the bound");
        if self.entries.len() < self.length + LANES + 1 {
            self.grow(0);
        }
        // Written in any case, because the branch would be hard to predict.
        self.entries[self.length] = index;
        self.length += usize::from(counts);
    }

    /// Adds `first` plus the number of each lane of a mask, in order.
    ///
    /// # Panics
    /// If an index could reach the bound.
    #[inline(always)]
    pub fn add<I: Isa>(&mut self, isa: I, first: usize, mask: u16) {
        assert!(first <= self.bound - LANES, "indices past the bound");
        if self.entries.len() < self.length + LANES {
            self.grow(0);
        }
        if let Some(out) = self.entries[self.length..].first_chunk_mut() {
            self.length += compress(isa, first as u32, mask, out);
        }
    }

    /// Adds all indices of another selection. If the other has overflowed, so has this one.
    ///
    /// # Panics
    /// If the bound of the other selection is greater.
    #[inline(always)]
    pub fn append(&mut self, other: &Self) {
        assert!(other.bound <= self.bound, "indices past the bound");
        self.overflowed |= other.overflowed;
        if self.entries.len() < self.length + other.length {
            self.grow(other.length);
        }
        if let Some(end) = self.entries.get_mut(self.length..self.length + other.length) {
            end.copy_from_slice(&other.entries[..other.length]);
            self.length += other.length;
        }
    }
}

/// Mask of the values that are at most `limit`, one bit per lane.
#[inline(always)]
pub fn at_most<I: Isa>(isa: I, values: &Lanes<f64>, limit: f64) -> u16 {
    let _ = isa;
    #[cfg(target_arch = "x86_64")]
    // SAFETY: `isa` exists only where the CPU has these instructions.
    unsafe {
        use super::Level;
        match I::LEVEL {
            Level::Avx512 => return x86::at_most_avx512(values, limit),
            Level::Avx2 => return x86::at_most_avx2(values, limit),
            Level::Portable => {}
        }
    }
    let mut mask = 0;
    for lane in 0..LANES {
        mask |= u16::from(values[lane] <= limit) << lane;
    }
    mask
}

/// Writes `first` plus the number of each lane of a mask to the beginning of `out`, and returns their number. The rest of `out`
/// is unspecified: zeros, or numbers of other lanes.
#[inline(always)]
fn compress<I: Isa>(isa: I, first: u32, mask: u16, out: &mut Lanes<u32>) -> usize {
    let _ = isa;
    #[cfg(target_arch = "x86_64")]
    // SAFETY: `isa` exists only where the CPU has these instructions.
    unsafe {
        use super::Level;
        match I::LEVEL {
            Level::Avx512 => return x86::compress_avx512(first, mask, out),
            Level::Avx2 => return x86::compress_avx2(first, mask, out),
            Level::Portable => {}
        }
    }
    let mut count = 0;
    for lane in 0..LANES {
        // The count never exceeds the lane: the modulus has no effect, but saves a bounds check.
        out[count % LANES] = first + lane as u32;
        count += usize::from(mask & (1 << lane) != 0);
    }
    count
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    #[allow(clippy::wildcard_imports)]
    use std::arch::x86_64::*;

    use super::Lanes;

    /// # Safety
    /// The CPU has AVX-512 F.
    #[inline(always)]
    pub unsafe fn at_most_avx512(values: &Lanes<f64>, limit: f64) -> u16 {
        unsafe {
            let limit = _mm512_set1_pd(limit);
            let mask = |half: usize| _mm512_cmp_pd_mask::<_CMP_LE_OQ>(_mm512_loadu_pd(values[8 * half..].as_ptr()), limit);
            u16::from(mask(0)) | u16::from(mask(1)) << 8
        }
    }

    /// # Safety
    /// The CPU has AVX-512 F.
    #[inline(always)]
    pub unsafe fn compress_avx512(first: u32, mask: u16, out: &mut Lanes<u32>) -> usize {
        unsafe {
            let lanes = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
            let lanes = _mm512_add_epi32(lanes, _mm512_set1_epi32(first.cast_signed()));
            _mm512_storeu_si512(out.as_mut_ptr().cast(), _mm512_maskz_compress_epi32(mask, lanes));
            mask.count_ones() as usize
        }
    }

    /// Table of the indices of the set bits of each byte, one byte per index, followed by zeros.
    const BITS: [u64; 256] = {
        let mut table = [0; 256];
        let mut byte = 0;
        while byte < 256 {
            let (mut bit, mut rank) = (0, 0);
            while bit < 8 {
                if byte & (1 << bit) != 0 {
                    table[byte] |= bit << (8 * rank);
                    rank += 1;
                }
                bit += 1;
            }
            byte += 1;
        }
        table
    };

    /// # Safety
    /// The CPU has AVX2.
    #[inline(always)]
    pub unsafe fn at_most_avx2(values: &Lanes<f64>, limit: f64) -> u16 {
        unsafe {
            let limit = _mm256_set1_pd(limit);
            let mask = |quarter: usize| {
                let values = _mm256_loadu_pd(values[4 * quarter..].as_ptr());
                _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LE_OQ>(values, limit)).cast_unsigned() << (4 * quarter)
            };
            (mask(0) | mask(1) | mask(2) | mask(3)) as u16
        }
    }

    /// # Safety
    /// The CPU has AVX2.
    #[inline(always)]
    pub unsafe fn compress_avx2(first: u32, mask: u16, out: &mut Lanes<u32>) -> usize {
        unsafe {
            let mut count = 0;
            for half in 0..2 {
                let byte = (mask >> (8 * half)) as u8;
                let lanes = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(BITS[usize::from(byte)].cast_signed()));
                let lanes = _mm256_add_epi32(lanes, _mm256_set1_epi32((first + 8 * half).cast_signed()));
                // The second half begins at most 8 past the beginning, so it ends within `out`.
                _mm256_storeu_si256(out.as_mut_ptr().add(count).cast(), lanes);
                count += byte.count_ones() as usize;
            }
            count
        }
    }
}
