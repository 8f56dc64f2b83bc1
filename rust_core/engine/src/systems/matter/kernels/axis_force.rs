//! The linear force along one axis of a block, with common coefficients or one set per particle.

use crate::forces::linear::{Coefficients, Varying};
use crate::math::Real;
use crate::simd::Lanes;

/// The linear force along one axis of a block. The loops below copy all input of a group of lanes to local arrays first:
/// only then can the compiler exclude aliasing, and vectorize them.
pub(super) trait AxisForce<T: Real>: Copy {
    /// Whether power is supplied from outside, by wind.
    const SUPPLIES: bool;
    /// The coefficients of a group.
    type Group: Copy;
    /// Reads the coefficients of a group.
    fn group(&self, group: usize) -> Self::Group;
    /// The acceleration of a lane.
    fn acceleration(&self, group: &Self::Group, lane: usize, x: T, v: T) -> T;
    /// The power that drag dissipates and the power of the wind, in units of [`AxisForce::unit`].
    fn power(&self, group: &Self::Group, lane: usize, v: T) -> (T, T);
    /// The unit of the powers [W].
    fn unit(&self) -> f64;
}

/// Common coefficients; `DRAG` says whether there is drag.
#[derive(Clone, Copy)]
pub(super) struct Uniform<T, const DRAG: bool>(pub(super) Coefficients<T>);

impl<T: Real, const DRAG: bool> AxisForce<T> for Uniform<T, DRAG> {
    const SUPPLIES: bool = false;
    type Group = ();

    #[inline(always)]
    fn group(&self, _group: usize) {}

    #[inline(always)]
    fn acceleration(&self, _group: &(), _lane: usize, _x: T, v: T) -> T {
        if DRAG { self.0.a0 + self.0.b * v } else { self.0.a0 }
    }

    #[inline(always)]
    fn power(&self, _group: &(), _lane: usize, v: T) -> (T, T) {
        (if DRAG { v * v } else { T::ZERO }, T::ZERO)
    }

    #[inline(always)]
    fn unit(&self) -> f64 {
        self.0.drag.to_f64()
    }
}

impl<T: Real> AxisForce<T> for Varying<'_, T> {
    const SUPPLIES: bool = true;
    /// a₀, b, c and γ.
    type Group = [Lanes<T>; 4];

    #[inline(always)]
    fn group(&self, group: usize) -> [Lanes<T>; 4] {
        [self.a0, self.b, self.c, self.drag].map(|column| column[group])
    }

    #[inline(always)]
    fn acceleration(&self, [a0, b, c, _]: &[Lanes<T>; 4], lane: usize, x: T, v: T) -> T {
        a0[lane] + b[lane] * v + c[lane] * x
    }

    #[inline(always)]
    fn power(&self, [.., drag]: &[Lanes<T>; 4], lane: usize, v: T) -> (T, T) {
        let relative = v - self.wind;
        let resistance = drag[lane] * relative;
        (resistance * relative, -(resistance * self.wind))
    }

    #[inline(always)]
    fn unit(&self) -> f64 {
        1.0
    }
}

/// Whether a force supplies power.
#[inline(always)]
pub(super) fn supplies<T: Real, L: AxisForce<T>>(_law: &L) -> bool {
    L::SUPPLIES
}
