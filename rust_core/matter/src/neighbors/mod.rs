//! Neighbor lists (Verlet lists): for every particle, all others within a cutoff and a skin.
//!
//! The particles are sorted by cell ([`Sort`], over the table of [`BucketGrid`]). Lists are built from the runs of candidates
//! around each particle ([`Lists`]). With a skin, they serve until the displacements of two neighboring particles differ by
//! more than the skin ([`displacements`]). A *slot* is a particle's index in the sorted order. Lists hold slots, and so do pair
//! sums ([`sums`]), so that their reads are local. Lists and their order depend on the positions alone, and are the same for
//! any number of threads.
//!
//! **Exactness.** A pair is listed if its distance, computed in f64, is at most cutoff + skin. A cell is larger than that by
//! 1e-6. Positions are rejected where f64 numbers are further apart than 1e-7 cutoffs. The error of a cell number is then 2e-7,
//! so that a listed pair is always in neighboring cells.

mod brute;
mod displacements;
mod domain;
mod grid;
mod lists;
mod neighbor_list;
mod ordering;
mod sort;
pub mod sums;

pub use brute::brute;
pub use domain::Domain;
pub use lists::List;
pub use neighbor_list::NeighborList;
pub use ordering::ordering;

use std::ops::Range;

use glam::DVec3;

use crate::adjacency::Adjacency;
use crate::error::{Error, Result};
use crate::math::{AXES, Coordinate};
use crate::parallel::{BlockedSlice, Executor};
use crate::simd::{LANES, Selection};
use displacements::Displacements;
pub use displacements::Reflections;
use domain::{check_lengths, check_spacing};
pub use grid::Bounds;
use grid::BucketGrid;
use lists::{Candidates, Ends, ListSegment, Lists, NEAR};
use sort::Sort;

/// Number of slots in a block of lists and sums.
pub(crate) const BLOCK: usize = 1024;

/// Metric of distances.
#[derive(Debug, Clone, Copy)]
struct Metric {
    encodings: [<f64 as Coordinate>::Encoding; AXES],
    periodic: bool,
    /// Squares of the largest listed distance, and of the largest distance of near neighbors [m²].
    square: f64,
    near_square: f64,
}

/// Positions of all particles.
#[derive(Debug, Clone, Copy)]
struct Positions<'a> {
    axes: [&'a [f64]; AXES],
    dimension: usize,
}

impl Positions<'_> {
    /// Position of one particle; 0 along an axis past the dimension.
    #[inline(always)]
    fn get(&self, particle: usize) -> [f64; AXES] {
        std::array::from_fn(|axis| if axis < self.dimension { self.axes[axis][particle] } else { 0.0 })
    }
}

/// Neighbors of every particle.
#[derive(Debug)]
pub struct Neighbors {
    count: usize,
    dimension: usize,
    domain: Domain,
    cutoff: f64,
    skin: f64,
    metric: Metric,
    grid: BucketGrid,
    sort: Sort,
    lists: Lists,
    /// Positions of the last build, by slot, with zeros as padding [m].
    sorted: [Vec<f64>; AXES],
    /// Bounding box of each block of particles.
    bounds: Vec<Bounds>,
    displacements: Displacements,
    /// Excluded pairs.
    excluded: Adjacency,
    /// Whether the lists are valid.
    built: bool,
}

impl Neighbors {
    /// Lists of `count` particles in a dimension, of pairs within `cutoff` [m], listed up to `skin` [m] further.
    ///
    /// # Errors
    /// If the numbers are out of range, or a periodic axis is so short that a particle would interact with two images of another.
    pub fn new(count: usize, dimension: usize, domain: &Domain, cutoff: f64, skin: f64) -> Result<Self> {
        check_lengths(cutoff, skin)?;
        if i32::try_from(count).is_err() {
            return Err(Error::parameter("particles", "fewer than 2³¹ of them", count));
        }
        let mut domain = *domain;
        domain.period[dimension..].fill(None);
        let support = cutoff + skin;
        domain.check(cutoff, support)?;
        let encodings = domain.lengths().map(|length| f64::encoding(length, support));
        let [square, near_square] = [skin, NEAR * skin].map(|skin| (cutoff + skin) * (cutoff + skin));
        let metric = Metric { encodings, periodic: domain.is_periodic(), square, near_square };
        Ok(Self {
            count,
            dimension,
            domain,
            cutoff,
            skin,
            metric,
            grid: BucketGrid::NONE,
            sort: Sort::new(count),
            lists: Lists::new(count),
            sorted: std::array::from_fn(|axis| vec![0.0; if axis < dimension { count + LANES } else { 0 }]),
            bounds: vec![Bounds::EMPTY; count.div_ceil(BLOCK)],
            displacements: Displacements::new(count, cutoff, skin),
            excluded: Adjacency::default(),
            built: false,
        })
    }

    /// Excludes pairs, given by the excluded neighbors of each particle.
    #[must_use]
    #[inline]
    pub fn excluding(self, excluded: Adjacency) -> Self {
        Self { excluded, ..self }
    }

    /// The excluded pairs.
    #[inline]
    pub fn excluded(&self) -> &Adjacency {
        &self.excluded
    }

    /// Rebuilds the lists if the displacements of neighboring particles since the last build differ by more than the skin.
    /// Returns whether it did. Positions [m] are not wrapped into the domain.
    ///
    /// # Errors
    /// If the rounding error of a distant position is not small compared with the cutoff, or the lists do not fit into memory.
    /// The lists are then invalid.
    pub fn update(&mut self, positions: [&[f64]; AXES], executor: &Executor) -> Result<bool> {
        let positions = Positions { axes: positions, dimension: self.dimension };
        if self.built && self.skin > 0.0 && !self.displacements.exceed(positions, &self.sort.order, &self.sorted, executor) {
            self.lists.serve(&self.displacements, executor);
            return Ok(false);
        }
        self.arrange(positions.axes, executor)?;
        let Self { grid, sort, sorted, metric, excluded, lists, .. } = self;
        lists.build(candidates(grid, (sort, sorted), metric, excluded), self.dimension, executor)?;
        self.displacements.begin(&self.sorted, self.dimension, &self.domain, &self.bounds, executor);
        self.lists.serve(&self.displacements, executor);
        // After an interrupt the lists are invalid.
        self.built = !executor.stopped();
        Ok(true)
    }

    /// Declares reflections of displacements after a build, by the position of a particle at the build [m]. The lists then also
    /// serve reflected displacements.
    pub fn reflect(&mut self, reflections: &(impl Fn([f64; AXES]) -> Reflections + Sync), executor: &Executor) {
        let Self { displacements, sorted, dimension, .. } = self;
        let point = |slot: usize| std::array::from_fn(|axis| if axis < *dimension { sorted[axis][slot] } else { 0.0 });
        displacements.reflect(&|slot| reflections(point(slot)), executor);
    }

    /// Largest displacement since the build with which lists may serve [m].
    #[inline]
    pub fn largest_displacement(&self) -> f64 {
        self.displacements.largest()
    }

    /// Bounding box of a block of [`BLOCK`] particles at the last build.
    #[inline]
    pub fn bounds(&self, block: usize) -> &Bounds {
        &self.bounds[block]
    }

    /// Lists the neighbors of some slots for a single use, after [`Neighbors::arrange`].
    #[inline]
    pub fn list_slots(&self, slots: Range<usize>, listed: &mut Listed, executor: &Executor) {
        listed.ends.clear();
        listed.ends.resize(slots.len(), Ends::default());
        let candidates = candidates(&self.grid, (&self.sort, &self.sorted), &self.metric, &self.excluded);
        lists::list(candidates, self.dimension, slots.start, &mut listed.ends, &mut listed.segment, executor);
    }

    /// An empty buffer for [`Neighbors::list_slots`].
    #[inline]
    pub fn listed(&self) -> Listed {
        Listed { ends: Vec::new(), segment: ListSegment::new(self.count) }
    }

    /// Rebuilds the lists at the positions `anchors`, so that all later sums have the same bits.
    ///
    /// # Errors
    /// As [`Neighbors::update`].
    #[inline]
    pub fn restore(&mut self, anchors: [&[f64]; AXES], executor: &Executor) -> Result<()> {
        self.built = false;
        self.update(anchors, executor).map(|_| ())
    }

    /// Particle index of each slot.
    #[inline]
    pub fn order(&self) -> &[u32] {
        &self.sort.order
    }

    /// Slot of each particle.
    #[inline]
    pub fn slots(&self) -> &[u32] {
        &self.sort.slots
    }

    /// Slots of the neighbors of the particle at a slot, always in the same order.
    #[inline]
    pub fn of(&self, slot: usize) -> &[u32] {
        self.lists.of(slot)
    }

    /// Neighbors of a slot that may be within the cutoff at the positions of the last update, for pair sums.
    #[inline(always)]
    pub fn list(&self, slot: usize) -> List<'_> {
        self.lists.at(slot)
    }

    /// Whether a far neighbor of a slot, or a mirror image of one, may be within the cutoff at the positions of the last update.
    /// A neighbor is far if it was farther than [`Neighbors::near`] at the last build.
    #[inline]
    pub fn needs_far(&self, slot: usize) -> bool {
        self.lists.needs_far(slot)
    }

    /// Largest distance of near neighbors [m].
    #[inline]
    pub fn near(&self) -> f64 {
        self.cutoff + NEAR * self.skin
    }

    /// An empty selection of slots, for pair sums over chosen neighbors.
    #[inline]
    pub fn selection(&self) -> Selection {
        Selection::new(self.count + LANES)
    }

    /// Separation vectors to the particle at a slot from all its neighbors, or their nearest images, at the last build [m].
    #[inline]
    pub fn separation(&self, slot: usize) -> impl Iterator<Item = DVec3> {
        let (own, encodings) = (self.anchor(slot), self.metric.encodings);
        self.of(slot).iter().map(move |&other| {
            let other = self.anchor(other as usize);
            DVec3::from_array(std::array::from_fn(|axis| f64::separation::<true, _>(own[axis], other[axis], encodings[axis])))
        })
    }

    /// Positions of all particles along an axis at the last build [m]; none past the dimension.
    #[inline]
    pub fn anchors(&self, axis: usize) -> impl Iterator<Item = f64> {
        let slots = if axis < self.dimension { self.slots() } else { &[] };
        slots.iter().map(move |&slot| self.sorted[axis][slot as usize])
    }

    /// Position of the particle at a slot at the last build [m].
    #[inline]
    pub fn anchor(&self, slot: usize) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|axis| self.sorted[axis].get(slot).copied().unwrap_or(0.0)))
    }

    /// Number of particles.
    #[inline]
    pub fn count(&self) -> usize {
        self.count
    }

    /// Number of dimensions.
    #[inline]
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// Domain of the particles.
    #[inline]
    pub fn domain(&self) -> &Domain {
        &self.domain
    }

    /// Support, cutoff plus skin: the largest listed distance [m].
    #[inline]
    pub fn support(&self) -> f64 {
        self.cutoff + self.skin
    }

    /// Memory [bytes].
    #[inline]
    pub fn bytes(&self) -> usize {
        self.sorted.iter().map(|axis| std::mem::size_of_val(axis.as_slice())).sum::<usize>()
            + std::mem::size_of_val(self.bounds.as_slice())
            + self.displacements.bytes()
            + self.sort.bytes()
            + self.lists.bytes()
            + self.excluded.bytes()
    }

    /// Sorts the particles at `positions` [m] into slots, for later list builds.
    ///
    /// # Errors
    /// If the rounding error of a distant position is not small compared with the cutoff.
    pub fn arrange(&mut self, positions: [&[f64]; AXES], executor: &Executor) -> Result<()> {
        self.built = false;
        let positions = Positions { axes: positions, dimension: self.dimension };
        let count = self.count;
        executor.for_each_block(BlockedSlice::new(&mut self.bounds, 1), &|bounds| {
            let particles = bounds.start * BLOCK..((bounds.start + 1) * BLOCK).min(count);
            bounds.items[0] = particles.map(|particle| positions.get(particle)).fold(Bounds::EMPTY, |bounds, point| {
                let there = point.iter().all(|coordinate| coordinate.is_finite());
                if there { bounds.with(&Bounds { low: point, high: point }) } else { bounds }
            });
        });
        let bounds = self.bounds.iter().fold(Bounds::EMPTY, Bounds::with);
        check_spacing(bounds.low.iter().chain(&bounds.high), self.cutoff)?;
        self.grid = BucketGrid::new(count, self.dimension, &self.domain.period, self.support(), &bounds);
        self.sort.sort(&self.grid, positions, executor);
        let order = &self.sort.order;
        for (sorted, axis) in self.sorted.iter_mut().zip(positions.axes).take(self.dimension) {
            executor.for_each_block(BlockedSlice::new(&mut sorted[..count], BLOCK), &|mine| {
                mine.items.iter_mut().zip(&order[mine.start..]).for_each(|(to, &particle)| *to = axis[particle as usize]);
            });
        }
        Ok(())
    }
}

/// Input of a list build.
fn candidates<'a>(
    grid: &'a BucketGrid,
    (sort, sorted): (&'a Sort, &'a [Vec<f64>; AXES]),
    metric: &'a Metric,
    excluded: &'a Adjacency,
) -> Candidates<'a> {
    Candidates { grid, starts: &sort.starts, columns: sorted.each_ref().map(Vec::as_slice), metric, order: &sort.order, excluded }
}

/// Neighbors of some slots, for a single use.
#[derive(Debug)]
pub struct Listed {
    ends: Vec<Ends>,
    segment: ListSegment,
}

impl Listed {
    /// Neighbors of each of the slots.
    #[inline]
    pub fn each(&self) -> impl Iterator<Item = &[u32]> {
        let ends = self.ends.iter().map(|ends| ends.all);
        [0].into_iter().chain(ends.clone()).zip(ends).map(|(start, end)| self.segment.list(start, end))
    }
}
