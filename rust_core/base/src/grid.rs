//! Uniform grids: cells in one, two or three dimensions, their edges, and fields with one value at the center of each cell.
//!
//! Internally, a grid of any dimension has three axes. Axes that it lacks come first and have one cell. The last axis is
//! therefore the one along which cells are adjacent in memory. A *row* is a line of cells along the last axis; rows are numbered
//! in memory order.

mod block;
mod edge_values;
mod edges;
mod laplacian;
mod padding;
mod stencil;
mod table;
mod tiles;

pub use block::{Block, COLUMNS};
pub use edge_values::{EdgeCells, EdgeFace, EdgeValues};
pub use edges::{Edge, Edges};
pub use laplacian::{CellCoefficients, Laplacian};
pub use padding::Padding;
pub use stencil::{Groups, PlaneRow, Window, load};
pub use table::RowTable;
pub use tiles::{DEEPEST, Sweep, depth};

use crate::error::Result;
use crate::math::AXES;
use crate::scene::{Array, Item, Value};

/// Uniform grid.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    /// Number of dimensions of space.
    pub dimension: usize,
    /// Number of cells along each of the three internal axes.
    pub cells: [usize; AXES],
    /// Grid spacing h, equal along all axes [m].
    pub spacing: f64,
    /// Lower corner [m]; 0 along an axis that the grid lacks.
    pub origin: [f64; AXES],
    /// Whether each axis is periodic.
    pub periodic: [bool; AXES],
}

/// Maximum number of cells, along an axis and in total.
const MOST_CELLS: f64 = 2_147_483_648.0;

impl Grid {
    /// Reads the grid that an item declares.
    ///
    /// # Errors
    /// If a value is missing or out of range.
    pub fn declared(item: &Item) -> Result<Self> {
        let item = item.record("grid")?;
        let vectors = ["cells", "origin", "periodic"].map(|name| item.vector(name).map(|vector| vector.to_array()));
        let [cells, origin, periodic] = vectors;
        let (cells, origin, periodic) = (cells?, origin?, periodic?);
        let dimension = cells.iter().take_while(|&&count| count > 0.0).count();
        let whole = cells.iter().all(|&count| count >= 0.0 && count.fract() == 0.0);
        let few = cells[..dimension].iter().product::<f64>() <= MOST_CELLS;
        if dimension == 0 || !whole || !few || cells[dimension..].iter().any(|&count| count > 0.0) {
            return Err(item.wrong("cells", "up to three numbers of cells ≥ 1, of at most 2³¹ cells", item.values.get("cells")));
        }
        let spacing = item.number("spacing")?;
        if spacing <= 0.0 {
            return Err(item.wrong("spacing", "a number > 0", item.values.get("spacing")));
        }
        let mut grid = Self { dimension, cells: [1; AXES], spacing, origin: [0.0; AXES], periodic: [false; AXES] };
        for axis in 0..dimension {
            let own = grid.axis(axis);
            grid.cells[own] = cells[axis] as usize;
            grid.origin[own] = origin[axis];
            grid.periodic[own] = periodic[axis] != 0.0;
        }
        Ok(grid)
    }

    /// Internal index of the spatial axis x, y or z.
    #[inline]
    pub fn axis(&self, of_space: usize) -> usize {
        AXES - self.dimension + of_space
    }

    /// Internal indices of the axes of the grid.
    #[inline]
    pub fn axes(&self) -> std::ops::Range<usize> {
        AXES - self.dimension..AXES
    }

    /// Number of cells.
    #[inline]
    pub fn count(&self) -> usize {
        self.cells.iter().product()
    }

    /// Number of rows.
    #[inline]
    pub fn rows(&self) -> usize {
        self.cells[0] * self.cells[1]
    }

    /// Number of cells in a row.
    #[inline]
    pub fn row_length(&self) -> usize {
        self.cells[2]
    }

    /// Shape of fields: number of cells along x, y and z.
    #[inline]
    pub fn shape(&self) -> Vec<usize> {
        self.cells[self.axes()].to_vec()
    }

    /// Measure h^D of a cell: length, area or volume [m^D].
    #[inline]
    pub fn content(&self) -> f64 {
        self.axes().map(|_| self.spacing).product()
    }

    /// Position of a row along the first two axes.
    #[inline]
    pub fn place(&self, row: usize) -> [usize; 2] {
        [row / self.cells[1], row % self.cells[1]]
    }

    /// Row adjacent to a row along one of the first two axes, above or below it. A periodic axis wraps around; otherwise there is
    /// none beyond the grid.
    #[inline]
    pub fn beside(&self, row: usize, axis: usize, upward: bool) -> Option<usize> {
        self.neighbors(row)[axis][usize::from(upward)]
    }

    /// Rows adjacent to a row: below and above it along each of the first two axes.
    #[inline]
    pub fn neighbors(&self, row: usize) -> [[Option<usize>; 2]; 2] {
        let (place, strides) = (self.place(row), [self.cells[1], 1]);
        std::array::from_fn(|axis| {
            let (stride, count, at, periodic) = (strides[axis], self.cells[axis], place[axis], self.periodic[axis]);
            let below = if at > 0 { Some(row - stride) } else { periodic.then(|| row + (count - 1) * stride) };
            let above = if at + 1 < count { Some(row + stride) } else { periodic.then(|| row - at * stride) };
            [below, above]
        })
    }

    /// Name of a cell: `cell (3, 4)`.
    #[inline]
    pub fn name(&self, index: usize) -> String {
        let row = self.place(index / self.row_length());
        let indices = [row[0], row[1], index % self.row_length()];
        let indices: Vec<String> = indices[self.axes()].iter().map(ToString::to_string).collect();
        format!("cell ({})", indices.join(", "))
    }

    /// Cells whose centers are nearest to a point, two along each axis, with multilinear interpolation weights that add up to 1.
    /// Beyond the outermost centers of an axis that is not periodic, those centers have all the weight.
    pub fn nearest(&self, point: [f64; AXES]) -> Vec<(usize, f64)> {
        let mut cells = vec![(0, 1.0)];
        for axis in 0..AXES {
            let count = self.cells[axis];
            let along = if count == 1 { 0.0 } else { (point[axis] - self.origin[axis]) / self.spacing - 0.5 };
            let ends = if self.periodic[axis] {
                let lower = along.floor();
                let index = lower.rem_euclid(count as f64) as usize % count;
                [(index, 1.0 - (along - lower)), ((index + 1) % count, along - lower)]
            } else {
                let along = along.clamp(0.0, (count - 1) as f64);
                let index = (along as usize).min(count.saturating_sub(2));
                [(index, 1.0 - (along - index as f64)), ((index + 1).min(count - 1), along - index as f64)]
            };
            let pairs = cells.iter().flat_map(|&(cell, weight)| ends.map(|(index, part)| (cell * count + index, weight * part)));
            cells = pairs.filter(|&(_, weight)| weight != 0.0).collect();
        }
        cells
    }

    /// Reads a field of an item: one number for all cells, or one per cell in their order.
    ///
    /// # Errors
    /// If the field is missing, of another shape, or not finite.
    pub fn field(&self, item: &Item, name: &str) -> Result<RowTable<f64>> {
        let length = self.row_length();
        let Some(Value::Numbers(array)) = item.values.get(name) else {
            let number = item.number(name)?;
            return Ok(RowTable::new(self.rows(), length, number, |_, _| {}));
        };
        self.fits(item, name, array)?;
        if let Some(index) = array.entries.iter().position(|number| !number.is_finite()) {
            let path = format!("{name} at {}", self.name(index));
            return Err(item.wrong(&path, "a finite number", Some(&Value::Number(array.entries[index]))));
        }
        Ok(RowTable::new(self.rows(), length, 0.0, |row, values| {
            values.copy_from_slice(&array.entries[row * length..][..length]);
        }))
    }

    /// Reads a field without negative values, as [`field`](Self::field) does.
    ///
    /// # Errors
    /// If the field is missing, of another shape, not finite, or negative somewhere.
    pub fn non_negative_field(&self, item: &Item, name: &str) -> Result<RowTable<f64>> {
        let table = self.field(item, name)?;
        match table.different().iter().find(|&&value| value < 0.0) {
            Some(&value) => Err(item.wrong(name, "numbers ≥ 0", Some(&Value::Number(value)))),
            None => Ok(table),
        }
    }

    /// Reads an optional mask of an item.
    ///
    /// # Errors
    /// If the mask is of another shape.
    #[inline]
    pub fn mask<'a>(&self, item: &'a Item, name: &str) -> Result<Option<&'a [bool]>> {
        match item.values.get(name) {
            None => Ok(None),
            Some(Value::Flags(array)) => self.fits(item, name, array).map(|()| Some(array.entries.as_slice())),
            other => Err(item.wrong(name, "true or false for each cell", other)),
        }
    }

    fn fits<T>(&self, item: &Item, name: &str, array: &Array<T>) -> Result<()> {
        let expected = || format!("an array of shape {:?}", self.shape());
        if array.shape == self.shape() { Ok(()) } else { Err(item.wrong(name, &expected(), item.values.get(name))) }
    }
}

#[cfg(test)]
mod tests;
