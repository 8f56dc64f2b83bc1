//! Packs of x86-64: one vector register each.

#[allow(clippy::wildcard_imports)]
use std::arch::x86_64::*;
use std::ops::{Add, AddAssign, Div, Mul, Sub};

use super::packs::{GroupPart, Number, Pack};
use super::{Group, ParticleRecord, WORDS};

/// Implements [`Number`] for a register. Operations that differ by name are listed; those that differ in kind are closures.
macro_rules! register {
    (
        $name:ident, $register:ident, $scalar:ident, $mask:ident, $width:literal,
        $add:ident $sub:ident $mul:ident $div:ident $sqrt:ident $min:ident $max:ident $splat:ident $load:ident $store:ident,
        less: |$a:ident, $b:ident| $less:expr,
        both: |$m:ident, $n:ident| $both:expr,
        select: |$o:ident, $p:ident, $q:ident| $select:expr,
        masked: |$l:ident, $r:ident| $masked:expr,
        has_bit: |$x:ident, $bit:ident| $has_bit:expr,
        coordinate_difference: |$s:ident, $t:ident| $difference:expr,
        transpose: $transpose:ident
        $(, fold: $fold:ident)?
    ) => {
        /// Register of this width.
        #[derive(Debug, Clone, Copy)]
        pub struct $name($register);

        register!(@operator $name, Add, add, $add);
        register!(@operator $name, Sub, sub, $sub);
        register!(@operator $name, Mul, mul, $mul);
        register!(@operator $name, Div, div, $div);

        impl AddAssign for $name {
            #[inline(always)]
            fn add_assign(&mut self, other: Self) {
                *self = *self + other;
            }
        }

        // SAFETY, here and below: packs exist only where the CPU has their registers ([`Packed`]).
        impl Number for $name {
            type Scalar = $scalar;
            type Mask = $mask;

            #[inline(always)]
            fn of(number: $scalar) -> Self {
                Self(unsafe { $splat(number) })
            }

            #[inline(always)]
            #[allow(clippy::cast_lossless)]
            fn constant(value: f64) -> Self {
                Self::of(value as $scalar)
            }

            #[inline(always)]
            fn sqrt(self) -> Self {
                Self(unsafe { $sqrt(self.0) })
            }

            #[inline(always)]
            fn min(self, other: Self) -> Self {
                Self(unsafe { $min(self.0, other.0) })
            }

            #[inline(always)]
            fn max(self, other: Self) -> Self {
                Self(unsafe { $max(self.0, other.0) })
            }

            #[inline(always)]
            fn less(self, other: Self) -> $mask {
                let ($a, $b) = (self.0, other.0);
                unsafe { $less }
            }

            #[inline(always)]
            fn both($m: $mask, $n: $mask) -> $mask {
                #[allow(unused_unsafe)]
                unsafe { $both }
            }

            #[inline(always)]
            fn select($o: $mask, one: Self, other: Self) -> Self {
                let ($p, $q) = (one.0, other.0);
                Self(unsafe { $select })
            }

            #[inline(always)]
            fn masked(self, $l: $mask) -> Self {
                let $r = self.0;
                Self(unsafe { $masked })
            }

            #[inline(always)]
            fn has_bit(self, $bit: u32) -> $mask {
                let $x = self.0;
                unsafe { $has_bit }
            }

            #[inline(always)]
            fn coordinate_difference(self, other: Self) -> Self {
                let ($s, $t) = (self.0, other.0);
                Self(unsafe { $difference })
            }
        }

        impl Pack for $name {
            const WIDTH: usize = $width;
            const OVERLAPS: bool = true;

            #[inline(always)]
            fn load(numbers: &[$scalar]) -> Self {
                assert!(numbers.len() >= $width);
                // SAFETY: there are at least as many numbers.
                Self(unsafe { $load(numbers.as_ptr()) })
            }

            #[inline(always)]
            fn store(self, to: &mut [$scalar]) {
                assert!(to.len() >= $width);
                // SAFETY: there is room for the numbers.
                unsafe { $store(to.as_mut_ptr(), self.0) };
            }

            #[inline(always)]
            fn transpose(records: &[ParticleRecord<$scalar>], group: Group<'_>, first: usize) -> ParticleRecord<Self> {
                let part = GroupPart::<$width>::new(records, group, first);
                // SAFETY: all indices are below the bound of the group, which is at most the number of records.
                let words = unsafe { $transpose(records.as_ptr().cast(), part) };
                [
                    Self(words[0]),
                    Self(words[1]),
                    Self(words[2]),
                    Self(words[3]),
                    Self(words[4]),
                    Self(words[5]),
                    Self(words[6]),
                    Self(words[7]),
                ]
            }

            $(
                #[inline(always)]
                fn fold<const SUMS: usize>(registers: [Self; SUMS]) -> [$scalar; SUMS] {
                    let mut fours = [unsafe { _mm_setzero_ps() }; SUMS];
                    for sum in 0..SUMS {
                        fours[sum] = unsafe { $fold(registers[sum].0) };
                    }
                    unsafe { fold_fours(fours) }
                }
            )?
        }
    };
    (@operator $name:ident, $trait:ident, $method:ident, $intrinsic:ident) => {
        impl $trait for $name {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(unsafe { $intrinsic(self.0, other.0) })
            }
        }
    };
}

register!(
    Single512, __m512, f32, __mmask16, 16,
    _mm512_add_ps _mm512_sub_ps _mm512_mul_ps _mm512_div_ps _mm512_sqrt_ps _mm512_min_ps _mm512_max_ps
    _mm512_set1_ps _mm512_loadu_ps _mm512_storeu_ps,
    less: |a, b| _mm512_cmp_ps_mask::<_CMP_LT_OQ>(a, b),
    both: |m, n| m & n,
    select: |mask, one, other| _mm512_mask_blend_ps(mask, other, one),
    masked: |mask, one| _mm512_maskz_mov_ps(mask, one),
    has_bit: |x, bit| _mm512_test_epi32_mask(_mm512_castps_si512(x), _mm512_set1_epi32(1 << bit)),
    coordinate_difference: |one, other| _mm512_cvtepi32_ps(_mm512_sub_epi32(_mm512_castps_si512(one), _mm512_castps_si512(other))),
    transpose: sixteen_singles,
    fold: four_of_sixteen
);

register!(
    Double512, __m512d, f64, __mmask8, 8,
    _mm512_add_pd _mm512_sub_pd _mm512_mul_pd _mm512_div_pd _mm512_sqrt_pd _mm512_min_pd _mm512_max_pd
    _mm512_set1_pd _mm512_loadu_pd _mm512_storeu_pd,
    less: |a, b| _mm512_cmp_pd_mask::<_CMP_LT_OQ>(a, b),
    both: |m, n| m & n,
    select: |mask, one, other| _mm512_mask_blend_pd(mask, other, one),
    masked: |mask, one| _mm512_maskz_mov_pd(mask, one),
    has_bit: |x, bit| _mm512_test_epi64_mask(_mm512_castpd_si512(x), _mm512_set1_epi64(1 << bit)),
    coordinate_difference: |one, other| _mm512_sub_pd(one, other),
    transpose: eight_doubles
);

register!(
    Single256, __m256, f32, __m256, 8,
    _mm256_add_ps _mm256_sub_ps _mm256_mul_ps _mm256_div_ps _mm256_sqrt_ps _mm256_min_ps _mm256_max_ps
    _mm256_set1_ps _mm256_loadu_ps _mm256_storeu_ps,
    less: |a, b| _mm256_cmp_ps::<_CMP_LT_OQ>(a, b),
    both: |m, n| _mm256_and_ps(m, n),
    select: |mask, one, other| _mm256_blendv_ps(other, one, mask),
    masked: |mask, one| _mm256_and_ps(mask, one),
    has_bit: |x, bit| {
        let one = _mm256_set1_epi32(1 << bit);
        _mm256_castsi256_ps(_mm256_cmpeq_epi32(_mm256_and_si256(_mm256_castps_si256(x), one), one))
    },
    coordinate_difference: |one, other| _mm256_cvtepi32_ps(_mm256_sub_epi32(_mm256_castps_si256(one), _mm256_castps_si256(other))),
    transpose: eight_singles,
    fold: four_of_eight
);

register!(
    Double256, __m256d, f64, __m256d, 4,
    _mm256_add_pd _mm256_sub_pd _mm256_mul_pd _mm256_div_pd _mm256_sqrt_pd _mm256_min_pd _mm256_max_pd
    _mm256_set1_pd _mm256_loadu_pd _mm256_storeu_pd,
    less: |a, b| _mm256_cmp_pd::<_CMP_LT_OQ>(a, b),
    both: |m, n| _mm256_and_pd(m, n),
    select: |mask, one, other| _mm256_blendv_pd(other, one, mask),
    masked: |mask, one| _mm256_and_pd(mask, one),
    has_bit: |x, bit| {
        let one = _mm256_set1_epi64x(1 << bit);
        _mm256_castsi256_pd(_mm256_cmpeq_epi64(_mm256_and_si256(_mm256_castpd_si256(x), one), one))
    },
    coordinate_difference: |one, other| _mm256_sub_pd(one, other),
    transpose: four_doubles
);

/// Transposes sixteen records of f32.
///
/// # Safety
/// The part belongs to these records, and the CPU has AVX-512 F and DQ.
#[inline(always)]
unsafe fn sixteen_singles(records: *const f32, part: GroupPart<'_, 16>) -> [__m512; WORDS] {
    unsafe {
        let mut halves = [[_mm512_setzero_ps(); 4]; 2];
        for half in 0..2 {
            // Each register takes two whole records, loaded into their places: each index is read once.
            let mut rows = [_mm512_setzero_ps(); 4];
            for row in 0..4 {
                let record = |lane: usize| records.add(part.index(lane) * WORDS);
                let (low, high) = (_mm256_loadu_ps(record(8 * half + row)), _mm256_loadu_ps(record(8 * half + row + 4)));
                rows[row] = _mm512_insertf32x8::<1>(_mm512_castps256_ps512(low), high);
            }
            // Words w and w + 4 of four records in each quarter.
            let [a, b, c, d] = rows;
            let (ab, cd) = (_mm512_castps_pd(_mm512_unpacklo_ps(a, b)), _mm512_castps_pd(_mm512_unpacklo_ps(c, d)));
            let (ba, dc) = (_mm512_castps_pd(_mm512_unpackhi_ps(a, b)), _mm512_castps_pd(_mm512_unpackhi_ps(c, d)));
            halves[half][0] = _mm512_castpd_ps(_mm512_unpacklo_pd(ab, cd));
            halves[half][1] = _mm512_castpd_ps(_mm512_unpackhi_pd(ab, cd));
            halves[half][2] = _mm512_castpd_ps(_mm512_unpacklo_pd(ba, dc));
            halves[half][3] = _mm512_castpd_ps(_mm512_unpackhi_pd(ba, dc));
        }
        let mut words = [_mm512_setzero_ps(); WORDS];
        for word in 0..4 {
            words[word] = _mm512_shuffle_f32x4::<0x88>(halves[0][word], halves[1][word]);
            words[word + 4] = _mm512_shuffle_f32x4::<0xdd>(halves[0][word], halves[1][word]);
        }
        words
    }
}

/// Sums of lanes at a distance of 8 and 4.
///
/// # Safety
/// The CPU has AVX-512 F and DQ.
#[inline(always)]
unsafe fn four_of_sixteen(register: __m512) -> __m128 {
    unsafe { four_of_eight(_mm256_add_ps(_mm512_castps512_ps256(register), _mm512_extractf32x8_ps::<1>(register))) }
}

/// Sums of lanes at a distance of 4.
///
/// # Safety
/// The CPU has AVX2.
#[inline(always)]
unsafe fn four_of_eight(register: __m256) -> __m128 {
    unsafe { _mm_add_ps(_mm256_castps256_ps128(register), _mm256_extractf128_ps::<1>(register)) }
}

/// Sums over the four lanes of registers, by a binary tree.
///
/// # Safety
/// The CPU has AVX2.
#[inline(always)]
unsafe fn fold_fours<const SUMS: usize>(registers: [__m128; SUMS]) -> [f32; SUMS] {
    let mut sums = [0.0; SUMS];
    for first in (0..SUMS).step_by(4) {
        let (number, mut folded) = ((SUMS - first).min(4), [0.0; 4]);
        // SAFETY: the caller has these instructions, and there is room for four numbers.
        unsafe {
            let mut four = [_mm_setzero_ps(); 4];
            four[..number].copy_from_slice(&registers[first..first + number]);
            // One number of each pair in the lower half, the other in the upper half.
            let [a, b, c, d] = four;
            let ab = _mm_add_ps(_mm_unpacklo_ps(a, b), _mm_unpackhi_ps(a, b));
            let cd = _mm_add_ps(_mm_unpacklo_ps(c, d), _mm_unpackhi_ps(c, d));
            _mm_storeu_ps(folded.as_mut_ptr(), _mm_add_ps(_mm_movelh_ps(ab, cd), _mm_movehl_ps(cd, ab)));
        }
        sums[first..first + number].copy_from_slice(&folded[..number]);
    }
    sums
}

/// Transposes eight records of f32.
///
/// # Safety
/// The part belongs to these records, and the CPU has AVX2.
#[inline(always)]
unsafe fn eight_singles(records: *const f32, part: GroupPart<'_, 8>) -> [__m256; WORDS] {
    unsafe {
        let mut words = [_mm256_setzero_ps(); WORDS];
        // Each index is read once. This is a loop, because compilers do not inline `map` over arrays of this length.
        let mut starts = [records; 8];
        for row in 0..8 {
            starts[row] = records.add(part.index(row) * WORDS);
        }
        for half in 0..2 {
            let mut rows = [_mm256_setzero_pd(); 4];
            let mut read = [_mm256_setzero_ps(); 4];
            for row in 0..4 {
                // Half a record in each half of the register.
                let low = _mm_loadu_ps(starts[row].add(4 * half));
                let high = _mm_loadu_ps(starts[row + 4].add(4 * half));
                read[row] = _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(low), high);
            }
            rows[0] = _mm256_castps_pd(_mm256_unpacklo_ps(read[0], read[1]));
            rows[1] = _mm256_castps_pd(_mm256_unpacklo_ps(read[2], read[3]));
            rows[2] = _mm256_castps_pd(_mm256_unpackhi_ps(read[0], read[1]));
            rows[3] = _mm256_castps_pd(_mm256_unpackhi_ps(read[2], read[3]));
            for pair in 0..2 {
                let (one, other) = (rows[2 * pair], rows[2 * pair + 1]);
                words[4 * half + 2 * pair] = _mm256_castpd_ps(_mm256_unpacklo_pd(one, other));
                words[4 * half + 2 * pair + 1] = _mm256_castpd_ps(_mm256_unpackhi_pd(one, other));
            }
        }
        words
    }
}

/// Transposes eight records of f64.
///
/// # Safety
/// The part belongs to these records, and the CPU has AVX-512 F and DQ.
#[inline(always)]
unsafe fn eight_doubles(records: *const f64, part: GroupPart<'_, 8>) -> [__m512d; WORDS] {
    unsafe {
        let mut words = [_mm512_setzero_pd(); WORDS];
        for pair in 0..WORDS / 2 {
            let mut rows = [_mm512_setzero_pd(); 2];
            for row in 0..2 {
                // Two words of a record in each quarter.
                let words_of = |quarter: usize| _mm_loadu_pd(records.add(part.index(row + 2 * quarter) * WORDS + 2 * pair));
                rows[row] = _mm512_castpd128_pd512(words_of(0));
                rows[row] = _mm512_mask_broadcast_f64x2(rows[row], 0x0c, words_of(1));
                rows[row] = _mm512_mask_broadcast_f64x2(rows[row], 0x30, words_of(2));
                rows[row] = _mm512_mask_broadcast_f64x2(rows[row], 0xc0, words_of(3));
            }
            words[2 * pair] = _mm512_unpacklo_pd(rows[0], rows[1]);
            words[2 * pair + 1] = _mm512_unpackhi_pd(rows[0], rows[1]);
        }
        words
    }
}

/// Transposes four records of f64.
///
/// # Safety
/// The part belongs to these records, and the CPU has AVX2.
#[inline(always)]
unsafe fn four_doubles(records: *const f64, part: GroupPart<'_, 4>) -> [__m256d; WORDS] {
    unsafe {
        let mut words = [_mm256_setzero_pd(); WORDS];
        for pair in 0..WORDS / 2 {
            let mut rows = [_mm256_setzero_pd(); 2];
            for row in 0..2 {
                // Two words of a record in each half.
                let low = _mm_loadu_pd(records.add(part.index(row) * WORDS + 2 * pair));
                let high = _mm_loadu_pd(records.add(part.index(row + 2) * WORDS + 2 * pair));
                rows[row] = _mm256_insertf128_pd::<1>(_mm256_castpd128_pd256(low), high);
            }
            words[2 * pair] = _mm256_unpacklo_pd(rows[0], rows[1]);
            words[2 * pair + 1] = _mm256_unpackhi_pd(rows[0], rows[1]);
        }
        words
    }
}
