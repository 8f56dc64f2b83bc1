//! Walls of a fluid, as mirrors.
//!
//! A particle near a wall meets the images of its neighbors, and its own, behind that wall: as many as the wall cuts off from
//! its support, so that density and pressure are as smooth there as inside. An image is never nearer than its original, so
//! the originals are all in the particle's list already, and nothing has to be stored. In a corner there are images of
//! images. A curved wall is met as its tangent plane.
//!
//! Mirrored are position and velocity: where the fluid slips freely its velocity across the wall, where it sticks all of it.
//! The pressure of an image is that of its original, and what gravity adds on the way: so a fluid at rest stays at rest.

use glam::{DMat3, DVec3};

use super::BLOCK;
use crate::boundaries::Wall;
use crate::forces::vicinity::Vicinity;
use crate::math::{AXES, Real, Vector};
use crate::neighbors::sums::{PairLaw, Records};
use crate::parallel::{Chunks, Crew};
use crate::simd::Record;

/// The most walls that a particle looks into.
const CORNER: usize = 4;

/// A wall, and whether the fluid sticks to it.
#[derive(Debug, Clone)]
pub struct Side {
    pub wall: Wall,
    pub sticks: bool,
}

impl Side {
    /// The mirror that a particle at `x` looks into, if it is within `reach`.
    fn mirror(&self, x: DVec3, reach: f64, view: &View) -> Option<Mirror> {
        let (distance, normal) = self.wall.distance(x);
        (distance < reach).then_some(Mirror { normal, distance, sticks: self.sticks && view.sticks })
    }
}

/// A wall as a particle near it sees it: its unit normal into the fluid, its distance [m], and whether the fluid sticks to it.
#[derive(Debug, Clone, Copy)]
struct Mirror {
    normal: DVec3,
    distance: f64,
    sticks: bool,
}

/// Whether two walls with these normals meet in a corner, where images are mirrored again. Walls that face each other, or go
/// on as one, do not.
fn meet(one: DVec3, other: DVec3) -> bool {
    one.dot(other).abs() < 0.5
}

/// What a law wants to see in a mirror.
#[derive(Debug, Clone, Copy)]
pub struct View {
    /// What gravity adds to the second number of a record per metre and density.
    pub weight: DVec3,
    /// Whether a fluid that sticks to a wall is at rest there: only viscosity cares.
    pub sticks: bool,
}

/// The walls of a fluid, and who is near them.
#[derive(Debug)]
pub struct Walls {
    sides: Vec<Side>,
    /// The distance within which a wall matters [m].
    reach: f64,
    /// The places that are near a wall.
    near: Vec<u32>,
}

impl Walls {
    /// Walls that matter within `reach` [m].
    pub fn new(sides: Vec<Side>, reach: f64) -> Self {
        Self { sides, reach, near: Vec::new() }
    }

    /// Looks who was near where lists of neighbors were made.
    pub fn survey(&mut self, vicinity: &Vicinity) {
        let neighbors = vicinity.neighbors();
        let Self { sides, near, .. } = self;
        let touches = |&place: &u32| {
            let x = vicinity.anchor(place as usize);
            sides.iter().any(|side| side.wall.distance(x).0 < neighbors.support())
        };
        near.clear();
        near.extend((0..neighbors.count() as u32).filter(touches));
    }

    /// The memory that they take [bytes].
    pub fn bytes(&self) -> usize {
        std::mem::size_of_val(self.sides.as_slice()) + std::mem::size_of_val(self.near.as_slice())
    }

    /// Adds to a law's sums what it meets in the walls.
    pub fn add<V: Vector, L: PairLaw<V, SUMS> + Pressed<V, SUMS>, const SUMS: usize>(
        &self,
        law: L,
        view: &View,
        (vicinity, records): (&Vicinity, &Records<V>),
        sums: &mut [[V::Scalar; SUMS]],
        crew: &Crew,
    ) {
        if self.near.is_empty() {
            return;
        }
        crew.sweep(Chunks::new(sums, BLOCK), &|mine| {
            let index = |place: usize| self.near.partition_point(|&near| (near as usize) < place);
            for &place in &self.near[index(mine.start)..index(mine.start + mine.items.len())] {
                let images = self.images(law, view, vicinity, records, place as usize);
                mine.items[place as usize - mine.start].iter_mut().zip(images).for_each(|(sum, image)| *sum += image);
            }
        });
    }

    /// The sums over the images that a particle meets: in each wall, and in the corners.
    fn images<V: Vector, L: PairLaw<V, SUMS> + Pressed<V, SUMS>, const SUMS: usize>(
        &self,
        law: L,
        view: &View,
        vicinity: &Vicinity,
        records: &Records<V>,
        place: usize,
    ) -> [V::Scalar; SUMS] {
        let x = vicinity.at(place);
        let mut seen = self.sides.iter().filter_map(|side| side.mirror(x, self.reach, view));
        let mirrors: [_; CORNER] = std::array::from_fn(|_| seen.next());
        let mirrors = || mirrors.iter().flatten().enumerate();
        let mut sums = [V::Scalar::ZERO; SUMS];
        let mut add = |image: &Image| {
            let law = Mirrored { law, reflection: Reflection::new(image, view) };
            let more = records.sum_at(vicinity.neighbors(), law, place);
            (0..SUMS).for_each(|sum| sums[sum] += more[sum]);
        };
        for (first, one) in mirrors() {
            let once = Image::ITSELF.in_mirror(one);
            add(&once);
            for (second, other) in mirrors().skip(first + 1).filter(|(_, other)| meet(one.normal, other.normal)) {
                let twice = once.in_mirror(other);
                add(&twice);
                let thirds = mirrors().skip(second + 1).map(|(_, third)| third);
                for third in thirds.filter(|third| meet(one.normal, third.normal) && meet(other.normal, third.normal)) {
                    add(&twice.in_mirror(third));
                }
            }
        }
        sums
    }
}

/// Where the image of a neighbor is: with y the place of anything relative to the particle that looks, y ← Ay + b.
#[derive(Debug, Clone, Copy)]
struct Image {
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
    const ITSELF: Self = Self {
        turn: DMat3::IDENTITY,
        shift: DVec3::ZERO,
        velocity: DMat3::IDENTITY,
        depths: [(DVec3::ZERO, 1.0); AXES],
        mirrors: 0,
    };

    /// Its image in another mirror: y − 2 (d + n·y) n.
    fn in_mirror(mut self, mirror: &Mirror) -> Self {
        let Mirror { normal, distance, sticks } = *mirror;
        let reflect = DMat3::IDENTITY - 2.0 * DMat3::from_cols(normal * normal.x, normal * normal.y, normal * normal.z);
        self.depths[self.mirrors] = (self.turn.transpose() * normal, distance + normal.dot(self.shift));
        self.mirrors += 1;
        self.turn = reflect * self.turn;
        self.shift = reflect * self.shift - 2.0 * distance * normal;
        self.velocity = if sticks { -self.velocity } else { reflect * self.velocity };
        self
    }
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
fn dot<V: Vector>(one: &Triple<V::Scalar>, other: &Triple<V::Scalar>) -> V::Scalar {
    let mut sum = V::Scalar::ZERO;
    for axis in 0..V::DIMENSION {
        sum += one[axis] * other[axis];
    }
    sum
}

/// A law that knows what a pressure in the records does.
pub trait Pressed<V: Vector, const SUMS: usize> {
    /// The density at rest of the other [kg/m³].
    fn density(&self, other: &Record<V::Scalar>) -> V::Scalar;

    /// The second number of a record, raised by what gravity adds on the way to an image.
    fn raised(&self, content: V::Scalar, by: V::Scalar) -> V::Scalar;

    /// What is different where the other is an image, whose pressure has been raised `by` so much: the powers, because it
    /// belongs to a wall that takes none.
    fn lift(
        &self,
        own: &Record<V::Scalar>,
        other: &Record<V::Scalar>,
        apart: [V::Scalar; AXES],
        square: V::Scalar,
        by: V::Scalar,
    ) -> [V::Scalar; SUMS];
}

/// A law between a particle and the images of others.
#[derive(Debug, Clone, Copy)]
struct Mirrored<T, L> {
    law: L,
    reflection: Reflection<T>,
}

impl<V: Vector, L: PairLaw<V, SUMS> + Pressed<V, SUMS>, const SUMS: usize> PairLaw<V, SUMS> for Mirrored<V::Scalar, L> {
    #[inline(always)]
    fn facing(self, own: &Record<V::Scalar>) -> Self {
        Self { law: self.law.facing(own), ..self }
    }

    #[inline(always)]
    fn terms(
        &self,
        own: &Record<V::Scalar>,
        other: &Record<V::Scalar>,
        apart: [V::Scalar; AXES],
        square: V::Scalar,
    ) -> [V::Scalar; SUMS] {
        let Reflection { turn, shift, velocity, rise, depths } = &self.reflection;
        let zero = V::Scalar::ZERO;
        let mut image = *other;
        let (mut from_image, mut far, mut before) = ([zero; AXES], zero, [zero; AXES]);
        for axis in 0..V::DIMENSION {
            from_image[axis] = dot::<V>(&turn[axis], &apart) + shift[axis];
            far += from_image[axis] * from_image[axis];
            before[axis] = other[V::DIMENSION + axis];
        }
        for axis in 0..V::DIMENSION {
            image[V::DIMENSION + axis] = dot::<V>(&velocity[axis], &before);
        }
        let content = other[2 * V::DIMENSION + 1];
        let raised = self.law.raised(content, self.law.density(other) * (dot::<V>(&rise.0, &apart) + rise.1));
        image[2 * V::DIMENSION + 1] = raised;
        let mut counts = square < V::Scalar::INFINITY;
        for (normal, distance) in depths {
            counts &= dot::<V>(normal, &apart) + *distance > zero;
        }
        let far = if counts { far } else { V::Scalar::INFINITY };
        let mut terms = self.law.terms(own, &image, from_image, far);
        let lift = self.law.lift(own, &image, from_image, far, raised - content);
        for sum in 0..SUMS {
            terms[sum] += lift[sum];
        }
        terms
    }
}
