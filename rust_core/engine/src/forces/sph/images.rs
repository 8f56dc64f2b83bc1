//! The images of a particle's neighbors in mirrors, and what a law makes of them.
//!
//! Mirrored are position and velocity: where the fluid slips freely its velocity across the wall, where it sticks all of it.
//! The pressure of an image is that of its original, and what gravity adds on the way: so a fluid at rest stays at rest.

use glam::{DMat3, DVec3};

use crate::math::{AXES, Real, Vector};
use crate::neighbors::sums::{Pair, PairLaw};
use crate::simd::{Number, Record};

/// A wall as a particle near it sees it: its unit normal into the fluid, its distance [m], and whether the fluid sticks to it.
#[derive(Debug, Clone, Copy)]
pub struct Mirror {
    pub normal: DVec3,
    pub distance: f64,
    pub sticks: bool,
}

/// What a law wants to see in a mirror.
#[derive(Debug, Clone, Copy)]
pub struct View {
    /// What gravity adds to the second number of a record per metre and density.
    pub weight: DVec3,
    /// Whether a fluid that sticks to a wall is at rest there: only viscosity cares.
    pub sticks: bool,
}

/// Where the image of a neighbor is: with y the place of anything relative to the particle that looks, y ← Ay + b.
#[derive(Debug, Clone, Copy)]
pub struct Image {
    /// A.
    turn: DMat3,
    /// b [m].
    shift: DVec3,
    /// What velocities are turned by.
    velocity: DMat3,
    /// The distance of the original, and of its images on the way here, from the mirrors: n and d of n·y + d for each, all
    /// above zero if there is such an image.
    depths: [(DVec3, f64); AXES],
    /// The number of mirrors on the way.
    mirrors: usize,
}

impl Image {
    /// Where everything is.
    pub const ITSELF: Self = Self {
        turn: DMat3::IDENTITY,
        shift: DVec3::ZERO,
        velocity: DMat3::IDENTITY,
        depths: [(DVec3::ZERO, 1.0); AXES],
        mirrors: 0,
    };

    /// Mirrors it once more: y ← y − 2 (d + n·y) n. In place, because it is large.
    pub fn reflect(&mut self, &Mirror { normal, distance, sticks }: &Mirror) {
        let along = self.turn.transpose() * normal;
        let depth = distance + normal.dot(self.shift);
        self.depths[self.mirrors] = (along, depth);
        self.mirrors += 1;
        self.turn -= outer(2.0 * normal, along);
        self.shift -= 2.0 * depth * normal;
        if sticks {
            self.velocity *= -1.0;
        } else {
            self.velocity -= outer(2.0 * normal, self.velocity.transpose() * normal);
        }
    }

    /// The square of the distance from the image of somebody who is `separation` from its original [m²].
    pub fn square(&self, separation: DVec3) -> f64 {
        (self.turn * separation - self.shift).length_squared()
    }
}

/// The matrix a bᵀ.
fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// A vector in the precision of the run.
type Triple<T> = [T; AXES];

/// An image in the precision of the run, as a function of the vector d from the original to the particle that looks.
#[derive(Debug, Clone, Copy)]
struct Reflection<T> {
    /// The vector from the image: Ad − b.
    turn: [Triple<T>; AXES],
    shift: Triple<T>,
    velocity: [Triple<T>; AXES],
    /// What gravity adds on the way there.
    rise: (Triple<T>, T),
    depths: [(Triple<T>, T); AXES],
}

impl<T: Real> Reflection<T> {
    fn new(image: &Image, view: &View) -> Self {
        let triple = |vector: DVec3| vector.to_array().map(T::from_f64);
        let rows = |matrix: DMat3| [matrix.row(0), matrix.row(1), matrix.row(2)].map(triple);
        Self {
            turn: rows(image.turn),
            shift: triple(-image.shift),
            velocity: rows(image.velocity),
            rise: (triple(view.weight - image.turn.transpose() * view.weight), T::from_f64(view.weight.dot(image.shift))),
            depths: image.depths.map(|(normal, distance)| (triple(-normal), T::from_f64(distance))),
        }
    }
}

/// n·d.
#[inline(always)]
fn dot<V: Vector, N: Number<Scalar = V::Scalar>>(one: &Triple<V::Scalar>, other: &Triple<N>) -> N {
    let mut sum = N::of(one[0]) * other[0];
    for axis in 1..V::DIMENSION {
        sum += N::of(one[axis]) * other[axis];
    }
    sum
}

/// A law that knows what a pressure in the records does; as it stands here, of one that reads none.
pub trait Pressed<V: Vector, const SUMS: usize> {
    /// The density at rest of the other [kg/m³].
    #[inline(always)]
    fn density<N: Number<Scalar = V::Scalar>>(&self, _other: &Record<N>) -> N {
        N::constant(0.0)
    }

    /// The second number of a record, raised by what gravity adds on the way to an image.
    #[inline(always)]
    fn raised<N: Number<Scalar = V::Scalar>>(&self, content: N, by: N) -> N {
        content + by
    }

    /// What is different where the other is an image, whose pressure has been raised `by` so much: the powers, because it
    /// belongs to a wall that takes none.
    #[inline(always)]
    fn lift<N: Number<Scalar = V::Scalar>>(&self, _pair: &Pair<N>, _by: N) -> [N; SUMS] {
        [N::constant(0.0); SUMS]
    }
}

/// A law between a particle and the images of others.
#[derive(Debug, Clone, Copy)]
pub struct Mirrored<T, L> {
    law: L,
    reflection: Reflection<T>,
}

impl<T: Real, L> Mirrored<T, L> {
    /// What a law makes of an image.
    pub fn new(law: L, image: &Image, view: &View) -> Self {
        Self { law, reflection: Reflection::new(image, view) }
    }
}

impl<V: Vector, L: PairLaw<V, SUMS> + Pressed<V, SUMS>, const SUMS: usize> PairLaw<V, SUMS> for Mirrored<V::Scalar, L> {
    #[inline(always)]
    fn for_particle(self, own: &Record<V::Scalar>) -> Self {
        Self { law: self.law.for_particle(own), ..self }
    }

    #[inline(always)]
    fn terms<N: Number<Scalar = V::Scalar>>(&self, pair: &Pair<N>) -> [N; SUMS] {
        let Reflection { turn, shift, velocity, rise, depths } = &self.reflection;
        let zero = N::constant(0.0);
        let Pair { own, other, separation, square } = pair;
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
        let raised = self.law.raised(content, by);
        image[2 * V::DIMENSION + 1] = raised;
        let infinity = N::of(V::Scalar::INFINITY);
        let mut counts = square.less(infinity);
        for (normal, distance) in depths {
            counts = N::both(counts, zero.less(dot::<V, N>(normal, separation) + N::of(*distance)));
        }
        let image = Pair { own: *own, other: image, separation: from_image, square: N::select(counts, far, infinity) };
        let mut terms = self.law.terms(&image);
        let lift = self.law.lift(&image, raised - content);
        for sum in 0..SUMS {
            terms[sum] += lift[sum];
        }
        terms
    }
}
