//! Discrete Laplacian ∇·(w h² ∇u), of order 2, with its edges and walls.
//!
//! The faces f between cells i and j have the coefficient w, the harmonic mean of both sides. A cell has κ = 2w for each face at
//! which u is held at zero; there the ghost value is −u. Then
//!
//! ```text
//!     L u = Σ w (uⱼ − uᵢ) − κ uᵢ,    ½ [Σ w (uᵢ − uⱼ)² + Σ κ uᵢ²] = −½ Σ u L u
//! ```
//!
//! For waves w = c²/h², for diffusion D/h².

use std::ops::Range;

use super::stencil::{self, PlaneRow};
use super::{Edge, Edges, Grid, RowTable, Window};
use crate::math::{AXES, Real};

/// Coefficients of the discrete Laplacian, row by row.
#[derive(Debug)]
pub struct Laplacian<T> {
    /// Grid of the cells.
    pub grid: Grid,
    /// Boundary conditions of the grid.
    pub edges: Edges,
    /// Coefficient w at the upper face of each cell along each axis; 0 without a neighbor and along an axis that the grid lacks.
    pub faces: [RowTable<T>; AXES],
    /// Coefficient κ of each cell, summed over all axes.
    pub anchor: RowTable<T>,
    /// Coefficient w if it is equal at all faces and there are no walls.
    pub uniform: Option<T>,
}

/// Coefficients of cells, from which those of faces follow.
pub struct CellCoefficients<'a> {
    /// Grid of the cells.
    pub grid: &'a Grid,
    /// Boundary conditions of the grid.
    pub edges: Edges,
    /// Mask of wall cells, which are cut out of the grid.
    pub walls: Option<&'a [bool]>,
    /// Coefficient w of a cell, by its row and its column.
    pub of: &'a dyn Fn(usize, usize) -> f64,
    /// Whether w is equal in all cells.
    pub same: bool,
}

impl CellCoefficients<'_> {
    /// Cell above a cell along an axis, if any.
    fn above(&self, row: usize, column: usize, axis: usize) -> Option<(usize, usize)> {
        if axis < 2 {
            return Some((self.grid.beside(row, axis, true)?, column));
        }
        let length = self.grid.row_length();
        if column + 1 < length { Some((row, column + 1)) } else { self.grid.periodic[2].then_some((row, 0)) }
    }

    /// Cell below a cell along an axis, if any.
    fn below(&self, row: usize, column: usize, axis: usize) -> Option<(usize, usize)> {
        if axis < 2 {
            return Some((self.grid.beside(row, axis, false)?, column));
        }
        if column > 0 { Some((row, column - 1)) } else { self.grid.periodic[2].then(|| (row, self.grid.row_length() - 1)) }
    }

    fn is_wall(&self, (row, column): (usize, usize)) -> bool {
        self.walls.is_some_and(|walls| walls[row * self.grid.row_length() + column])
    }

    /// Coefficient w of the face between two cells.
    fn between(&self, one: (usize, usize), other: (usize, usize)) -> f64 {
        if self.is_wall(one) || self.is_wall(other) {
            return 0.0;
        }
        let (one, other) = ((self.of)(one.0, one.1), (self.of)(other.0, other.1));
        let (low, high) = (one.min(other), one.max(other));
        if low == high { low } else { 2.0 * low / (low / high + 1.0) }
    }

    /// Coefficient κ of a cell along an axis.
    pub fn anchor(&self, row: usize, column: usize, axis: usize) -> f64 {
        if self.is_wall((row, column)) {
            return 0.0;
        }
        let sides = [self.below(row, column, axis), self.above(row, column, axis)];
        let held = |side: usize| match sides[side] {
            Some(other) => self.is_wall(other),
            None => self.edges.0[axis][side] == Edge::Fixed,
        };
        2.0 * (self.of)(row, column) * (f64::from(u8::from(held(0))) + f64::from(u8::from(held(1))))
    }

    /// Builds a table with one number per cell.
    pub fn table<T: Real>(&self, of: &dyn Fn(usize, usize) -> f64) -> RowTable<T> {
        RowTable::new(self.grid.rows(), self.grid.row_length(), T::ZERO, |row, values| {
            values.iter_mut().enumerate().for_each(|(column, value)| *value = T::from_f64(of(row, column)));
        })
    }

    /// Builds a table for an axis, with one number per cell; zeros if the grid lacks the axis.
    pub fn along<T: Real>(&self, axis: usize, of: &dyn Fn(usize, usize) -> f64) -> RowTable<T> {
        if self.grid.axes().contains(&axis) { self.table(of) } else { self.table(&|_, _| 0.0) }
    }
}

impl<T: Real> Laplacian<T> {
    /// Builds the operator with these coefficients.
    pub fn new(cells: &CellCoefficients<'_>) -> Self {
        let face = |axis: usize, row: usize, column: usize| {
            cells.above(row, column, axis).map_or(0.0, |other| cells.between((row, column), other))
        };
        let axes = cells.grid.axes();
        let uniform = cells.same && cells.walls.is_none();
        Self {
            edges: cells.edges,
            faces: std::array::from_fn(|axis| cells.along(axis, &|row, column| face(axis, row, column))),
            anchor: cells.table(&|row, column| axes.clone().map(|axis| cells.anchor(row, column, axis)).sum()),
            uniform: uniform.then(|| T::from_f64((cells.of)(0, 0))),
            grid: cells.grid.clone(),
        }
    }

    /// Computes L u of the cells `range` of a row.
    #[inline]
    pub fn apply(&self, rows: Window<'_, T>, row: usize, range: Range<usize>, out: &mut [T]) {
        stencil::apply(self, rows, row, range, out);
    }

    /// Evaluates L u lazily for the cells of a row from `start` on, without a buffer. Available if w is uniform in a plane grid
    /// and the row has neighbors on both sides.
    #[inline]
    pub fn plane_row<'a>(&self, rows: Window<'a, T>, row: usize, start: usize) -> Option<PlaneRow<'a, T>> {
        stencil::plane_row(self, rows, row, start)
    }

    /// Factor of ghost values beyond an edge, relative to the values in the row itself: −1 at a fixed edge, else 1.
    #[inline]
    pub fn ghost(&self, axis: usize, side: usize) -> T {
        if self.edges.0[axis][side] == Edge::Fixed { -T::ONE } else { T::ONE }
    }

    /// Largest eigenvalue of −L: exact if w is uniform, else an upper bound.
    #[inline]
    pub fn largest(&self) -> f64 {
        match self.uniform {
            Some(weight) => self.grid.axes().map(|axis| 4.0 * weight.to_f64() * self.largest_sine_squared(axis)).sum(),
            None => self.largest_row(self.grid.axes(), &self.anchor, None),
        }
    }

    /// Value sin²(θ/2) of the largest eigenvalue 4w sin²(θ/2) of −L along an axis of n cells, for uniform w.
    ///
    /// - θ = π for two fixed ends (the checkerboard mode);
    /// - θ = π (n − 1)/n for two free ends;
    /// - θ = π (n − ½)/n for one of each;
    /// - θ is the largest multiple of 2π/n up to π for a periodic axis.
    #[inline]
    pub fn largest_sine_squared(&self, axis: usize) -> f64 {
        let (count, edges) = (self.grid.cells[axis] as f64, self.edges.0[axis]);
        let halves = match edges.iter().filter(|&&edge| edge == Edge::Fixed).count() {
            2 => count,
            1 => count - 0.5,
            _ if self.grid.periodic[axis] => 2.0 * (0.5 * count).floor(),
            _ => count - 1.0,
        };
        libm::sin(0.5 * std::f64::consts::PI * halves / count).powi(2)
    }

    /// Upper bound of the eigenvalues of −L along some axes, from the rows of its matrix (Gershgorin). The bound is the largest 2
    /// Σ w + κ of all cells, with κ along these axes. If `factor` is given, each cell's value is multiplied by it.
    pub fn largest_row(&self, axes: Range<usize>, anchor: &RowTable<T>, factor: Option<&RowTable<T>>) -> f64 {
        let grid = &self.grid;
        let length = grid.row_length();
        let mut most = 0.0_f64;
        for row in 0..grid.rows() {
            for cell in 0..length {
                let mut faces = 0.0;
                for axis in axes.clone() {
                    let table = &self.faces[axis];
                    let (lower, at) = if axis < 2 {
                        (grid.beside(row, axis, false).unwrap_or(row), cell)
                    } else {
                        (row, if cell == 0 { length - 1 } else { cell - 1 })
                    };
                    let below =
                        if axis < 2 && grid.beside(row, axis, false).is_none() { 0.0 } else { table.row(lower)[at].to_f64() };
                    faces += table.row(row)[cell].to_f64() + below;
                }
                let sum = 2.0 * faces + anchor.row(row)[cell].to_f64();
                most = most.max(factor.map_or(sum, |factor| factor.row(row)[cell].to_f64() * sum));
            }
        }
        most
    }

    /// Memory [bytes].
    #[inline]
    pub fn bytes(&self) -> usize {
        self.faces.iter().chain([&self.anchor]).map(RowTable::bytes).sum()
    }
}
