//! Values at the edges of a grid: inhomogeneous boundary conditions.
//!
//! A face of an outer cell has the coefficient w. A Dirichlet condition sets u to g there; the ghost value is 2g − u. A Neumann
//! condition sets the outward derivative to q; the ghost value is u + h q. The homogeneous [`Laplacian`](super::Laplacian) gains
//!
//! ```text
//!     b = 2 w g   or   b = w h q
//! ```

use std::ops::Range;
use std::sync::Arc;

use super::edges::SIDES;
use super::{Edge, Edges, Padding};
use crate::error::{Error, Result};
use crate::math::{AXES, Real};
use crate::memory;
use crate::scene::{Argument, Array, Callback, Item, Value};

/// Kind of the item of a Dirichlet condition.
pub const DIRICHLET: &str = "Dirichlet";
/// Kind of the item of a Neumann condition.
pub const NEUMANN: &str = "Neumann";

/// Value of one side: numbers, or a user-defined function of the time.
#[derive(Clone)]
enum SideValue {
    Numbers(Vec<f64>),
    Function { function: Arc<dyn Callback>, path: String, shape: Vec<usize> },
}

/// Side of a grid with a value.
#[derive(Clone)]
struct Side {
    axis: usize,
    upper: bool,
    held: bool,
    value: SideValue,
    /// Number of values: one, or one for each cell along the side.
    count: usize,
}

/// Face of an outer cell at which the boundary condition has a value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EdgeFace {
    /// Column of the cell in its row.
    pub column: usize,
    /// Index of the value in the list of all values.
    pub slot: usize,
    /// Whether the value is that of u; otherwise it is that of its outward derivative.
    pub held: bool,
    /// Factor from the value to b: 2w or w h.
    pub weight: f64,
}

impl EdgeFace {
    /// Flux into the cell at a value of its field: w (2g − 2u) or w h q.
    #[inline]
    pub fn inflow(&self, values: &[f64], u: f64) -> f64 {
        self.weight * if self.held { values[self.slot] - u } else { values[self.slot] }
    }
}

/// Values at the edges of a grid, for one field.
#[derive(Default)]
pub struct EdgeValues {
    sides: Vec<Side>,
    /// Faces, row by row.
    faces: Vec<EdgeFace>,
    /// Index at which the faces of each row begin; empty without faces.
    starts: Vec<usize>,
    /// Factor from a derivative to the difference across a cell.
    spacing: f64,
}

/// Geometry from which the faces follow.
pub struct EdgeCells<'a> {
    /// User's grid within all cells.
    pub padding: &'a Padding,
    /// Boundary conditions, without their values.
    pub edges: Edges,
    /// Coefficient w of a cell, by its row and its column; 0 in walls.
    pub of: &'a dyn Fn(usize, usize) -> f64,
    /// Whether sides at which u is zero have faces too, if another side has a value.
    pub all: bool,
    /// Index of the first value in the list.
    pub first: usize,
}

impl EdgeValues {
    /// Reads the values of the boundary conditions that an item declares by this name.
    ///
    /// # Errors
    /// If a value is missing, of the wrong shape or not finite, or memory does not suffice.
    pub fn declared(item: &Item, name: &str, cells: &EdgeCells<'_>) -> Result<Self> {
        let Some(Value::Records(conditions)) = item.values.get(name) else { return Ok(Self::default()) };
        let grid = &cells.padding.inner;
        let mut sides = Vec::new();
        for (index, condition) in conditions.iter().enumerate() {
            let axis = grid.axis(index / 2);
            let around = (0..AXES).filter(|&other| other != axis).map(|other| grid.cells[other]).product::<usize>();
            let shape: Vec<usize> = grid.axes().filter(|&other| other != axis).map(|other| grid.cells[other]).collect();
            let held = condition.kind != NEUMANN;
            let key = if held { "value" } else { "gradient" };
            let path = format!("{}['{}']", item.path_of(name), SIDES[index]);
            let value = match condition.kind.as_str() {
                DIRICHLET | NEUMANN => SideValue::declared(condition, &path, key, shape)?,
                _ if cells.all && cells.edges.0[axis][index % 2] == Edge::Fixed => SideValue::Numbers(vec![0.0]),
                _ => continue,
            };
            let count = match &value {
                SideValue::Numbers(numbers) => numbers.len(),
                SideValue::Function { shape, .. } if shape.is_empty() => 1,
                SideValue::Function { .. } => around,
            };
            sides.push(Side { axis, upper: index % 2 == 1, held, value, count });
        }
        Self { sides, spacing: grid.spacing, ..Self::default() }.with_faces(cells)
    }

    fn with_faces(mut self, cells: &EdgeCells<'_>) -> Result<Self> {
        let (inner, outer) = (&cells.padding.inner, &cells.padding.outer);
        let length = outer.row_length();
        let count: usize = self.sides.iter().map(|side| outer.count() / outer.cells[side.axis]).sum();
        let bytes = 2 * count * size_of::<(usize, EdgeFace)>();
        memory::check("the values at the edges", bytes, 0, || "a coarser grid".to_owned())?;
        let mut found: Vec<(usize, EdgeFace)> = Vec::with_capacity(count);
        let mut first = cells.first;
        for side in &self.sides {
            let end = if side.upper { outer.cells[side.axis] - 1 } else { 0 };
            let mut face = |row: usize, column: usize| {
                let place = inner.place(cells.padding.nearest_row(row));
                let place = [place[0], place[1], cells.padding.nearest_column(column)];
                let others = (0..AXES).filter(|&axis| axis != side.axis);
                let along = others.fold(0, |index, axis| index * inner.cells[axis] + place[axis]);
                let slot = first + if side.count == 1 { 0 } else { along };
                let weight = (cells.of)(row, column) * if side.held { 2.0 } else { inner.spacing };
                found.push((row, EdgeFace { column, slot, held: side.held, weight }));
            };
            for row in 0..outer.rows() {
                if side.axis == 2 {
                    face(row, end);
                } else if outer.place(row)[side.axis] == end {
                    (0..length).for_each(|column| face(row, column));
                }
            }
            first += side.count;
        }
        if !found.is_empty() {
            found.sort_by_key(|(row, face)| (*row, face.column));
            self.starts = vec![0; outer.rows() + 1];
            found.iter().for_each(|(row, _)| self.starts[row + 1] += 1);
            (0..outer.rows()).for_each(|row| self.starts[row + 1] += self.starts[row]);
        }
        self.faces = found.into_iter().map(|(_, face)| face).collect();
        Ok(self)
    }

    /// Whether no side has a value.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.sides.is_empty()
    }

    /// Whether a value is a user-defined function of the time.
    #[inline]
    pub fn vary(&self) -> bool {
        self.sides.iter().any(|side| matches!(side.value, SideValue::Function { .. }))
    }

    /// Number of values.
    #[inline]
    pub fn count(&self) -> usize {
        self.sides.iter().map(|side| side.count).sum()
    }

    /// Appends all values at a time [s] to a list.
    ///
    /// # Errors
    /// If a user-defined function fails.
    pub fn list(&self, time: f64, values: &mut Vec<f64>) -> Result<()> {
        for side in &self.sides {
            match &side.value {
                SideValue::Numbers(numbers) => values.extend_from_slice(numbers),
                SideValue::Function { function, path, shape } => {
                    let what = if shape.is_empty() { "a number" } else { "an array" };
                    let numbers = function.call(&[Argument::Number(time)], what, shape);
                    let numbers = numbers.map_err(|failure| failure.at(path.clone()))?;
                    if let Some(odd) = numbers.iter().find(|number| !number.is_finite()) {
                        return Err(Error::undefined(path.clone(), "finite numbers", format!("{odd} at {time:?} s")));
                    }
                    values.extend(numbers);
                }
            }
        }
        Ok(())
    }

    /// Largest size of u that the values impose: |g|, or h |q|.
    pub fn largest(&self, values: &[f64]) -> f64 {
        let size = |face: &EdgeFace| values[face.slot].abs() * if face.held { 1.0 } else { self.spacing };
        self.faces.iter().map(size).fold(0.0, f64::max)
    }

    /// Faces in a row.
    #[inline]
    pub fn in_row(&self, row: usize) -> &[EdgeFace] {
        if self.faces.is_empty() { &[] } else { &self.faces[self.starts[row]..self.starts[row + 1]] }
    }

    /// Adds b to L u in the cells `range` of a row. Terms of one cell are summed first, so an exchange of axes changes no bit.
    #[inline]
    pub fn add<T: Real>(&self, row: usize, range: Range<usize>, values: &[f64], out: &mut [T]) {
        for faces in self.in_row(row).chunk_by(|one, other| one.column == other.column) {
            if range.contains(&faces[0].column) {
                let sum: f64 = faces.iter().map(|face| face.weight * values[face.slot]).sum();
                out[faces[0].column - range.start] += T::from_f64(sum);
            }
        }
    }

    /// Refuses values of an item's parameter that a precision does not hold.
    ///
    /// # Errors
    /// If there is such a value.
    pub fn check_range<T: Real>(item: &Item, name: &str, values: &[f64]) -> Result<()> {
        match values.iter().find(|&&value| !T::from_f64(value).is_finite()) {
            None => Ok(()),
            Some(&value) => Err(item.wrong(name, &format!("values that {} holds", T::NAME), Some(&Value::Number(value)))),
        }
    }

    /// Memory [bytes].
    #[inline]
    pub fn bytes(&self) -> usize {
        let numbers =
            |side: &Side| if let SideValue::Numbers(numbers) = &side.value { size_of_val(numbers.as_slice()) } else { 0 };
        let values: usize = self.sides.iter().map(numbers).sum();
        size_of_val(self.faces.as_slice()) + size_of_val(self.starts.as_slice()) + values
    }
}

impl SideValue {
    /// Reads the value of the side at `path`, whose arrays have this shape.
    fn declared(item: &Item, path: &str, name: &str, shape: Vec<usize>) -> Result<Self> {
        match item.values.get(name) {
            Some(Value::Number(number)) if number.is_finite() => Ok(Self::Numbers(vec![*number])),
            Some(Value::Numbers(Array { shape: given, entries }))
                if *given == shape && entries.iter().all(|number| number.is_finite()) =>
            {
                Ok(Self::Numbers(entries.clone()))
            }
            Some(Value::Callback(function)) => {
                let shape = if item.flag("uniform")? { Vec::new() } else { shape };
                Ok(Self::Function { function: Arc::clone(function), path: format!("{path}.{name}"), shape })
            }
            other => {
                let side = Item { path: path.to_owned(), ..Item::from(item.kind.as_str()) };
                Err(side.wrong(name, &format!("a finite number, a function or an array of shape {shape:?}"), other))
            }
        }
    }
}
