//! Walls of a fluid, as mirrors.
//!
//! A particle near a wall meets the images of its neighbors, and its own, behind that wall: as many as the wall cuts off from
//! its support, so that density and pressure are as smooth there as inside. An image is never nearer than its original, so
//! the originals are all in the particle's list already, and nothing has to be stored. In a corner there are images of
//! images. A curved wall is met as its tangent plane.
//!
//! Mirrored are position and velocity: where the fluid slips freely its velocity across the wall, where it sticks all of it.
//! The pressure of an image is that of its original, and what gravity adds on the way: so a fluid at rest stays at rest.

use crate::math::{AXES, Real, Vector};
use crate::neighbors::sums::PairLaw;
use crate::simd::Record;

/// A wall as a particle near it sees it.
#[derive(Debug, Clone, Copy)]
pub struct Mirror<T> {
    /// The unit normal n into the fluid.
    pub normal: [T; AXES],
    /// The distance of the particle from the wall [m].
    pub distance: T,
    /// What gravity adds to the pressure per metre behind the wall, −ρ₀ g·n [Pa/m].
    pub weight: T,
    /// Whether the fluid sticks to the wall: 1 or 0.
    pub sticks: T,
}

/// A law whose pressures can be changed.
pub trait Pressed<V: Vector> {
    /// Adds to the pressure in a record.
    fn press(&self, record: &mut Record<V::Scalar>, by: V::Scalar);
}

/// A law between a particle and the images of others.
#[derive(Debug, Clone, Copy)]
pub struct Mirrored<T, L> {
    law: L,
    mirror: Mirror<T>,
}

/// A law as it acts from behind a wall.
pub fn mirrored<T, L>(law: L, mirror: Mirror<T>) -> Mirrored<T, L> {
    Mirrored { law, mirror }
}

impl<V: Vector, L: Pressed<V>> Pressed<V> for Mirrored<V::Scalar, L> {
    #[inline(always)]
    fn press(&self, record: &mut Record<V::Scalar>, by: V::Scalar) {
        self.law.press(record, by);
    }
}

impl<V: Vector, L: PairLaw<V, SUMS> + Pressed<V>, const SUMS: usize> PairLaw<V, SUMS> for Mirrored<V::Scalar, L> {
    #[inline(always)]
    fn terms(
        &self,
        own: &Record<V::Scalar>,
        other: &Record<V::Scalar>,
        apart: [V::Scalar; AXES],
        square: V::Scalar,
    ) -> [V::Scalar; SUMS] {
        let Mirror { normal, distance, weight, sticks } = self.mirror;
        let zero = V::Scalar::ZERO;
        let two = V::Scalar::from_f64(2.0);
        let (mut across, mut speed) = (zero, zero);
        for axis in 0..V::DIMENSION {
            across += apart[axis] * normal[axis];
            speed += other[V::DIMENSION + axis] * normal[axis];
        }
        // How far the original is from the wall. What stands behind it has no image in it.
        let depth = distance - across;
        let mut image = *other;
        let mut from_image = [zero; AXES];
        let mut far = zero;
        for axis in 0..V::DIMENSION {
            from_image[axis] = apart[axis] + two * depth * normal[axis];
            far += from_image[axis] * from_image[axis];
            let velocity = other[V::DIMENSION + axis];
            let slipping = velocity - two * speed * normal[axis];
            image[V::DIMENSION + axis] = slipping - sticks * (slipping + velocity);
        }
        self.law.press(&mut image, two * depth * weight);
        let counts = square < V::Scalar::INFINITY && depth > zero;
        self.law.terms(own, &image, from_image, if counts { far } else { V::Scalar::INFINITY })
    }
}
