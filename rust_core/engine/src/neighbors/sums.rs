//! Sums over neighbors: the loop that all pair laws share.
//!
//! What a law reads of a particle is one [`Record`], kept in the order of places. The neighbors of a particle are taken in
//! groups of lanes: their records are transposed into lanes, the law gives its terms for every lane, and each lane adds up
//! its own. At the end the lanes are folded in one tree, so that the bits are the same at every SIMD level and for any
//! number of threads.

use super::{BLOCK, Neighbors};
use crate::math::{AXES, Real, Stored, Vector};
use crate::parallel::{Chunks, Crew};
use crate::simd::{Kernel, LANES, Lanes, Record, WORDS, dispatch, transpose};

/// What happens between two particles, as the first of them feels it.
pub trait PairLaw<V: Vector, const SUMS: usize>: Copy + Sync {
    /// The terms of one pair, which are added to the sums of the first particle.
    ///
    /// `own` and `other` are the records, whose first words (as many as there are axes) mean nothing here; `apart` is the
    /// vector from the other particle to this one [m], and `square` its square [m²]. Lists reach beyond the cutoff, and
    /// are filled up with pairs whose `square` is infinite: the law makes its terms 0 from its cutoff on. It has no
    /// branches, and everything in it is `#[inline(always)]`, or it is not vectorized.
    fn terms(
        &self,
        own: &Record<V::Scalar>,
        other: &Record<V::Scalar>,
        apart: [V::Scalar; AXES],
        square: V::Scalar,
    ) -> [V::Scalar; SUMS];
}

/// The records of all particles, in the order of places.
#[derive(Debug)]
pub struct Records<V: Vector> {
    words: Vec<Record<<V::Scalar as Stored>::Word>>,
    rulers: [<V::Scalar as Stored>::Ruler; AXES],
    periodic: bool,
}

impl<V: Vector> Records<V> {
    /// Room for the particles of `neighbors`.
    pub fn new(neighbors: &Neighbors) -> Self {
        Self {
            words: vec![Default::default(); neighbors.count()],
            rulers: neighbors.domain().lengths().map(|length| V::Scalar::ruler(length, neighbors.support())),
            periodic: neighbors.domain().is_periodic(),
        }
    }

    /// The memory that they take [bytes].
    pub fn bytes(&self) -> usize {
        std::mem::size_of_val(self.words.as_slice())
    }

    /// Writes all records anew: the positions, and what `each` writes into the other words of the particle that it is
    /// given: those from the number of axes on. It finds zeros there.
    pub fn fill(
        &mut self,
        neighbors: &Neighbors,
        positions: [&[f64]; AXES],
        crew: &Crew,
        each: &(impl Fn(usize, &mut Record<V::Scalar>) + Sync),
    ) {
        let (order, rulers) = (neighbors.order(), self.rulers);
        crew.sweep(Chunks::new(&mut self.words, BLOCK), &|mine| {
            for (words, &particle) in mine.items.iter_mut().zip(&order[mine.start..]) {
                let mut numbers = [V::Scalar::ZERO; WORDS];
                each(particle as usize, &mut numbers);
                *words = numbers.map(Stored::word);
                for axis in 0..V::DIMENSION {
                    words[axis] = V::Scalar::place(positions[axis][particle as usize], rulers[axis]);
                }
            }
        });
    }

    /// The sums of a law over the neighbors of each particle, into `sums`, in the order of places.
    ///
    /// # Panics
    /// If `neighbors` are not those that the records were made for, or `sums` has another length.
    pub fn sum<L: PairLaw<V, SUMS>, const SUMS: usize>(
        &self,
        neighbors: &Neighbors,
        law: L,
        sums: &mut [[V::Scalar; SUMS]],
        crew: &Crew,
    ) {
        assert!(self.words.len() == neighbors.count() && sums.len() == neighbors.count(), "one record and sum per particle");
        crew.sweep(Chunks::new(sums, BLOCK), &|mine| {
            let sweep = Sweep { records: self, neighbors, law, start: mine.start, sums: mine.items };
            if self.periodic {
                dispatch(Wrapped::<V, L, SUMS, true>(sweep));
            } else {
                dispatch(Wrapped::<V, L, SUMS, false>(sweep));
            }
        });
    }

    /// The sums of a law over the neighbors of the particle at one place, and over itself: what is mirrored in a wall.
    pub fn sum_images<L: PairLaw<V, SUMS>, const SUMS: usize>(
        &self,
        neighbors: &Neighbors,
        law: L,
        place: usize,
    ) -> [V::Scalar; SUMS] {
        if self.periodic {
            dispatch(Alone::<V, L, SUMS, true> { records: self, neighbors, law, place })
        } else {
            dispatch(Alone::<V, L, SUMS, false> { records: self, neighbors, law, place })
        }
    }
}

/// The sums of one block.
struct Sweep<'a, V: Vector, L, const SUMS: usize> {
    records: &'a Records<V>,
    neighbors: &'a Neighbors,
    law: L,
    start: usize,
    sums: &'a mut [[V::Scalar; SUMS]],
}

/// The sums of one block, with or without periods.
struct Wrapped<'a, V: Vector, L, const SUMS: usize, const PERIODIC: bool>(Sweep<'a, V, L, SUMS>);

impl<V: Vector, L: PairLaw<V, SUMS>, const SUMS: usize, const PERIODIC: bool> Kernel for Wrapped<'_, V, L, SUMS, PERIODIC> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Sweep { records, neighbors, law, start, sums } = self.0;
        for (place, sum) in (start..).zip(sums) {
            *sum = around::<V, L, SUMS, PERIODIC>(records, neighbors, law, place);
        }
    }
}

/// The sums of one particle and its images, with or without periods.
struct Alone<'a, V: Vector, L, const SUMS: usize, const PERIODIC: bool> {
    records: &'a Records<V>,
    neighbors: &'a Neighbors,
    law: L,
    place: usize,
}

impl<V: Vector, L: PairLaw<V, SUMS>, const SUMS: usize, const PERIODIC: bool> Kernel for Alone<'_, V, L, SUMS, PERIODIC> {
    type Output = [V::Scalar; SUMS];

    #[inline(always)]
    fn run(self) -> [V::Scalar; SUMS] {
        let Self { records, neighbors, law, place } = self;
        let mut sums = around::<V, L, SUMS, PERIODIC>(records, neighbors, law, place);
        let own = records.words[place].map(V::Scalar::number);
        let itself = law.terms(&own, &own, [V::Scalar::ZERO; AXES], V::Scalar::ZERO);
        for sum in 0..SUMS {
            sums[sum] += itself[sum];
        }
        sums
    }
}

/// The sums of the particle at one place.
#[inline(always)]
fn around<V: Vector, L: PairLaw<V, SUMS>, const SUMS: usize, const PERIODIC: bool>(
    records: &Records<V>,
    neighbors: &Neighbors,
    law: L,
    place: usize,
) -> [V::Scalar; SUMS] {
    let (list, length) = neighbors.lists.with_rest(place);
    let own = &records.words[place];
    let numbers = own.map(V::Scalar::number);
    let mut lanes = [[V::Scalar::ZERO; LANES]; SUMS];
    for first in (0..length).step_by(LANES) {
        let Some(group) = list[first..].first_chunk() else { break };
        let others = transpose(&records.words, group);
        let (apart, square) = distances::<V, PERIODIC>(own, &others, &records.rulers, length - first);
        add(&law, &numbers, &others, &apart, &square, &mut lanes);
    }
    lanes.map(fold)
}

/// How far a particle is from each of a group of others, of whom the first `number` count: their vectors and squares.
#[inline(always)]
fn distances<V: Vector, const PERIODIC: bool>(
    own: &Record<<V::Scalar as Stored>::Word>,
    others: &Record<Lanes<<V::Scalar as Stored>::Word>>,
    rulers: &[<V::Scalar as Stored>::Ruler; AXES],
    number: usize,
) -> ([Lanes<V::Scalar>; AXES], Lanes<V::Scalar>) {
    let mut apart = [[V::Scalar::ZERO; LANES]; AXES];
    let mut square = [V::Scalar::ZERO; LANES];
    for axis in 0..V::DIMENSION {
        for lane in 0..LANES {
            let distance = V::Scalar::apart::<PERIODIC>(own[axis], others[axis][lane], rulers[axis]);
            apart[axis][lane] = distance;
            square[lane] += distance * distance;
        }
    }
    for lane in 0..LANES {
        square[lane] = if lane < number { square[lane] } else { V::Scalar::INFINITY };
    }
    (apart, square)
}

/// Adds the terms of every lane.
#[inline(always)]
fn add<V: Vector, L: PairLaw<V, SUMS>, const SUMS: usize>(
    law: &L,
    own: &Record<V::Scalar>,
    others: &Record<Lanes<<V::Scalar as Stored>::Word>>,
    apart: &[Lanes<V::Scalar>; AXES],
    square: &Lanes<V::Scalar>,
    sums: &mut [Lanes<V::Scalar>; SUMS],
) {
    for lane in 0..LANES {
        let other = others.each_ref().map(|word| V::Scalar::number(word[lane]));
        let terms = law.terms(own, &other, apart.each_ref().map(|axis| axis[lane]), square[lane]);
        for sum in 0..SUMS {
            sums[sum][lane] += terms[sum];
        }
    }
}

/// The sum of all lanes, in one tree.
#[inline(always)]
fn fold<T: Real>(mut lanes: Lanes<T>) -> T {
    let mut half = LANES / 2;
    while half > 0 {
        for lane in 0..half {
            let other = lanes[lane + half];
            lanes[lane] += other;
        }
        half /= 2;
    }
    lanes[0]
}
