//! Stencils: springs with the same law between particles with a constant index offset.
//!
//! A cloth, or a lattice, in row-major order consists of a few stencils with holes at its edges. Both ends are then read
//! contiguously. Each spring is computed once, as the [`SeparationFactors`](super::law::SeparationFactors) of its separation in
//! its force. Each particle then gathers the forces on it, stencil by stencil. Their sum therefore has the same bits for any
//! division into blocks.

use std::collections::BTreeMap;
use std::ops::Range;

use super::Spring;
use super::law::{SpringLaw, SpringRun};
use super::statistics::SpringStatistics;
use crate::math::{AXES, Real, Vector};
use crate::matter::EnergySink;
use crate::simd::{LANES, padded};
use crate::{Rates, StateView};

/// Particles per tile. All stencils visit a tile in turn, so that its sums stay in the first-level cache.
pub const TILE: usize = 16 * LANES;

/// Maximum number of particles per block, for which factors are kept. Large compared with the rows of a grid that reach into the
/// block.
pub const BLOCK: usize = 16 * TILE;

/// Sums over the stencils for the particles of a tile.
#[derive(Debug)]
pub struct StencilSums<T> {
    /// Force [N].
    force: [[T; TILE]; AXES],
    /// Force of the damping alone [N].
    damping: [[T; TILE]; AXES],
    /// Power dissipated in the springs whose lower ends are these particles [W].
    power: [T; TILE],
}

impl<T: Real> StencilSums<T> {
    /// Zero forces and powers.
    pub const ZERO: Self = Self { force: [[T::ZERO; TILE]; AXES], damping: [[T::ZERO; TILE]; AXES], power: [T::ZERO; TILE] };

    /// Sets the sums in use to zero.
    #[inline(always)]
    pub fn clear<V: Vector<Scalar = T>, const DAMPED: bool>(&mut self) {
        for axis in 0..V::DIMENSION {
            self.force[axis] = [T::ZERO; TILE];
            if DAMPED {
                self.damping[axis] = [T::ZERO; TILE];
            }
        }
        if DAMPED {
            self.power = [T::ZERO; TILE];
        }
    }

    /// Adds the sums to the rates of the particles of a block from `start` on.
    #[inline(always)]
    pub fn add_to<V: Vector<Scalar = T>, const DAMPED: bool>(&self, rates: &mut Rates<'_, V>, start: usize, length: usize) {
        for axis in 0..V::DIMENSION {
            add(&mut rates.force.axes[axis][start..start + length], &self.force[axis]);
            if let (true, Some(damping)) = (DAMPED, &mut rates.damping) {
                add(&mut damping.axes[axis][start..start + length], &self.damping[axis]);
            }
        }
        if DAMPED {
            let mut power = [T::ZERO; LANES];
            for group in self.power.as_chunks::<LANES>().0 {
                (0..LANES).for_each(|lane| power[lane] += group[lane]);
            }
            (0..LANES).for_each(|lane| rates.power[EnergySink::Damping as usize][lane] += power[lane].to_f64());
        }
    }
}

/// Adds numbers to a column. A closure might not be inlined into the code of a SIMD level.
#[inline(always)]
fn add<T: Real>(column: &mut [T], numbers: &[T; TILE]) {
    column.iter_mut().zip(numbers).for_each(|(sum, number)| *sum += *number);
}

/// Maximum number of stencils, because each has a cost per tile.
const MOST: usize = 32;

/// Smallest occupancy of a stencil's tiles, in percent. Sparser stencils cost less as slices.
const DENSITY: usize = 50;

/// Smallest share of all springs in stencils, in percent.
const STRUCTURE: usize = 50;

/// Springs (i, i + offset) with the same law.
#[derive(Debug)]
pub struct SpringStencil<T> {
    /// Difference of the indices.
    pub offset: usize,
    /// Common law.
    pub law: SpringLaw<T>,
    /// Number of springs.
    pub count: usize,
    /// Smallest lower end.
    first: usize,
    /// Whether each particle from the smallest to the largest lower end is one.
    present: Vec<bool>,
}

/// The stencils in a network, and whether each spring is in one of them.
pub fn find<T: Real>(springs: &[Spring]) -> (Vec<SpringStencil<T>>, Vec<bool>) {
    let mut kinds: BTreeMap<(u32, [u64; 3]), Vec<usize>> = BTreeMap::new();
    for (index, spring) in springs.iter().enumerate() {
        let [i, j] = spring.ends;
        kinds.entry((i.abs_diff(j), SpringLaw::<T>::of(spring).key())).or_default().push(index);
    }
    let mut found: Vec<(SpringStencil<T>, Vec<usize>)> =
        kinds.into_values().filter_map(|kind| SpringStencil::of(springs, &kind)).collect();
    found.sort_by_key(|(stencil, _)| std::cmp::Reverse(stencil.count));
    found.truncate(MOST);
    // In an unstructured network, a few stencils would only leave holes in the slices.
    if found.iter().map(|(stencil, _)| stencil.count).sum::<usize>() * 100 < springs.len() * STRUCTURE {
        found.clear();
    }
    let mut taken = vec![false; springs.len()];
    found.iter().flat_map(|(_, members)| members).for_each(|&index| taken[index] = true);
    (found.into_iter().map(|(stencil, _)| stencil).collect(), taken)
}

impl<T: Real> SpringStencil<T> {
    /// The stencil of springs of one kind, with its members; None if too sparse. A pair is in it at most once.
    fn of(springs: &[Spring], kind: &[usize]) -> Option<(Self, Vec<usize>)> {
        let lower = |index: usize| springs[index].ends[0].min(springs[index].ends[1]) as usize;
        let [i, j] = springs[kind[0]].ends;
        let first = kind.iter().map(|&index| lower(index)).min()?;
        let last = kind.iter().map(|&index| lower(index)).max()?;
        let mut present = vec![false; last + 1 - first];
        let members: Vec<usize> =
            kind.iter().copied().filter(|&index| !std::mem::replace(&mut present[lower(index) - first], true)).collect();
        let visited = present.chunks(TILE).filter(|tile| tile.contains(&true)).map(|tile| padded(tile.len())).sum::<usize>();
        let stencil =
            Self { offset: i.abs_diff(j) as usize, law: SpringLaw::of(&springs[kind[0]]), count: members.len(), first, present };
        (stencil.count * 100 >= DENSITY * visited).then_some((stencil, members))
    }

    /// Memory [bytes].
    #[inline]
    pub fn bytes(&self) -> usize {
        std::mem::size_of_val(self.present.as_slice())
    }

    /// The particles of a range between the smallest and the largest lower end.
    fn lower_ends(&self, range: &Range<usize>) -> Range<usize> {
        range.start.max(self.first)..range.end.min(self.first + self.present.len())
    }

    /// The particles of a range between the smallest and the largest upper end.
    fn upper_ends(&self, range: &Range<usize>) -> Range<usize> {
        range.start.max(self.first + self.offset)..range.end.min(self.first + self.present.len() + self.offset)
    }

    /// Calls `each` with the ends of every spring whose lower end is in a range.
    pub fn for_each(&self, range: Range<usize>, mut each: impl FnMut(usize, usize, &SpringLaw<T>)) {
        self.lower_ends(&range)
            .filter(|&index| self.present[index - self.first])
            .for_each(|index| each(index, index + self.offset, &self.law));
    }

    /// The smallest lower end of the springs that reach a block, rounded down so that tiles begin at whole groups of lanes.
    fn reach(&self, block: &Range<usize>) -> usize {
        block.start.saturating_sub(self.offset) / LANES * LANES
    }

    /// Length of the columns of factors for a block of `length` particles: two for each spring that reaches it.
    #[inline]
    pub fn factors(&self, length: usize) -> usize {
        2 * (padded(length + self.offset) + LANES)
    }

    /// Adds the forces on the particles of a tile, and the powers of the springs whose lower ends are in it. The tiles of a block
    /// must be visited in order, with the same factors.
    #[inline(always)]
    pub fn accumulate<V: Vector<Scalar = T>, const DAMPED: bool>(
        &self,
        (tile, block): (&Range<usize>, &Range<usize>),
        at: &StateView<'_, V>,
        factors: &mut [T],
        sums: &mut StencilSums<T>,
    ) {
        let first = self.reach(block);
        let (tension, drag) = factors.split_at_mut(factors.len() / 2);
        if tile.start == block.start {
            for start in (first..block.start).step_by(TILE) {
                let (before, place) = (start..block.start.min(start + TILE), start - first);
                self.compute::<V, DAMPED, false>(&before, at, &mut tension[place..], &mut drag[place..], &mut sums.power);
            }
        }
        let place = tile.start - first;
        self.compute::<V, DAMPED, true>(tile, at, &mut tension[place..], &mut drag[place..], &mut sums.power);
        let (lower, upper, factors) = (self.lower_ends(tile), self.upper_ends(tile), (&*tension, &*drag, first));
        self.gather::<V, DAMPED, true, false>(tile.start, lower.start..lower.end.min(upper.start), at, factors, sums);
        self.gather::<V, DAMPED, true, true>(tile.start, upper.start..lower.end, at, factors, sums);
        self.gather::<V, DAMPED, false, true>(tile.start, upper.start.max(lower.end)..upper.end, at, factors, sums);
    }

    /// Computes the factors of the springs whose lower ends are in a range, 0 where there is none. Adds their powers if
    /// `TALLIED`.
    #[inline(always)]
    fn compute<V: Vector<Scalar = T>, const DAMPED: bool, const TALLIED: bool>(
        &self,
        range: &Range<usize>,
        at: &StateView<'_, V>,
        tension: &mut [T],
        drag: &mut [T],
        power: &mut [T; TILE],
    ) {
        let ends = self.lower_ends(range);
        if ends.is_empty() {
            return;
        }
        let (law, length, place) = (self.law, ends.len(), ends.start - range.start);
        let (near, far) = (SpringRun::new(at, &ends), SpringRun::new(at, &(ends.start + self.offset..ends.end + self.offset)));
        let present = &self.present[ends.start - self.first..][..length];
        let (tension, drag) = (&mut tension[place..][..length], &mut drag[place..][..length]);
        if !present.contains(&true) {
            tension.fill(T::ZERO);
            drag.fill(T::ZERO);
            return;
        }
        let power = &mut power[place..][..length];
        for index in 0..length {
            let factors = law.factors::<V, DAMPED>(near.get::<V, DAMPED>(index), far.get::<V, DAMPED>(index));
            tension[index] = if present[index] { factors.tension } else { T::ZERO };
            if DAMPED {
                drag[index] = if present[index] { factors.drag } else { T::ZERO };
            }
            if DAMPED && TALLIED {
                power[index] += if present[index] { factors.power } else { T::ZERO };
            }
        }
    }

    /// Adds the forces on a range of particles of a tile, all of which may be lower ends, upper ends, or both. The factors begin
    /// with those of the lower end `first`.
    #[inline(always)]
    fn gather<V: Vector<Scalar = T>, const DAMPED: bool, const LOWER: bool, const UPPER: bool>(
        &self,
        start: usize,
        range: Range<usize>,
        at: &StateView<'_, V>,
        (tension, drag, first): (&[T], &[T], usize),
        sums: &mut StencilSums<T>,
    ) {
        if range.is_empty() {
            return;
        }
        let (length, place) = (range.len(), range.start - start);
        let far = if LOWER { range.start + self.offset } else { range.start };
        let near = if UPPER { range.start - self.offset } else { range.start };
        let is_empty = |ends: usize| !self.present[ends - self.first..][..length].contains(&true);
        if (!LOWER || is_empty(range.start)) && (!UPPER || is_empty(near)) {
            return;
        }
        let up = (&tension[range.start - first..][..length], &drag[range.start - first..][..length]);
        let down = (&tension[near - first..][..length], &drag[near - first..][..length]);
        for axis in 0..V::DIMENSION {
            let own = at.position.slice(axis, range.clone());
            let (above, below) = (at.position.slice(axis, far..far + length), at.position.slice(axis, near..near + length));
            let force = &mut sums.force[axis][place..][..length];
            let damping = &mut sums.damping[axis][place..][..length];
            for index in 0..length {
                let (to, from) = (above[index] - own[index], own[index] - below[index]);
                let pull = |(up, down): (T, T)| match (LOWER, UPPER) {
                    (true, true) => up * to - down * from,
                    (true, false) => up * to,
                    _ => T::ZERO - down * from,
                };
                force[index] += pull((up.0[index], down.0[index]));
                if DAMPED {
                    damping[index] += pull((up.1[index], down.1[index]));
                }
            }
        }
    }

    /// Adds the springs with a lower end in a range to statistics.
    #[inline(always)]
    pub fn measure<V: Vector<Scalar = T>>(&self, block: &Range<usize>, at: &StateView<'_, V>, statistics: &mut SpringStatistics) {
        let block = self.lower_ends(block);
        let mut square = [0.0; TILE];
        for start in block.clone().step_by(TILE) {
            let range = start..block.end.min(start + TILE);
            let (near, far) =
                (SpringRun::new(at, &range), SpringRun::new(at, &(range.start + self.offset..range.end + self.offset)));
            let square = &mut square[..range.len()];
            for index in 0..range.len() {
                square[index] = near.get::<V, false>(index).square_to::<V>(far.get::<V, false>(index));
            }
            let groups = self.present[start - self.first..].chunks(LANES).zip(square.chunks(LANES));
            for (present, square) in groups {
                for (lane, (&present, &square)) in present.iter().zip(square).enumerate() {
                    statistics.add(lane, present, square, self.law);
                }
            }
        }
    }
}
