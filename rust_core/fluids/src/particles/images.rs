//! Mirror images of a particle's neighbors behind walls, and the pair laws with images.
//!
//! Position and velocity are mirrored. At a free-slip wall the normal velocity is reversed; at a no-slip wall the whole velocity
//! is. The pressure of an image is that of its original plus the hydrostatic difference, so that a fluid at rest stays at rest.

use glam::{DMat3, DVec3};

use crate::math::{AXES, Real, Vector};
use crate::neighbors::sums::{Pair, PairLaw};
use crate::simd::{Number, ParticleRecord};

/// Tangent plane of a wall near a particle: unit normal into the fluid, distance [m], and no-slip condition.
#[derive(Debug, Clone, Copy)]
pub struct Mirror {
    pub normal: DVec3,
    pub distance: f64,
    pub no_slip: bool,
}

/// Boundary condition of a pair law at a wall.
#[derive(Debug, Clone, Copy)]
pub struct WallCondition {
    /// Hydrostatic gradient of the second word of a record, divided by density.
    pub weight: DVec3,
    /// Whether no-slip walls act as such, as for viscosity. Otherwise all walls are free-slip.
    pub no_slip: bool,
}

/// Image of a neighbor: an affine map y ← Ay + b of positions y relative to the particle.
#[derive(Debug, Clone, Copy)]
pub struct Image {
    /// Orthogonal matrix A.
    turn: DMat3,
    /// Translation b [m].
    shift: DVec3,
    /// Orthogonal matrix for the velocities.
    velocity: DMat3,
    /// Distances n·y + d of the original, and of its successive images, from the mirrors: n and d for each. The image exists if
    /// all are positive.
    depths: [(DVec3, f64); AXES],
    /// Number of reflections.
    mirrors: usize,
}

impl Image {
    /// Identity map.
    pub const ITSELF: Self = Self {
        turn: DMat3::IDENTITY,
        shift: DVec3::ZERO,
        velocity: DMat3::IDENTITY,
        depths: [(DVec3::ZERO, 1.0); AXES],
        mirrors: 0,
    };

    /// Appends a reflection: y ← y − 2 (d + n·y) n. The image is modified in place, because it is large.
    pub fn reflect(&mut self, &Mirror { normal, distance, no_slip }: &Mirror) {
        let along = self.turn.transpose() * normal;
        let depth = distance + normal.dot(self.shift);
        self.depths[self.mirrors] = (along, depth);
        self.mirrors += 1;
        self.turn -= outer(2.0 * normal, along);
        self.shift -= 2.0 * depth * normal;
        if no_slip {
            self.velocity *= -1.0;
        } else {
            self.velocity -= outer(2.0 * normal, self.velocity.transpose() * normal);
        }
    }

    /// Squared distance from the image of a neighbor at `separation` [m²].
    #[inline]
    pub fn square(&self, separation: DVec3) -> f64 {
        (self.turn * separation - self.shift).length_squared()
    }
}

/// Matrix a bᵀ.
fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// A vector in the precision of the run.
type Triple<T> = [T; AXES];

/// Image in the precision of the run, as a function of the vector d from the original to the particle.
#[derive(Debug, Clone, Copy)]
pub struct Reflection<T> {
    /// Vector from the image: Ad − b.
    turn: [Triple<T>; AXES],
    shift: Triple<T>,
    velocity: [Triple<T>; AXES],
    /// Hydrostatic difference between original and image: gradient and constant.
    rise: (Triple<T>, T),
    depths: [(Triple<T>, T); AXES],
}

impl<T: Real> Reflection<T> {
    /// Reflection by an image.
    pub fn new(image: &Image, condition: &WallCondition) -> Self {
        let triple = |vector: DVec3| vector.to_array().map(T::from_f64);
        let rows = |matrix: DMat3| [matrix.row(0), matrix.row(1), matrix.row(2)].map(triple);
        Self {
            turn: rows(image.turn),
            shift: triple(-image.shift),
            velocity: rows(image.velocity),
            rise: (
                triple(condition.weight - image.turn.transpose() * condition.weight),
                T::from_f64(condition.weight.dot(image.shift)),
            ),
            depths: image.depths.map(|(normal, distance)| (triple(-normal), T::from_f64(distance))),
        }
    }
}

/// Scalar product n·d.
#[inline(always)]
fn dot<V: Vector, N: Number<Scalar = V::Scalar>>(one: &Triple<V::Scalar>, other: &Triple<N>) -> N {
    let mut sum = N::of(one[0]) * other[0];
    for axis in 1..V::DIMENSION {
        sum += N::of(one[axis]) * other[axis];
    }
    sum
}

/// Treatment of image pressures by a pair law. The default is for a law without pressure.
pub trait ImagePressure<V: Vector, const SUMS: usize> {
    /// Rest density of the other particle [kg/m³].
    #[inline(always)]
    fn density<N: Number<Scalar = V::Scalar>>(&self, _other: &ParticleRecord<N>) -> N {
        N::constant(0.0)
    }

    /// Second word of an image's record: that of the original plus the hydrostatic difference.
    #[inline(always)]
    fn image_pressure<N: Number<Scalar = V::Scalar>>(&self, content: N, by: N) -> N {
        content + by
    }

    /// Correction of the sums for an image whose pressure is raised `by` this amount. It corrects the powers, because a wall
    /// takes none.
    #[inline(always)]
    fn power_correction<N: Number<Scalar = V::Scalar>>(&self, _pair: &Pair<N>, _by: N) -> [N; SUMS] {
        [N::constant(0.0); SUMS]
    }
}

/// Pair law between a particle and an image.
#[derive(Debug, Clone, Copy)]
pub struct Mirrored<T, L> {
    law: L,
    reflection: Reflection<T>,
}

impl<T: Real, L> Mirrored<T, L> {
    /// Pair law for an image.
    #[inline(always)]
    pub fn new(law: L, reflection: &Reflection<T>) -> Self {
        Self { law, reflection: *reflection }
    }
}

impl<V: Vector, L: PairLaw<V, SUMS> + ImagePressure<V, SUMS>, const SUMS: usize> PairLaw<V, SUMS> for Mirrored<V::Scalar, L> {
    #[inline(always)]
    fn for_particle(self, own: &ParticleRecord<V::Scalar>) -> Self {
        Self { law: self.law.for_particle(own), ..self }
    }

    #[inline(always)]
    fn terms<N: Number<Scalar = V::Scalar>>(&self, pair: &Pair<N>) -> [N; SUMS] {
        let Reflection { turn, shift, velocity, rise, depths } = &self.reflection;
        let zero = N::constant(0.0);
        let Pair { own, other, separation, square, .. } = pair;
        let (mut image, mut from_image, mut before) = (*other, [zero; AXES], [zero; AXES]);
        for axis in 0..V::DIMENSION {
            from_image[axis] = dot::<V, N>(&turn[axis], separation) + N::of(shift[axis]);
            before[axis] = other[V::DIMENSION + axis];
        }
        let mut far = from_image[0] * from_image[0];
        for axis in 1..V::DIMENSION {
            far += from_image[axis] * from_image[axis];
        }
        for axis in 0..V::DIMENSION {
            image[V::DIMENSION + axis] = dot::<V, N>(&velocity[axis], &before);
        }
        let content = other[2 * V::DIMENSION + 1];
        let by = self.law.density(other) * (dot::<V, N>(&rise.0, separation) + N::of(rise.1));
        let pressure = self.law.image_pressure(content, by);
        image[2 * V::DIMENSION + 1] = pressure;
        let infinity = N::of(V::Scalar::INFINITY);
        let mut counts = square.less(infinity);
        for (normal, distance) in depths {
            counts = N::both(counts, zero.less(dot::<V, N>(normal, separation) + N::of(*distance)));
        }
        let square = N::select(counts, far, infinity);
        let image = Pair { own: *own, other: image, separation: from_image, square, distance: square.sqrt() };
        let mut terms = self.law.terms(&image);
        let correction = self.law.power_correction(&image, pressure - content);
        for sum in 0..SUMS {
            terms[sum] += correction[sum];
        }
        terms
    }
}
