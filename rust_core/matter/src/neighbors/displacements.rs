//! Displacements of particles since the last build of their lists. They determine how long the lists serve, and where near
//! neighbors suffice.
//!
//! A pair that is not listed was farther apart than cutoff + skin. It can come within the cutoff only if the displacements of its
//! particles differ by more than the skin. In a flow this takes far longer than for one of them to exceed half of the skin.
//!
//! Displacements are bounded in boxes and in length, over runs of slots in the same cell of a coarse grid. The boxes of each run
//! are compared with those of the cells around it. Particles in other cells are too far apart, up to a displacement of half of
//! the difference between cell size and cutoff.
//!
//! At walls the lists also serve for pairs of a particle and the mirror image of another, whose displacement is reflected
//! ([`Reflections`]).

use super::domain::Domain;
use super::grid::Bounds;
use super::lists::NEAR;
use super::{BLOCK, LANES, Positions};
use crate::math::AXES;
use crate::parallel::{BlockedSlice, Executor};
use crate::simd::{Isa, Kernel, dispatch};

/// Smallest size of a coarse cell, in units of the support.
const CELL: f64 = 1.5;

/// Ratio of consecutive cell sizes that are tried.
const GROWTH: f64 = 1.25;

/// Margin of near neighbors for the rounding of distances, in units of the cutoff; single precision has 1e-7.
const MARGIN: f64 = 1e-6;

/// Minimum number of particles per coarse cell.
const OCCUPANCY: usize = 8;

/// Reflections of displacements that the lists must serve.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Reflections {
    /// Whether the component along each axis changes sign.
    pub axes: [bool; AXES],
    /// Whether displacements are reflected in any direction.
    pub any: bool,
}

impl Reflections {
    /// Union of the reflections of both.
    #[must_use]
    #[inline]
    pub fn with(self, other: Self) -> Self {
        Self { axes: std::array::from_fn(|axis| self.axes[axis] | other.axes[axis]), any: self.any | other.any }
    }

    /// Extent of displacements together with their reflections.
    fn of(self, extent: &Extent) -> Extent {
        let Extent { mut bounds, length } = *extent;
        for axis in 0..AXES {
            if self.any || self.axes[axis] {
                let most = if self.any { length } else { bounds.high[axis].max(-bounds.low[axis]) };
                (bounds.low[axis], bounds.high[axis]) = (-most, most);
            }
        }
        Extent { bounds, length }
    }
}

/// Extent of a set of displacements: their box, and the largest length [m].
#[derive(Debug, Clone, Copy)]
struct Extent {
    bounds: Bounds,
    length: f64,
}

impl Extent {
    /// Extent of no displacements.
    const EMPTY: Self = Self { bounds: Bounds::EMPTY, length: 0.0 };

    /// Extent of both sets.
    fn with(self, other: &Self) -> Self {
        Self { bounds: self.bounds.with(&other.bounds), length: self.length.max(other.length) }
    }

    /// Upper bound of the difference between a displacement of each set [m].
    fn difference(&self, other: &Self) -> f64 {
        let (one, two) = (&self.bounds, &other.bounds);
        let along = |axis: usize| (one.high[axis] - two.low[axis]).max(two.high[axis] - one.low[axis]);
        let across = (0..AXES).map(|axis| along(axis).powi(2)).sum::<f64>().sqrt();
        // The first bound is smaller for particles that move together, the second for particles that move independently.
        across.min(self.length + other.length)
    }
}

/// Consecutive slots of a block in the same coarse cell.
#[derive(Debug, Clone, Copy)]
struct SlotRun {
    /// End of the slots.
    end: u32,
    cell: u32,
    reflections: Reflections,
    displacements: Extent,
    /// Largest difference from the displacement of a neighbor [m].
    difference: f64,
}

/// Displacements since the last build.
#[derive(Debug)]
pub struct Displacements {
    cutoff: f64,
    skin: f64,
    /// Number of coarse cells along each axis, and whether the last one is adjacent to the first.
    cells: [usize; AXES],
    periodic: [bool; AXES],
    /// Size of a cell [m].
    size: f64,
    /// Runs of each block of slots.
    runs: Vec<Vec<SlotRun>>,
    /// Displacements in each cell; displacements in the cells around each cell, along the axes so far; and a copy during their
    /// computation.
    of_cells: Vec<Extent>,
    around: Vec<Extent>,
    copy: Vec<Extent>,
}

impl Displacements {
    /// Displacements of `count` particles, whose lists reach up to cutoff + skin [m].
    pub fn new(count: usize, cutoff: f64, skin: f64) -> Self {
        Self {
            cutoff,
            skin,
            cells: [1; AXES],
            periodic: [false; AXES],
            size: 0.0,
            runs: vec![Vec::new(); count.div_ceil(BLOCK)],
            of_cells: Vec::new(),
            around: Vec::new(),
            copy: Vec::new(),
        }
    }

    /// Memory [bytes].
    #[inline]
    pub fn bytes(&self) -> usize {
        let boxes = self.of_cells.capacity() + self.around.capacity() + self.copy.capacity();
        boxes * size_of::<Extent>() + self.runs.iter().map(|runs| runs.capacity() * size_of::<SlotRun>()).sum::<usize>()
    }

    /// Largest displacement with which lists may serve [m].
    #[inline]
    pub fn largest(&self) -> f64 {
        (0.5 * (self.size - self.cutoff)).max(0.0)
    }

    /// Starts the record of displacements for lists that were built at the positions `sorted`, by slot, in these boxes.
    pub fn begin(
        &mut self,
        sorted: &[Vec<f64>; AXES],
        dimension: usize,
        domain: &Domain,
        bounds: &[Bounds],
        executor: &Executor,
    ) {
        if self.skin == 0.0 {
            return;
        }
        let bounds = bounds.iter().fold(Bounds::EMPTY, Bounds::with);
        let (mut low, mut inverse) = ([0.0; AXES], [0.0; AXES]);
        self.size = CELL * (self.cutoff + self.skin);
        let count = sorted[0].len() - LANES;
        loop {
            self.cells = [1; AXES];
            for axis in 0..dimension {
                let (first, length, around) = match domain.period[axis] {
                    Some((lower, upper)) => (lower, upper - lower, 0.0),
                    None => (bounds.low[axis], bounds.high[axis] - bounds.low[axis], 1.0),
                };
                let cells = ((length / self.size).floor() + around).max(1.0);
                self.cells[axis] = cells.min(1e9) as usize;
                (low[axis], inverse[axis]) = (first, if around > 0.0 { 1.0 / self.size } else { cells / length });
                self.periodic[axis] = around == 0.0;
            }
            if self.cells.iter().map(|&cells| cells as f64).product::<f64>() <= most_cells(count) as f64 {
                break;
            }
            self.size *= GROWTH;
        }
        for boxes in [&mut self.of_cells, &mut self.around, &mut self.copy] {
            boxes.clear();
            boxes.reserve(self.cells.iter().product());
        }
        let (cells, periodic) = (self.cells, self.periodic);
        let along = |axis: usize, coordinate: f64| {
            let cell = ((coordinate - low[axis]) * inverse[axis]).floor();
            let number = cells[axis] as f64;
            // Particles that are not finite may be in any cell, because their displacement is not finite either.
            (if periodic[axis] { cell - number * (cell / number).floor() } else { cell.min(number - 1.0) }) as usize
        };
        let cell = |slot: usize| {
            let along = |axis: usize| if axis < dimension { along(axis, sorted[axis][slot]).min(cells[axis] - 1) } else { 0 };
            (along(2) * cells[1] + along(1)) * cells[0] + along(0)
        };
        executor.for_each_block(BlockedSlice::new(&mut self.runs, 1), &|runs| {
            let slots = runs.start * BLOCK..((runs.start + 1) * BLOCK).min(count);
            let runs = &mut runs.items[0];
            runs.clear();
            for slot in slots {
                let (cell, end) = (cell(slot) as u32, slot as u32 + 1);
                match runs.last_mut() {
                    Some(run) if run.cell == cell => run.end = end,
                    _ => {
                        if runs.len() == runs.capacity() {
                            runs.reserve_exact(runs.len() / 8 + 16);
                        }
                        runs.push(SlotRun {
                            end,
                            cell,
                            reflections: Reflections::default(),
                            displacements: Extent::EMPTY,
                            difference: 0.0,
                        });
                    }
                }
            }
            // Spare capacity for a few more runs avoids allocations in the next builds.
            if runs.capacity() < runs.len() + runs.len() / 8 {
                runs.reserve_exact(runs.len() / 8);
            }
        });
    }

    /// Declares the reflections of each slot.
    pub fn reflect(&mut self, reflections: &(impl Fn(usize) -> Reflections + Sync), executor: &Executor) {
        executor.for_each_block(BlockedSlice::new(&mut self.runs, 1), &|runs| {
            let mut start = runs.start * BLOCK;
            for run in &mut runs.items[0] {
                run.reflections = (start..run.end as usize).map(reflections).fold(Reflections::default(), Reflections::with);
                start = run.end as usize;
            }
        });
    }

    /// Runs of slots of a block, each with its end, and whether all neighbors within the cutoff are near. Valid after
    /// [`Displacements::exceed`].
    #[inline]
    pub fn are_near(&self, block: usize) -> impl Iterator<Item = (usize, bool)> {
        let most = NEAR * self.skin - MARGIN * self.cutoff;
        self.runs[block].iter().map(move |run| (run.end as usize, run.difference <= most))
    }

    /// Whether displacements of neighboring particles differ by more than the skin, or are not finite. The lists were built at
    /// the positions `sorted` by slot; `positions` are by particle. Returns true on an interrupt.
    pub fn exceed(&mut self, positions: Positions<'_>, order: &[u32], sorted: &[Vec<f64>; AXES], executor: &Executor) -> bool {
        executor.for_each_block(BlockedSlice::new(&mut self.runs, 1), &|runs| {
            let start = runs.start * BLOCK;
            dispatch(Measure { runs: &mut runs.items[0], start, positions, order, sorted });
        });
        if executor.stopped() {
            return true;
        }
        let largest = self.largest();
        let Self { runs, of_cells, around, copy, cells, periodic, .. } = self;
        of_cells.clear();
        of_cells.resize(cells.iter().product(), Extent::EMPTY);
        let mut all = Extent::EMPTY;
        for run in runs.iter().flatten() {
            let displacements = run.reflections.of(&run.displacements);
            let of_cell = &mut of_cells[run.cell as usize];
            *of_cell = of_cell.with(&displacements);
            all = all.with(&displacements);
        }
        // This limit also holds if all particles move together. Walls and points that they approach are searched up to this
        // displacement.
        if all.length > largest {
            return true;
        }
        around.clone_from(of_cells);
        let mut stride = 1;
        for axis in 0..AXES {
            if cells[axis] > 1 {
                copy.clone_from(around);
                widen(around, copy, cells[axis], stride, periodic[axis]);
            }
            stride *= cells[axis];
        }
        let mut greatest = 0.0_f64;
        for run in runs.iter_mut().flatten() {
            run.difference = run.reflections.of(&run.displacements).difference(&around[run.cell as usize]);
            greatest = greatest.max(run.difference);
        }
        greatest > self.skin
    }
}

/// Maximum number of coarse cells.
fn most_cells(count: usize) -> usize {
    (count / OCCUPANCY).max(64)
}

/// Adds the extents in both adjacent cells along an axis to that in each cell.
fn widen(around: &mut [Extent], of: &[Extent], cells: usize, stride: usize, periodic: bool) {
    for (index, extent) in around.iter_mut().enumerate() {
        let along = index / stride % cells;
        if along + 1 < cells {
            *extent = extent.with(&of[index + stride]);
        } else if periodic {
            *extent = extent.with(&of[index - along * stride]);
        }
        if along > 0 {
            *extent = extent.with(&of[index - stride]);
        } else if periodic {
            *extent = extent.with(&of[index + (cells - 1) * stride]);
        }
    }
}

/// Kernel for the displacements of the runs of one block.
struct Measure<'a> {
    runs: &'a mut [SlotRun],
    start: usize,
    positions: Positions<'a>,
    order: &'a [u32],
    sorted: &'a [Vec<f64>; AXES],
}

impl Kernel for Measure<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Isa>(self, _isa: S) {
        if self.positions.dimension == 2 { self.measure::<2>() } else { self.measure::<3>() }
    }
}

impl Measure<'_> {
    #[inline(always)]
    fn measure<const DIMENSION: usize>(self) {
        let Self { runs, mut start, positions, order, sorted } = self;
        for run in runs {
            let slots = start..run.end as usize;
            start = slots.end;
            let (mut low, mut high) = ([f64::INFINITY; DIMENSION], [f64::NEG_INFINITY; DIMENSION]);
            let (mut most, mut zero) = (0.0, 0.0);
            for slot in slots {
                let (particle, mut square) = (order[slot] as usize, 0.0);
                for axis in 0..DIMENSION {
                    let displacement = positions.axes[axis][particle] - sorted[axis][slot];
                    low[axis] = if displacement < low[axis] { displacement } else { low[axis] };
                    high[axis] = if displacement > high[axis] { displacement } else { high[axis] };
                    square += displacement * displacement;
                }
                most = if square > most { square } else { most };
                zero += square * 0.0;
            }
            let mut bounds = Bounds { low: [0.0; AXES], high: [0.0; AXES] };
            bounds.low[..DIMENSION].copy_from_slice(&low);
            bounds.high[..DIMENSION].copy_from_slice(&high);
            run.displacements = Extent { bounds, length: most.sqrt() };
            // The product of 0 and a non-finite number is NaN.
            if zero != 0.0 {
                let bounds = Bounds { low: [f64::NEG_INFINITY; AXES], high: [f64::INFINITY; AXES] };
                run.displacements = Extent { bounds, length: f64::INFINITY };
            }
        }
    }
}
