//! Accelerations of a row by differences of order 4: Σₐ Lₐ (1 − Lₐ h²/(12c²)) u, with Lₐ of order 2 along axis a.

use super::medium::{Fourth, Medium};
use crate::grid::Window;
use crate::math::Real;

/// Number of rows of scratch memory.
pub const SCRATCH: usize = 4;

/// Computes the accelerations of a whole row; `scratch` holds [`SCRATCH`] rows.
pub fn accelerate<T: Real>(
    (medium, fourth): (&Medium<T>, &Fourth<T>),
    rows: Window<'_, T>,
    row: usize,
    out: &mut [T],
    scratch: &mut [T],
) {
    let length = out.len();
    let line = LineOperator { medium, fourth };
    let (below, rest) = scratch.split_at_mut(length);
    let (center, rest) = rest.split_at_mut(length);
    let (above, rest) = rest.split_at_mut(length);
    let sum = &mut rest[..length];
    out.fill(T::ZERO);
    for axis in medium.laplacian.grid.axes() {
        line.corrected(axis, rows, row, center);
        if axis < 2 {
            let beside = [false, true].map(|upward| medium.laplacian.grid.beside(row, axis, upward).unwrap_or(row));
            line.corrected(axis, rows, beside[0], below);
            line.corrected(axis, rows, beside[1], above);
        }
        line.apply(axis, row, [below, center, above], sum);
        out.iter_mut().zip(&*sum).for_each(|(out, &sum)| *out += sum);
    }
}

/// Operators Lₐ.
#[derive(Clone, Copy)]
pub struct LineOperator<'a, T> {
    pub medium: &'a Medium<T>,
    pub fourth: &'a Fourth<T>,
}

impl<T: Real> LineOperator<'_, T> {
    /// Computes Lₐ of a row, from the rows below and above it along a; for the last axis these are not used.
    fn apply(&self, axis: usize, row: usize, [below, center, above]: [&[T]; 3], out: &mut [T]) {
        let anchor = self.fourth.anchors[axis].row(row);
        let faces = &self.medium.laplacian.faces[axis];
        let upper = faces.row(row);
        if axis < 2 {
            let lower = faces.row(self.medium.laplacian.grid.beside(row, axis, false).unwrap_or(row));
            // At a lower edge, the row below is the row itself.
            for cell in 0..out.len() {
                let here = center[cell];
                out[cell] = lower[cell] * (below[cell] - here) + upper[cell] * (above[cell] - here) - anchor[cell] * here;
            }
        } else {
            let last = out.len() - 1;
            for cell in 0..out.len() {
                let here = center[cell];
                let (before, after) = (if cell == 0 { last } else { cell - 1 }, if cell == last { 0 } else { cell + 1 });
                out[cell] = upper[before] * (center[before] - here) + upper[cell] * (center[after] - here) - anchor[cell] * here;
            }
        }
    }

    /// Computes Lₐ u of a row.
    pub fn of(&self, axis: usize, rows: Window<'_, T>, row: usize, out: &mut [T]) {
        let beside =
            [false, true].map(|upward| if axis < 2 { self.medium.laplacian.grid.beside(row, axis, upward) } else { None });
        let [below, above] = beside.map(|other| rows.row(other.unwrap_or(row)));
        self.apply(axis, row, [below, rows.row(row), above], out);
    }

    /// Computes (1 − Lₐ h²/(12c²)) u of a row.
    fn corrected(&self, axis: usize, rows: Window<'_, T>, row: usize, out: &mut [T]) {
        self.of(axis, rows, row, out);
        let (center, slowness) = (rows.row(row), self.fourth.slowness.row(row));
        for cell in 0..out.len() {
            out[cell] = center[cell] - slowness[cell] * out[cell];
        }
    }
}
