//! The tree of a sum over all pairs: a quadtree or octree of the sources, and its walk by groups of targets that follow each
//! other in Hilbert order.
//!
//! A cell is taken whole, by its expansion about its center, if s < θ d, with the side s of a cube about the center that
//! contains its bodies, and the distance d of the center from the bounding box of the group, and if all of the bodies are
//! nearer to the center than d; else its parts are, down to bodies. Cells are stored depth first, each with the number of cells
//! in its subtree, so that a walk is one loop.
//!
//! Sources: J. Barnes, P. Hut, Nature 324 (1986) 446; groups: J. E. Barnes, J. Comput. Phys. 87 (1990) 161; the bound by the
//! bodies: J. K. Salmon, M. S. Warren, J. Comput. Phys. 111 (1994) 136.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use glam::DVec3;

use super::expansion::{CellLaw, Expansion, Moments};
use super::hilbert::HilbertOrder;
use super::sums::{self, BLOCK, SourceLaw};
use crate::math::{AXES, Real};
use crate::parallel::{BlockedSlice, Executor};
use crate::simd::{Record, WORDS};

/// Most bodies of a leaf, unless they have one key.
const LEAF: usize = 16;

/// Most bodies of a branch, which one thread builds.
const BRANCH: usize = 4096;

/// Groups of targets per block of work.
const GROUPS: usize = 8;

/// The factor by which rounding can make a radius too small, and more.
const ROUNDING: f64 = 1.0 + 1e-9;

/// A cell: bodies that follow each other in Hilbert order.
#[derive(Debug, Clone)]
struct Cell {
    /// The center of its expansion.
    center: DVec3,
    /// Squared distance from the center beyond which it is taken whole.
    reach: f64,
    bodies: Range<u32>,
    /// The number of cells in its subtree, itself included.
    cells: u32,
}

/// The tree of some sources.
pub struct Tree<T, const CELL: usize> {
    order: HilbertOrder,
    /// The sources in Hilbert order.
    bodies: Vec<Record<T>>,
    cells: Vec<Cell>,
    /// The record of each cell as a source.
    words: Vec<[T; CELL]>,
}

/// Targets in Hilbert order.
pub struct Targets<T> {
    /// The place of each in this order.
    slots: Vec<u32>,
    /// Their positions, in it.
    positions: Vec<[T; AXES]>,
}

impl<T: Real> Targets<T> {
    /// The targets at these positions.
    pub fn new(positions: &[[T; AXES]], dimension: usize, executor: &Executor) -> Self {
        let place = |index: usize| DVec3::from_array(positions[index].map(Real::to_f64));
        let order = HilbertOrder::new(positions.len(), dimension, &place, executor);
        Self { slots: order.slots(), positions: order.keys.iter().map(|key| positions[key.1 as usize]).collect() }
    }
}

impl<T: Real, const CELL: usize> Tree<T, CELL> {
    /// The tree of `sources` for a law, with the opening angle θ.
    pub fn new<L: CellLaw<T, CELL, SUMS>, const SUMS: usize>(
        _law: L,
        sources: &[Record<T>],
        dimension: usize,
        angle: f64,
        executor: &Executor,
    ) -> Self {
        let place = |index: usize| DVec3::new(sources[index][0].to_f64(), sources[index][1].to_f64(), sources[index][2].to_f64());
        let order = HilbertOrder::new(sources.len(), dimension, &place, executor);
        let mut bodies = vec![[T::ZERO; WORDS]; sources.len()];
        executor.for_each_block(BlockedSlice::new(&mut bodies, BRANCH), &|mine| {
            for (body, key) in mine.items.iter_mut().zip(&order.keys[mine.start..]) {
                *body = sources[key.1 as usize];
            }
        });
        let builder = Builder { order: &order, bodies: &bodies, angle };
        let Branch { cells, words, .. } = builder.build::<L::Moments, CELL>(executor);
        Self { order, bodies, cells, words }
    }

    /// The sources as targets.
    pub fn targets(&self) -> Targets<T> {
        let positions = self.bodies.iter().map(|body| [body[0], body[1], body[2]]).collect();
        Targets { slots: self.order.slots(), positions }
    }

    /// The sums of a law for bodies and one for cells over all sources, for each target, and the number of interactions.
    pub fn sums<const SUMS: usize>(
        &self,
        near: impl SourceLaw<T, WORDS, SUMS>,
        far: impl SourceLaw<T, CELL, SUMS>,
        targets: &Targets<T>,
        dimension: usize,
        executor: &Executor,
    ) -> (Vec<[f64; SUMS]>, usize) {
        let interactions = AtomicUsize::new(0);
        let mut sorted = vec![[0.0; SUMS]; targets.positions.len()];
        executor.for_each_block(BlockedSlice::new(&mut sorted, GROUPS * BLOCK), &|mine| {
            let mut lists = (Vec::new(), Vec::new());
            let positions = &targets.positions[mine.start..][..mine.items.len()];
            for (group, sums) in positions.chunks(BLOCK).zip(mine.items.chunks_mut(BLOCK)) {
                let middle = self.list(group, &mut lists);
                let (cells, bodies) = &lists;
                let relative: Vec<_> = group.iter().map(|place| from(middle, place).to_array().map(T::from_f64)).collect();
                sums::add(dimension, near, group, bodies, sums);
                sums::add(dimension, far, &relative, cells, sums);
                interactions.fetch_add(group.len() * (cells.len() + bodies.len()), Ordering::Relaxed);
            }
        });
        let mut sums = vec![[0.0; SUMS]; sorted.len()];
        executor.for_each_block(BlockedSlice::new(&mut sums, BRANCH), &|mine| {
            for (sums, &slot) in mine.items.iter_mut().zip(&targets.slots[mine.start..]) {
                *sums = sorted[slot as usize];
            }
        });
        (sums, interactions.into_inner())
    }

    /// Lists the sources of a group of targets: cells that are taken whole, and bodies. The positions of cells are relative to
    /// the returned middle of the group, because f32 may not resolve small cells at large coordinates.
    fn list(&self, group: &[[T; AXES]], (cells, bodies): &mut (Vec<[T; CELL]>, Vec<Record<T>>)) -> DVec3 {
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

/// The offset of a place from an origin.
fn from<T: Real>(origin: DVec3, place: &[T; AXES]) -> DVec3 {
    DVec3::from_array(place.map(Real::to_f64)) - origin
}

/// The inputs of a tree.
struct Builder<'a, T> {
    order: &'a HilbertOrder,
    bodies: &'a [Record<T>],
    angle: f64,
}

/// Cells in depth-first order: a branch of the tree, or all of it.
struct Branch<T, M, const CELL: usize> {
    cells: Vec<Cell>,
    words: Vec<[T; CELL]>,
    /// The expansions of those that are complete, but not yet a part of another.
    expansions: Vec<Expansion<M>>,
}

impl<T: Real> Builder<'_, T> {
    /// All cells. One thread finds branches, all build their cells, and one joins these.
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

    /// Appends the cells of a range; those of its parts of at most `most` bodies or one key by `finish`.
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

    /// Completes the cell at `place`, whose parts are those after it.
    fn complete<M: Moments<T, CELL>, const CELL: usize>(
        &self,
        cells: &mut Branch<T, M, CELL>,
        place: usize,
        expansion: Expansion<M>,
    ) {
        let count = cells.cells.len() - place;
        let cell = &mut cells.cells[place];
        let reach = (2.0 * expansion.half_side / self.angle).max(expansion.radius) * ROUNDING;
        *cell = Cell { center: expansion.center, reach: reach * reach, bodies: cell.bodies.clone(), cells: count as u32 };
        cells.words[place] = expansion.moments.words();
        cells.expansions.push(expansion);
    }
}

impl<T: Real, M, const CELL: usize> Branch<T, M, CELL> {
    /// Appends an incomplete cell and returns its place.
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
