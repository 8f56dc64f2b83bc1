//! The medium: the coefficients of the discrete wave operator.
//!
//! With faces f between cells i and j, w = c²/h² there, the harmonic mean of both sides, and κ = 2w for each face of a cell at
//! which u is held at zero (there the ghost is −u),
//!
//! ```text
//!     L u = Σ w (uⱼ − uᵢ) − κ uᵢ,    E = ½ ρ h^D [Σ w (uᵢ − uⱼ)² + Σ κ uᵢ²],    ρ h^D L u = −∂E/∂u
//! ```
//!
//! Of order 4 along each axis a is Lₐ (1 − Lₐ / (12 w)): three points twice, so that edges and walls need no other rule, and
//! the operator is symmetric again.

use super::parameters::Parameters;
use crate::grid::{Edge, Edges, Grid, RowTable};
use crate::math::{AXES, Real};

/// The coefficients, row by row.
#[derive(Debug)]
pub struct Medium<T> {
    pub grid: Grid,
    pub edges: Edges,
    /// w at the upper face of each cell along each axis [1/s²], 0 where no neighbor follows; empty along an axis that the
    /// grid lacks.
    pub faces: [RowTable<T>; AXES],
    /// κ of each cell, over all axes [1/s²].
    pub anchor: RowTable<T>,
    /// w, where it is the same at all faces and there are no walls.
    pub uniform: Option<T>,
    /// What the differences of order 4 need.
    pub fourth: Option<Fourth<T>>,
}

/// Further coefficients of the operator of order 4.
#[derive(Debug)]
pub struct Fourth<T> {
    /// κ along each axis [1/s²].
    pub anchors: [RowTable<T>; AXES],
    /// h²/(12c²) [s²]; 0 where c is.
    pub slowness: RowTable<T>,
}

/// The cells about which coefficients are asked.
struct Cells<'a> {
    parameters: &'a Parameters,
    grid: &'a Grid,
}

impl Cells<'_> {
    /// The cell above a cell along an axis, if there is one.
    fn above(&self, row: usize, column: usize, axis: usize) -> Option<(usize, usize)> {
        if axis < 2 {
            return Some((self.grid.beside(row, axis, true)?, column));
        }
        let length = self.grid.row_length();
        if column + 1 < length { Some((row, column + 1)) } else { self.grid.periodic[2].then_some((row, 0)) }
    }

    /// The cell below a cell along an axis, if there is one.
    fn below(&self, row: usize, column: usize, axis: usize) -> Option<(usize, usize)> {
        if axis < 2 {
            return Some((self.grid.beside(row, axis, false)?, column));
        }
        if column > 0 { Some((row, column - 1)) } else { self.grid.periodic[2].then(|| (row, self.grid.row_length() - 1)) }
    }

    fn is_wall(&self, (row, column): (usize, usize)) -> bool {
        self.parameters.walls.as_ref().is_some_and(|walls| walls[row * self.grid.row_length() + column])
    }

    /// c²/h² of a cell [1/s²].
    fn square(&self, (row, column): (usize, usize)) -> f64 {
        (self.parameters.speed.row(row)[column] / self.grid.spacing).powi(2)
    }

    /// w between two cells [1/s²].
    fn between(&self, one: (usize, usize), other: (usize, usize)) -> f64 {
        if self.is_wall(one) || self.is_wall(other) {
            return 0.0;
        }
        let (one, other) = (self.square(one), self.square(other));
        let (low, high) = (one.min(other), one.max(other));
        if low == high { low } else { 2.0 * low / (low / high + 1.0) }
    }

    /// κ of a cell along an axis [1/s²].
    fn anchor(&self, row: usize, column: usize, axis: usize) -> f64 {
        let cell = (row, column);
        if self.is_wall(cell) {
            return 0.0;
        }
        let sides = [self.below(row, column, axis), self.above(row, column, axis)];
        let held = |side: usize| match sides[side] {
            Some(other) => self.is_wall(other),
            None => self.parameters.edges.0[axis][side] == Edge::Fixed,
        };
        2.0 * self.square(cell) * (f64::from(u8::from(held(0))) + f64::from(u8::from(held(1))))
    }
}

impl<T: Real> Medium<T> {
    /// The coefficients for a wave with these parameters.
    pub fn new(parameters: &Parameters) -> Self {
        let grid = parameters.grid.clone();
        let cells = Cells { parameters, grid: &grid };
        let (rows, length) = (grid.rows(), grid.row_length());
        let table = |of: &dyn Fn(usize, usize) -> f64| {
            RowTable::new(rows, length, T::ZERO, |row, values| {
                values.iter_mut().enumerate().for_each(|(column, value)| *value = T::from_f64(of(row, column)));
            })
        };
        let along = |axis: usize, of: &dyn Fn(usize, usize) -> f64| {
            if grid.axes().contains(&axis) { table(of) } else { table(&|_, _| 0.0) }
        };
        let faces = std::array::from_fn(|axis| {
            along(axis, &|row, column| cells.above(row, column, axis).map_or(0.0, |other| cells.between((row, column), other)))
        });
        let axes = grid.axes();
        let anchor = table(&|row, column| axes.clone().map(|axis| cells.anchor(row, column, axis)).sum());
        let fourth = (parameters.order == 4).then(|| Fourth {
            anchors: std::array::from_fn(|axis| along(axis, &|row, column| cells.anchor(row, column, axis))),
            slowness: table(&|row, column| {
                let square = cells.square((row, column));
                if square > 0.0 { 1.0 / (12.0 * square) } else { 0.0 }
            }),
        });
        let square = cells.square((0, 0));
        let same = parameters.speed.different().iter().all(|&speed| speed == parameters.speed.row(0)[0]);
        let uniform = (same && parameters.walls.is_none()).then(|| T::from_f64(square));
        Self { edges: parameters.edges, faces, anchor, uniform, fourth, grid }
    }

    /// The factor of a row's own values that stand for those beyond an edge: −1 where that is fixed, else 1.
    pub fn ghost(&self, axis: usize, side: usize) -> T {
        if self.edges.0[axis][side] == Edge::Fixed { -T::ONE } else { T::ONE }
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        let fourth = self.fourth.iter().flat_map(|fourth| fourth.anchors.iter().chain([&fourth.slowness]));
        self.faces.iter().chain([&self.anchor]).chain(fourth).map(RowTable::bytes).sum()
    }
}
