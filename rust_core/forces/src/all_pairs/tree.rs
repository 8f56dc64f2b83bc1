//! Tree of a sum over all pairs: a quadtree or octree of the sources. It is walked by groups of targets that are consecutive in
//! Hilbert order.
//!
//! A cell is accepted as a whole, by its expansion about its center, if s < θ d and all of its bodies are nearer to the center
//! than d. Here s is the side of a cube about the center that contains the bodies. The distance of the center from the bounding
//! box of the group is d. Otherwise the parts of the cell are tested, down to bodies.
//!
//! For a cell with more charge m than an average leaf, m₀, θ is smaller by the factor (m₀/m)^(1/15), which balances errors. With
//! one angle for all cells, the errors of the few large cells would dominate. Cells are stored depth first, each with the number
//! of cells in its subtree, so that a walk is one loop.
//!
//! Sources: J. Barnes, P. Hut, Nature 324 (1986) 446; for groups J. E. Barnes, J. Comput. Phys. 87 (1990) 161; for the bound by
//! the bodies J. K. Salmon, M. S. Warren, J. Comput. Phys. 111 (1994) 136; for angles that depend on the mass, θ⁵ ∝ m^(−1/3), W.
//! Dehnen, J. Comput. Phys. 179 (2002) 27.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use glam::DVec3;

use super::expansion::{CellLaw, Expansion, Moments};
use super::hilbert::HilbertOrder;
use super::sums::{self, BLOCK, SourceLaw, TargetSums};
use crate::math::{AXES, Real};
use crate::parallel::{BlockedSlice, Executor};
use crate::simd::{ParticleRecord, WORDS};

/// Maximum number of bodies in a leaf, except for bodies with the same key.
const LEAF: usize = 32;

/// Maximum number of bodies in a branch, which one thread builds.
const BRANCH: usize = 4096;

/// Groups of targets per block of work.
const GROUPS: usize = 8;

/// Exponent of a cell's charge in its opening angle.
const EXPONENT: f64 = -1.0 / 15.0;

/// Factor that exceeds the relative rounding error of a radius.
const ROUNDING: f64 = 1.0 + 1e-9;

/// Cell of bodies that are consecutive in Hilbert order.
#[derive(Debug, Clone)]
struct Cell {
    /// Center of the expansion.
    center: DVec3,
    /// Squared distance from the center beyond which the cell is accepted as a whole.
    reach: f64,
    bodies: Range<u32>,
    /// Number of cells in the subtree, this cell included.
    cells: u32,
}

/// Tree of a set of sources.
pub struct Tree<T, const CELL: usize> {
    order: HilbertOrder,
    /// Sources in Hilbert order.
    bodies: Vec<ParticleRecord<T>>,
    cells: Vec<Cell>,
    /// Record of each cell as a source.
    words: Vec<[T; CELL]>,
}

impl<T: Real, const CELL: usize> Tree<T, CELL> {
    /// Builds the tree of `count` sources for a law, with the opening angle θ.
    pub fn new<L: CellLaw<T, CELL, SUMS>, const SUMS: usize>(
        _law: L,
        count: usize,
        source: &(impl Fn(usize) -> ParticleRecord<T> + Sync),
        dimension: usize,
        angle: f64,
        executor: &Executor,
    ) -> Self {
        let order = HilbertOrder::new(count, dimension, &|index| from(DVec3::ZERO, &place(&source(index))), executor);
        let mut bodies = vec![[T::ZERO; WORDS]; count];
        let mut weights = vec![0.0; count.div_ceil(BRANCH)];
        let slots = (BlockedSlice::new(&mut bodies, BRANCH), BlockedSlice::new(&mut weights, 1));
        executor.for_each_block(slots, &|(mine, weight)| {
            for (body, key) in mine.items.iter_mut().zip(&order.keys[mine.start..]) {
                *body = source(key.1 as usize);
            }
            weight.items[0] = mine.items.iter().map(|body| body[AXES].to_f64().abs()).sum();
        });
        let builder = Builder { order: &order, bodies: &bodies, angle, weight: weights.iter().sum() };
        let Branch { cells, words, .. } = builder.build::<L::Moments, CELL>(executor);
        Self { order, bodies, cells, words }
    }

    /// Sums over all sources for the sources as targets, of one law for bodies and one for cells.
    pub fn mutual_sums<const SUMS: usize>(
        &self,
        near: impl SourceLaw<T, WORDS, SUMS>,
        far: impl SourceLaw<T, CELL, SUMS>,
        dimension: usize,
        executor: &Executor,
    ) -> TargetSums<SUMS> {
        self.sums(near, far, &self.order, |slot| place(&self.bodies[slot]), dimension, executor)
    }

    /// Sums over all sources for `count` targets at other positions.
    pub fn sums_at<const SUMS: usize>(
        &self,
        near: impl SourceLaw<T, WORDS, SUMS>,
        far: impl SourceLaw<T, CELL, SUMS>,
        count: usize,
        target: &(impl Fn(usize) -> [T; AXES] + Sync),
        dimension: usize,
        executor: &Executor,
    ) -> TargetSums<SUMS> {
        let order = HilbertOrder::new(count, dimension, &|index| from(DVec3::ZERO, &target(index)), executor);
        self.sums(near, far, &order, |slot| target(order.keys[slot].1 as usize), dimension, executor)
    }

    /// Sums over all sources for targets in a given order, along which `target` returns their positions.
    fn sums<const SUMS: usize>(
        &self,
        near: impl SourceLaw<T, WORDS, SUMS>,
        far: impl SourceLaw<T, CELL, SUMS>,
        order: &HilbertOrder,
        target: impl Fn(usize) -> [T; AXES] + Sync,
        dimension: usize,
        executor: &Executor,
    ) -> TargetSums<SUMS> {
        let interactions = AtomicUsize::new(0);
        let mut values = vec![[0.0; SUMS]; order.keys.len()];
        executor.for_each_block(BlockedSlice::new(&mut values, GROUPS * BLOCK), &|mine| {
            let (mut lists, mut group, mut relative) = ((Vec::new(), Vec::new()), Vec::new(), Vec::new());
            for (first, sums) in (mine.start..).step_by(BLOCK).zip(mine.items.chunks_mut(BLOCK)) {
                group.clear();
                group.extend((first..first + sums.len()).map(&target));
                let middle = self.list(&group, &mut lists);
                relative.clear();
                relative.extend(group.iter().map(|place| from(middle, place).to_array().map(T::from_f64)));
                let (cells, bodies) = &lists;
                sums::add(dimension, near, &group, bodies, sums);
                sums::add(dimension, far, &relative, cells, sums);
                interactions.fetch_add(group.len() * (cells.len() + bodies.len()), Ordering::Relaxed);
            }
        });
        let slots = order.slots();
        let results = size_of_val(values.as_slice()) + size_of_val(slots.as_slice());
        TargetSums { bytes: self.bytes() + results, values, slots, interactions: interactions.into_inner() }
    }

    /// Memory [bytes].
    fn bytes(&self) -> usize {
        let sources = size_of_val(self.order.keys.as_slice()) + size_of_val(self.bodies.as_slice());
        sources + size_of_val(self.cells.as_slice()) + size_of_val(self.words.as_slice())
    }

    /// Lists the sources of a group of targets: accepted cells, and bodies. Returns the middle of the group, to which the
    /// positions of cells are relative, because f32 may not resolve small cells at large coordinates.
    fn list(&self, group: &[[T; AXES]], (cells, bodies): &mut (Vec<[T; CELL]>, Vec<ParticleRecord<T>>)) -> DVec3 {
        let places = || group.iter().map(|place| from(DVec3::ZERO, place));
        let low = places().fold(DVec3::INFINITY, DVec3::min);
        let high = places().fold(DVec3::NEG_INFINITY, DVec3::max);
        let middle = 0.5 * (low + high);
        cells.clear();
        bodies.clear();
        let mut next = 0;
        while let Some(cell) = self.cells.get(next) {
            let gap = (low - cell.center).max(cell.center - high).max(DVec3::ZERO);
            if cell.reach < gap.length_squared() {
                let mut words = self.words[next];
                words[..AXES].copy_from_slice(&(cell.center - middle).to_array().map(T::from_f64));
                cells.push(words);
                next += cell.cells as usize;
            } else {
                if cell.cells == 1 {
                    bodies.extend_from_slice(&self.bodies[cell.bodies.start as usize..cell.bodies.end as usize]);
                }
                next += 1;
            }
        }
        middle
    }
}

/// Position of a body.
fn place<T: Copy>(body: &ParticleRecord<T>) -> [T; AXES] {
    [body[0], body[1], body[2]]
}

/// Offset of a position from an origin.
fn from<T: Real>(origin: DVec3, place: &[T; AXES]) -> DVec3 {
    DVec3::from_array(place.map(Real::to_f64)) - origin
}

/// Inputs of a tree.
struct Builder<'a, T> {
    order: &'a HilbertOrder,
    bodies: &'a [ParticleRecord<T>],
    angle: f64,
    /// Sum of the magnitudes of all charges.
    weight: f64,
}

/// Cells in depth-first order, of a branch or of the whole tree.
struct Branch<T, M, const CELL: usize> {
    cells: Vec<Cell>,
    words: Vec<[T; CELL]>,
    /// Expansions of the complete cells that are not yet part of another cell.
    expansions: Vec<Expansion<M>>,
}

impl<T: Real> Builder<'_, T> {
    /// Builds all cells. One thread finds the branches, all threads build their cells, and one thread joins them.
    fn build<M: Moments<T, CELL>, const CELL: usize>(&self, executor: &Executor) -> Branch<T, M, CELL> {
        let all = 0..self.bodies.len();
        let mut branches = Vec::new();
        self.grow(all.clone(), BRANCH, &mut Branch::<T, M, CELL>::default(), &mut |range, cells| {
            branches.push((range, Branch::default()));
            cells.expansions.push(Expansion::default());
        });
        executor.for_each_block(BlockedSlice::new(&mut branches, 1), &|mine| {
            for (range, cells) in mine.items {
                self.grow(range.clone(), LEAF, cells, &mut |range, cells| {
                    let expansion = Expansion::of_bodies(&self.bodies[range.clone()]);
                    let place = cells.begin(range);
                    self.complete(cells, place, expansion);
                });
            }
        });
        let (mut cells, mut built) = (Branch::default(), branches.into_iter());
        self.grow(all, BRANCH, &mut cells, &mut |_, cells| {
            if let Some((_, branch)) = built.next() {
                cells.cells.extend(branch.cells);
                cells.words.extend(branch.words);
                cells.expansions.extend(branch.expansions);
            }
        });
        cells
    }

    /// Appends the cells of a range. `finish` appends the parts with at most `most` bodies or one key.
    fn grow<M: Moments<T, CELL>, const CELL: usize>(
        &self,
        range: Range<usize>,
        most: usize,
        cells: &mut Branch<T, M, CELL>,
        finish: &mut impl FnMut(Range<usize>, &mut Branch<T, M, CELL>),
    ) {
        if range.is_empty() {
            return;
        }
        if range.len() <= most || self.order.have_one_key(&range) {
            return finish(range, cells);
        }
        let (place, first) = (cells.begin(range.clone()), cells.expansions.len());
        self.order.parts(range).for_each(|part| self.grow(part, most, cells, finish));
        let expansion = Expansion::of_parts(&cells.expansions[first..]);
        cells.expansions.truncate(first);
        self.complete(cells, place, expansion);
    }

    /// Completes the cell at `place`, whose parts follow it.
    fn complete<M: Moments<T, CELL>, const CELL: usize>(
        &self,
        cells: &mut Branch<T, M, CELL>,
        place: usize,
        expansion: Expansion<M>,
    ) {
        let count = cells.cells.len() - place;
        let cell = &mut cells.cells[place];
        let share = expansion.weight / self.weight * (self.bodies.len() as f64 / LEAF as f64);
        let angle = self.angle * libm::pow(share, EXPONENT).min(1.0);
        let reach = (2.0 * expansion.half_side / angle).max(expansion.radius) * ROUNDING;
        *cell = Cell { center: expansion.center, reach: reach * reach, bodies: cell.bodies.clone(), cells: count as u32 };
        cells.words[place] = expansion.moments.words();
        cells.expansions.push(expansion);
    }
}

impl<T: Real, M, const CELL: usize> Branch<T, M, CELL> {
    /// Appends an incomplete cell; returns its index.
    fn begin(&mut self, bodies: Range<usize>) -> usize {
        let bodies = bodies.start as u32..bodies.end as u32;
        self.cells.push(Cell { center: DVec3::ZERO, reach: f64::INFINITY, bodies, cells: 1 });
        self.words.push([T::ZERO; CELL]);
        self.cells.len() - 1
    }
}

impl<T, M, const CELL: usize> Default for Branch<T, M, CELL> {
    fn default() -> Self {
        Self { cells: Vec::new(), words: Vec::new(), expansions: Vec::new() }
    }
}
