//! Smoothing kernels W(r) of support 2h, each with its slope F(r) = W′(r)/r and the derivative F′(r)/r of the slope. Their
//! gradients are ∇W = F d and ∇∇W = F 1 + F′/r d dᵀ.
//!
//! With u = r/2h and (y)₊ = max(y, 0), in 2D and 3D:
//!
//! | kernel | W/W₀ | h² F/W₀ | W₀ h^D | source |
//! |---|---|---|---|---|
//! | Wendland C2 | (1−u)₊⁴ (1+4u) | −5 (1−u)₊³ | 7/4π, 21/16π | H. Wendland, Adv. Comput. Math. 4 (1995) 389 |
//! | Wendland C4 | (1−u)₊⁶ (1+6u+35u²/3) | −14/3 (1−u)₊⁵ (1+5u) | 9/4π, 495/256π | ibid. |
//! | B-spline | 2(1−u)₊³ − (1−2u)₊³ | below | 10/7π, 1/π | J. J. Monaghan, J. C. Lattanzio, Astron. Astrophys. 149 (1985) 135 |

use std::f64::consts::PI;

use super::lattice;
use crate::math::Real;
use crate::simd::Number;

/// Regularization of a divisor distance, in units of the support.
const TINY: f64 = 1e-6;

/// Number of shapes.
pub const SHAPES: usize = 3;

/// Shape of a kernel: unit height and unit smoothing length, as a function of u = r/2h from 0 to 1.
pub trait KernelShape: Copy + Send + Sync + 'static {
    /// Place among all shapes, from 0 on.
    fn number(self) -> usize;
    /// Normalization W₀ h^D.
    fn height(self, dimension: usize) -> f64;
    /// Value W/W₀.
    fn value<N: Number>(self, u: N) -> N;
    /// Constant factor of h² F/W₀.
    fn factor(self) -> f64;
    /// Slope h² F/W₀ divided by [`KernelShape::factor`].
    fn slope<N: Number>(self, u: N) -> N;
    /// Bend h⁴ F′/(r W₀) = h² (dF/du)/(4u W₀), regularized where it diverges for u → 0.
    fn bend<N: Number>(self, u: N) -> N;
}

/// Wendland's kernel with two continuous derivatives. Sums are compiled for this default.
#[derive(Debug, Clone, Copy)]
pub struct WendlandC2;

impl KernelShape for WendlandC2 {
    fn number(self) -> usize {
        0
    }

    fn height(self, dimension: usize) -> f64 {
        if dimension == 2 { 7.0 / (4.0 * PI) } else { 21.0 / (16.0 * PI) }
    }

    fn factor(self) -> f64 {
        -5.0
    }

    #[inline(always)]
    fn value<N: Number>(self, u: N) -> N {
        let y = N::constant(1.0) - u;
        let square = y * y;
        square * square * (N::constant(1.0) + N::constant(4.0) * u)
    }

    #[inline(always)]
    fn slope<N: Number>(self, u: N) -> N {
        let y = N::constant(1.0) - u;
        y * (y * y)
    }

    #[inline(always)]
    fn bend<N: Number>(self, u: N) -> N {
        let y = N::constant(1.0) - u;
        N::constant(3.75) * (y * y) / (u + N::constant(TINY))
    }
}

/// Other kernels, selected at run time.
#[derive(Debug, Clone, Copy)]
pub enum OtherShape {
    /// Wendland's kernel with four continuous derivatives.
    WendlandC4,
    /// The cubic B-spline.
    CubicSpline,
}

impl KernelShape for OtherShape {
    fn number(self) -> usize {
        1 + self as usize
    }

    fn height(self, dimension: usize) -> f64 {
        let [plane, space] = match self {
            Self::WendlandC4 => [9.0 / (4.0 * PI), 495.0 / (256.0 * PI)],
            Self::CubicSpline => [10.0 / (7.0 * PI), 1.0 / PI],
        };
        if dimension == 2 { plane } else { space }
    }

    fn factor(self) -> f64 {
        match self {
            Self::WendlandC4 => -14.0 / 3.0,
            Self::CubicSpline => 1.0,
        }
    }

    #[inline(always)]
    fn value<N: Number>(self, u: N) -> N {
        let y = N::constant(1.0) - u;
        match self {
            Self::WendlandC4 => {
                let square = y * y;
                square * square * square * (N::constant(1.0) + u * (N::constant(6.0) + N::constant(35.0 / 3.0) * u))
            }
            Self::CubicSpline => {
                let inner = (N::constant(1.0) - (u + u)).max(N::constant(0.0));
                N::constant(2.0) * (y * y * y) - inner * inner * inner
            }
        }
    }

    /// The slope of the spline is −3 + 9u/2 for u < ½, then −3 (1−u)²/2u.
    #[inline(always)]
    fn slope<N: Number>(self, u: N) -> N {
        let y = N::constant(1.0) - u;
        match self {
            Self::WendlandC4 => {
                let square = y * y;
                (square * square * y) * (N::constant(1.0) + N::constant(5.0) * u)
            }
            Self::CubicSpline => {
                let far = N::constant(-1.5) * (y * y) / u;
                let near = N::constant(4.5) * u - N::constant(3.0);
                N::select(u.less(N::constant(0.5)), near, far)
            }
        }
    }

    /// The bend of the spline is 9/8u for u < ½, then 3 (1−u²)/8u³.
    #[inline(always)]
    fn bend<N: Number>(self, u: N) -> N {
        match self {
            Self::WendlandC4 => {
                let y = N::constant(1.0) - u;
                N::constant(35.0) * (y * y) * (y * y)
            }
            Self::CubicSpline => {
                let far = N::constant(0.375) * (N::constant(1.0) - u * u) / (u * u * u);
                let near = N::constant(1.125) / (u + N::constant(TINY));
                N::select(u.less(N::constant(0.5)), near, far)
            }
        }
    }
}

/// Kernel of a given smoothing length, in the precision of the run.
#[derive(Debug, Clone, Copy)]
pub struct SmoothingKernel<T, K> {
    /// Inverse support 1/2h [1/m].
    pub inverse_support: T,
    /// Height W₀ [m^−D].
    pub height: T,
    /// Steepness W₀/h² [m^−(D+2)], and its product with the constant factor of F.
    pub steepness: T,
    slope: T,
    /// Inverse square 1/h² [1/m²].
    inverse_square: T,
    /// Shape of the kernel.
    pub shape: K,
}

impl<T: Real, K: KernelShape> SmoothingKernel<T, K> {
    /// Kernel of smoothing length h [m] for particles at this spacing [m].
    ///
    /// Its slope is scaled to make the gradient of a linear field exact on a lattice of that spacing: −Σ Δ^D F x² = 1. With few
    /// neighbors, it would otherwise have an error of some percent.
    pub fn new(shape: K, smoothing_length: f64, spacing: f64, dimension: usize) -> Self {
        let square = smoothing_length * smoothing_length;
        let height = shape.height(dimension) / if dimension == 2 { square } else { square * smoothing_length };
        let steepness = height / square / lattice::moment(shape, spacing / smoothing_length, dimension);
        Self {
            inverse_support: T::from_f64(0.5 / smoothing_length),
            height: T::from_f64(height),
            steepness: T::from_f64(steepness),
            slope: T::from_f64(shape.factor() * steepness),
            inverse_square: T::from_f64(square.recip()),
            shape,
        }
    }

    /// Kernel value W at a distance [m].
    #[inline(always)]
    pub fn value<N: Number<Scalar = T>>(&self, distance: N) -> N {
        N::of(self.height) * self.shape.value(self.reach(distance))
    }

    /// Product V F for a volume V at a distance [m].
    #[inline(always)]
    pub fn slope<N: Number<Scalar = T>>(&self, volume: N, distance: N) -> N {
        // In this order the first product does not wait for the distance.
        (N::of(self.slope) * volume) * self.shape.slope(self.reach(distance))
    }

    /// Product V F′/r for a volume V at a distance r [m].
    #[inline(always)]
    pub fn bend<N: Number<Scalar = T>>(&self, volume: N, distance: N) -> N {
        // In this order nothing overflows in single precision.
        (N::of(self.steepness) * volume) * (N::of(self.inverse_square) * self.shape.bend(self.reach(distance)))
    }

    /// Relative distance u = r/2h, clamped to 1 beyond the support.
    #[inline(always)]
    fn reach<N: Number<Scalar = T>>(&self, distance: N) -> N {
        (distance * N::of(self.inverse_support)).min(N::constant(1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::super::waves::integral;
    use super::*;

    /// Checks values, slopes and bends. Simpson's rule with steps of width w has an error of about 2/180 w⁴ max|f⁗|, here 1e-9.
    fn check(shape: impl KernelShape + std::fmt::Debug) {
        for dimension in [2, 3] {
            // On such a fine lattice the sum equals the integral.
            let kernel = SmoothingKernel::<f64, _>::new(shape, 1.0, 0.05, dimension);
            assert!((integral(dimension, |r| kernel.value(r)) - 1.0).abs() < 1e-6, "{shape:?} in {dimension}D");
            for step in 1..400 {
                let r = f64::from(step) * 0.005;
                let difference = (kernel.value(r + 1e-5) - kernel.value(r - 1e-5)) / 2e-5;
                // The third derivative is below 100 W₀ everywhere, and the difference has an error of 1e-8 W₀. The lattice moment
                // equals that of the integral, 1, to about 1e-6.
                assert!((kernel.slope(1.0, r) * r - difference).abs() < 1e-5 * kernel.height, "{shape:?} at {r}");
            }
            for step in 1..400 {
                let r = f64::from(step) * 0.005;
                let difference = (kernel.slope(1.0, r + 1e-6) - kernel.slope(1.0, r - 1e-6)) / 2e-6;
                // The slope of the spline has a kink at r = h, where the difference is its mean. TINY is 2e-4 of the smallest u.
                let error = (kernel.bend(1.0, r) * r - difference).abs();
                assert!(error < 1e-3 * kernel.steepness * (1.0 + 1.0 / r) || (r - 1.0).abs() < 1e-9, "bend at {r}: {error}");
            }
            assert_eq!((kernel.value(2.0), kernel.slope(1.0, 2.0), kernel.slope(1.0, 3.0)), (0.0, 0.0, 0.0));
        }
    }

    #[test]
    fn kernels_are_normalized_and_slopes_are_their_derivatives() {
        check(WendlandC2);
        check(OtherShape::WendlandC4);
        check(OtherShape::CubicSpline);
    }
}
