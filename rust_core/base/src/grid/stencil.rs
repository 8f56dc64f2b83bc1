//! Discrete Laplacian L u of a row of cells, by central differences of order 2.
//!
//! The sums are (west + east) + (south + north) [+ (below + above)]: mirroring a field, or exchanging x and y, changes no bit.

use std::ops::Range;

use super::Laplacian;
use crate::math::Real;
use crate::simd::{Isa, Kernel, dispatch};

/// Consecutive rows of a field: all rows, or a range of them.
#[derive(Debug, Clone, Copy)]
pub struct Window<'a, T> {
    /// Values of all fields of all rows.
    pub values: &'a [T],
    /// Index of the first row.
    pub first: usize,
    /// Number of cells in a row.
    pub length: usize,
    /// Number of fields: a row of one field is followed by the row of the next field.
    pub fields: usize,
    /// Index of the field to read.
    pub field: usize,
}

impl<'a, T> Window<'a, T> {
    /// Returns a window on a single field, from its first row on.
    #[inline]
    pub fn new(values: &'a [T], length: usize) -> Self {
        Self { values, first: 0, length, fields: 1, field: 0 }
    }

    /// Values of a row.
    #[inline(always)]
    pub fn row(self, row: usize) -> &'a [T] {
        &self.values[((row - self.first) * self.fields + self.field) * self.length..][..self.length]
    }
}

/// Values of the cells of a row, read in groups of consecutive cells.
pub trait Groups<T>: Copy {
    /// Whether all `W` cells from `cell` on are inner cells, which need no treatment of the ends of the row.
    fn is_inner<const W: usize>(&self, cell: usize) -> bool;

    /// Values of `W` cells from `cell` on, all of them inner cells.
    fn inner<const W: usize>(&self, cell: usize) -> [T; W];

    /// Values of any `W` cells from `cell` on.
    fn any<const W: usize>(&self, cell: usize) -> [T; W];
}

/// Loads `W` numbers from index `at` on.
#[inline(always)]
pub fn load<T: Real, const W: usize>(column: &[T], at: usize) -> [T; W] {
    let mut lanes = [T::ZERO; W];
    lanes.copy_from_slice(&column[at..at + W]);
    lanes
}

impl<T: Real> Groups<T> for &[T] {
    #[inline(always)]
    fn is_inner<const W: usize>(&self, _cell: usize) -> bool {
        true
    }

    #[inline(always)]
    fn inner<const W: usize>(&self, cell: usize) -> [T; W] {
        load(self, cell)
    }

    #[inline(always)]
    fn any<const W: usize>(&self, cell: usize) -> [T; W] {
        load(self, cell)
    }
}

/// Discrete Laplacian L u of a row in a plane grid, from some cell on, for uniform w.
#[derive(Debug, Clone, Copy)]
pub struct PlaneRow<'a, T> {
    start: usize,
    weight: T,
    center: &'a [T],
    below: &'a [T],
    above: &'a [T],
    /// Ghost values below the first and above the last cell.
    ends: [T; 2],
}

impl<T: Real> Groups<T> for PlaneRow<'_, T> {
    #[inline(always)]
    fn is_inner<const W: usize>(&self, cell: usize) -> bool {
        let cell = self.start + cell;
        cell > 0 && cell + W < self.center.len()
    }

    #[inline(always)]
    fn inner<const W: usize>(&self, cell: usize) -> [T; W] {
        let cell = self.start + cell;
        self.total(cell, load(self.center, cell - 1), load(self.center, cell + 1))
    }

    #[inline(always)]
    fn any<const W: usize>(&self, cell: usize) -> [T; W] {
        let (cell, last) = (self.start + cell, self.center.len() - 1);
        let (mut west, mut east) = ([self.ends[0]; W], [self.ends[1]; W]);
        for lane in 0..W {
            if cell + lane > 0 {
                west[lane] = self.center[cell + lane - 1];
            }
            if cell + lane < last {
                east[lane] = self.center[cell + lane + 1];
            }
        }
        self.total(cell, west, east)
    }
}

impl<T: Real> PlaneRow<'_, T> {
    /// Values of L u in `W` cells from `cell` on. The order of the sums is that of [`apply`], so the bits are equal.
    #[inline(always)]
    fn total<const W: usize>(&self, cell: usize, west: [T; W], east: [T; W]) -> [T; W] {
        let (center, below, above): ([T; W], [T; W], [T; W]) =
            (load(self.center, cell), load(self.below, cell), load(self.above, cell));
        let mut result = [T::ZERO; W];
        for lane in 0..W {
            let sum = (below[lane] + above[lane]) + (west[lane] + east[lane]);
            result[lane] = self.weight * (sum - T::from_f64(4.0) * center[lane]);
        }
        result
    }
}

/// Evaluates L u lazily for the cells of a row from `start` on, if w is uniform in a plane grid and the row is not at an edge.
pub fn plane_row<'a, T: Real>(
    laplacian: &Laplacian<T>,
    rows: Window<'a, T>,
    row: usize,
    start: usize,
) -> Option<PlaneRow<'a, T>> {
    let weight = laplacian.uniform.filter(|_| laplacian.grid.dimension == 2)?;
    let [below, above] = laplacian.grid.neighbors(row)[1].map(|other| other.map(|other| rows.row(other)));
    let center = rows.row(row);
    Some(PlaneRow { start, weight, center, below: below?, above: above?, ends: ends(laplacian, center) })
}

/// Ghost values below the first and above the last cell of a row.
fn ends<T: Real>(laplacian: &Laplacian<T>, center: &[T]) -> [T; 2] {
    let [first, last] = [center[0], center[center.len() - 1]];
    if laplacian.grid.periodic[2] { [last, first] } else { [laplacian.ghost(2, 0) * first, laplacian.ghost(2, 1) * last] }
}

/// Computes L u of the cells `range` of a row.
pub fn apply<T: Real>(laplacian: &Laplacian<T>, rows: Window<'_, T>, row: usize, range: Range<usize>, out: &mut [T]) {
    let center = rows.row(row);
    let axes = laplacian.grid.axes();
    let all = laplacian.grid.neighbors(row);
    let pairs = (axes.start..2).map(|axis| (axis, all[axis]));
    let ends = ends(laplacian, center);
    if let Some(weight) = laplacian.uniform {
        let mut signs = [[T::ONE; 2]; 2];
        let mut neighbors = [[center; 2]; 2];
        let count = axes.len();
        for (index, (axis, beside)) in pairs.enumerate() {
            for side in 0..2 {
                match beside[side] {
                    Some(other) => neighbors[index][side] = rows.row(other),
                    None => signs[index][side] = laplacian.ghost(axis, side),
                }
            }
        }
        let twice = T::from_f64(2.0 * count as f64);
        let law = UniformWeights { weight, twice, signs };
        run(Stencil { law, center, neighbors, ends, range, out }, count);
    } else {
        let nothing: &[T] = &[];
        let mut weights = [[nothing; 2]; 2];
        let mut neighbors = [[center; 2]; 2];
        let count = axes.len();
        for (index, (axis, beside)) in pairs.enumerate() {
            let faces = &laplacian.faces[axis];
            weights[index] = [faces.row(beside[0].unwrap_or(row)), faces.row(row)];
            for side in 0..2 {
                if let Some(other) = beside[side] {
                    neighbors[index][side] = rows.row(other);
                }
            }
        }
        let faces = laplacian.faces[2].row(row);
        let law = VaryingWeights { weights, along: [faces; 2], anchor: laplacian.anchor.row(row) };
        run(Stencil { law, center, neighbors, ends, range, out }, count);
    }
}

fn run<T: Real, L: DifferenceWeights<T>>(stencil: Stencil<'_, T, L>, dimension: usize) {
    match dimension {
        1 => dispatch(RowPairs::<_, 0>(stencil)),
        2 => dispatch(RowPairs::<_, 1>(stencil)),
        _ => dispatch(RowPairs::<_, 2>(stencil)),
    }
}

/// Weights of the differences of a cell to its neighbors.
trait DifferenceWeights<T: Real>: Copy {
    /// Restricts the weights to the cells `from..to`.
    fn cut(self, from: usize, to: usize) -> Self;
    /// Terms of the two neighbors along one of the first axes.
    fn pair(&self, pair: usize, cell: usize, center: T, lower: T, upper: T) -> T;
    /// Terms of the two neighbors in the row.
    fn along(&self, cell: usize, center: T, lower: T, upper: T) -> T;
    /// Value of L u from the sum of these terms.
    fn total(&self, cell: usize, center: T, sum: T) -> T;
}

/// Uniform w: L u = w (Σ uⱼ − 2D u). Ghosts beyond edges are the row itself, times a sign.
#[derive(Clone, Copy)]
struct UniformWeights<T> {
    weight: T,
    twice: T,
    signs: [[T; 2]; 2],
}

impl<T: Real> DifferenceWeights<T> for UniformWeights<T> {
    #[inline(always)]
    fn cut(self, _from: usize, _to: usize) -> Self {
        self
    }

    #[inline(always)]
    fn pair(&self, pair: usize, _cell: usize, _center: T, lower: T, upper: T) -> T {
        self.signs[pair][0] * lower + self.signs[pair][1] * upper
    }

    #[inline(always)]
    fn along(&self, _cell: usize, _center: T, lower: T, upper: T) -> T {
        lower + upper
    }

    #[inline(always)]
    fn total(&self, _cell: usize, center: T, sum: T) -> T {
        self.weight * (sum - self.twice * center)
    }
}

/// Varying w, 0 at edges: L u = Σ w (uⱼ − u) − κ u.
#[derive(Clone, Copy)]
struct VaryingWeights<'a, T> {
    /// Coefficients w at the lower and the upper faces along the first axes.
    weights: [[&'a [T]; 2]; 2],
    /// Coefficients w at the lower and the upper faces along the row.
    along: [&'a [T]; 2],
    /// Coefficients κ.
    anchor: &'a [T],
}

impl<T: Real> DifferenceWeights<T> for VaryingWeights<'_, T> {
    /// Cuts the faces along the row. Before the cut, both entries are the upper faces of the whole row.
    #[inline(always)]
    fn cut(self, from: usize, to: usize) -> Self {
        let [faces, _] = self.along;
        let lower = if from == 0 { &faces[faces.len() - 1..] } else { &faces[from - 1..to - 1] };
        let mut weights = self.weights;
        weights.iter_mut().flatten().filter(|weights| !weights.is_empty()).for_each(|weights| *weights = &weights[from..to]);
        Self { weights, along: [lower, &faces[from..to]], anchor: &self.anchor[from..to] }
    }

    #[inline(always)]
    fn pair(&self, pair: usize, cell: usize, center: T, lower: T, upper: T) -> T {
        let [below, above] = self.weights[pair];
        below[cell] * (lower - center) + above[cell] * (upper - center)
    }

    #[inline(always)]
    fn along(&self, cell: usize, center: T, lower: T, upper: T) -> T {
        let [below, above] = self.along;
        below[cell] * (lower - center) + above[cell] * (upper - center)
    }

    #[inline(always)]
    fn total(&self, cell: usize, center: T, sum: T) -> T {
        sum - self.anchor[cell] * center
    }
}

/// Row with its neighbors.
struct Stencil<'a, T, L> {
    law: L,
    center: &'a [T],
    /// Rows below and above along the first axes; beyond an edge, the row itself.
    neighbors: [[&'a [T]; 2]; 2],
    /// Ghost values below the first and above the last cell.
    ends: [T; 2],
    range: Range<usize>,
    out: &'a mut [T],
}

/// Stencil of `P` pairs of rows.
struct RowPairs<S, const P: usize>(S);

impl<T: Real, L: DifferenceWeights<T>, const P: usize> Kernel for RowPairs<Stencil<'_, T, L>, P> {
    type Output = ();

    #[inline(always)]
    fn run<S: Isa>(self, _isa: S) {
        let Stencil { law, center, neighbors, ends, range, out } = self.0;
        let (first, last) = (range.start, center.len() - 1);
        let (from, to) = (first.max(1), range.end.min(last));
        let end = |cell: usize, out: &mut [T]| {
            let lower = [if cell == 0 { ends[0] } else { center[cell - 1] }];
            let upper = [if cell == last { ends[1] } else { center[cell + 1] }];
            span::<T, L, P>(law, center, neighbors, [&lower, &upper], cell..cell + 1, out);
        };
        if first == 0 {
            end(0, &mut out[..1]);
        }
        if from < to {
            let beside = [&center[from - 1..to - 1], &center[from + 1..=to]];
            span::<T, L, P>(law, center, neighbors, beside, from..to, &mut out[from - first..to - first]);
        }
        if last > 0 && range.end > last {
            end(last, &mut out[last - first..]);
        }
    }
}

/// Computes the cells `range`, given their neighbors in the row.
#[inline(always)]
fn span<T: Real, L: DifferenceWeights<T>, const P: usize>(
    law: L,
    center: &[T],
    neighbors: [[&[T]; 2]; 2],
    [lower, upper]: [&[T]; 2],
    range: Range<usize>,
    out: &mut [T],
) {
    let (from, to) = (range.start, range.end);
    let count = to - from;
    let law = law.cut(from, to);
    let center = &center[from..to];
    let [[a, b], [c, d]] = neighbors.map(|pair| pair.map(|row| &row[from..to]));
    let (lower, upper, out) = (&lower[..count], &upper[..count], &mut out[..count]);
    for cell in 0..count {
        let here = center[cell];
        let along = law.along(cell, here, lower[cell], upper[cell]);
        let sum = match P {
            0 => along,
            1 => law.pair(0, cell, here, a[cell], b[cell]) + along,
            _ => (law.pair(0, cell, here, a[cell], b[cell]) + law.pair(1, cell, here, c[cell], d[cell])) + along,
        };
        out[cell] = law.total(cell, here, sum);
    }
}
