//! Sums over neighbors: the loop that all pair laws share.
//!
//! What a law reads of a particle is one [`Record`], kept in the order of places. The neighbors of a particle are taken in
//! groups of lanes: their records are transposed into lanes, the law gives its terms for every lane, and each lane adds up
//! its own. At the end the lanes are folded in one tree, so that the bits are the same at every SIMD level and for any
//! number of threads.

use super::{BLOCK, List, Neighbors};
use crate::math::{AXES, Placed, Real, Vector};
use crate::parallel::{Chunks, Crew};
use crate::simd::{Isa, Kernel, LANES, Lanes, LevelKernel, Record, WORDS, dispatch, dispatch_level, transpose};

/// What happens between two particles, as the first of them feels it.
pub trait PairLaw<V: Vector, const SUMS: usize>: Copy + Sync {
    /// The law as one particle sees it, for all of its pairs: what depends on that particle alone is settled here.
    #[must_use]
    #[inline(always)]
    fn facing(self, _own: &Record<V::Scalar>) -> Self {
        self
    }

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
    /// One per place, and a group of lanes more.
    words: Vec<Record<V::Scalar>>,
    rulers: [<V::Scalar as Placed>::Ruler; AXES],
    periodic: bool,
}

impl<V: Vector> Records<V> {
    /// Room for the particles of `neighbors`.
    pub fn new(neighbors: &Neighbors) -> Self {
        Self {
            words: vec![[V::Scalar::ZERO; WORDS]; neighbors.count() + LANES],
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
        crew.sweep(Chunks::new(&mut self.words[..neighbors.count()], BLOCK), &|mine| {
            let order = &order[mine.start..];
            dispatch(Fill::<V, _> { records: mine.items, order, positions, rulers, each });
        });
    }

    /// Changes the record at one place, but for its position.
    pub fn write(&mut self, place: usize, change: impl FnOnce(&mut [V::Scalar])) {
        change(&mut self.words[place][V::DIMENSION..]);
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
        let count = neighbors.count();
        assert!(self.words.len() == count + LANES && sums.len() == count, "one record and sum per particle");
        crew.sweep(Chunks::new(sums, BLOCK), &|mine| {
            let sweep = Sweep { records: self, neighbors, law, start: mine.start, sums: mine.items };
            if V::Scalar::WRAPS || !self.periodic {
                dispatch_level(Wrapped::<V, L, SUMS, false>(sweep));
            } else {
                dispatch_level(Wrapped::<V, L, SUMS, true>(sweep));
            }
        });
    }

    /// The sums of a law over a list of neighbors of the particle at one place.
    pub fn sum_at<L: PairLaw<V, SUMS>, const SUMS: usize>(&self, list: List<'_>, law: &L, place: usize) -> [V::Scalar; SUMS] {
        if V::Scalar::WRAPS || !self.periodic {
            dispatch_level(Alone::<V, L, SUMS, false> { records: self, list, law, place })
        } else {
            dispatch_level(Alone::<V, L, SUMS, true> { records: self, list, law, place })
        }
    }
}

/// The writing of the records of one block: at a level, because rounding is slow without.
struct Fill<'a, V: Vector, F> {
    records: &'a mut [Record<V::Scalar>],
    order: &'a [u32],
    positions: [&'a [f64]; AXES],
    rulers: [<V::Scalar as Placed>::Ruler; AXES],
    each: &'a F,
}

impl<V: Vector, F: Fn(usize, &mut Record<V::Scalar>)> Kernel for Fill<'_, V, F> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (words, &particle) in self.records.iter_mut().zip(self.order) {
            *words = [V::Scalar::ZERO; WORDS];
            (self.each)(particle as usize, words);
            for axis in 0..V::DIMENSION {
                words[axis] = V::Scalar::place(self.positions[axis][particle as usize], self.rulers[axis]);
            }
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

impl<V: Vector, L: PairLaw<V, SUMS>, const SUMS: usize, const PERIODIC: bool> LevelKernel for Wrapped<'_, V, L, SUMS, PERIODIC> {
    type Output = ();

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) {
        let Sweep { records, neighbors, law, start, sums } = self.0;
        for (place, sum) in (start..).zip(sums) {
            *sum = around::<V, L, SUMS, PERIODIC>(isa, records, neighbors.list(place), &law, place);
        }
    }
}

/// The sums of one particle, with or without periods.
struct Alone<'a, V: Vector, L, const SUMS: usize, const PERIODIC: bool> {
    records: &'a Records<V>,
    list: List<'a>,
    law: &'a L,
    place: usize,
}

impl<V: Vector, L: PairLaw<V, SUMS>, const SUMS: usize, const PERIODIC: bool> LevelKernel for Alone<'_, V, L, SUMS, PERIODIC> {
    type Output = [V::Scalar; SUMS];

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> [V::Scalar; SUMS] {
        around::<V, L, SUMS, PERIODIC>(isa, self.records, self.list, self.law, self.place)
    }
}

/// The sums of the particle at one place over a list.
#[inline(always)]
fn around<V: Vector, L: PairLaw<V, SUMS>, const SUMS: usize, const PERIODIC: bool>(
    isa: impl Isa,
    records: &Records<V>,
    List { segment, range }: List<'_>,
    law: &L,
    place: usize,
) -> [V::Scalar; SUMS] {
    // A copy, because compilers do not see that nobody writes to the original meanwhile.
    let own = records.words[place];
    let law = law.facing(&own);
    let mut lanes = [[V::Scalar::ZERO; LANES]; SUMS];
    for first in range.clone().step_by(LANES) {
        let others = transpose(isa, &records.words, segment.group(first));
        let (apart, square) = distances::<V, PERIODIC>(&own, &others, &records.rulers, range.end - first);
        add(&law, &own, &others, &apart, &square, &mut lanes);
    }
    lanes.map(fold)
}

/// How far a particle is from each of a group of others, of whom the first `number` count: their vectors and squares.
#[inline(always)]
fn distances<V: Vector, const PERIODIC: bool>(
    own: &Record<V::Scalar>,
    others: &Record<Lanes<V::Scalar>>,
    rulers: &[<V::Scalar as Placed>::Ruler; AXES],
    number: usize,
) -> ([Lanes<V::Scalar>; AXES], Lanes<V::Scalar>) {
    // Axis by axis, without a loop: compilers would leave the lanes in memory and read them back in odd pieces.
    let along = |axis: usize| line::<V::Scalar, PERIODIC>(own[axis], &others[axis], rulers[axis]);
    let apart = [along(0), along(1), if V::DIMENSION == 3 { along(2) } else { [V::Scalar::ZERO; LANES] }];
    let mut square = [V::Scalar::ZERO; LANES];
    for lane in 0..LANES {
        square[lane] = apart[0][lane] * apart[0][lane] + apart[1][lane] * apart[1][lane];
        if V::DIMENSION == 3 {
            square[lane] += apart[2][lane] * apart[2][lane];
        }
    }
    // Added from a table, because compilers make branches of a comparison with the lane.
    let table = Rest::<V::Scalar>::TABLE;
    let rest = &table.as_flattened()[LANES - number.min(LANES)..][..LANES];
    for lane in 0..LANES {
        square[lane] += rest[lane];
    }
    (apart, square)
}

/// How far a place is from each of a group of others along one axis.
#[inline(always)]
fn line<T: Real, const PERIODIC: bool>(own: T, others: &Lanes<T>, ruler: T::Ruler) -> Lanes<T> {
    let mut apart = [T::ZERO; LANES];
    for lane in 0..LANES {
        apart[lane] = T::apart::<PERIODIC>(own, others[lane], ruler);
    }
    apart
}

/// What is added to the squares of the lanes: nothing as long as there are neighbors, then infinity.
struct Rest<T>(T);

impl<T: Real> Rest<T> {
    const TABLE: [Lanes<T>; 2] = [[T::ZERO; LANES], [T::INFINITY; LANES]];
}

/// Adds the terms of every lane.
#[inline(always)]
fn add<V: Vector, L: PairLaw<V, SUMS>, const SUMS: usize>(
    law: &L,
    own: &Record<V::Scalar>,
    others: &Record<Lanes<V::Scalar>>,
    apart: &[Lanes<V::Scalar>; AXES],
    square: &Lanes<V::Scalar>,
    sums: &mut [Lanes<V::Scalar>; SUMS],
) {
    for lane in 0..LANES {
        let other = others.each_ref().map(|word| word[lane]);
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
