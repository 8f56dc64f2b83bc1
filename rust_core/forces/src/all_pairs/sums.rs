//! Sums over all pairs: the loop of all long-range forces.
//!
//! Targets are in the lanes of registers. Each lane adds the terms of one source after the other. The order of each sum is
//! therefore that of the sources, at every SIMD level and for any number of threads. Terms of [`RUN`] sources are summed in the
//! precision of the run, and these sums in double precision. The rounding error of a sum then does not grow with the number of
//! sources.

use std::ops::Index;

use crate::math::{AXES, Real};
use crate::parallel::{BlockedSlice, Executor};
use crate::simd::{Isa, Kernel, LANES, Number, Pack, dispatch_wide};

/// Targets per block: a whole number of tiles at every SIMD level.
pub const BLOCK: usize = 64;

/// Registers of targets in a tile: enough independent square roots and divisions to occupy their unit.
const TILE: usize = 2;

/// Number of sources whose terms are summed in the precision of the run.
const RUN: usize = 256;

/// Terms of a source in the sums of a target.
pub trait SourceLaw<T, const WORDS: usize, const SUMS: usize>: Copy + Sync {
    /// Number of leading terms that are not always 0.
    const TERMS: usize = SUMS;

    /// The terms for the offset d of the source from the target, its square |d|², and the record of the source. All
    /// implementations are `#[inline(always)]`, so that values stay in registers.
    fn terms<N: Number<Scalar = T>>(&self, offset: [N; AXES], square: N, source: &[N; WORDS]) -> [N; SUMS];
}

/// Sums for a set of targets.
pub struct TargetSums<const SUMS: usize> {
    /// Sums of each target, in the order of evaluation.
    pub values: Vec<[f64; SUMS]>,
    /// Index of each target in `values`; empty if both have the same order.
    pub slots: Vec<u32>,
    /// Number of interactions of targets with cells and bodies.
    pub interactions: usize,
    /// Memory of the evaluation [bytes].
    pub bytes: usize,
}

impl<const SUMS: usize> Index<usize> for TargetSums<SUMS> {
    type Output = [f64; SUMS];

    fn index(&self, target: usize) -> &[f64; SUMS] {
        &self.values[self.slots.get(target).map_or(target, |&slot| slot as usize)]
    }
}

/// Sums of a law over all sources for every target, in `dimension` dimensions. The record of a source begins with its position.
pub fn sum<T: Real, L: SourceLaw<T, WORDS, SUMS>, const WORDS: usize, const SUMS: usize>(
    dimension: usize,
    law: L,
    targets: &[[T; AXES]],
    sources: &[[T; WORDS]],
    executor: &Executor,
) -> TargetSums<SUMS> {
    let mut values = vec![[0.0; SUMS]; targets.len()];
    executor.for_each_block(BlockedSlice::new(&mut values, BLOCK), &|mine| {
        add(dimension, law, &targets[mine.start..][..mine.items.len()], sources, mine.items);
    });
    let bytes = size_of_val(targets) + size_of_val(sources) + size_of_val(values.as_slice());
    TargetSums { values, slots: Vec::new(), interactions: targets.len() * sources.len(), bytes }
}

/// Adds the sums for at most [`BLOCK`] targets.
pub fn add<T: Real, L: SourceLaw<T, WORDS, SUMS>, const WORDS: usize, const SUMS: usize>(
    dimension: usize,
    law: L,
    targets: &[[T; AXES]],
    sources: &[[T; WORDS]],
    sums: &mut [[f64; SUMS]],
) {
    if dimension == 2 {
        dispatch_wide(TargetBlock::<T, L, 2, WORDS, SUMS> { law, targets, sources, sums });
    } else {
        dispatch_wide(TargetBlock::<T, L, 3, WORDS, SUMS> { law, targets, sources, sums });
    }
}

/// Sums of one block of targets.
struct TargetBlock<'a, T, L, const DIMENSION: usize, const WORDS: usize, const SUMS: usize> {
    law: L,
    targets: &'a [[T; AXES]],
    sources: &'a [[T; WORDS]],
    sums: &'a mut [[f64; SUMS]],
}

impl<T: Real, L: SourceLaw<T, WORDS, SUMS>, const DIMENSION: usize, const WORDS: usize, const SUMS: usize> Kernel
    for TargetBlock<'_, T, L, DIMENSION, WORDS, SUMS>
{
    type Output = ();

    #[inline(always)]
    fn run<I: Isa>(self, _isa: I) {
        let Self { law, targets, sources, sums } = self;
        let mut columns = [[T::ZERO; BLOCK]; AXES];
        for (lane, target) in targets.iter().enumerate() {
            for axis in 0..DIMENSION {
                columns[axis][lane] = target[axis];
            }
        }
        let mut totals = [[0.0; BLOCK]; SUMS];
        for first in (0..targets.len()).step_by(TILE * <I::Pack<T> as Pack>::WIDTH) {
            for run in sources.chunks(RUN) {
                tile::<T, I::Pack<T>, L, DIMENSION, WORDS, SUMS>(law, &columns, first, run, &mut totals);
            }
        }
        for (lane, sums) in sums.iter_mut().enumerate() {
            for sum in 0..L::TERMS {
                sums[sum] += totals[sum][lane];
            }
        }
    }
}

/// Adds the sums over one run of sources for a tile of targets, from lane `first` of a block on.
#[inline(always)]
fn tile<
    T: Real,
    P: Pack<Scalar = T>,
    L: SourceLaw<T, WORDS, SUMS>,
    const DIMENSION: usize,
    const WORDS: usize,
    const SUMS: usize,
>(
    law: L,
    columns: &[[T; BLOCK]; AXES],
    first: usize,
    sources: &[[T; WORDS]],
    totals: &mut [[f64; BLOCK]; SUMS],
) {
    let zero = P::constant(0.0);
    let mut targets = [[zero; AXES]; TILE];
    for register in 0..TILE {
        for axis in 0..DIMENSION {
            targets[register][axis] = P::load(&columns[axis][first + register * P::WIDTH..]);
        }
    }
    let mut sums = [[zero; SUMS]; TILE];
    for source in sources {
        let mut words = [zero; WORDS];
        for word in 0..WORDS {
            words[word] = P::of(source[word]);
        }
        for register in 0..TILE {
            let mut offset = [zero; AXES];
            for axis in 0..DIMENSION {
                offset[axis] = words[axis] - targets[register][axis];
            }
            let mut square = offset[0] * offset[0];
            for axis in 1..DIMENSION {
                square += offset[axis] * offset[axis];
            }
            let terms = law.terms(offset, square, &words);
            for sum in 0..L::TERMS {
                sums[register][sum] += terms[sum];
            }
        }
    }
    for register in 0..TILE {
        for sum in 0..L::TERMS {
            let mut lanes = [T::ZERO; LANES];
            sums[register][sum].store(&mut lanes);
            let totals = &mut totals[sum][first + register * P::WIDTH..][..P::WIDTH];
            for lane in 0..P::WIDTH {
                totals[lane] += lanes[lane].to_f64();
            }
        }
    }
}
