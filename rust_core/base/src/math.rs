//! Precision and dimension: the only file that depends on f32 or f64 and on two or three dimensions.
//!
//! All other code is written once over [`Real`] and [`Vector`]. The vectors themselves are glam's. Bulk state is one array per
//! component ([`crate::columns::Columns`]), which is six times as fast as an array of vectors.

use std::cell::RefCell;
use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use glam::{DVec2, DVec3, Vec2, Vec3};

use crate::aligned::{Aligned, filled};

mod coordinate;
pub mod spline;

pub use coordinate::Coordinate;

/// Floating-point number: f32 or f64.
pub trait Real:
    Copy
    + Default
    + Debug
    + PartialEq
    + PartialOrd
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
    + Coordinate
{
    /// Zero.
    const ZERO: Self;
    /// One.
    const ONE: Self;
    /// Positive infinity.
    const INFINITY: Self;
    /// Machine epsilon ε.
    const EPSILON: f64;
    /// Largest finite number.
    const MAX: f64;
    /// Name of the type in scenes and plans.
    const NAME: &'static str;

    /// Nearest number to `value`.
    fn from_f64(value: f64) -> Self;
    /// Converts the number to double precision.
    fn to_f64(self) -> f64;
    /// Whether the number is neither infinite nor NaN.
    fn is_finite(self) -> bool;
    /// Stores one of four tags in the two lowest bits of the number, below any relevant precision.
    #[must_use]
    fn tagged(self, tag: u8) -> Self;
    /// Tag of the number.
    fn tag(self) -> u8;
    /// Lends the scratch buffer of the calling thread to `work`: `length` uninitialized numbers, aligned to a cache line.
    fn with_scratch<R>(length: usize, work: impl FnOnce(&mut [Self]) -> R) -> R;
}

macro_rules! real {
    ($number:ident, $bits:ident, $scratch:ident) => {
        thread_local! {
            static $scratch: RefCell<Option<Aligned<$number>>> = const { RefCell::new(None) };
        }

        impl Real for $number {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const INFINITY: Self = $number::INFINITY;
            const EPSILON: f64 = $number::EPSILON as f64;
            const MAX: f64 = $number::MAX as f64;
            const NAME: &'static str = stringify!($number);

            #[inline(always)]
            #[allow(clippy::cast_lossless)]
            fn from_f64(value: f64) -> Self {
                value as $number
            }

            #[inline(always)]
            #[allow(clippy::cast_lossless)]
            fn to_f64(self) -> f64 {
                self as f64
            }

            #[inline(always)]
            fn is_finite(self) -> bool {
                $number::is_finite(self)
            }

            #[inline(always)]
            #[allow(clippy::cast_lossless)]
            fn tagged(self, tag: u8) -> Self {
                Self::from_bits(self.to_bits() & !3 | tag as $bits)
            }

            #[inline(always)]
            fn tag(self) -> u8 {
                (self.to_bits() & 3) as u8
            }

            fn with_scratch<R>(length: usize, work: impl FnOnce(&mut [Self]) -> R) -> R {
                // Taken out while lent: a nested loan then allocates instead of panicking.
                let mut memory = $scratch.take().unwrap_or_else(|| filled(0.0, 0));
                if memory.len() < length {
                    memory.resize(length, 0.0);
                }
                let result = work(&mut memory[..length]);
                $scratch.set(Some(memory));
                result
            }
        }
    };
}

real!(f32, u32, SCRATCH_F32);
real!(f64, u64, SCRATCH_F64);

/// Maximum number of axes. Per-axis arrays have this length; axes past the dimension stay empty.
pub const AXES: usize = 3;

/// Vector in two or three dimensions, for geometry and parameters.
pub trait Vector:
    Copy
    + Default
    + Debug
    + PartialEq
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Neg<Output = Self>
    + Mul<Self::Scalar, Output = Self>
    + AddAssign
    + SubAssign
{
    /// Type of the components.
    type Scalar: Real;
    /// Number of axes.
    const DIMENSION: usize;

    /// Vector with the components `each(axis)`.
    fn from_axes(each: impl FnMut(usize) -> Self::Scalar) -> Self;
    /// Component along an axis.
    fn axis(self, axis: usize) -> Self::Scalar;
    /// Vector in double precision and three dimensions; the third component of a 2D vector is 0.
    fn widen(self) -> DVec3;
    /// Nearest vector to `value`; in 2D, the third component is dropped.
    fn narrow(value: DVec3) -> Self {
        let components = value.to_array();
        Self::from_axes(|axis| Self::Scalar::from_f64(components[axis]))
    }
}

macro_rules! vector {
    ($vector:ident, $number:ident, $dimension:literal) => {
        impl Vector for $vector {
            type Scalar = $number;
            const DIMENSION: usize = $dimension;

            #[inline(always)]
            fn from_axes(each: impl FnMut(usize) -> $number) -> Self {
                Self::from_array(std::array::from_fn(each))
            }

            #[inline(always)]
            fn axis(self, axis: usize) -> $number {
                self[axis]
            }

            #[inline(always)]
            fn widen(self) -> DVec3 {
                let mut wide = [0.0; 3];
                for (axis, component) in self.to_array().into_iter().enumerate() {
                    wide[axis] = component.to_f64();
                }
                DVec3::from_array(wide)
            }
        }
    };
}

vector!(Vec2, f32, 2);
vector!(Vec3, f32, 3);
vector!(DVec2, f64, 2);
vector!(DVec3, f64, 3);

/// Pseudorandom vector for an index: three numbers between −1 and 1, by splitmix64 of Steele, Lea and Flood (OOPSLA 2014).
#[inline]
pub fn noise(index: u64) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|axis| {
        let mut bits = (3 * index + axis as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (bits ^ (bits >> 31)) as f64 / 2.0_f64.powi(63) - 1.0
    }))
}
