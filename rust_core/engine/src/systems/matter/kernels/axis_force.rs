//! The linear force along one axis of a block, with common coefficients or one set per particle.

use crate::forces::linear::{LinearCoefficients, VaryingCoefficients};
use crate::math::Real;
use crate::simd::{Lanes, Number};

/// The linear force along one axis of a block, on one particle or on several in lanes.
pub(super) trait AxisForce<T: Real>: Copy {
    /// Whether power is supplied from outside, by wind.
    const SUPPLIES: bool;
    /// Coefficients, each a `C`: of one particle, or of several in lanes.
    type Coefficients<C: Copy>: Copy;
    /// Coefficients that `read` takes from each of their columns.
    fn coefficients<C: Copy>(&self, read: impl Fn(&[Lanes<T>]) -> C) -> Self::Coefficients<C>;
    /// Acceleration.
    fn acceleration<N: Number<Scalar = T>>(&self, coefficients: &Self::Coefficients<N>, x: N, v: N) -> N;
    /// Power that drag dissipates and power of the wind, in units of [`AxisForce::unit`].
    fn power<N: Number<Scalar = T>>(&self, coefficients: &Self::Coefficients<N>, v: N) -> [N; 2];
    /// Unit of the powers [W].
    fn unit(&self) -> f64;
}

/// Common coefficients; `DRAG` is whether there is drag.
#[derive(Clone, Copy)]
pub(super) struct UniformForce<T, const DRAG: bool>(pub(super) LinearCoefficients<T>);

impl<T: Real, const DRAG: bool> AxisForce<T> for UniformForce<T, DRAG> {
    const SUPPLIES: bool = false;
    type Coefficients<C: Copy> = ();

    #[inline(always)]
    fn coefficients<C: Copy>(&self, _read: impl Fn(&[Lanes<T>]) -> C) {}

    #[inline(always)]
    fn acceleration<N: Number<Scalar = T>>(&self, _coefficients: &(), _x: N, v: N) -> N {
        if DRAG { N::of(self.0.a0) + N::of(self.0.b) * v } else { N::of(self.0.a0) }
    }

    #[inline(always)]
    fn power<N: Number<Scalar = T>>(&self, _coefficients: &(), v: N) -> [N; 2] {
        let nothing = N::constant(0.0);
        [if DRAG { v * v } else { nothing }, nothing]
    }

    #[inline(always)]
    fn unit(&self) -> f64 {
        self.0.drag.to_f64()
    }
}

impl<T: Real> AxisForce<T> for VaryingCoefficients<'_, T> {
    const SUPPLIES: bool = true;
    /// Coefficients a₀, b, c and γ.
    type Coefficients<C: Copy> = [C; 4];

    #[inline(always)]
    fn coefficients<C: Copy>(&self, read: impl Fn(&[Lanes<T>]) -> C) -> [C; 4] {
        [read(self.a0), read(self.b), read(self.c), read(self.drag)]
    }

    #[inline(always)]
    fn acceleration<N: Number<Scalar = T>>(&self, &[a0, b, c, _]: &[N; 4], x: N, v: N) -> N {
        a0 + b * v + c * x
    }

    #[inline(always)]
    fn power<N: Number<Scalar = T>>(&self, &[.., drag]: &[N; 4], v: N) -> [N; 2] {
        let relative = v - N::of(self.wind);
        let resistance = drag * relative;
        [resistance * relative, resistance * N::of(-self.wind)]
    }

    #[inline(always)]
    fn unit(&self) -> f64 {
        1.0
    }
}
