//! Pair laws of surface tension: the sums of the color field, and the force.

use crate::math::{AXES, Real, Vector};
use crate::neighbors::sums::{Pair, PairLaw};
use crate::particles::KINDS;
use crate::particles::images::ImagePressure;
use crate::particles::kernel::{KernelShape, SmoothingKernel};
use crate::particles::records::{content, is_obstacle, pick, volume};
use crate::simd::{Number, ParticleRecord};

/// Number of sums of [`ColorField`]: g along each axis, c S, and s S₀.
pub const COLOR_SUMS: usize = AXES + 2;
pub const COLOR: usize = AXES;
pub const LOCAL_DENSITY: usize = AXES + 1;

/// Flags, 1 or 0, of the materials that one material counts in the color and in the local density.
#[derive(Debug, Clone, Copy)]
pub struct Cohesion<T> {
    pub color: [T; KINDS],
    pub local_density: [T; KINDS],
}

/// Common data of both laws: the coefficients of every material, and those of the particle's material.
#[derive(Debug, Clone, Copy)]
pub struct Common<T, K, const MIXED: bool> {
    pub kernel: SmoothingKernel<T, K>,
    pub cohesion: [Cohesion<T>; KINDS],
    pub for_particle: Cohesion<T>,
    /// Inverse range 1/r₀ [1/m].
    pub inverse_range: T,
}

impl<T: Real, K: KernelShape, const MIXED: bool> Common<T, K, MIXED> {
    #[inline(always)]
    fn for_particle(mut self, tagged: T) -> Self {
        if MIXED {
            self.for_particle = self.cohesion[usize::from(tagged.tag())];
        }
        self
    }

    /// The volume, or 0 if a particle of this tag does not count in the color.
    #[inline(always)]
    fn cohesive<N: Number<Scalar = T>>(&self, tagged: N, volume: N) -> N {
        if MIXED { volume * pick::<N, MIXED>(tagged, &self.for_particle.color) } else { volume }
    }

    /// Closeness 1 − r/r₀; 0 beyond r₀, and for a particle of this tag that does not count in the local density.
    #[inline(always)]
    fn closeness<N: Number<Scalar = T>>(&self, tagged: N, distance: N) -> N {
        let closeness = (N::constant(1.0) - distance * N::of(self.inverse_range)).max(N::constant(0.0));
        if MIXED { closeness * pick::<N, MIXED>(tagged, &self.for_particle.local_density) } else { closeness }
    }
}

/// Sums of the color field.
#[derive(Debug, Clone, Copy)]
pub struct ColorField<T, K, const MIXED: bool>(pub Common<T, K, MIXED>);

impl<V: Vector, K: KernelShape, const MIXED: bool> PairLaw<V, COLOR_SUMS> for ColorField<V::Scalar, K, MIXED> {
    #[inline(always)]
    fn for_particle(self, own: &ParticleRecord<V::Scalar>) -> Self {
        Self(self.0.for_particle(volume::<V, _>(own)))
    }

    #[inline(always)]
    fn terms<N: Number<Scalar = V::Scalar>>(&self, pair: &Pair<N>) -> [N; COLOR_SUMS] {
        let (volume, distance) = (volume::<V, N>(&pair.other), pair.distance);
        let cohesive_volume = self.0.cohesive(volume, volume);
        let slope = self.0.kernel.slope(cohesive_volume, distance);
        let mut terms = [N::constant(0.0); COLOR_SUMS];
        for axis in 0..V::DIMENSION {
            terms[axis] = slope * pair.separation[axis];
        }
        terms[COLOR] = cohesive_volume * self.0.kernel.value(distance);
        let closeness = self.0.closeness(volume, distance);
        terms[LOCAL_DENSITY] = closeness * closeness;
        terms
    }
}

impl<V: Vector, K: KernelShape, const MIXED: bool> ImagePressure<V, COLOR_SUMS> for ColorField<V::Scalar, K, MIXED> {}

/// Force density [N/m^D]. The records contain b, 2k/r₀ or the volume of an obstacle, and a with the tag of the material.
#[derive(Debug, Clone, Copy)]
pub struct TensionForce<T, K, const MIXED: bool> {
    pub common: Common<T, K, MIXED>,
    /// Volume of a fluid particle at rest [m^D].
    pub volume: T,
    /// Smallest divisor distance [m].
    pub tiny: T,
}

impl<V: Vector, K: KernelShape, const MIXED: bool> PairLaw<V, AXES> for TensionForce<V::Scalar, K, MIXED> {
    #[inline(always)]
    fn for_particle(self, own: &ParticleRecord<V::Scalar>) -> Self {
        Self { common: self.common.for_particle(content::<V, _>(own)), ..self }
    }

    #[inline(always)]
    fn terms<N: Number<Scalar = V::Scalar>>(&self, pair: &Pair<N>) -> [N; AXES] {
        let Pair { own, other, separation, distance, .. } = pair;
        let (first, tagged) = (2 * V::DIMENSION, content::<V, N>(other));
        let (distance, mut cohesive_volume) = (*distance, N::of(self.volume));
        if MIXED {
            let volume = N::select(is_obstacle(tagged), other[first], cohesive_volume);
            cohesive_volume = self.common.cohesive(tagged, volume);
        }
        let slope = self.common.kernel.slope(cohesive_volume, distance);
        let (mut terms, mut along) = ([N::constant(0.0); AXES], N::constant(0.0));
        for axis in 0..V::DIMENSION {
            terms[axis] = other[V::DIMENSION + axis] - own[V::DIMENSION + axis];
            along += terms[axis] * separation[axis];
        }
        let along_pair = self.common.closeness(tagged, distance) / distance.max(N::of(self.tiny));
        let repulsion = (own[first] + other[first]) * along_pair;
        let push =
            self.common.kernel.bend(cohesive_volume, distance) * along + repulsion - (content::<V, N>(own) + tagged) * slope;
        for axis in 0..V::DIMENSION {
            terms[axis] = slope * terms[axis] + push * separation[axis];
        }
        terms
    }
}

impl<V: Vector, K: KernelShape, const MIXED: bool> ImagePressure<V, AXES> for TensionForce<V::Scalar, K, MIXED> {}
