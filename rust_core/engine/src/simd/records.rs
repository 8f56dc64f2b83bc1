//! Reading the records of several particles at once.
//!
//! Compilers make element-wise loads of the plain loop; loading quarters of vectors and interleaving them in registers is
//! two to three times as fast (`benches/neighbors.rs`). Data is only moved, so all ways give the same bits.

use std::any::TypeId;
use std::mem::{size_of, transmute_copy};

use super::{Group, Isa, LANES, Lanes};

/// The words of a record: 32 bytes in f32.
pub const WORDS: usize = 8;

/// What a pair sum reads of one particle.
pub type Record<W> = [W; WORDS];

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
        // SAFETY: W is the type that the function is for; all indices are below the length; and `isa` exists only where
        // the CPU has these instructions.
        unsafe {
            if single && I::LEVEL == Level::Avx512 {
                return same(single_avx512(records.as_ptr().cast(), indices));
            }
            if single && I::LEVEL == Level::Avx2 {
                return same(single_avx2(records.as_ptr().cast(), indices));
            }
            if double && I::LEVEL == Level::Avx512 {
                return same(double_avx512(records.as_ptr().cast(), indices));
            }
            if double && I::LEVEL == Level::Avx2 {
                return same(double_avx2(records.as_ptr().cast(), indices));
            }
        }
    }
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

/// The same value under another name of its type.
///
/// # Safety
/// The two types must be of one layout, in which every value of the first is one of the second.
#[inline(always)]
unsafe fn same<A: Copy, B: Copy>(value: A) -> B {
    assert!(size_of::<A>() == size_of::<B>(), "not the same");
    unsafe { transmute_copy(&value) }
}

#[cfg(target_arch = "x86_64")]
use x86::{double_avx2, double_avx512, single_avx2, single_avx512};

#[cfg(target_arch = "x86_64")]
mod x86 {
    use std::arch::asm;
    #[allow(clippy::wildcard_imports)]
    use std::arch::x86_64::*;

    use super::{Lanes, Record, WORDS};

    /// The same vector, of which the compiler does not know where it comes from: it would else take some lanes from the
    /// records again, one by one.
    #[inline]
    #[target_feature(enable = "avx512f")]
    fn hide_512(mut vector: __m512) -> __m512 {
        // SAFETY: no instruction at all.
        unsafe { asm!("/* {0} */", inout(zmm_reg) vector, options(pure, nomem, nostack, preserves_flags)) };
        vector
    }

    /// As [`hide_512`].
    #[inline]
    #[target_feature(enable = "avx2")]
    fn hide_256(mut vector: __m256) -> __m256 {
        // SAFETY: no instruction at all.
        unsafe { asm!("/* {0} */", inout(ymm_reg) vector, options(pure, nomem, nostack, preserves_flags)) };
        vector
    }

    /// One index. It is read as volatile, because compilers would else compute all addresses in vectors only to take them
    /// apart again.
    #[inline(always)]
    fn index(indices: &Lanes<u32>, lane: usize) -> usize {
        // SAFETY: a reference to a number can be read.
        unsafe { std::ptr::read_volatile(&raw const indices[lane]) as usize }
    }

    /// The four words of each record from `word` on as one vector per record of a group of four; the groups side by side.
    macro_rules! quarters {
        ($records:ident, $indices:ident, $word:expr, [$($lane:expr),*]) => {
            [$($records.add(index($indices, $lane) * WORDS + $word)),*]
        };
    }

    /// # Safety
    /// All indices are those of records, and the CPU has AVX-512 F and DQ.
    #[inline(always)]
    pub unsafe fn single_avx512(records: *const f32, indices: &Lanes<u32>) -> Record<Lanes<f32>> {
        unsafe {
            let mut words = [_mm512_setzero_ps(); WORDS];
            for half in 0..2 {
                let load = |lane: usize| {
                    let [a, b, c, d] = quarters!(records, indices, 4 * half, [lane, lane + 4, lane + 8, lane + 12]);
                    let low = _mm512_castps128_ps512(_mm_loadu_ps(a));
                    let low = _mm512_insertf32x4::<1>(low, _mm_loadu_ps(b));
                    let low = _mm512_insertf32x4::<2>(low, _mm_loadu_ps(c));
                    _mm512_castps_pd(_mm512_insertf32x4::<3>(low, _mm_loadu_ps(d)))
                };
                let rows = [load(0), load(1), load(2), load(3)].map(|row| _mm512_castpd_ps(row));
                let low =
                    [_mm512_unpacklo_ps(rows[0], rows[1]), _mm512_unpacklo_ps(rows[2], rows[3])].map(|r| _mm512_castps_pd(r));
                let high =
                    [_mm512_unpackhi_ps(rows[0], rows[1]), _mm512_unpackhi_ps(rows[2], rows[3])].map(|r| _mm512_castps_pd(r));
                words[4 * half] = hide_512(_mm512_castpd_ps(_mm512_unpacklo_pd(low[0], low[1])));
                words[4 * half + 1] = hide_512(_mm512_castpd_ps(_mm512_unpackhi_pd(low[0], low[1])));
                words[4 * half + 2] = hide_512(_mm512_castpd_ps(_mm512_unpacklo_pd(high[0], high[1])));
                words[4 * half + 3] = hide_512(_mm512_castpd_ps(_mm512_unpackhi_pd(high[0], high[1])));
            }
            super::same(words)
        }
    }

    /// # Safety
    /// All indices are those of records, and the CPU has AVX2.
    #[inline(always)]
    pub unsafe fn single_avx2(records: *const f32, indices: &Lanes<u32>) -> Record<Lanes<f32>> {
        unsafe {
            let mut words = [[_mm256_setzero_ps(); 2]; WORDS];
            for (part, half) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                let load = |lane: usize| {
                    let [a, b] = quarters!(records, indices, 4 * half, [8 * part + lane, 8 * part + lane + 4]);
                    _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(_mm_loadu_ps(a)), _mm_loadu_ps(b))
                };
                let rows = [load(0), load(1), load(2), load(3)];
                let low =
                    [_mm256_unpacklo_ps(rows[0], rows[1]), _mm256_unpacklo_ps(rows[2], rows[3])].map(|r| _mm256_castps_pd(r));
                let high =
                    [_mm256_unpackhi_ps(rows[0], rows[1]), _mm256_unpackhi_ps(rows[2], rows[3])].map(|r| _mm256_castps_pd(r));
                words[4 * half][part] = hide_256(_mm256_castpd_ps(_mm256_unpacklo_pd(low[0], low[1])));
                words[4 * half + 1][part] = hide_256(_mm256_castpd_ps(_mm256_unpackhi_pd(low[0], low[1])));
                words[4 * half + 2][part] = hide_256(_mm256_castpd_ps(_mm256_unpacklo_pd(high[0], high[1])));
                words[4 * half + 3][part] = hide_256(_mm256_castpd_ps(_mm256_unpackhi_pd(high[0], high[1])));
            }
            super::same(words)
        }
    }

    /// # Safety
    /// All indices are those of records, and the CPU has AVX-512 F and DQ.
    #[inline(always)]
    pub unsafe fn double_avx512(records: *const f64, indices: &Lanes<u32>) -> Record<Lanes<f64>> {
        unsafe {
            let mut words = [[_mm512_setzero_pd(); 2]; WORDS];
            for part in 0..2 {
                for pair in 0..4 {
                    let load = |first: usize| {
                        let lane = 8 * part + first;
                        let [a, b, c, d] = quarters!(records, indices, 2 * pair, [lane, lane + 2, lane + 4, lane + 6]);
                        let low = _mm512_castpd128_pd512(_mm_loadu_pd(a));
                        let low = _mm512_insertf64x2::<1>(low, _mm_loadu_pd(b));
                        let low = _mm512_insertf64x2::<2>(low, _mm_loadu_pd(c));
                        _mm512_insertf64x2::<3>(low, _mm_loadu_pd(d))
                    };
                    let rows = [load(0), load(1)];
                    words[2 * pair][part] = _mm512_castps_pd(hide_512(_mm512_castpd_ps(_mm512_unpacklo_pd(rows[0], rows[1]))));
                    words[2 * pair + 1][part] =
                        _mm512_castps_pd(hide_512(_mm512_castpd_ps(_mm512_unpackhi_pd(rows[0], rows[1]))));
                }
            }
            super::same(words)
        }
    }

    /// # Safety
    /// All indices are those of records, and the CPU has AVX2.
    #[inline(always)]
    pub unsafe fn double_avx2(records: *const f64, indices: &Lanes<u32>) -> Record<Lanes<f64>> {
        unsafe {
            let mut words = [[_mm256_setzero_pd(); 4]; WORDS];
            for part in 0..4 {
                for pair in 0..4 {
                    let load = |first: usize| {
                        let lane = 4 * part + first;
                        let [a, b] = quarters!(records, indices, 2 * pair, [lane, lane + 2]);
                        _mm256_insertf128_pd::<1>(_mm256_castpd128_pd256(_mm_loadu_pd(a)), _mm_loadu_pd(b))
                    };
                    let rows = [load(0), load(1)];
                    words[2 * pair][part] = _mm256_castps_pd(hide_256(_mm256_castpd_ps(_mm256_unpacklo_pd(rows[0], rows[1]))));
                    words[2 * pair + 1][part] =
                        _mm256_castps_pd(hide_256(_mm256_castpd_ps(_mm256_unpackhi_pd(rows[0], rows[1]))));
                }
            }
            super::same(words)
        }
    }
}
