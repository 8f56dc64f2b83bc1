//! The packs of x86-64: one vector register each.

#[allow(clippy::wildcard_imports)]
use std::arch::x86_64::*;
use std::ops::{Add, AddAssign, Div, Mul, Sub};

use super::packs::{Number, Pack, Packed, Part};
use super::{Group, Record, WORDS};

impl Packed for f32 {
    type Avx512 = Single512;
    type Avx2 = Single256;
}

impl Packed for f64 {
    type Avx512 = Double512;
    type Avx2 = Double256;
}

/// A register as a [`Number`]; operations that differ by name are listed, those that differ in kind are closures.
macro_rules! register {
    (
        $name:ident, $register:ident, $scalar:ident, $mask:ident, $width:literal,
        $add:ident $sub:ident $mul:ident $div:ident $sqrt:ident $min:ident $max:ident $splat:ident $load:ident $store:ident,
        less: |$a:ident, $b:ident| $less:expr,
        both: |$m:ident, $n:ident| $both:expr,
        select: |$o:ident, $p:ident, $q:ident| $select:expr,
        has_bit: |$x:ident, $bit:ident| $has_bit:expr,
        coordinate_difference: |$s:ident, $t:ident| $difference:expr,
        transpose: $transpose:ident
    ) => {
        /// A register of this width.
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

            #[inline(always)]
            fn load(numbers: &[$scalar]) -> Self {
                assert!(numbers.len() >= $width);
                // SAFETY: there are as many numbers.
                Self(unsafe { $load(numbers.as_ptr()) })
            }

            #[inline(always)]
            fn store(self, to: &mut [$scalar]) {
                assert!(to.len() >= $width);
                // SAFETY: there is room for as many.
                unsafe { $store(to.as_mut_ptr(), self.0) };
            }

            #[inline(always)]
            fn transpose(records: &[Record<$scalar>], group: Group<'_>, first: usize) -> Record<Self> {
                let part = Part::<$width>::new(records, group, first);
                // SAFETY: all indices are below the bound of the group, and that is the number of records.
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
    has_bit: |x, bit| _mm512_test_epi32_mask(_mm512_castps_si512(x), _mm512_set1_epi32(1 << bit)),
    coordinate_difference: |one, other| _mm512_cvtepi32_ps(_mm512_sub_epi32(_mm512_castps_si512(one), _mm512_castps_si512(other))),
    transpose: sixteen_singles
);

register!(
    Double512, __m512d, f64, __mmask8, 8,
    _mm512_add_pd _mm512_sub_pd _mm512_mul_pd _mm512_div_pd _mm512_sqrt_pd _mm512_min_pd _mm512_max_pd
    _mm512_set1_pd _mm512_loadu_pd _mm512_storeu_pd,
    less: |a, b| _mm512_cmp_pd_mask::<_CMP_LT_OQ>(a, b),
    both: |m, n| m & n,
    select: |mask, one, other| _mm512_mask_blend_pd(mask, other, one),
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
    has_bit: |x, bit| {
        let one = _mm256_set1_epi32(1 << bit);
        _mm256_castsi256_ps(_mm256_cmpeq_epi32(_mm256_and_si256(_mm256_castps_si256(x), one), one))
    },
    coordinate_difference: |one, other| _mm256_cvtepi32_ps(_mm256_sub_epi32(_mm256_castps_si256(one), _mm256_castps_si256(other))),
    transpose: eight_singles
);

register!(
    Double256, __m256d, f64, __m256d, 4,
    _mm256_add_pd _mm256_sub_pd _mm256_mul_pd _mm256_div_pd _mm256_sqrt_pd _mm256_min_pd _mm256_max_pd
    _mm256_set1_pd _mm256_loadu_pd _mm256_storeu_pd,
    less: |a, b| _mm256_cmp_pd::<_CMP_LT_OQ>(a, b),
    both: |m, n| _mm256_and_pd(m, n),
    select: |mask, one, other| _mm256_blendv_pd(other, one, mask),
    has_bit: |x, bit| {
        let one = _mm256_set1_epi64x(1 << bit);
        _mm256_castsi256_pd(_mm256_cmpeq_epi64(_mm256_and_si256(_mm256_castpd_si256(x), one), one))
    },
    coordinate_difference: |one, other| _mm256_sub_pd(one, other),
    transpose: four_doubles
);

/// The words of sixteen records.
///
/// # Safety
/// The part is one of these records, and the CPU has AVX-512 F and DQ.
#[inline(always)]
unsafe fn sixteen_singles(records: *const f32, part: Part<'_, 16>) -> [__m512; WORDS] {
    unsafe {
        let mut rows = [_mm512_setzero_ps(); 8];
        for row in 0..8 {
            // One record in each half.
            let low = _mm256_loadu_ps(records.add(part.index(row) * WORDS));
            let high = _mm256_loadu_ps(records.add(part.index(row + 8) * WORDS));
            rows[row] = _mm512_insertf32x8::<1>(_mm512_castps256_ps512(low), high);
        }
        // Words 0, 4 | 1, 5 | 2, 6 | 3, 7 of the first four rows and of the last four.
        let first = four_rows(rows[0], rows[1], rows[2], rows[3]);
        let last = four_rows(rows[4], rows[5], rows[6], rows[7]);
        // Quarters in the order 0, 0, 2, 2 and 1, 1, 3, 3 of both.
        let low = _mm512_setr_epi64(0, 1, 8, 9, 4, 5, 12, 13);
        let high = _mm512_setr_epi64(2, 3, 10, 11, 6, 7, 14, 15);
        let mut words = [_mm512_setzero_ps(); WORDS];
        for word in 0..4 {
            words[word] = _mm512_castpd_ps(_mm512_permutex2var_pd(first[word], low, last[word]));
            words[word + 4] = _mm512_castpd_ps(_mm512_permutex2var_pd(first[word], high, last[word]));
        }
        words
    }
}

/// Transposes the squares of four rows.
///
/// # Safety
/// The CPU has AVX-512 F.
#[inline(always)]
unsafe fn four_rows(a: __m512, b: __m512, c: __m512, d: __m512) -> [__m512d; 4] {
    unsafe {
        let (ab, cd) = (_mm512_castps_pd(_mm512_unpacklo_ps(a, b)), _mm512_castps_pd(_mm512_unpacklo_ps(c, d)));
        let (ba, dc) = (_mm512_castps_pd(_mm512_unpackhi_ps(a, b)), _mm512_castps_pd(_mm512_unpackhi_ps(c, d)));
        [_mm512_unpacklo_pd(ab, cd), _mm512_unpackhi_pd(ab, cd), _mm512_unpacklo_pd(ba, dc), _mm512_unpackhi_pd(ba, dc)]
    }
}

/// The words of eight records.
///
/// # Safety
/// The part is one of these records, and the CPU has AVX2.
#[inline(always)]
unsafe fn eight_singles(records: *const f32, part: Part<'_, 8>) -> [__m256; WORDS] {
    unsafe {
        let mut words = [_mm256_setzero_ps(); WORDS];
        for half in 0..2 {
            let mut rows = [_mm256_setzero_pd(); 4];
            let mut read = [_mm256_setzero_ps(); 4];
            for row in 0..4 {
                // Half a record of one in each half.
                let low = _mm_loadu_ps(records.add(part.index(row) * WORDS + 4 * half));
                let high = _mm_loadu_ps(records.add(part.index(row + 4) * WORDS + 4 * half));
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

/// The words of eight records.
///
/// # Safety
/// The part is one of these records, and the CPU has AVX-512 F.
#[inline(always)]
unsafe fn eight_doubles(records: *const f64, part: Part<'_, 8>) -> [__m512d; WORDS] {
    unsafe {
        // The even words of two records at a time, and the odd ones.
        let mut pairs = [[_mm512_setzero_pd(); 4]; 2];
        for pair in 0..4 {
            let one = _mm512_loadu_pd(records.add(part.index(2 * pair) * WORDS));
            let other = _mm512_loadu_pd(records.add(part.index(2 * pair + 1) * WORDS));
            pairs[0][pair] = _mm512_unpacklo_pd(one, other);
            pairs[1][pair] = _mm512_unpackhi_pd(one, other);
        }
        let mut words = [_mm512_setzero_pd(); WORDS];
        for odd in 0..2 {
            let [a, b, c, d] = pairs[odd];
            // Quarters 0, 2 of both, then 1, 3.
            let (ab, cd) = (_mm512_shuffle_f64x2::<0b10_00_10_00>(a, b), _mm512_shuffle_f64x2::<0b10_00_10_00>(c, d));
            let (ba, dc) = (_mm512_shuffle_f64x2::<0b11_01_11_01>(a, b), _mm512_shuffle_f64x2::<0b11_01_11_01>(c, d));
            words[odd] = _mm512_shuffle_f64x2::<0b10_00_10_00>(ab, cd);
            words[odd + 4] = _mm512_shuffle_f64x2::<0b11_01_11_01>(ab, cd);
            words[odd + 2] = _mm512_shuffle_f64x2::<0b10_00_10_00>(ba, dc);
            words[odd + 6] = _mm512_shuffle_f64x2::<0b11_01_11_01>(ba, dc);
        }
        words
    }
}

/// The words of four records.
///
/// # Safety
/// The part is one of these records, and the CPU has AVX2.
#[inline(always)]
unsafe fn four_doubles(records: *const f64, part: Part<'_, 4>) -> [__m256d; WORDS] {
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
