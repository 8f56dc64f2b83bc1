//! Reading the records of several particles at once.
//!
//! Compilers make loads and insertions of single words of the plain loop. Here quarters of vectors are loaded and interleaved
//! in registers, which `benches/neighbors.rs` shows to be faster. Data is only moved, so all ways give the same bits.

use std::any::TypeId;
use std::mem::MaybeUninit;

use super::{Group, Isa, LANES, Lanes};

/// The words of a record: 32 bytes in f32.
pub const WORDS: usize = 8;

/// What a pair sum reads of one particle.
pub type Record<W> = [W; WORDS];

/// Lanes that begin at a cache line: a vector that straddles two costs twice.
#[repr(align(64))]
struct Aligned<T>(T);

/// The words of the records of a group, one lane per record.
///
/// # Panics
/// If there are fewer records than the bound of the group.
#[inline(always)]
pub fn transpose<I: Isa, W: Copy + Default + 'static>(isa: I, records: &[Record<W>], group: Group<'_>) -> Record<Lanes<W>> {
    assert!(records.len() >= group.bound(), "records that are not there");
    let indices = group.indices();
    let _ = isa;
    #[cfg(target_arch = "x86_64")]
    {
        use super::Level;
        let (single, double) = (TypeId::of::<W>() == TypeId::of::<f32>(), TypeId::of::<W>() == TypeId::of::<f64>());
        let mut words = MaybeUninit::<Aligned<Record<Lanes<W>>>>::uninit();
        let (from, to) = (records.as_ptr(), words.as_mut_ptr());
        // SAFETY: W is the type that the function is for; all indices are below the number of records; `to` has room for
        // all lanes of all words, and each function writes them all; and `isa` exists only where the CPU has these
        // instructions.
        unsafe {
            match I::LEVEL {
                Level::Avx512 if single => x86::single_avx512(from.cast(), indices, to.cast()),
                Level::Avx512 if double => x86::double_avx512(from.cast(), indices, to.cast()),
                Level::Avx2 if single => x86::single_avx2(from.cast(), indices, to.cast()),
                Level::Avx2 if double => x86::double_avx2(from.cast(), indices, to.cast()),
                _ => return plain(records, indices),
            }
            // No instruction, but compilers have to suppose that it changes the words: knowing where they come from, they
            // would put together some of them from pieces, which is slow.
            std::arch::asm!("/* {0} */", in(reg) to, options(nostack, preserves_flags));
            words.assume_init().0
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    plain(records, indices)
}

/// The reference, and the way of all other levels.
#[inline(always)]
fn plain<W: Copy + Default>(records: &[Record<W>], indices: &Lanes<u32>) -> Record<Lanes<W>> {
    let mut words = [[W::default(); LANES]; WORDS];
    for lane in 0..LANES {
        let record = &records[indices[lane] as usize];
        for word in 0..WORDS {
            words[word][lane] = record[word];
        }
    }
    words
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    #[allow(clippy::wildcard_imports)]
    use std::arch::x86_64::*;

    use super::{LANES, Lanes, WORDS};

    /// One index. It is read as volatile, because compilers would else compute all addresses in vectors only to take them
    /// apart again.
    #[inline(always)]
    fn index(indices: &Lanes<u32>, lane: usize) -> usize {
        // SAFETY: a reference to a number can be read.
        unsafe { std::ptr::read_volatile(&raw const indices[lane]) as usize }
    }

    /// # Safety
    /// All indices are those of records, there is room for all lanes of all words, and the CPU has AVX-512 F and DQ.
    #[inline(always)]
    pub unsafe fn single_avx512(records: *const f32, indices: &Lanes<u32>, words: *mut f32) {
        unsafe {
            let mut rows = [_mm512_setzero_ps(); WORDS];
            for row in 0..WORDS {
                // One record in each half.
                let [low, high] = [row, row + 8].map(|lane| _mm256_loadu_ps(records.add(index(indices, lane) * WORDS)));
                rows[row] = _mm512_insertf32x8::<1>(_mm512_castps256_ps512(low), high);
            }
            let [a, b, c, d, e, f, g, h] = rows;
            // Words 0, 1 and 4, 5 of four records, then of all eight; and likewise the others.
            let pairs = |one: __m512, other: __m512| {
                (_mm512_castps_pd(_mm512_unpacklo_ps(one, other)), _mm512_castps_pd(_mm512_unpackhi_ps(one, other)))
            };
            let (ab, cd, ef, gh) = (pairs(a, b), pairs(c, d), pairs(e, f), pairs(g, h));
            let fours = [
                (_mm512_unpacklo_pd(ab.0, cd.0), _mm512_unpacklo_pd(ef.0, gh.0)),
                (_mm512_unpackhi_pd(ab.0, cd.0), _mm512_unpackhi_pd(ef.0, gh.0)),
                (_mm512_unpacklo_pd(ab.1, cd.1), _mm512_unpacklo_pd(ef.1, gh.1)),
                (_mm512_unpackhi_pd(ab.1, cd.1), _mm512_unpackhi_pd(ef.1, gh.1)),
            ];
            // Quarters in the order 0, 0, 2, 2 and 1, 1, 3, 3 of both.
            let low = _mm512_setr_epi64(0, 1, 8, 9, 4, 5, 12, 13);
            let high = _mm512_setr_epi64(2, 3, 10, 11, 6, 7, 14, 15);
            for (word, (first, second)) in fours.into_iter().enumerate() {
                let store = |word: usize, lanes: __m512d| _mm512_storeu_ps(words.add(word * LANES), _mm512_castpd_ps(lanes));
                store(word, _mm512_permutex2var_pd(first, low, second));
                store(word + WORDS / 2, _mm512_permutex2var_pd(first, high, second));
            }
        }
    }

    /// # Safety
    /// All indices are those of records, there is room for all lanes of all words, and the CPU has AVX2.
    #[inline(always)]
    pub unsafe fn single_avx2(records: *const f32, indices: &Lanes<u32>, words: *mut f32) {
        unsafe {
            for part in 0..2 {
                let zero = _mm256_setzero_ps();
                let (mut first, mut second) = ([zero; 4], [zero; 4]);
                for row in 0..4 {
                    let [a, b] = [8 * part + row, 8 * part + row + 4].map(|lane| records.add(index(indices, lane) * WORDS));
                    let quarters = |word: usize| {
                        let vector = _mm256_castps128_ps256(_mm_loadu_ps(a.add(word)));
                        _mm256_insertf128_ps::<1>(vector, _mm_loadu_ps(b.add(word)))
                    };
                    (first[row], second[row]) = (quarters(0), quarters(4));
                }
                for (half, [a, b, c, d]) in [first, second].into_iter().enumerate() {
                    let low = (_mm256_castps_pd(_mm256_unpacklo_ps(a, b)), _mm256_castps_pd(_mm256_unpacklo_ps(c, d)));
                    let high = (_mm256_castps_pd(_mm256_unpackhi_ps(a, b)), _mm256_castps_pd(_mm256_unpackhi_ps(c, d)));
                    let to = words.add(half * WORDS / 2 * LANES + 8 * part);
                    _mm256_storeu_ps(to, _mm256_castpd_ps(_mm256_unpacklo_pd(low.0, low.1)));
                    _mm256_storeu_ps(to.add(LANES), _mm256_castpd_ps(_mm256_unpackhi_pd(low.0, low.1)));
                    _mm256_storeu_ps(to.add(2 * LANES), _mm256_castpd_ps(_mm256_unpacklo_pd(high.0, high.1)));
                    _mm256_storeu_ps(to.add(3 * LANES), _mm256_castpd_ps(_mm256_unpackhi_pd(high.0, high.1)));
                }
            }
        }
    }

    /// # Safety
    /// All indices are those of records, there is room for all lanes of all words, and the CPU has AVX-512 F and DQ.
    #[inline(always)]
    pub unsafe fn double_avx512(records: *const f64, indices: &Lanes<u32>, words: *mut f64) {
        unsafe {
            for part in 0..2 {
                let zero = _mm512_setzero_pd();
                let mut rows = [[zero; 2]; WORDS / 2];
                for row in 0..2 {
                    let start = 8 * part + row;
                    let [a, b, c, d] =
                        [start, start + 2, start + 4, start + 6].map(|lane| records.add(index(indices, lane) * WORDS));
                    for pair in 0..WORDS / 2 {
                        let vector = _mm512_castpd128_pd512(_mm_loadu_pd(a.add(2 * pair)));
                        let vector = _mm512_insertf64x2::<1>(vector, _mm_loadu_pd(b.add(2 * pair)));
                        let vector = _mm512_insertf64x2::<2>(vector, _mm_loadu_pd(c.add(2 * pair)));
                        rows[pair][row] = _mm512_insertf64x2::<3>(vector, _mm_loadu_pd(d.add(2 * pair)));
                    }
                }
                for (pair, [a, b]) in rows.into_iter().enumerate() {
                    let to = words.add(2 * pair * LANES + 8 * part);
                    _mm512_storeu_pd(to, _mm512_unpacklo_pd(a, b));
                    _mm512_storeu_pd(to.add(LANES), _mm512_unpackhi_pd(a, b));
                }
            }
        }
    }

    /// # Safety
    /// All indices are those of records, there is room for all lanes of all words, and the CPU has AVX2.
    #[inline(always)]
    pub unsafe fn double_avx2(records: *const f64, indices: &Lanes<u32>, words: *mut f64) {
        unsafe {
            for part in 0..4 {
                let mut rows = [[_mm256_setzero_pd(); 2]; WORDS / 2];
                for row in 0..2 {
                    let start = 4 * part + row;
                    let [a, b] = [start, start + 2].map(|lane| records.add(index(indices, lane) * WORDS));
                    for pair in 0..WORDS / 2 {
                        let vector = _mm256_castpd128_pd256(_mm_loadu_pd(a.add(2 * pair)));
                        rows[pair][row] = _mm256_insertf128_pd::<1>(vector, _mm_loadu_pd(b.add(2 * pair)));
                    }
                }
                for (pair, [a, b]) in rows.into_iter().enumerate() {
                    let to = words.add(2 * pair * LANES + 4 * part);
                    _mm256_storeu_pd(to, _mm256_unpacklo_pd(a, b));
                    _mm256_storeu_pd(to.add(LANES), _mm256_unpackhi_pd(a, b));
                }
            }
        }
    }
}
