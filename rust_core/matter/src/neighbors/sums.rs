//! Sums over neighbors: the loop of all pair laws.
//!
//! A law's input of a particle is one [`ParticleRecord`], in the order of slots. The neighbors of a particle are processed in
//! groups of lanes. Their records are interleaved into registers, and the law computes its terms for every lane. Each lane has
//! its own sums. At the end the lanes are added in one tree. The bits are therefore the same at every SIMD level and for any
//! number of threads.

use super::{BLOCK, List, Neighbors};
use crate::aligned::filled;
use crate::math::{AXES, Coordinate, Real, Vector};
use crate::parallel::{BlockedSlice, Executor};
use crate::simd::{Group, Isa, Kernel, LANES, Lanes, Number, Pack, ParticleRecord, RecordTable, WORDS, dispatch, dispatch_wide};

/// A particle and its neighbor, or several neighbors, one in each lane.
#[derive(Debug, Clone, Copy)]
pub struct Pair<N> {
    /// Record of the particle. Its first words, one per axis, are undefined here.
    pub own: ParticleRecord<N>,
    /// Record of the neighbor.
    pub other: ParticleRecord<N>,
    /// Separation d = xᵢ − xⱼ [m].
    pub separation: [N; AXES],
    /// Squared distance |d|² [m²].
    pub square: N,
    /// Distance |d| [m].
    pub distance: N,
}

/// Pair law: the terms of a pair in the sums of its first particle.
pub trait PairLaw<V: Vector, const SUMS: usize>: Copy + Sync {
    /// Law for all pairs of one particle, with precomputed values of that particle.
    #[must_use]
    #[inline(always)]
    fn for_particle(self, _own: &ParticleRecord<V::Scalar>) -> Self {
        self
    }

    /// Terms of one pair, which are added to the sums of the first particle.
    ///
    /// Lists reach beyond the cutoff, and are padded with pairs of infinite `square`. The terms must therefore vanish from the
    /// law's cutoff on. All implementations are `#[inline(always)]`, so that values stay in registers.
    fn terms<N: Number<Scalar = V::Scalar>>(&self, pair: &Pair<N>) -> [N; SUMS];
}

/// Records of all particles, by slot.
#[derive(Debug)]
pub struct Records<V: Vector> {
    /// One record per slot, and a group of lanes as padding.
    words: RecordTable<V::Scalar>,
    /// Records by particle, while they are written. Their words come from many columns, which are read in order. Whole records
    /// are then sorted.
    unsorted: RecordTable<V::Scalar>,
    encodings: [<V::Scalar as Coordinate>::Encoding; AXES],
    periodic: bool,
}

impl<V: Vector> Records<V> {
    /// Records for the particles of `neighbors`.
    #[inline]
    pub fn new(neighbors: &Neighbors) -> Self {
        Self {
            words: filled([V::Scalar::ZERO; WORDS], neighbors.count() + LANES),
            unsorted: filled([V::Scalar::ZERO; WORDS], neighbors.count()),
            encodings: neighbors.domain().lengths().map(|length| V::Scalar::encoding(length, neighbors.support())),
            periodic: neighbors.domain().is_periodic(),
        }
    }

    /// Memory [bytes].
    #[inline]
    pub fn bytes(&self) -> usize {
        std::mem::size_of_val(&*self.words) + std::mem::size_of_val(&*self.unsorted)
    }

    /// Rewrites all records: the positions, and the following words, which `each` writes for a particle. These words are zero
    /// before.
    pub fn fill(
        &mut self,
        neighbors: &Neighbors,
        positions: [&[f64]; AXES],
        executor: &Executor,
        each: &(impl Fn(usize, &mut ParticleRecord<V::Scalar>) + Sync),
    ) {
        let Self { words, unsorted, encodings, .. } = self;
        executor.for_each_block(BlockedSlice::new(unsorted, BLOCK), &|mine| {
            dispatch(Fill::<V, _> { records: mine.items, start: mine.start, positions, encodings: *encodings, each });
        });
        let (order, unsorted) = (neighbors.order(), &*unsorted);
        executor.for_each_block(BlockedSlice::new(&mut words[..neighbors.count()], BLOCK), &|mine| {
            mine.items.iter_mut().zip(&order[mine.start..]).for_each(|(to, &particle)| *to = unsorted[particle as usize]);
        });
    }

    /// Changes the record at one slot, except its position.
    pub fn write(&mut self, slot: usize, change: impl FnOnce(&mut [V::Scalar])) {
        change(&mut self.words[slot][V::DIMENSION..]);
    }

    /// Computes the sums of a law over the neighbors of each particle, by slot.
    ///
    /// # Panics
    /// If `neighbors` are not those of the records, or `sums` has another length.
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
            dispatch_wide(BlockSweep { records: self, neighbors, law, start: mine.start, sums: mine.items, executor });
        });
    }

    /// Computes sums of laws over neighbor lists of particles at some slots, and passes each to `take` with its slot. The
    /// function `law` constructs the law of a list from its data. Laws are large, and are constructed where they stay in
    /// registers.
    pub fn sum_few<'a, D, L: PairLaw<V, SUMS>, const SUMS: usize>(
        &self,
        few: impl Iterator<Item = (usize, List<'a>, D)>,
        law: impl Fn(&D) -> L,
        take: impl FnMut(usize, [V::Scalar; SUMS]),
    ) {
        dispatch(ParticleSweep::<V, _, _, _, SUMS> { records: self, each: few, law, take });
    }
}

/// Kernel that writes the records of one block of particles. It is dispatched by SIMD level because scalar rounding is slow.
struct Fill<'a, V: Vector, F> {
    records: &'a mut [ParticleRecord<V::Scalar>],
    start: usize,
    positions: [&'a [f64]; AXES],
    encodings: [<V::Scalar as Coordinate>::Encoding; AXES],
    each: &'a F,
}

impl<V: Vector, F: Fn(usize, &mut ParticleRecord<V::Scalar>)> Kernel for Fill<'_, V, F> {
    type Output = ();

    #[inline(always)]
    fn run<S: Isa>(self, _isa: S) {
        for (particle, words) in (self.start..).zip(self.records) {
            *words = [V::Scalar::ZERO; WORDS];
            (self.each)(particle, words);
            for axis in 0..V::DIMENSION {
                words[axis] = V::Scalar::encode(self.positions[axis][particle], self.encodings[axis]);
            }
        }
    }
}

/// Kernel for the sums of one block.
struct BlockSweep<'a, V: Vector, L, const SUMS: usize> {
    records: &'a Records<V>,
    neighbors: &'a Neighbors,
    law: L,
    start: usize,
    sums: &'a mut [[V::Scalar; SUMS]],
    executor: &'a Executor,
}

impl<V: Vector, L: PairLaw<V, SUMS>, const SUMS: usize> Kernel for BlockSweep<'_, V, L, SUMS> {
    type Output = ();

    #[inline(always)]
    fn run<I: Isa>(self, _isa: I) {
        let Self { records, neighbors, law, start, sums, executor } = self;
        for (slot, sum) in (start..).zip(sums).take_while(|_| !executor.stopped()) {
            *sum = sum_over_list::<V, L, I::Group<V::Scalar>, SUMS, true>(records, neighbors.list(slot), &law, slot);
        }
    }
}

/// Kernel for the sums of a few particles.
struct ParticleSweep<'r, V: Vector, S, F, T, const SUMS: usize> {
    records: &'r Records<V>,
    each: S,
    law: F,
    take: T,
}

impl<'a, V, D, L, S, F, T, const SUMS: usize> Kernel for ParticleSweep<'_, V, S, F, T, SUMS>
where
    V: Vector,
    L: PairLaw<V, SUMS>,
    S: Iterator<Item = (usize, List<'a>, D)>,
    F: Fn(&D) -> L,
    T: FnMut(usize, [V::Scalar; SUMS]),
{
    type Output = ();

    #[inline(always)]
    fn run<I: Isa>(mut self, _isa: I) {
        for (slot, list, data) in self.each {
            let law = (self.law)(&data);
            let sums = sum_over_list::<V, L, I::Group<V::Scalar>, SUMS, false>(self.records, list, &law, slot);
            (self.take)(slot, sums);
        }
    }
}

/// Sums of the particle at one slot over a list. For long lists, `OVERLAPS` is worthwhile. It takes more code, and hides the
/// latency of a group's operations behind those of the next.
#[inline(always)]
fn sum_over_list<V, L, P, const SUMS: usize, const OVERLAPS: bool>(
    records: &Records<V>,
    List { segment, range }: List<'_>,
    law: &L,
    slot: usize,
) -> [V::Scalar; SUMS]
where
    V: Vector,
    L: PairLaw<V, SUMS>,
    P: Pack<Scalar = V::Scalar>,
{
    const { assert!(P::WIDTH == LANES, "registers of whole groups") };
    let own = records.words[slot];
    let law = law.for_particle(&own);
    let own = splat::<P>(&own);
    let mut groups = segment.groups(range.start, range.end);
    let (mut sums, mut left) = ([P::constant(0.0); SUMS], range.len());
    if const { !(OVERLAPS && P::OVERLAPS) } {
        for group in groups {
            add(&law, &pair::<V, P>(own, records, group, left), &mut sums);
            left = left.saturating_sub(LANES);
        }
    } else if let Some(group) = groups.next() {
        let mut current = pair::<V, P>(own, records, group, left);
        // The square roots of the next neighbors start before those of the present ones are needed.
        for group in groups {
            left -= LANES;
            let next = pair::<V, P>(own, records, group, left);
            add(&law, &current, &mut sums);
            current = next;
        }
        add(&law, &current, &mut sums);
    }
    P::fold(sums)
}

/// Adds the terms of a pair to the sums.
#[inline(always)]
fn add<V: Vector, L: PairLaw<V, SUMS>, P: Pack<Scalar = V::Scalar>, const SUMS: usize>(
    law: &L,
    pair: &Pair<P>,
    sums: &mut [P; SUMS],
) {
    let terms = law.terms(pair);
    for sum in 0..SUMS {
        sums[sum] += terms[sum];
    }
}

/// Record with the same number in every lane.
#[inline(always)]
fn splat<P: Pack>(own: &ParticleRecord<P::Scalar>) -> ParticleRecord<P>
where
    P::Scalar: Copy,
{
    let mut words = [P::constant(0.0); WORDS];
    for word in 0..WORDS {
        words[word] = P::of(own[word]);
    }
    words
}

/// A particle paired with a group of neighbors, of which the first `number` are valid.
#[inline(always)]
fn pair<V: Vector, P: Pack<Scalar = V::Scalar>>(
    own: ParticleRecord<P>,
    records: &Records<V>,
    group: Group<'_>,
    number: usize,
) -> Pair<P> {
    let (other, encodings) = (P::transpose(&records.words, group, 0), &records.encodings);
    let mut separation = [P::constant(0.0); AXES];
    for axis in 0..V::DIMENSION {
        separation[axis] = if V::Scalar::WRAPS || !records.periodic {
            V::Scalar::separation::<false, P>(own[axis], other[axis], encodings[axis])
        } else {
            V::Scalar::separation::<true, P>(own[axis], other[axis], encodings[axis])
        };
    }
    let mut square = separation[0] * separation[0];
    for axis in 1..V::DIMENSION {
        square += separation[axis] * separation[axis];
    }
    // The addend comes from a table, because compilers turn a comparison with the lane into branches.
    let table = Rest::<V::Scalar>::TABLE;
    square += P::load(&table.as_flattened()[LANES - number.min(LANES)..]);
    Pair { own, other, separation, square, distance: square.sqrt() }
}

/// Addend of the lanes' squares: 0 for valid lanes, infinity for the others.
struct Rest<T>(T);

impl<T: Real> Rest<T> {
    const TABLE: [Lanes<T>; 2] = [[T::ZERO; LANES], [T::INFINITY; LANES]];
}
