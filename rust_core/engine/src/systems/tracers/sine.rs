//! Sine of numbers in lanes, in operations that are rounded alike at every SIMD level.
//!
//! Let n be the whole number nearest to x/π; then sin x = (−1)ⁿ sin (x − n π). On [−π/2, π/2] the Taylor series reaches the
//! accuracy of the number type after eleven terms in f64 and seven in f32. The number π is subtracted in three parts, as a
//! sum. The sine of −x is the negative of the sine of x, to the bit.
//!
//! Source: W. J. Cody, W. Waite, Software Manual for the Elementary Functions (1980), chapter 8.

use crate::math::Real;
use crate::simd::Number;

/// Constants of the sine in a number format.
struct Format {
    /// Number whose addition rounds to whole numbers. The lowest bit of the sum tells whether they are odd.
    whole: f64,
    /// π as a sum of three parts.
    pi: [f64; 3],
    /// Number of terms of the series.
    terms: usize,
}

/// Constants in f64. The first two parts of π have 33 bits, so that their products with n up to 2²⁰ are exact.
const DOUBLE: Format = Format {
    whole: 6_755_399_441_055_744.0,
    pi: [3.141_592_653_468_251_2, 1.215_420_101_260_793_2e-10, 4.044_532_497_591_901e-21],
    terms: 11,
};
/// Constants in f32. The first two parts of π have 9 and 11 bits: products are exact up to n = 2¹³.
const SINGLE: Format =
    Format { whole: 12_582_912.0, pi: [3.140_625, 9.675_025_939_941_406e-4, 1.509_958_025_280_866_4e-7], terms: 7 };

/// Sine of x.
#[inline(always)]
pub fn sine<T: Real, N: Number<Scalar = T>>(x: N) -> N {
    let Format { whole, pi, terms } = if size_of::<T>() == size_of::<f64>() { &DOUBLE } else { &SINGLE };
    let shifted = x * N::constant(std::f64::consts::FRAC_1_PI) + N::constant(*whole);
    let odd = shifted.has_bit(0);
    let turns = shifted - N::constant(*whole);
    let mut reduced = x;
    for part in pi {
        reduced = reduced - turns * N::constant(*part);
    }
    let square = reduced * reduced;
    let mut ratio = N::constant(1.0);
    for term in (1..*terms).rev() {
        let even = (2 * term) as f64;
        ratio = N::constant(1.0) - square * N::constant(1.0 / (even * (even + 1.0))) * ratio;
    }
    let sine = reduced * ratio;
    N::select(odd, N::constant(0.0) - sine, sine)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sine_is_good_to_the_last_bits_and_odd() {
        for index in 0..200_000 {
            let x = 0.000_317 * f64::from(index);
            let (double, single) = (sine::<f64, f64>(x), f64::from(sine::<f32, f32>(x as f32)));
            assert!((double - libm::sin(x)).abs() < 4e-16, "{x}: {double}");
            assert!((single - libm::sin(f64::from(x as f32))).abs() < 2.5e-7, "{x}: {single}");
            assert_eq!(sine::<f64, f64>(-x).to_bits(), (-double).to_bits());
        }
    }
}
