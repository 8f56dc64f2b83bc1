//! Encoded coordinates in the records of pair sums, whose differences have full relative precision at any distance from the
//! origin.
//!
//! In f64 the code is the coordinate itself. In f32 it is a 32-bit fixed-point coordinate modulo eight to sixteen supports,
//! of which a period is an integer multiple: the wrapping difference of two is exact, is that of the nearest images, and
//! needs one multiplication to become a length. Its unit is below 4e-9 supports, so the error is that of the conversion,
//! 6e-8 of the length itself, and up to three times that where a period makes the unit no power of two.

use std::fmt::Debug;

use crate::simd::{Number, Packed};

/// 2³², the number of fixed-point coordinates along an axis in f32.
const UNITS: f64 = 4_294_967_296.0;

/// Adding and subtracting this rounds a number below 2⁵¹ to the nearest integer, ties to even. All SIMD levels have vector
/// instructions for it, but not all for `round_ties_even`.
const WHOLE: f64 = 6_755_399_441_055_744.0;

/// The nearest integer to a value below 2⁵¹.
#[inline(always)]
fn nearest<N: Number>(value: N) -> N {
    (value + N::constant(WHOLE)) - N::constant(WHOLE)
}

/// Number types that can hold an encoded coordinate: records hold numbers and coordinates side by side.
pub trait Coordinate: Packed {
    /// Whether differences are those of the nearest images without further computation.
    const WRAPS: bool;
    /// Parameters of the encoding along one axis.
    type Encoding: Copy + Debug + Send + Sync + 'static;

    /// The encoding for an axis with an optional period, for differences up to `support`.
    fn encoding(period: Option<f64>, support: f64) -> Self::Encoding;
    /// The code of a coordinate. Its value as a number has no meaning.
    fn encode(coordinate: f64, encoding: Self::Encoding) -> Self;
    /// The difference of two coordinates, or of the nearest images where the axis is periodic. `PERIODIC` says whether any
    /// axis is.
    fn separation<const PERIODIC: bool, N: Number<Scalar = Self>>(one: N, other: N, encoding: Self::Encoding) -> N;
}

/// The fixed-point encoding of f32.
#[derive(Debug, Clone, Copy)]
pub struct Fixed {
    /// Units per meter [1/m].
    scale: f64,
    /// The unit [m].
    unit: f32,
}

impl Coordinate for f32 {
    const WRAPS: bool = true;
    type Encoding = Fixed;

    fn encoding(period: Option<f64>, support: f64) -> Fixed {
        // A power of two without a period, whose product with a coordinate is exact.
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

/// The distance of periodic images in f64.
#[derive(Debug, Clone, Copy)]
pub struct Image {
    /// The period [m], 0 for none.
    period: f64,
    /// Its inverse [1/m], 0 for none.
    inverse: f64,
}

impl Coordinate for f64 {
    const WRAPS: bool = false;
    type Encoding = Image;

    fn encoding(period: Option<f64>, _support: f64) -> Image {
        Image { period: period.unwrap_or(0.0), inverse: period.map_or(0.0, |period| 1.0 / period) }
    }

    #[inline(always)]
    fn encode(coordinate: f64, _ruler: Image) -> f64 {
        coordinate
    }

    #[inline(always)]
    fn separation<const PERIODIC: bool, N: Number<Scalar = f64>>(one: N, other: N, encoding: Image) -> N {
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

    /// Half a unit for each coordinate; half an ulp for the conversion, and with a period, where the unit is no power of
    /// two, for the unit and the product too.
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
            // The coordinate itself is rounded at 2700 m, and its quotient by the period costs as much again.
            assert!((f64::separation::<true, _>(one, other, double) - 0.25).abs() < 4.0 * 2700.0 * f64::EPSILON);
        }
    }
}
