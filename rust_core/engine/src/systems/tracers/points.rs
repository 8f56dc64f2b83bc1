//! Points: one array for each coordinate.

use crate::math::Real;
use crate::parallel::Split;
use crate::simd::padded;

/// Number of points that a thread advances at a time: they stay in the first-level cache.
pub const BLOCK: usize = 512;

/// Points in `D` dimensions. The arrays are padded to whole groups of lanes with copies of the last point, which move with
/// it.
#[derive(Debug, Clone)]
pub struct Points<T, const D: usize> {
    /// Coordinates along each axis.
    pub axes: [Vec<T>; D],
    /// Number of points, without padding.
    pub count: usize,
}

impl<T: Real, const D: usize> Points<T, D> {
    /// Creates `count` points at the origin.
    pub fn zeros(count: usize) -> Self {
        Self { axes: std::array::from_fn(|_| vec![T::ZERO; padded(count)]), count }
    }

    /// Creates points from rows of coordinates.
    pub fn from_rows(rows: &[f64]) -> Self {
        let mut points = Self::zeros(rows.len() / D);
        points.fill(rows);
        points
    }

    /// Replaces all points by rows of coordinates.
    pub fn fill(&mut self, rows: &[f64]) {
        let Some(last) = self.count.checked_sub(1) else { return };
        for (axis, column) in self.axes.iter_mut().enumerate() {
            for (index, slot) in column.iter_mut().enumerate() {
                *slot = T::from_f64(rows[index.min(last) * D + axis]);
            }
        }
    }

    /// Rows of coordinates.
    pub fn rows(&self) -> Vec<f64> {
        let mut rows = vec![0.0; self.count * D];
        for (axis, column) in self.axes.iter().enumerate() {
            rows.iter_mut().skip(axis).step_by(D).zip(column).for_each(|(slot, value)| *slot = value.to_f64());
        }
        rows
    }

    /// Copies the coordinates of equally many other points.
    pub fn copy_from(&mut self, other: &Self) {
        self.axes.iter_mut().zip(&other.axes).for_each(|(own, other)| own.copy_from_slice(other));
    }

    /// First point with a coordinate that is not finite.
    pub fn fault(&self) -> Option<usize> {
        (0..self.count).find(|&index| self.axes.iter().any(|axis| !axis[index].is_finite()))
    }

    /// All points, as blocks.
    pub fn blocks(&mut self) -> PointBlock<'_, T, D> {
        PointBlock { start: 0, axes: self.axes.each_mut().map(Vec::as_mut_slice) }
    }

    /// Number of blocks.
    pub fn block_count(&self) -> usize {
        padded(self.count).div_ceil(BLOCK)
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        self.axes.iter().map(|axis| size_of_val(axis.as_slice())).sum()
    }
}

/// Consecutive points, in blocks.
pub struct PointBlock<'a, T, const D: usize> {
    /// Index of the first point.
    pub start: usize,
    /// Coordinates along each axis.
    pub axes: [&'a mut [T]; D],
}

impl<T: Send, const D: usize> Split for PointBlock<'_, T, D> {
    fn blocks(&self) -> usize {
        self.axes[0].len().div_ceil(BLOCK)
    }

    fn split_at(self, blocks: usize) -> (Self, Self) {
        let length = (blocks * BLOCK).min(self.axes[0].len());
        let mut rest: [&mut [T]; D] = std::array::from_fn(|_| &mut [][..]);
        let mut axis = 0;
        let first = self.axes.map(|column| {
            let (first, others) = column.split_at_mut(length);
            rest[axis] = others;
            axis += 1;
            first
        });
        (Self { start: self.start, axes: first }, Self { start: self.start + length, axes: rest })
    }
}
