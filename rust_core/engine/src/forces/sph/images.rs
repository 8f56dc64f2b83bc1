//! Walls of a fluid, as mirrors.
//!
//! A particle near a wall meets the images of its neighbors, and its own, behind that wall: as many as the wall cuts off from
//! its support, so that density and pressure are as smooth there as inside. An image is never nearer than its original, so
//! the originals are all in the particle's list already, and nothing has to be stored. In a corner there are images of
//! images. A curved wall is met as its tangent plane.
//!
//! Mirrored are position and velocity: where the fluid slips freely its velocity across the wall, where it sticks all of it.
//! The pressure of an image is that of its original, and what gravity adds on the way: so a fluid at rest stays at rest.

use glam::DVec3;

use super::BLOCK;
use crate::boundaries::Wall;
use crate::forces::vicinity::Vicinity;
use crate::math::{AXES, Real, Vector};
use crate::neighbors::sums::{PairLaw, Records};
use crate::parallel::{Chunks, Crew};
use crate::simd::Record;

/// The most walls that a particle looks into.
const CORNER: usize = 4;

/// A wall as a particle near it sees it.
#[derive(Debug, Clone, Copy)]
struct Mirror<T> {
    /// The unit normal n into the fluid.
    normal: [T; AXES],
    /// The distance of the particle from the wall [m].
    distance: T,
    /// What gravity adds to the pressure per metre behind the wall, −ρ₀ g·n [Pa/m], or to another content of the records.
    weight: T,
    /// Whether the fluid sticks to the wall: 1 or 0.
    sticks: T,
}

/// A wall, and whether the fluid sticks to it.
#[derive(Debug, Clone)]
pub struct Side {
    pub wall: Wall,
    pub sticks: bool,
}

impl Side {
    /// The wall as a particle at `x` sees it within `reach`, and its normal.
    fn mirror<V: Vector>(&self, x: DVec3, reach: f64, view: &View) -> Option<(DVec3, Mirror<V::Scalar>)> {
        let (distance, normal) = self.wall.distance(x);
        (distance < reach).then(|| {
            let mirror = Mirror {
                normal: normal.to_array().map(V::Scalar::from_f64),
                distance: V::Scalar::from_f64(distance),
                weight: V::Scalar::from_f64(-view.weight.dot(normal)),
                sticks: if self.sticks && view.sticks { V::Scalar::ONE } else { V::Scalar::ZERO },
            };
            (normal, mirror)
        })
    }
}

/// Whether two walls with these normals meet in a corner, where images are mirrored again. Walls that face each other, or go
/// on as one, do not.
fn meet(one: DVec3, other: DVec3) -> bool {
    one.dot(other).abs() < 0.5
}

/// What a law wants to see in a mirror.
#[derive(Debug, Clone, Copy)]
pub struct View {
    /// What gravity adds to the second number of a record per metre.
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
        let mut seen = self.sides.iter().filter_map(|side| side.mirror::<V>(x, self.reach, view));
        let mirrors: [_; CORNER] = std::array::from_fn(|_| seen.next());
        let mut sums = [V::Scalar::ZERO; SUMS];
        let mut add = |more: [V::Scalar; SUMS]| (0..SUMS).for_each(|sum| sums[sum] += more[sum]);
        let neighbors = vicinity.neighbors();
        for (first, (normal, mirror)) in mirrors.iter().flatten().enumerate() {
            let once = Mirrored { law, mirror: *mirror };
            add(records.sum_images(neighbors, once, place));
            let seconds = mirrors.iter().flatten().enumerate().skip(first + 1);
            for (second, (other, mirror)) in seconds.filter(|(_, (other, _))| meet(*normal, *other)) {
                let twice = Mirrored { law: once, mirror: *mirror };
                add(records.sum_images(neighbors, twice, place));
                let thirds = mirrors.iter().flatten().skip(second + 1);
                for (_, mirror) in thirds.filter(|(third, _)| meet(*normal, *third) && meet(*other, *third)) {
                    add(records.sum_images(neighbors, Mirrored { law: twice, mirror: *mirror }, place));
                }
            }
        }
        sums
    }
}

/// A law that knows what a pressure in the records does.
pub trait Pressed<V: Vector, const SUMS: usize> {
    /// What a pressure `by` that is added to that of the other adds to the sums beside the force: its power.
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
    mirror: Mirror<T>,
}

/// The image of a particle.
struct Image<V: Vector> {
    record: Record<V::Scalar>,
    apart: [V::Scalar; AXES],
    square: V::Scalar,
    /// What its pressure has been raised by.
    by: V::Scalar,
}

impl<V: Vector> Image<V> {
    #[inline(always)]
    fn new(mirror: &Mirror<V::Scalar>, other: &Record<V::Scalar>, apart: [V::Scalar; AXES], square: V::Scalar) -> Self {
        let Mirror { normal, distance, weight, sticks } = *mirror;
        let zero = V::Scalar::ZERO;
        let two = V::Scalar::from_f64(2.0);
        let (mut across, mut speed) = (zero, zero);
        for axis in 0..V::DIMENSION {
            across += apart[axis] * normal[axis];
            speed += other[V::DIMENSION + axis] * normal[axis];
        }
        // How far the original is from the wall. What stands behind it has no image in it.
        let depth = distance - across;
        let mut record = *other;
        let mut from_image = [zero; AXES];
        let mut far = zero;
        for axis in 0..V::DIMENSION {
            from_image[axis] = apart[axis] + two * depth * normal[axis];
            far += from_image[axis] * from_image[axis];
            let velocity = other[V::DIMENSION + axis];
            let slipping = velocity - two * speed * normal[axis];
            record[V::DIMENSION + axis] = slipping - sticks * (slipping + velocity);
        }
        let by = two * depth * weight;
        record[2 * V::DIMENSION + 1] += by;
        let counts = square < V::Scalar::INFINITY && depth > zero;
        Self { record, apart: from_image, square: if counts { far } else { V::Scalar::INFINITY }, by }
    }
}

impl<V: Vector, L: PairLaw<V, SUMS> + Pressed<V, SUMS>, const SUMS: usize> PairLaw<V, SUMS> for Mirrored<V::Scalar, L> {
    #[inline(always)]
    fn terms(
        &self,
        own: &Record<V::Scalar>,
        other: &Record<V::Scalar>,
        apart: [V::Scalar; AXES],
        square: V::Scalar,
    ) -> [V::Scalar; SUMS] {
        let image = Image::<V>::new(&self.mirror, other, apart, square);
        let mut terms = self.law.terms(own, &image.record, image.apart, image.square);
        let lift = self.law.lift(own, &image.record, image.apart, image.square, image.by);
        for sum in 0..SUMS {
            terms[sum] += lift[sum];
        }
        terms
    }
}

impl<V: Vector, L: Pressed<V, SUMS>, const SUMS: usize> Pressed<V, SUMS> for Mirrored<V::Scalar, L> {
    #[inline(always)]
    fn lift(
        &self,
        own: &Record<V::Scalar>,
        other: &Record<V::Scalar>,
        apart: [V::Scalar; AXES],
        square: V::Scalar,
        by: V::Scalar,
    ) -> [V::Scalar; SUMS] {
        let image = Image::<V>::new(&self.mirror, other, apart, square);
        self.law.lift(own, &image.record, image.apart, image.square, by)
    }
}
