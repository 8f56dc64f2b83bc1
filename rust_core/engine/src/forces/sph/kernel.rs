//! Smoothing kernels W(r) of support 2h: each with its value and the slope F(r) = W′(r)/r, so that ∇W = F d.
//!
//! With u = r/2h and (y)₊ = max(y, 0), in 2D and 3D:
//!
//! | kernel | W/W₀ | h² F/W₀ | W₀ h^D | source |
//! |---|---|---|---|---|
//! | Wendland C2 | (1−u)₊⁴ (1+4u) | −5 (1−u)₊³ | 7/4π, 21/16π | H. Wendland, Adv. Comput. Math. 4 (1995) 389 |
//! | Wendland C4 | (1−u)₊⁶ (1+6u+35u²/3) | −14/3 (1−u)₊⁵ (1+5u) | 9/4π, 495/256π | the same |
//! | cubic spline | 2(1−u)₊³ − (1−2u)₊³ | below | 10/7π, 1/π | J. J. Monaghan, J. C. Lattanzio, Astron. Astrophys. 149 (1985) 135 |

use std::f64::consts::PI;

use crate::math::Real;

/// A kernel of unit height and unit smoothing length, as a function of u = r/2h from 0 to 1.
pub trait Shape<T: Real>: Copy + Send + Sync + 'static {
    /// W₀ h^D in 2D and 3D.
    const HEIGHT: [f64; 2];
    /// W/W₀.
    fn value(u: T) -> T;
    /// h² F/W₀.
    fn slope(u: T) -> T;
}

/// Wendland's kernel with two continuous derivatives.
#[derive(Debug, Clone, Copy)]
pub struct WendlandC2;

impl<T: Real> Shape<T> for WendlandC2 {
    const HEIGHT: [f64; 2] = [7.0 / (4.0 * PI), 21.0 / (16.0 * PI)];

    #[inline(always)]
    fn value(u: T) -> T {
        let y = T::ONE - u;
        let square = y * y;
        square * square * (T::ONE + T::from_f64(4.0) * u)
    }

    #[inline(always)]
    fn slope(u: T) -> T {
        let y = T::ONE - u;
        T::from_f64(-5.0) * (y * y * y)
    }
}

/// Wendland's kernel with four continuous derivatives.
#[derive(Debug, Clone, Copy)]
pub struct WendlandC4;

impl<T: Real> Shape<T> for WendlandC4 {
    const HEIGHT: [f64; 2] = [9.0 / (4.0 * PI), 495.0 / (256.0 * PI)];

    #[inline(always)]
    fn value(u: T) -> T {
        let y = T::ONE - u;
        let square = y * y;
        square * square * square * (T::ONE + u * (T::from_f64(6.0) + T::from_f64(35.0 / 3.0) * u))
    }

    #[inline(always)]
    fn slope(u: T) -> T {
        let y = T::ONE - u;
        let square = y * y;
        T::from_f64(-14.0 / 3.0) * (square * square * y) * (T::ONE + T::from_f64(5.0) * u)
    }
}

/// The cubic B-spline.
#[derive(Debug, Clone, Copy)]
pub struct CubicSpline;

impl<T: Real> Shape<T> for CubicSpline {
    const HEIGHT: [f64; 2] = [10.0 / (7.0 * PI), 1.0 / PI];

    #[inline(always)]
    fn value(u: T) -> T {
        let (outer, inner) = (T::ONE - u, T::ONE - (u + u));
        let inner = if inner > T::ZERO { inner } else { T::ZERO };
        T::from_f64(2.0) * (outer * outer * outer) - inner * inner * inner
    }

    /// −3 + 9u/2 for u < ½, then −3 (1−u)²/2u.
    #[inline(always)]
    fn slope(u: T) -> T {
        let outer = T::ONE - u;
        let far = T::from_f64(-1.5) * (outer * outer) / u;
        let near = T::from_f64(4.5) * u - T::from_f64(3.0);
        if u < T::from_f64(0.5) { near } else { far }
    }
}

/// A kernel of a certain smoothing length, in the precision of the run.
#[derive(Debug, Clone, Copy)]
pub struct Kernel<T, K> {
    /// 1/2h [1/m].
    pub inverse_support: T,
    /// W₀ [m^−D].
    pub height: T,
    /// W₀/h² [m^−(D+2)].
    pub steepness: T,
    shape: std::marker::PhantomData<K>,
}

impl<T: Real, K: Shape<T>> Kernel<T, K> {
    /// The kernel of smoothing length h [m].
    pub fn new(smoothing_length: f64, dimension: usize) -> Self {
        let square = smoothing_length * smoothing_length;
        let height = K::HEIGHT[dimension - 2] / if dimension == 2 { square } else { square * smoothing_length };
        Self {
            inverse_support: T::from_f64(0.5 / smoothing_length),
            height: T::from_f64(height),
            steepness: T::from_f64(height / square),
            shape: std::marker::PhantomData,
        }
    }

    /// W at a distance [m].
    #[inline(always)]
    pub fn value(&self, distance: T) -> T {
        self.height * K::value(self.reach(distance))
    }

    /// F at a distance [m].
    #[inline(always)]
    pub fn slope(&self, distance: T) -> T {
        self.steepness * K::slope(self.reach(distance))
    }

    /// u, and 1 beyond the support.
    #[inline(always)]
    fn reach(&self, distance: T) -> T {
        let u = distance * self.inverse_support;
        if u < T::ONE { u } else { T::ONE }
    }
}

/// The number of steps of Simpson's rule; the error is below 1e-12 for these polynomials.
const STEPS: usize = 2000;

/// The standard deviation of a kernel along one axis, in smoothing lengths: σ² = ∫ r² W dV / D.
pub fn deviation<K: Shape<f64>>(dimension: usize) -> f64 {
    let square = integral(dimension, |r| r * r * K::HEIGHT[dimension - 2] * K::value(0.5 * r));
    (square / dimension as f64).sqrt()
}

/// ∫ |F| dV of a kernel of unit smoothing length.
pub fn roughness<K: Shape<f64>>(dimension: usize) -> f64 {
    integral(dimension, |r| K::HEIGHT[dimension - 2] * K::slope(0.5 * r).abs())
}

/// The integral of a function of the distance over the support of a kernel of unit smoothing length, by Simpson's rule.
fn integral(dimension: usize, value: impl Fn(f64) -> f64) -> f64 {
    let shell = |r: f64| if dimension == 2 { 2.0 * PI * r } else { 4.0 * PI * r * r };
    let width = 2.0 / STEPS as f64;
    let weight = |step: usize| if step == 0 || step == STEPS { 1.0 } else { 2.0 + 2.0 * (step % 2) as f64 };
    let at = |step: usize| step as f64 * width;
    (0..=STEPS).map(|step| weight(step) * value(at(step)) * shell(at(step))).sum::<f64>() * width / 3.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Simpson's rule over steps of width w is off by some 2/180 w⁴ max|f⁗|, 1e-9 here.
    fn check<K: Shape<f64>>() {
        for dimension in [2, 3] {
            let kernel = Kernel::<f64, K>::new(1.0, dimension);
            assert!(
                (integral(dimension, |r| kernel.value(r)) - 1.0).abs() < 1e-6,
                "{} in {dimension}D",
                std::any::type_name::<K>()
            );
            for step in 1..400 {
                let r = f64::from(step) * 0.005;
                let difference = (kernel.value(r + 1e-5) - kernel.value(r - 1e-5)) / 2e-5;
                // The third derivative is below 100 W₀ everywhere, so that the difference is good to 1e-10/6 of that.
                assert!((kernel.slope(r) * r - difference).abs() < 1e-8 * kernel.height, "{} at {r}", std::any::type_name::<K>());
            }
            assert_eq!((kernel.value(2.0), kernel.slope(2.0), kernel.slope(3.0)), (0.0, 0.0, 0.0));
        }
    }

    #[test]
    fn kernels_are_normalized_and_slopes_are_their_derivatives() {
        check::<WendlandC2>();
        check::<WendlandC4>();
        check::<CubicSpline>();
    }

    /// 2/ω with ω = c max k exp(−σ²k²/2) = c e^−½/σ: 3.3 σ/c. The figures are those of that limit in h/c.
    #[test]
    fn the_acoustic_limit_is_that_of_the_literature() {
        let limit = |deviation: f64| 2.0 * 0.5_f64.exp() * deviation;
        for (found, expected) in [
            (deviation::<WendlandC2>(2), 1.756),
            (deviation::<WendlandC2>(3), 1.722),
            (deviation::<CubicSpline>(2), 1.878),
            (deviation::<CubicSpline>(3), 1.829),
            (deviation::<WendlandC4>(2), 1.531),
            (deviation::<WendlandC4>(3), 1.507),
        ] {
            assert!((limit(found) - expected).abs() < 5e-3 * expected, "{} {expected}", limit(found));
        }
    }
}
