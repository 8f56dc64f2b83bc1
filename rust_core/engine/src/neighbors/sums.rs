//! Sums over neighbors: the loop that all pair laws share.
//!
//! A law's input of a particle is one [`Record`], in the order of slots. The neighbors of a particle are processed in
//! groups of lanes: their records are interleaved into registers, the law computes its terms for every lane, and each lane
//! has its own sums. At the end the lanes are added in one tree, so that the bits are the same at every SIMD level and for
//! any number of threads.

use super::{BLOCK, List, Neighbors};
use crate::math::{AXES, Coordinate, Real, Vector};
use crate::parallel::{BlockedSlice, Executor};
use crate::simd::{Isa, Kernel, LANES, Lanes, LevelKernel, Number, Pack, Record, Table, WORDS, dispatch, dispatch_level};

/// A particle and its neighbor; or several neighbors, one in each lane.
#[derive(Debug, Clone, Copy)]
pub struct Pair<N> {
    /// The particle's record, whose first words (as many as there are axes) are undefined here.
    pub own: Record<N>,
    /// The neighbor's record.
    pub other: Record<N>,
    /// The separation d = xᵢ − xⱼ [m].
    pub separation: [N; AXES],
    /// |d|² [m²].
    pub square: N,
}

/// A pair law: the terms of a pair in the sums of its first particle.
pub trait PairLaw<V: Vector, const SUMS: usize>: Copy + Sync {
    /// The law for all pairs of one particle, with precomputed values of that particle.
    #[must_use]
    #[inline(always)]
    fn for_particle(self, _own: &Record<V::Scalar>) -> Self {
        self
    }

    /// The terms of one pair, which are added to the sums of the first particle.
    ///
    /// Lists reach beyond the cutoff, and are padded with pairs of infinite `square`: the law's terms vanish from its
    /// cutoff on. All of its code is `#[inline(always)]`, or it does not stay in registers.
    fn terms<N: Number<Scalar = V::Scalar>>(&self, pair: &Pair<N>) -> [N; SUMS];
}

/// The records of all particles, by slot.
#[derive(Debug)]
pub struct Records<V: Vector> {
    /// One per slot, and a group of lanes as padding.
    words: Table<V::Scalar>,
    encodings: [<V::Scalar as Coordinate>::Encoding; AXES],
    periodic: bool,
}

impl<V: Vector> Records<V> {
    /// Records for the particles of `neighbors`.
    pub fn new(neighbors: &Neighbors) -> Self {
        Self {
            words: Table::zeros(neighbors.count() + LANES),
            encodings: neighbors.domain().lengths().map(|length| V::Scalar::encoding(length, neighbors.support())),
            periodic: neighbors.domain().is_periodic(),
        }
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        std::mem::size_of_val(&*self.words)
    }

    /// Rewrites all records: the positions, and the words from the number of axes on, which `each` writes for a particle.
    /// They are zero before.
    pub fn fill(
        &mut self,
        neighbors: &Neighbors,
        positions: [&[f64]; AXES],
        executor: &Executor,
        each: &(impl Fn(usize, &mut Record<V::Scalar>) + Sync),
    ) {
        let (order, encodings) = (neighbors.order(), self.encodings);
        executor.for_each_block(BlockedSlice::new(&mut self.words[..neighbors.count()], BLOCK), &|mine| {
            let order = &order[mine.start..];
            dispatch(Fill::<V, _> { records: mine.items, order, positions, encodings, each });
        });
    }

    /// Changes the record at one slot, except its position.
    pub fn write(&mut self, slot: usize, change: impl FnOnce(&mut [V::Scalar])) {
        change(&mut self.words[slot][V::DIMENSION..]);
    }

    /// The sums of a law over the neighbors of each particle, into `sums`, by slot.
    ///
    /// # Panics
    /// If `neighbors` are not those that the records were made for, or `sums` has another length.
    pub fn sum<L: PairLaw<V, SUMS>, const SUMS: usize>(
        &self,
        neighbors: &Neighbors,
        law: L,
        sums: &mut [[V::Scalar; SUMS]],
        executor: &Executor,
    ) {
        let count = neighbors.count();
        assert!(self.words.len() == count + LANES && sums.len() == count, "one record and sum per particle");
        executor.for_each_block(BlockedSlice::new(sums, BLOCK), &|mine| {
            let for_each_block = Sweep { records: self, neighbors, law, start: mine.start, sums: mine.items, executor };
            if V::Scalar::WRAPS || !self.periodic {
                dispatch_level(Wrapped::<V, L, SUMS, false>(for_each_block));
            } else {
                dispatch_level(Wrapped::<V, L, SUMS, true>(for_each_block));
            }
        });
    }

    /// The sums of laws over neighbor lists of particles at some slots, each passed to `take` with its slot.
    pub fn sum_few<'a, L: PairLaw<V, SUMS>, const SUMS: usize>(
        &self,
        few: impl Iterator<Item = (usize, List<'a>, L)>,
        take: impl FnMut(usize, [V::Scalar; SUMS]),
    ) {
        let records = self;
        if V::Scalar::WRAPS || !self.periodic {
            dispatch_level(Few::<V, _, _, SUMS, false> { records, each: few, take });
        } else {
            dispatch_level(Few::<V, _, _, SUMS, true> { records, each: few, take });
        }
    }
}

/// The kernel that writes the records of one block, dispatched by SIMD level because scalar rounding is slow.
struct Fill<'a, V: Vector, F> {
    records: &'a mut [Record<V::Scalar>],
    order: &'a [u32],
    positions: [&'a [f64]; AXES],
    encodings: [<V::Scalar as Coordinate>::Encoding; AXES],
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
                words[axis] = V::Scalar::encode(self.positions[axis][particle as usize], self.encodings[axis]);
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
    executor: &'a Executor,
}

/// The sums of one block, specialized to periodicity.
struct Wrapped<'a, V: Vector, L, const SUMS: usize, const PERIODIC: bool>(Sweep<'a, V, L, SUMS>);

impl<V: Vector, L: PairLaw<V, SUMS>, const SUMS: usize, const PERIODIC: bool> LevelKernel for Wrapped<'_, V, L, SUMS, PERIODIC> {
    type Output = ();

    #[inline(always)]
    fn run<I: Isa>(self, _isa: I) {
        let Sweep { records, neighbors, law, start, sums, executor } = self.0;
        for (slot, sum) in (start..).zip(sums).take_while(|_| !executor.stopped()) {
            *sum = sum_over_list::<V, L, I::Pack<V::Scalar>, SUMS, PERIODIC>(records, neighbors.list(slot), &law, slot);
        }
    }
}

/// The sums of a few particles, specialized to periodicity.
struct Few<'r, V: Vector, S, T, const SUMS: usize, const PERIODIC: bool> {
    records: &'r Records<V>,
    each: S,
    take: T,
}

impl<'a, V, L, S, T, const SUMS: usize, const PERIODIC: bool> LevelKernel for Few<'_, V, S, T, SUMS, PERIODIC>
where
    V: Vector,
    L: PairLaw<V, SUMS>,
    S: Iterator<Item = (usize, List<'a>, L)>,
    T: FnMut(usize, [V::Scalar; SUMS]),
{
    type Output = ();

    #[inline(always)]
    fn run<I: Isa>(mut self, _isa: I) {
        for (slot, list, law) in self.each {
            (self.take)(slot, sum_over_list::<V, L, I::Pack<V::Scalar>, SUMS, PERIODIC>(self.records, list, &law, slot));
        }
    }
}

/// The sums of the particle at one slot over a list.
#[inline(always)]
fn sum_over_list<V: Vector, L: PairLaw<V, SUMS>, P: Pack<Scalar = V::Scalar>, const SUMS: usize, const PERIODIC: bool>(
    records: &Records<V>,
    List { segment, range }: List<'_>,
    law: &L,
    slot: usize,
) -> [V::Scalar; SUMS] {
    let own = records.words[slot];
    let law = law.for_particle(&own);
    let own = splat::<P>(&own);
    let groups = segment.groups(range.start, range.end);
    let mut lanes = [[V::Scalar::ZERO; LANES]; SUMS];
    // One register's lanes of all groups, then the next ones.
    for first in (0..LANES).step_by(P::WIDTH) {
        let mut sums = [P::constant(0.0); SUMS];
        let mut left = range.len();
        for group in groups.clone() {
            if left > first {
                let other = P::transpose(&records.words, group, first);
                let terms = law.terms(&pair::<V, P, PERIODIC>(own, other, &records.encodings, left, first));
                for sum in 0..SUMS {
                    sums[sum] += terms[sum];
                }
            }
            left = left.saturating_sub(LANES);
        }
        for sum in 0..SUMS {
            sums[sum].store(&mut lanes[sum][first..]);
        }
    }
    lanes.map(fold)
}

/// The same number in every lane.
#[inline(always)]
fn splat<P: Pack>(own: &Record<P::Scalar>) -> Record<P>
where
    P::Scalar: Copy,
{
    let mut words = [P::constant(0.0); WORDS];
    for word in 0..WORDS {
        words[word] = P::of(own[word]);
    }
    words
}

/// A particle paired with a group of neighbors, from the lane `first` on; the first `number` of the group are valid.
#[inline(always)]
fn pair<V: Vector, P: Pack<Scalar = V::Scalar>, const PERIODIC: bool>(
    own: Record<P>,
    other: Record<P>,
    encodings: &[<V::Scalar as Coordinate>::Encoding; AXES],
    number: usize,
    first: usize,
) -> Pair<P> {
    let mut separation = [P::constant(0.0); AXES];
    for axis in 0..V::DIMENSION {
        separation[axis] = V::Scalar::separation::<PERIODIC, P>(own[axis], other[axis], encodings[axis]);
    }
    let mut square = separation[0] * separation[0];
    for axis in 1..V::DIMENSION {
        square += separation[axis] * separation[axis];
    }
    // Added from a table, because compilers turn a comparison with the lane into branches.
    let table = Rest::<V::Scalar>::TABLE;
    square += P::load(&table.as_flattened()[LANES + first - number.min(LANES)..]);
    Pair { own, other, separation, square }
}

/// Addend of the lanes' squares: 0 for valid lanes, then infinity.
struct Rest<T>(T);

impl<T: Real> Rest<T> {
    const TABLE: [Lanes<T>; 2] = [[T::ZERO; LANES], [T::INFINITY; LANES]];
}

/// The sum of all lanes, by a tree.
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
