//! Packs: numbers in lanes, for the terms of several pairs, or the stages of several particles, at once.
//!
//! A law is written over [`Number`], which is one number or a vector register of numbers. Registers are used instead of loops
//! over arrays because interleaved records then stay in registers. Compilers that vectorize a loop go through memory instead.
//! Every operation follows IEEE 754 in each lane, so the bits are equal for all widths.

use std::ops::{Add, AddAssign, Div, Mul, Sub};

use wide::bytemuck::cast;
use wide::{f32x4, f64x4, i32x4, i64x4};

#[cfg(target_arch = "x86_64")]
use super::registers::{Double256, Double512, Single256, Single512};
use super::{Group, LANES, ParticleRecord, WORDS};

/// Number, or vector of numbers in lanes.
pub trait Number: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + AddAssign {
    /// Type of a lane.
    type Scalar;
    /// Subset of the lanes.
    type Mask: Copy;

    /// Broadcasts a number to every lane.
    fn of(number: Self::Scalar) -> Self;
    /// Broadcasts the nearest number to `value` to every lane.
    fn constant(value: f64) -> Self;
    /// Square root, correctly rounded.
    #[must_use]
    fn sqrt(self) -> Self;
    /// Minimum: this number in lanes where it is less than the other, and the other elsewhere.
    #[must_use]
    fn min(self, other: Self) -> Self;
    /// Maximum: this number in lanes where it is greater than the other, and the other elsewhere.
    #[must_use]
    fn max(self, other: Self) -> Self;
    /// Mask of the lanes where this number is less than the other.
    fn less(self, other: Self) -> Self::Mask;
    /// Intersection of two masks.
    fn both(one: Self::Mask, other: Self::Mask) -> Self::Mask;
    /// Selects one number in the lanes of a mask, another elsewhere.
    fn select(mask: Self::Mask, one: Self, other: Self) -> Self;
    /// Number in the lanes of a mask, 0 elsewhere.
    #[must_use]
    fn masked(self, mask: Self::Mask) -> Self;
    /// Mask of the lanes where this bit of the number is set.
    fn has_bit(self, bit: u32) -> Self::Mask;
    /// Difference of two encoded coordinates: in f32, of their bits as integers, modulo 2³²; in f64, of the numbers.
    #[must_use]
    fn coordinate_difference(self, other: Self) -> Self;
}

/// Register of a level, or several; the width divides [`LANES`].
pub trait Pack: Number {
    /// Number of lanes.
    const WIDTH: usize;
    /// Whether loops hide the latency of one group's operations behind those of the next.
    const OVERLAPS: bool;

    /// Loads numbers, of which there are at least [`Pack::WIDTH`].
    fn load(numbers: &[Self::Scalar]) -> Self;
    /// Writes the numbers to the beginning of a slice that is at least as long.
    fn store(self, to: &mut [Self::Scalar]);
    /// Transposes the records of a part of a group, from `first` on: words of the records, one lane per record.
    ///
    /// # Panics
    /// If there are fewer records than the bound of the group, or fewer lanes than the part takes.
    fn transpose(records: &[ParticleRecord<Self::Scalar>], group: Group<'_>, first: usize) -> ParticleRecord<Self>;

    /// Sum of all lanes of each register, by a binary tree.
    #[inline(always)]
    fn fold<const SUMS: usize>(registers: [Self; SUMS]) -> [Self::Scalar; SUMS]
    where
        Self::Scalar: Packed,
    {
        // Loops, because compilers do not inline `map` over arrays of every length.
        let mut sums = [Self::Scalar::default(); SUMS];
        for sum in 0..SUMS {
            let mut lanes = [Self::Scalar::default(); LANES];
            registers[sum].store(&mut lanes);
            sums[sum] = fold(&mut lanes[..Self::WIDTH]);
        }
        sums
    }
}

/// Sum of lanes, by a binary tree.
#[inline(always)]
fn fold<T: Packed>(lanes: &mut [T]) -> T {
    let mut half = lanes.len() / 2;
    while half > 0 {
        for lane in 0..half {
            let other = lanes[lane + half];
            lanes[lane] += other;
        }
        half /= 2;
    }
    lanes[0]
}

/// Number type with packs. A pack must be accessed through an [`super::Isa`], which exists only if the CPU has the registers.
/// Code over these types alone would run on any CPU.
pub trait Packed: Number<Scalar = Self, Mask = bool> + Default {
    /// Pack of the base level.
    type Base: Pack<Scalar = Self>;
    /// Pack of AVX-512.
    #[cfg(target_arch = "x86_64")]
    type Avx512: Pack<Scalar = Self>;
    /// Pack of AVX2.
    #[cfg(target_arch = "x86_64")]
    type Avx2: Pack<Scalar = Self>;
    /// Pack of AVX-512 for whole groups of lanes.
    #[cfg(target_arch = "x86_64")]
    type Avx512Group: Pack<Scalar = Self>;
    /// Pack of AVX2 for whole groups of lanes.
    #[cfg(target_arch = "x86_64")]
    type Avx2Group: Pack<Scalar = Self>;
}

/// Part of a group; none of its indices is past the end of the records.
#[derive(Debug, Clone, Copy)]
pub(super) struct GroupPart<'a, const WIDTH: usize>(&'a [u32; WIDTH]);

impl<'a, const WIDTH: usize> GroupPart<'a, WIDTH> {
    /// Returns the part of a group from `first` on.
    #[inline(always)]
    pub fn new<T>(records: &[ParticleRecord<T>], group: Group<'a>, first: usize) -> Self {
        assert!(records.len() >= group.bound(), "records that are not there");
        Self(group.indices()[first..].first_chunk().expect("a part of the group"))
    }

    /// Reads one index. The read is volatile; otherwise compilers compute all addresses in vectors, only to extract them again.
    #[inline(always)]
    pub fn index(self, lane: usize) -> usize {
        // SAFETY: a reference to a number can be read.
        unsafe { std::ptr::read_volatile(&raw const self.0[lane]) as usize }
    }
}

macro_rules! scalar {
    ($number:ident, |$one:ident, $other:ident| $difference:expr) => {
        impl Number for $number {
            type Scalar = $number;
            type Mask = bool;

            #[inline(always)]
            fn of(number: $number) -> $number {
                number
            }

            #[inline(always)]
            #[allow(clippy::cast_lossless)]
            fn constant(value: f64) -> $number {
                value as $number
            }

            #[inline(always)]
            fn sqrt(self) -> $number {
                $number::sqrt(self)
            }

            #[inline(always)]
            fn min(self, other: $number) -> $number {
                if self < other { self } else { other }
            }

            #[inline(always)]
            fn max(self, other: $number) -> $number {
                if self > other { self } else { other }
            }

            #[inline(always)]
            fn less(self, other: $number) -> bool {
                self < other
            }

            #[inline(always)]
            fn both(one: bool, other: bool) -> bool {
                one & other
            }

            #[inline(always)]
            fn select(mask: bool, one: $number, other: $number) -> $number {
                if mask { one } else { other }
            }

            #[inline(always)]
            fn masked(self, mask: bool) -> $number {
                if mask { self } else { 0.0 }
            }

            #[inline(always)]
            fn has_bit(self, bit: u32) -> bool {
                self.to_bits() & (1 << bit) != 0
            }

            #[inline(always)]
            fn coordinate_difference(self, other: $number) -> $number {
                let ($one, $other) = (self, other);
                $difference
            }
        }
    };
}

scalar!(f32, |one, other| one.to_bits().wrapping_sub(other.to_bits()).cast_signed() as f32);
scalar!(f64, |one, other| one - other);

/// Defines a pack of four numbers, by the crate `wide`: registers of the base level of the target.
macro_rules! four {
    ($pack:ident, $number:ident, $bits:ident, |$one:ident, $other:ident| $difference:expr) => {
        impl Number for $pack {
            type Scalar = $number;
            /// Mask: all bits set in the lanes of the subset, none in the others.
            type Mask = Self;

            #[inline(always)]
            fn of(number: $number) -> Self {
                Self::splat(number)
            }

            #[inline(always)]
            #[allow(clippy::cast_lossless)]
            fn constant(value: f64) -> Self {
                Self::splat(value as $number)
            }

            #[inline(always)]
            fn sqrt(self) -> Self {
                $pack::sqrt(self)
            }

            #[inline(always)]
            fn min(self, other: Self) -> Self {
                Self::select(self.less(other), self, other)
            }

            #[inline(always)]
            fn max(self, other: Self) -> Self {
                Self::select(other.less(self), self, other)
            }

            #[inline(always)]
            fn less(self, other: Self) -> Self {
                self.simd_lt(other)
            }

            #[inline(always)]
            fn both(one: Self, other: Self) -> Self {
                one & other
            }

            #[inline(always)]
            fn select(mask: Self, one: Self, other: Self) -> Self {
                mask.bitselect(one, other)
            }

            #[inline(always)]
            fn masked(self, mask: Self) -> Self {
                self & mask
            }

            #[inline(always)]
            fn has_bit(self, bit: u32) -> Self {
                let flag = $bits::splat(1 << bit);
                cast((cast::<_, $bits>(self) & flag).simd_eq(flag))
            }

            #[inline(always)]
            fn coordinate_difference(self, other: Self) -> Self {
                let ($one, $other) = (self, other);
                $difference
            }
        }

        impl Pack for $pack {
            const WIDTH: usize = 4;
            const OVERLAPS: bool = false;

            #[inline(always)]
            fn load(numbers: &[$number]) -> Self {
                Self::new([numbers[0], numbers[1], numbers[2], numbers[3]])
            }

            #[inline(always)]
            fn store(self, to: &mut [$number]) {
                to[..4].copy_from_slice(self.as_array());
            }

            #[inline(always)]
            fn transpose(records: &[ParticleRecord<$number>], group: Group<'_>, first: usize) -> ParticleRecord<Self> {
                let part = GroupPart::<4>::new(records, group, first);
                let (mut low, mut high) = ([Self::splat(0.0); 4], [Self::splat(0.0); 4]);
                for lane in 0..4 {
                    let record = &records[part.index(lane)];
                    (low[lane], high[lane]) = (Self::load(record), Self::load(&record[4..]));
                }
                let ([a, b, c, d], [e, f, g, h]) = (Self::transpose(low), Self::transpose(high));
                [a, b, c, d, e, f, g, h]
            }
        }
    };
}

four!(f32x4, f32, i32x4, |one, other| f32x4::from_i32x4(cast::<_, i32x4>(one) - cast::<_, i32x4>(other)));
four!(f64x4, f64, i64x4, |one, other| one - other);

/// Two packs as one. Their operations alternate, so each hides the latency of the other.
#[derive(Debug, Clone, Copy)]
pub struct Twice<P>(P, P);

macro_rules! operator_twice {
    ($trait:ident, $name:ident) => {
        impl<P: Pack> $trait for Twice<P> {
            type Output = Self;

            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self(self.0.$name(other.0), self.1.$name(other.1))
            }
        }
    };
}

operator_twice!(Add, add);
operator_twice!(Sub, sub);
operator_twice!(Mul, mul);
operator_twice!(Div, div);

impl<P: Pack> AddAssign for Twice<P> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<P: Pack<Scalar: Copy>> Number for Twice<P> {
    type Scalar = P::Scalar;
    type Mask = (P::Mask, P::Mask);

    #[inline(always)]
    fn of(number: P::Scalar) -> Self {
        Self(P::of(number), P::of(number))
    }

    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self(P::constant(value), P::constant(value))
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt(), self.1.sqrt())
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(self.0.min(other.0), self.1.min(other.1))
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(self.0.max(other.0), self.1.max(other.1))
    }

    #[inline(always)]
    fn less(self, other: Self) -> Self::Mask {
        (self.0.less(other.0), self.1.less(other.1))
    }

    #[inline(always)]
    fn both(one: Self::Mask, other: Self::Mask) -> Self::Mask {
        (P::both(one.0, other.0), P::both(one.1, other.1))
    }

    #[inline(always)]
    fn select(mask: Self::Mask, one: Self, other: Self) -> Self {
        Self(P::select(mask.0, one.0, other.0), P::select(mask.1, one.1, other.1))
    }

    #[inline(always)]
    fn masked(self, mask: Self::Mask) -> Self {
        Self(self.0.masked(mask.0), self.1.masked(mask.1))
    }

    #[inline(always)]
    fn has_bit(self, bit: u32) -> Self::Mask {
        (self.0.has_bit(bit), self.1.has_bit(bit))
    }

    #[inline(always)]
    fn coordinate_difference(self, other: Self) -> Self {
        Self(self.0.coordinate_difference(other.0), self.1.coordinate_difference(other.1))
    }
}

impl<P: Pack<Scalar: Copy>> Pack for Twice<P> {
    const WIDTH: usize = 2 * P::WIDTH;
    const OVERLAPS: bool = false;

    #[inline(always)]
    fn load(numbers: &[P::Scalar]) -> Self {
        Self(P::load(numbers), P::load(&numbers[P::WIDTH..]))
    }

    #[inline(always)]
    fn store(self, to: &mut [P::Scalar]) {
        self.0.store(to);
        self.1.store(&mut to[P::WIDTH..]);
    }

    #[inline(always)]
    fn transpose(records: &[ParticleRecord<P::Scalar>], group: Group<'_>, first: usize) -> ParticleRecord<Self> {
        let (one, other) = (P::transpose(records, group, first), P::transpose(records, group, first + P::WIDTH));
        let mut words = [Self(one[0], other[0]); WORDS];
        for word in 1..WORDS {
            words[word] = Self(one[word], other[word]);
        }
        words
    }

    #[inline(always)]
    fn fold<const SUMS: usize>(registers: [Self; SUMS]) -> [P::Scalar; SUMS]
    where
        P::Scalar: Packed,
    {
        let mut sums = [P::constant(0.0); SUMS];
        for sum in 0..SUMS {
            sums[sum] = registers[sum].0 + registers[sum].1;
        }
        P::fold(sums)
    }
}

impl Packed for f32 {
    type Base = f32x4;
    #[cfg(target_arch = "x86_64")]
    type Avx512 = Single512;
    #[cfg(target_arch = "x86_64")]
    type Avx2 = Single256;
    #[cfg(target_arch = "x86_64")]
    type Avx512Group = Single512;
    #[cfg(target_arch = "x86_64")]
    type Avx2Group = Twice<Single256>;
}

impl Packed for f64 {
    type Base = f64x4;
    #[cfg(target_arch = "x86_64")]
    type Avx512 = Double512;
    #[cfg(target_arch = "x86_64")]
    type Avx2 = Double256;
    #[cfg(target_arch = "x86_64")]
    type Avx512Group = Twice<Double512>;
    #[cfg(target_arch = "x86_64")]
    type Avx2Group = Twice<Twice<Double256>>;
}

const _: () = assert!(WORDS == 8 && LANES == 16, "the registers are written for these");
