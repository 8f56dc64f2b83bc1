//! Stencils: springs of one law between particles with a constant index offset.
//!
//! A cloth, or a lattice, in row-major order is a few stencils with holes at its edges. Both ends are then read
//! contiguously, and every spring is computed once. All blocks add in one global order (tile by tile, in a tile stencil by
//! stencil, in a stencil first the forces on lower ends, then those on upper ends) and skip particles outside: so the sum
//! on a particle has the same bits for any division into blocks.

use std::collections::BTreeMap;
use std::ops::Range;

use super::Spring;
use super::law::{Run, SpringLaw};
use super::statistics::SpringStatistics;
use crate::forces::{Rates, StateView};
use crate::math::{AXES, Real, Vector};
use crate::matter::EnergySink;
use crate::simd::{LANES, padded};

/// Particles per tile: all stencils visit a tile in turn, which stays in the first-level cache.
pub const TILE: usize = 16 * LANES;

/// Forces and powers of one stencil's springs in a tile.
#[derive(Debug)]
pub struct Scratch<T> {
    /// The force on their lower ends [N].
    force: [[T; TILE]; AXES],
    /// Its part by damping [N].
    damping: [[T; TILE]; AXES],
    /// The dissipated power [W].
    power: [T; TILE],
}

impl<T: Real> Scratch<T> {
    /// Zero forces and powers.
    pub const EMPTY: Self = Self { force: [[T::ZERO; TILE]; AXES], damping: [[T::ZERO; TILE]; AXES], power: [T::ZERO; TILE] };
}

/// Maximum number of stencils: each has a cost per tile.
const MOST: usize = 32;

/// Least occupancy of its tiles, in percent: sparser stencils cost less as slices.
const DENSITY: usize = 50;

/// Least share of all springs in stencils, in percent.
const STRUCTURE: usize = 50;

/// The springs (i, i + offset) that obey one law.
#[derive(Debug)]
pub struct Stencil<T> {
    /// The difference of the indices.
    pub offset: usize,
    /// The common law.
    pub law: SpringLaw<T>,
    /// The number of springs.
    pub count: usize,
    /// The first group of lanes that has a lower end.
    first: usize,
    /// Which lanes are lower ends, one bit each, from the first group to the last.
    present: Vec<u16>,
}

/// The stencils in a network, and whether each spring is in one of them.
pub fn find<T: Real>(springs: &[Spring]) -> (Vec<Stencil<T>>, Vec<bool>) {
    let mut kinds: BTreeMap<(u32, [u64; 3]), Vec<usize>> = BTreeMap::new();
    for (index, spring) in springs.iter().enumerate() {
        let [i, j] = spring.ends;
        kinds.entry((i.abs_diff(j), SpringLaw::<T>::of(spring).key())).or_default().push(index);
    }
    let mut found: Vec<(Stencil<T>, Vec<usize>)> = kinds.into_values().filter_map(|kind| Stencil::of(springs, &kind)).collect();
    found.sort_by_key(|(stencil, _)| std::cmp::Reverse(stencil.count));
    found.truncate(MOST);
    // A few stencils in an unstructured network would only leave holes in its slices.
    if found.iter().map(|(stencil, _)| stencil.count).sum::<usize>() * 100 < springs.len() * STRUCTURE {
        found.clear();
    }
    let mut taken = vec![false; springs.len()];
    found.iter().flat_map(|(_, members)| members).for_each(|&index| taken[index] = true);
    (found.into_iter().map(|(stencil, _)| stencil).collect(), taken)
}

impl<T: Real> Stencil<T> {
    /// The stencil of springs of one kind and its members: a pair can be in it only once. None if too sparse.
    fn of(springs: &[Spring], kind: &[usize]) -> Option<(Self, Vec<usize>)> {
        let lower = |index: usize| springs[index].ends[0].min(springs[index].ends[1]) as usize;
        let [i, j] = springs[kind[0]].ends;
        let first = kind.iter().map(|&index| lower(index)).min()? / LANES;
        let last = kind.iter().map(|&index| lower(index)).max()? / LANES;
        let mut present = vec![0_u16; last + 1 - first];
        let members: Vec<usize> = kind
            .iter()
            .copied()
            .filter(|&index| {
                let (group, bit) = (&mut present[lower(index) / LANES - first], 1 << (lower(index) % LANES));
                let new = *group & bit == 0;
                *group |= bit;
                new
            })
            .collect();
        let tiles = present.chunks(TILE / LANES).filter(|tile| tile.iter().any(|&group| group != 0));
        let lanes = tiles.map(|tile| tile.len() * LANES).sum::<usize>();
        let stencil =
            Self { offset: i.abs_diff(j) as usize, law: SpringLaw::of(&springs[kind[0]]), count: members.len(), first, present };
        (stencil.count * 100 >= DENSITY * lanes).then_some((stencil, members))
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        std::mem::size_of_val(self.present.as_slice())
    }

    /// The lower ends in a range of particles, group by group: the group's first particle, and one bit for each lane.
    fn groups(&self, range: Range<usize>) -> impl Iterator<Item = (usize, u16)> {
        let lower = (range.start / LANES).max(self.first);
        let upper = range.end.div_ceil(LANES).min(self.first + self.present.len());
        (lower..upper).map(|group| (group * LANES, self.present[group - self.first]))
    }

    /// Calls `each` with the ends of every spring whose lower end is in a range.
    pub fn for_each(&self, range: Range<usize>, mut each: impl FnMut(usize, usize, &SpringLaw<T>)) {
        for (start, present) in self.groups(range) {
            (0..LANES)
                .filter(|lane| present >> lane & 1 == 1)
                .for_each(|lane| each(start + lane, start + lane + self.offset, &self.law));
        }
    }

    /// Adds the forces and powers of its springs with a lower end in `tile` on the particles of a block.
    #[inline(always)]
    pub fn accumulate<V: Vector<Scalar = T>, const DAMPED: bool>(
        &self,
        tile: &Range<usize>,
        block: &Range<usize>,
        at: &StateView<'_, V>,
        rates: &mut Rates<'_, V>,
        scratch: &mut Scratch<T>,
    ) {
        let halo = block.start.saturating_sub(self.offset) / LANES * LANES;
        let Range { start, end } = self.lower(tile.start.max(halo)..tile.end.min(block.end), at);
        if start >= end
            || self.present[start / LANES - self.first..][..(end - start).div_ceil(LANES)].iter().all(|&group| group == 0)
        {
            return;
        }
        self.compute::<V, DAMPED>(&(start..end), at, scratch);
        let lower = start.max(block.start)..end;
        let upper = (start + self.offset).max(block.start)..(end + self.offset).min(block.end);
        let place = |ends: &Range<usize>| ends.start - block.start..ends.end - block.start;
        let ends = [(&lower, start), (&upper, start + self.offset)]
            .map(|(ends, first)| if ends.is_empty() { (0..0, 0) } else { (place(ends), ends.start - first) });
        for axis in 0..V::DIMENSION {
            add(&ends, rates.force.axes[axis], &scratch.force[axis]);
            if let (true, Some(damping)) = (DAMPED, &mut rates.damping) {
                add(&ends, damping.axes[axis], &scratch.damping[axis]);
            }
        }
        if DAMPED && !lower.is_empty() {
            let mut power = [T::ZERO; LANES];
            for group in scratch.power[lower.start - start..padded(end - start)].as_chunks::<LANES>().0 {
                (0..LANES).for_each(|lane| power[lane] += group[lane]);
            }
            (0..LANES).for_each(|lane| rates.power[EnergySink::Damping as usize][lane] += power[lane].to_f64());
        }
    }

    /// The part of a range that can hold lower ends: it starts with a group of lanes, and the upper ends are in columns.
    #[inline(always)]
    fn lower<V: Vector<Scalar = T>>(&self, range: Range<usize>, at: &StateView<'_, V>) -> Range<usize> {
        let last = at.position.axis(0).len().saturating_sub(self.offset);
        range.start.max(self.first * LANES)..range.end.min((self.first + self.present.len()) * LANES).min(last)
    }

    /// Computes the springs with a lower end in a range, and puts zeros where there is none.
    #[inline(always)]
    fn compute<V: Vector<Scalar = T>, const DAMPED: bool>(
        &self,
        range: &Range<usize>,
        at: &StateView<'_, V>,
        scratch: &mut Scratch<T>,
    ) {
        let (near, far) = (Run::new(at, range), Run::new(at, &(range.start + self.offset..range.end + self.offset)));
        let law = self.law;
        let length = range.len();
        let force = scratch.force.each_mut().map(|axis| &mut axis[..length]);
        let damping = scratch.damping.each_mut().map(|axis| &mut axis[..length]);
        let power = &mut scratch.power[..length];
        for index in 0..length {
            let pull = law.force::<V, DAMPED>(near.get::<V, DAMPED>(index), far.get::<V, DAMPED>(index));
            for axis in 0..V::DIMENSION {
                force[axis][index] = pull.force[axis];
                if DAMPED {
                    damping[axis][index] = pull.damping[axis];
                }
            }
            power[index] = pull.power;
        }
        scratch.power[length..padded(length)].fill(T::ZERO);
        for (group, &present) in self.present[range.start / LANES - self.first..][..length.div_ceil(LANES)].iter().enumerate() {
            let mut holes = !present;
            while holes != 0 {
                let hole = group * LANES + holes.trailing_zeros() as usize;
                for axis in 0..V::DIMENSION {
                    (scratch.force[axis][hole], scratch.damping[axis][hole]) = (T::ZERO, T::ZERO);
                }
                scratch.power[hole] = T::ZERO;
                holes &= holes - 1;
            }
        }
    }

    /// Adds the springs with a lower end in a range to statistics.
    #[inline(always)]
    pub fn measure<V: Vector<Scalar = T>>(&self, block: &Range<usize>, at: &StateView<'_, V>, statistics: &mut SpringStatistics) {
        let block = self.lower(block.clone(), at);
        let mut square = [0.0; TILE];
        for start in block.clone().step_by(TILE) {
            let range = start..block.end.min(start + TILE);
            let (near, far) = (Run::new(at, &range), Run::new(at, &(range.start + self.offset..range.end + self.offset)));
            let square = &mut square[..range.len()];
            for index in 0..range.len() {
                square[index] = near.get::<V, false>(index).square_to::<V>(far.get::<V, false>(index));
            }
            let groups = self.present[start / LANES - self.first..].iter().zip(square.chunks(LANES));
            for (&present, square) in groups {
                for (lane, &square) in square.iter().enumerate() {
                    statistics.add(lane, present >> lane & 1 == 1, square, self.law);
                }
            }
        }
    }
}

/// Adds pulls to the forces on lower ends, and takes them from those on upper ends: each given by its range in the column, and the
/// place of its first pull. Not a closure, which might not be inlined into the code of a SIMD level.
#[inline(always)]
fn add<T: Real>([lower, upper]: &[(Range<usize>, usize); 2], column: &mut [T], pulls: &[T; TILE]) {
    column[lower.0.clone()].iter_mut().zip(&pulls[lower.1..]).for_each(|(force, pull)| *force += *pull);
    column[upper.0.clone()].iter_mut().zip(&pulls[upper.1..]).for_each(|(force, pull)| *force -= *pull);
}
