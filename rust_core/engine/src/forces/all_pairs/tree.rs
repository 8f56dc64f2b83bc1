//! The tree of a sum over all pairs: a quadtree or octree of the sources, and its walk by groups of targets that follow each
//! other in Hilbert order.
//!
//! A cell is taken whole, by its expansion about its center, if s < θ d, with the side s of a cube about the center that
//! contains its bodies, and the distance d of the center from the bounding box of the group, and if all of the bodies are
//! nearer to the center than d; else its parts are, down to bodies. For a cell with more charge m than an average leaf, m₀, θ
//! is smaller by the factor (m₀/m)^(1/15), which balances errors: with one angle for all cells, those of the large ones would
//! dominate, although they are few. Cells are stored depth first, each with the number of cells in its subtree, so that a
//! walk is one loop.
//!
//! Sources: J. Barnes, P. Hut, Nature 324 (1986) 446; groups: J. E. Barnes, J. Comput. Phys. 87 (1990) 161; the bound by the
//! bodies: J. K. Salmon, M. S. Warren, J. Comput. Phys. 111 (1994) 136; angles that depend on the mass, θ⁵ ∝ m^(−1/3): W. Dehnen,
//! J. Comput. Phys. 179 (2002) 27.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use glam::DVec3;

use super::expansion::{CellLaw, Expansion, Moments};
use super::hilbert::HilbertOrder;
use super::sums::{self, BLOCK, SourceLaw, Sums};
use crate::math::{AXES, Real};
use crate::parallel::{BlockedSlice, Executor};
use crate::simd::{Record, WORDS};

/// Most bodies of a leaf, unless they have one key.
const LEAF: usize = 32;

/// Most bodies of a branch, which one thread builds.
const BRANCH: usize = 4096;

/// Groups of targets per block of work.
const GROUPS: usize = 8;

/// The exponent of a cell's charge in its opening angle.
const EXPONENT: f64 = -1.0 / 15.0;

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

impl<T: Real, const CELL: usize> Tree<T, CELL> {
    /// The tree of `count` sources for a law, with the opening angle θ.
    pub fn new<L: CellLaw<T, CELL, SUMS>, const SUMS: usize>(
        _law: L,
        count: usize,
        source: &(impl Fn(usize) -> Record<T> + Sync),
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

    /// The sums of a law for bodies and one for cells over all sources, for the sources as targets.
    pub fn mutual_sums<const SUMS: usize>(
        &self,
        near: impl SourceLaw<T, WORDS, SUMS>,
        far: impl SourceLaw<T, CELL, SUMS>,
        dimension: usize,
        executor: &Executor,
    ) -> Sums<SUMS> {
        self.sums(near, far, &self.order, |slot| place(&self.bodies[slot]), dimension, executor)
    }

    /// The same for `count` targets at other places.
    pub fn sums_at<const SUMS: usize>(
        &self,
        near: impl SourceLaw<T, WORDS, SUMS>,
        far: impl SourceLaw<T, CELL, SUMS>,
        count: usize,
        target: &(impl Fn(usize) -> [T; AXES] + Sync),
        dimension: usize,
        executor: &Executor,
    ) -> Sums<SUMS> {
        let order = HilbertOrder::new(count, dimension, &|index| from(DVec3::ZERO, &target(index)), executor);
        self.sums(near, far, &order, |slot| target(order.keys[slot].1 as usize), dimension, executor)
    }

    /// The same for targets in an order along which their places are `target`.
    fn sums<const SUMS: usize>(
        &self,
        near: impl SourceLaw<T, WORDS, SUMS>,
        far: impl SourceLaw<T, CELL, SUMS>,
        order: &HilbertOrder,
        target: impl Fn(usize) -> [T; AXES] + Sync,
        dimension: usize,
        executor: &Executor,
    ) -> Sums<SUMS> {
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
        Sums { bytes: self.bytes() + results, values, slots, interactions: interactions.into_inner() }
    }

    /// Memory [bytes].
    fn bytes(&self) -> usize {
        let sources = size_of_val(self.order.keys.as_slice()) + size_of_val(self.bodies.as_slice());
        sources + size_of_val(self.cells.as_slice()) + size_of_val(self.words.as_slice())
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

/// The place of a body.
fn place<T: Copy>(body: &Record<T>) -> [T; AXES] {
    [body[0], body[1], body[2]]
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
    /// The sum of the magnitudes of all charges.
    weight: f64,
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
        let share = expansion.weight / self.weight * (self.bodies.len() as f64 / LEAF as f64);
        let angle = self.angle * libm::pow(share, EXPONENT).min(1.0);
        let reach = (2.0 * expansion.half_side / angle).max(expansion.radius) * ROUNDING;
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
