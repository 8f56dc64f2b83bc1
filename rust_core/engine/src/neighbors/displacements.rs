//! The displacements of particles since the last build of their lists, and how long the lists serve.
//!
//! A pair that is not listed was farther apart than cutoff + skin. It comes within the cutoff only if the displacements of
//! its particles differ by more than the skin, which in a flow takes far longer than for one of them to exceed half of it.
//! Displacements are bounded in boxes, over runs of slots in the same cell of a coarse grid; the boxes of each cell are
//! compared with those of the cells around it. Particles in other cells are too far from each other, up to a
//! displacement of half of the difference of cell size and cutoff.
//!
//! At walls the lists also serve for pairs of a particle and the mirror image of another, whose displacement is reflected
//! ([`Reflections`]).

use super::domain::Domain;
use super::grid::Bounds;
use super::{BLOCK, LANES, Positions};
use crate::math::AXES;
use crate::parallel::{BlockedSlice, Executor};
use crate::simd::{Kernel, dispatch};

/// Smallest size of a coarse cell, in units of the support.
const CELL: f64 = 1.5;

/// Factor between the sizes of cells that are tried.
const GROWTH: f64 = 1.25;

/// Particles per coarse cell, at least.
const OCCUPANCY: usize = 8;

/// Reflections of displacements that lists must serve for.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Reflections {
    /// Whether the component along each axis changes sign.
    pub axes: [bool; AXES],
    /// Whether they are reflected in any direction.
    pub any: bool,
}

impl Reflections {
    /// All of both.
    #[must_use]
    pub fn with(self, other: Self) -> Self {
        Self { axes: std::array::from_fn(|axis| self.axes[axis] | other.axes[axis]), any: self.any | other.any }
    }

    /// The box of displacements and their reflections.
    fn of(self, displacements: &Bounds) -> Bounds {
        let mut bounds = *displacements;
        let radius = if self.any { farthest(displacements) } else { 0.0 };
        for axis in 0..AXES {
            if self.any || self.axes[axis] {
                let most = bounds.high[axis].max(-bounds.low[axis]).max(radius);
                (bounds.low[axis], bounds.high[axis]) = (-most, most);
            }
        }
        bounds
    }
}

/// The largest length of a vector in a box.
fn farthest(bounds: &Bounds) -> f64 {
    (0..AXES).map(|axis| bounds.high[axis].max(-bounds.low[axis]).powi(2)).sum::<f64>().sqrt()
}

/// Consecutive slots of a block in the same coarse cell.
#[derive(Debug, Clone, Copy)]
struct Run {
    /// Their end.
    end: u32,
    cell: u32,
    reflections: Reflections,
    /// Their displacements [m].
    displacements: Bounds,
}

/// The displacements since the last build.
#[derive(Debug)]
pub struct Displacements {
    cutoff: f64,
    skin: f64,
    /// The number of coarse cells along each axis, and whether the last one is beside the first.
    cells: [usize; AXES],
    periodic: [bool; AXES],
    /// The size of a cell [m].
    size: f64,
    /// The runs of each block of slots.
    runs: Vec<Vec<Run>>,
    /// The displacements in each cell [m], in the cells around each along the axes so far, and a copy while that is computed.
    of_cells: Vec<Bounds>,
    around: Vec<Bounds>,
    copy: Vec<Bounds>,
}

impl Displacements {
    /// Those of `count` particles, whose lists reach up to cutoff + skin [m].
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
    pub fn bytes(&self) -> usize {
        let boxes = self.of_cells.capacity() + self.around.capacity() + self.copy.capacity();
        boxes * size_of::<Bounds>() + self.runs.iter().map(|runs| runs.capacity() * size_of::<Run>()).sum::<usize>()
    }

    /// The largest displacement with which lists may serve [m].
    pub fn largest(&self) -> f64 {
        (0.5 * (self.size - self.cutoff)).max(0.0)
    }

    /// Begins with lists that were built at the positions `sorted`, by slot, in these boxes.
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
            // What is not finite is in any cell: its displacement is neither.
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
                        runs.push(Run { end, cell, reflections: Reflections::default(), displacements: Bounds::EMPTY });
                    }
                }
            }
            // Room for a few more, so that the next builds need no allocation.
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

    /// Whether those of neighboring particles differ by more than the skin, or are not finite, at these positions by
    /// particle, of lists built at the positions `sorted` by slot.
    pub fn exceed(&mut self, positions: Positions<'_>, order: &[u32], sorted: &[Vec<f64>; AXES], executor: &Executor) -> bool {
        executor.for_each_block(BlockedSlice::new(&mut self.runs, 1), &|runs| {
            let start = runs.start * BLOCK;
            dispatch(Measure { runs: &mut runs.items[0], start, positions, order, sorted });
        });
        let largest = self.largest();
        let Self { runs, of_cells, around, copy, cells, periodic, .. } = self;
        of_cells.clear();
        of_cells.resize(cells.iter().product(), Bounds::EMPTY);
        let mut all = Bounds::EMPTY;
        for run in runs.iter().flatten() {
            let displacements = run.reflections.of(&run.displacements);
            let of_cell = &mut of_cells[run.cell as usize];
            *of_cell = of_cell.with(&displacements);
            all = all.with(&displacements);
        }
        // Also where all move together: walls and points that they approach are looked for up to this displacement.
        if farthest(&all) > largest {
            return true;
        }
        let skin = self.skin * self.skin;
        if difference(&all, &all) <= skin {
            return false;
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
        let near = |(own, around): (&Bounds, &Bounds)| own.low[0] > own.high[0] || difference(own, around) <= skin;
        !of_cells.iter().zip(&*around).all(near)
    }
}

/// Largest number of coarse cells.
fn most_cells(count: usize) -> usize {
    (count / OCCUPANCY).max(64)
}

/// The square of the largest difference of a vector in one box from one in another.
fn difference(one: &Bounds, other: &Bounds) -> f64 {
    (0..AXES).map(|axis| (one.high[axis] - other.low[axis]).max(other.high[axis] - one.low[axis]).powi(2)).sum()
}

/// Adds the boxes of both adjacent cells along an axis to each.
fn widen(around: &mut [Bounds], of: &[Bounds], cells: usize, stride: usize, periodic: bool) {
    for (index, bounds) in around.iter_mut().enumerate() {
        let along = index / stride % cells;
        if along + 1 < cells {
            *bounds = bounds.with(&of[index + stride]);
        } else if periodic {
            *bounds = bounds.with(&of[index - along * stride]);
        }
        if along > 0 {
            *bounds = bounds.with(&of[index - stride]);
        } else if periodic {
            *bounds = bounds.with(&of[index + (cells - 1) * stride]);
        }
    }
}

/// The displacements of the runs of one block.
struct Measure<'a> {
    runs: &'a mut [Run],
    start: usize,
    positions: Positions<'a>,
    order: &'a [u32],
    sorted: &'a [Vec<f64>; AXES],
}

impl Kernel for Measure<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { runs, mut start, positions, order, sorted } = self;
        for run in runs {
            let end = run.end as usize;
            run.displacements = Bounds { low: [0.0; AXES], high: [0.0; AXES] };
            for axis in 0..positions.dimension {
                let (mut low, mut high, mut zero) = (f64::INFINITY, f64::NEG_INFINITY, 0.0);
                for (&particle, then) in order[start..end].iter().zip(&sorted[axis][start..end]) {
                    let displacement = positions.axes[axis][particle as usize] - then;
                    low = if displacement < low { displacement } else { low };
                    high = if displacement > high { displacement } else { high };
                    zero += displacement * 0.0;
                }
                // 0 times what is not finite is NaN.
                if zero != 0.0 {
                    (low, high) = (f64::NEG_INFINITY, f64::INFINITY);
                }
                (run.displacements.low[axis], run.displacements.high[axis]) = (low, high);
            }
            start = end;
        }
    }
}
