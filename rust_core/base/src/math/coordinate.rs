//! Encoded coordinates in the records of pair sums. Their differences have full relative precision at any distance from the
//! origin.
//!
//! In f64 the code is the coordinate itself. In f32 the code is a 32-bit fixed-point coordinate, modulo eight to sixteen
//! supports, or modulo a shorter period. A period of the domain is an integer multiple of the modulus. The wrapping difference of
//! two codes is exact and refers to the nearest images. One multiplication converts it to a length.
//!
//! The fixed-point unit is below 4e-9 supports. The error is therefore that of the conversion, 6e-8 of the length. It is up to
//! three times as large if a period prevents the unit from being a power of two.

use std::fmt::Debug;

use crate::simd::{Number, Packed};

/// Number of fixed-point coordinates along an axis in f32: 2³².
const UNITS: f64 = 4_294_967_296.0;

/// Constant whose addition and subtraction rounds a number below 2⁵¹ to the nearest integer, ties to even. All SIMD levels have
/// vector instructions for this, but not all for `round_ties_even`.
const WHOLE: f64 = 6_755_399_441_055_744.0;

/// Rounds a value below 2⁵¹ to the nearest integer.
#[inline(always)]
fn nearest<N: Number>(value: N) -> N {
    (value + N::constant(WHOLE)) - N::constant(WHOLE)
}

/// Number types that can hold an encoded coordinate. Records hold numbers and coordinates side by side.
pub trait Coordinate: Packed {
    /// Whether differences of codes refer to the nearest images without further computation.
    const WRAPS: bool;
    /// Parameters of the encoding along one axis.
    type Encoding: Copy + Debug + Send + Sync + 'static;

    /// Encoding for an axis with an optional period, for differences up to `support`.
    fn encoding(period: Option<f64>, support: f64) -> Self::Encoding;
    /// Encodes a coordinate. The value of the code as a number has no meaning.
    fn encode(coordinate: f64, encoding: Self::Encoding) -> Self;
    /// Difference of two coordinates, or of their nearest images along a periodic axis. `PERIODIC` says whether any axis is
    /// periodic.
    fn separation<const PERIODIC: bool, N: Number<Scalar = Self>>(one: N, other: N, encoding: Self::Encoding) -> N;
}

/// Fixed-point encoding of f32.
#[derive(Debug, Clone, Copy)]
pub struct Fixed {
    /// Units per meter [1/m].
    scale: f64,
    /// Fixed-point unit [m].
    unit: f32,
}

impl Coordinate for f32 {
    const WRAPS: bool = true;
    type Encoding = Fixed;

    fn encoding(period: Option<f64>, support: f64) -> Fixed {
        // Without a period the scale is a power of two, so its product with a coordinate is exact.
        let modulus = period.map_or_else(
            || libm::ldexp(1.0, libm::ilogb(support) + 4),
            |period| period / (period / (8.0 * support)).floor().max(1.0),
        );
        Fixed { scale: UNITS / modulus, unit: (modulus / UNITS) as f32 }
    }

    #[inline(always)]
    fn encode(coordinate: f64, encoding: Fixed) -> f32 {
        f32::from_bits((coordinate * encoding.scale).round_ties_even() as i64 as u32)
    }

    #[inline(always)]
    fn separation<const PERIODIC: bool, N: Number<Scalar = f32>>(one: N, other: N, encoding: Fixed) -> N {
        one.coordinate_difference(other) * N::of(encoding.unit)
    }
}

/// Period of an axis and its inverse, for nearest images in f64.
#[derive(Debug, Clone, Copy)]
pub struct MinimumImage {
    /// Period [m], 0 for none.
    period: f64,
    /// Inverse of the period [1/m], 0 for none.
    inverse: f64,
}

impl Coordinate for f64 {
    const WRAPS: bool = false;
    type Encoding = MinimumImage;

    fn encoding(period: Option<f64>, _support: f64) -> MinimumImage {
        MinimumImage { period: period.unwrap_or(0.0), inverse: period.map_or(0.0, |period| 1.0 / period) }
    }

    #[inline(always)]
    fn encode(coordinate: f64, _ruler: MinimumImage) -> f64 {
        coordinate
    }

    #[inline(always)]
    fn separation<const PERIODIC: bool, N: Number<Scalar = f64>>(one: N, other: N, encoding: MinimumImage) -> N {
        let difference = one.coordinate_difference(other);
        if !PERIODIC {
            return difference;
        }
        difference - N::of(encoding.period) * nearest(difference * N::of(encoding.inverse))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Error bound: half a unit for each coordinate, and half an ulp for the conversion. With a period the unit is no power of
    /// two; then half an ulp is added for the unit and for the product.
    fn tolerance(separation: f64, support: f64, period: Option<f64>) -> f64 {
        let roundings = if period.is_some() { 3.0 } else { 1.0 };
        4e-9 * support + roundings * 0.5 * f64::from(f32::EPSILON) * separation.abs()
    }

    #[test]
    fn differences_are_as_good_as_single_precision_however_far_away() {
        for (support, period) in [(1.0, None), (0.3, None), (7e-5, None), (1.0, Some(2.0)), (0.3, Some(2.7)), (0.1, Some(1e4))] {
            let encoding = f32::encoding(period, support);
            for start in [0.0, -1e5, 1e5, 123_456.7] {
                for step in -49..50 {
                    let (one, other) = (start * support, start * support + f64::from(step) * 0.02 * support);
                    let separation =
                        f32::separation::<true, _>(f32::encode(one, encoding), f32::encode(other, encoding), encoding);
                    assert!(
                        (f64::from(separation) - (one - other)).abs() <= tolerance(one - other, support, period),
                        "{separation} {one} {other}"
                    );
                }
            }
        }
    }

    #[test]
    fn the_nearest_image_is_found_in_any_period() {
        let (period, support) = (2.7, 0.3);
        let (single, double) = (f32::encoding(Some(period), support), f64::encoding(Some(period), support));
        for turns in -1000..1000 {
            let (one, other) = (0.1, -0.15 + f64::from(turns) * period);
            let separation = f32::separation::<true, _>(f32::encode(one, single), f32::encode(other, single), single);
            assert!((f64::from(separation) - 0.25).abs() < tolerance(0.25, support, Some(period)), "{separation}");
            // The coordinate is rounded at 2700 m; its quotient by the period adds as large an error.
            assert!((f64::separation::<true, _>(one, other, double) - 0.25).abs() < 4.0 * 2700.0 * f64::EPSILON);
        }
    }
}
