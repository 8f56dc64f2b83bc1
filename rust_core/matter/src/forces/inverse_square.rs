//! Law of central forces, F = −s q^((p−1)/2) d with q = |d|² + ε², and its special case p = −2, the inverse-square force.

use super::pointwise::{ForceField, PointRate};
use crate::math::{AXES, Real, Vector};
use crate::simd::Number;

/// The power law q ↦ q^((p−1)/2).
pub trait PowerLaw<T>: Copy {
    /// Returns a factor times the power of q; 0 at q = 0 and for a factor of 0. The power is always computed, because a selection
    /// can be vectorized and a branch cannot.
    fn times(self, factor: T, q: T) -> T;
}

/// The power q^(−3/2), for p = −2.
#[derive(Debug, Clone, Copy)]
pub struct InverseCube;

impl InverseCube {
    /// Returns a factor times q^(−3/2), or 0 where the power is infinite.
    #[inline(always)]
    fn times<N: Number>(factor: N, q: N) -> N {
        let cube = q * q.sqrt();
        (factor / cube).masked(N::constant(0.0).less(cube))
    }
}

impl<T: Real> PowerLaw<T> for InverseCube {
    #[inline(always)]
    fn times(self, factor: T, q: T) -> T {
        Self::times(factor, q)
    }
}

/// An inverse-square force and the particles that it acts on.
#[derive(Debug, Clone, Copy)]
pub struct InverseSquare<'a, T> {
    /// The force field.
    pub law: InverseSquareLaw<T>,
    /// Weights of the particles: 1 if affected, else 0; padded.
    pub members: &'a [T],
}

/// The law of an inverse-square force.
pub type InverseSquareLaw<T> = CentralLaw<T, InverseCube>;

impl<T: Real> InverseSquareLaw<T> {
    /// Force on particles of these weights at these positions. The result equals that of [`ForceField::at`] bit by bit.
    #[inline(always)]
    pub fn force<V: Vector<Scalar = T>, N: Number<Scalar = T>>(&self, weight: N, place: [N; AXES]) -> [N; AXES] {
        let (mut force, mut q) = (place, N::of(self.square));
        for axis in 0..V::DIMENSION {
            force[axis] = place[axis] - N::of(self.center[axis]);
            q += force[axis] * force[axis];
        }
        let push = InverseCube::times(weight * N::of(-self.strength), q);
        for axis in 0..V::DIMENSION {
            force[axis] = push * force[axis];
        }
        force
    }
}

/// The central force on one particle.
#[derive(Debug, Clone, Copy)]
pub struct CentralLaw<T, P> {
    /// Strength s [N at r = 1 m].
    pub strength: T,
    /// Square of the softening length, ε² [m²].
    pub square: T,
    /// The center relative to the origin [m].
    pub center: [T; AXES],
    /// Power law of q.
    pub power: P,
}

impl<V: Vector, P: PowerLaw<V::Scalar>> ForceField<V> for CentralLaw<V::Scalar, P> {
    #[inline(always)]
    fn at(&self, weight: V::Scalar, x: [V::Scalar; AXES], _v: [V::Scalar; AXES]) -> PointRate<V::Scalar> {
        let mut d = [V::Scalar::ZERO; AXES];
        let mut q = self.square;
        for axis in 0..V::DIMENSION {
            d[axis] = x[axis] - self.center[axis];
            q += d[axis] * d[axis];
        }
        // At the center the direction is undefined and the force is 0.
        let push = self.power.times(-(weight * self.strength), q);
        PointRate { force: d.map(|d| push * d), dissipated: V::Scalar::ZERO, work: V::Scalar::ZERO }
    }
}
