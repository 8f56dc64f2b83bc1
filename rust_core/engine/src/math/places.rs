//! Where particles are, in the records that pair sums read: so that a difference of two places is as good as the precision
//! in which it is computed, however far from the origin both are.
//!
//! In f64 a place is the coordinate. In f32 it is a 32-bit fixed-point number modulo eight to sixteen supports, of which a
//! periodic axis holds a whole number: the wrapping difference of two is exact, is that of the nearest images, and needs
//! one multiplication to become a length. Its unit is below 4e-9 supports, so what is left is the rounding of the
//! conversion, 6e-8 of the length itself, and up to three times that where a period makes the unit an odd number.

use std::fmt::Debug;

use crate::simd::{Number, Packed};

/// 2³², the number of different places along an axis in f32.
const UNITS: f64 = 4_294_967_296.0;

/// Added and taken away again, this rounds a number below 2⁵¹ to the nearest whole one, ties to even. Every level has
/// vector instructions for it, and for `round_ties_even` only some.
const WHOLE: f64 = 6_755_399_441_055_744.0;

/// The nearest whole number to a value below 2⁵¹.
#[inline(always)]
fn nearest<N: Number>(value: N) -> N {
    (value + N::constant(WHOLE)) - N::constant(WHOLE)
}

/// Numbers that can hold a place: records then hold numbers and places side by side.
pub trait Coordinate: Packed {
    /// Whether differences find the nearest image by themselves, so that nobody has to ask for it.
    const WRAPS: bool;
    /// How places along one axis are measured.
    type Ruler: Copy + Debug + Send + Sync + 'static;

    /// The ruler for an axis of a certain period, if it has one, between whose places differences up to `support` matter.
    fn ruler(period: Option<f64>, support: f64) -> Self::Ruler;
    /// The place of a coordinate. Its value as a number means nothing.
    fn encode(coordinate: f64, ruler: Self::Ruler) -> Self;
    /// How far a place lies above another, or above its nearest image where the axis is periodic. `PERIODIC` says whether
    /// any axis is.
    fn separation<const PERIODIC: bool, N: Number<Scalar = Self>>(one: N, other: N, ruler: Self::Ruler) -> N;
}

/// How places in f32 are measured.
#[derive(Debug, Clone, Copy)]
pub struct Fixed {
    /// Units in a metre [1/m].
    scale: f64,
    /// The unit [m].
    unit: f32,
}

impl Coordinate for f32 {
    const WRAPS: bool = true;
    type Ruler = Fixed;

    fn ruler(period: Option<f64>, support: f64) -> Fixed {
        // Without a period a power of two, whose multiplication with a coordinate is exact.
        let modulus = period.map_or_else(
            || libm::ldexp(1.0, libm::ilogb(support) + 4),
            |period| period / (period / (8.0 * support)).floor().max(1.0),
        );
        Fixed { scale: UNITS / modulus, unit: (modulus / UNITS) as f32 }
    }

    #[inline(always)]
    fn encode(coordinate: f64, ruler: Fixed) -> f32 {
        f32::from_bits((coordinate * ruler.scale).round_ties_even() as i64 as u32)
    }

    #[inline(always)]
    fn separation<const PERIODIC: bool, N: Number<Scalar = f32>>(one: N, other: N, ruler: Fixed) -> N {
        one.coordinate_difference(other) * N::of(ruler.unit)
    }
}

/// How far images are from each other in f64.
#[derive(Debug, Clone, Copy)]
pub struct Image {
    /// The period [m], 0 for none.
    period: f64,
    /// Its inverse [1/m], 0 for none.
    inverse: f64,
}

impl Coordinate for f64 {
    const WRAPS: bool = false;
    type Ruler = Image;

    fn ruler(period: Option<f64>, _support: f64) -> Image {
        Image { period: period.unwrap_or(0.0), inverse: period.map_or(0.0, |period| 1.0 / period) }
    }

    #[inline(always)]
    fn encode(coordinate: f64, _ruler: Image) -> f64 {
        coordinate
    }

    #[inline(always)]
    fn separation<const PERIODIC: bool, N: Number<Scalar = f64>>(one: N, other: N, ruler: Image) -> N {
        let difference = one.coordinate_difference(other);
        if !PERIODIC {
            return difference;
        }
        difference - N::of(ruler.period) * nearest(difference * N::of(ruler.inverse))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Half a unit for each place; half an ulp for the conversion, and where there is a period, so that the unit is no power
    /// of two, for the unit and the product too.
    fn tolerance(separation: f64, support: f64, period: Option<f64>) -> f64 {
        let roundings = if period.is_some() { 3.0 } else { 1.0 };
        4e-9 * support + roundings * 0.5 * f64::from(f32::EPSILON) * separation.abs()
    }

    #[test]
    fn differences_are_as_good_as_single_precision_however_far_away() {
        for (support, period) in [(1.0, None), (0.3, None), (7e-5, None), (1.0, Some(2.0)), (0.3, Some(2.7)), (0.1, Some(1e4))] {
            let ruler = f32::ruler(period, support);
            for start in [0.0, -1e5, 1e5, 123_456.7] {
                for step in -49..50 {
                    let (one, other) = (start * support, start * support + f64::from(step) * 0.02 * support);
                    let separation = f32::separation::<true, _>(f32::encode(one, ruler), f32::encode(other, ruler), ruler);
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
        let (single, double) = (f32::ruler(Some(period), support), f64::ruler(Some(period), support));
        for turns in -1000..1000 {
            let (one, other) = (0.1, -0.15 + f64::from(turns) * period);
            let separation = f32::separation::<true, _>(f32::encode(one, single), f32::encode(other, single), single);
            assert!((f64::from(separation) - 0.25).abs() < tolerance(0.25, support, Some(period)), "{separation}");
            // The coordinate itself is rounded at 2700 m, and its quotient by the period costs as much again.
            assert!((f64::separation::<true, _>(one, other, double) - 0.25).abs() < 4.0 * 2700.0 * f64::EPSILON);
        }
    }
}
