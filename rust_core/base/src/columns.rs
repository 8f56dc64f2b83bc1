//! Structure of arrays: one vector per particle, one array per component. All bulk data are stored this way.

use std::ops::Range;

use crate::aligned::{Aligned, filled};
use crate::error::Result;
use crate::history::Archive;
use crate::math::{AXES, Real, Vector};
use crate::simd::padded;

/// One vector per particle, stored as one array per axis. The arrays are padded with zeros to whole groups of lanes.
#[derive(Debug, Clone, Default)]
pub struct Columns<V: Vector> {
    axes: Vec<Aligned<V::Scalar>>,
    count: usize,
}

impl<V: Vector> Columns<V> {
    /// Returns `count` zero vectors.
    #[inline]
    pub fn zeros(count: usize) -> Self {
        Self { axes: vec![filled(V::Scalar::ZERO, padded(count)); V::DIMENSION], count }
    }

    /// Returns the vectors `each(index)` of all particles.
    pub fn from_fn(count: usize, each: impl Fn(usize) -> V) -> Self {
        let mut columns = Self::zeros(count);
        (0..count).for_each(|index| columns.set(index, each(index)));
        columns
    }

    /// Number of vectors.
    #[inline]
    pub fn count(&self) -> usize {
        self.count
    }

    /// Vector at an index.
    #[inline]
    pub fn get(&self, index: usize) -> V {
        V::from_axes(|axis| self.axes[axis][index])
    }

    /// Writes the vector at an index.
    #[inline]
    pub fn set(&mut self, index: usize, value: V) {
        for axis in 0..V::DIMENSION {
            self.axes[axis][index] = value.axis(axis);
        }
    }

    /// Index of the first vector that is not finite, if any.
    #[inline]
    pub fn out_of_range(&self) -> Option<usize> {
        (0..self.count).find(|&index| !self.get(index).widen().is_finite())
    }

    /// Copies all vectors of `other`, which must have the same count.
    #[inline]
    pub fn copy_from(&mut self, other: &Self) {
        for (mine, theirs) in self.axes.iter_mut().zip(&other.axes) {
            mine.copy_from_slice(theirs);
        }
    }

    /// Components along one axis, padding included.
    #[inline(always)]
    pub fn axis(&self, axis: usize) -> &[V::Scalar] {
        &self.axes[axis]
    }

    /// Read-only view of all vectors.
    #[inline]
    pub fn view(&self) -> View<'_, V> {
        View { start: 0, axes: std::array::from_fn(|axis| self.axes.get(axis).map_or(&[][..], |axis| axis.as_slice())) }
    }

    /// Writes the components to an archive, axis by axis.
    pub fn capture(&self, name: &str, archive: &mut Archive) {
        let components = (0..V::DIMENSION).flat_map(|axis| &self.axes[axis][..self.count()]);
        archive.write(name, components.map(|component| component.to_f64()));
    }

    /// Reads the components from an archive.
    ///
    /// # Errors
    /// If they are missing or of another number.
    pub fn restore(&mut self, name: &str, archive: &mut Archive) -> Result<()> {
        let count = self.count();
        let mut numbers = archive.read_exactly(name, V::DIMENSION * count)?.iter();
        for axis in self.span().axes.iter_mut().take(V::DIMENSION) {
            axis[..count].iter_mut().zip(&mut numbers).for_each(|(slot, &number)| *slot = V::Scalar::from_f64(number));
        }
        Ok(())
    }

    /// Mutable span of all vectors.
    #[inline]
    pub fn span(&mut self) -> Span<'_, V> {
        let mut arrays = self.axes.iter_mut();
        Span { axes: std::array::from_fn(|_| arrays.next().map_or(&mut [][..], |axis| axis.as_mut_slice())) }
    }

    /// Memory of the arrays [bytes].
    #[inline]
    pub fn bytes(&self) -> usize {
        self.axes.iter().map(|axis| std::mem::size_of_val(axis.as_slice())).sum()
    }
}

/// Read-only view of columns or of a range of columns. Indices refer to the whole columns.
#[derive(Debug, Clone, Copy, Default)]
pub struct View<'a, V: Vector> {
    start: usize,
    axes: [&'a [V::Scalar]; AXES],
}

impl<'a, V: Vector> View<'a, V> {
    /// Components along one axis, padding included. In a view of whole columns, their index is the particle's.
    #[inline(always)]
    pub fn axis(&self, axis: usize) -> &'a [V::Scalar] {
        self.axes[axis]
    }

    /// Components of a range of particles along one axis; empty for an axis past the dimension.
    #[inline(always)]
    pub fn slice(&self, axis: usize, range: Range<usize>) -> &'a [V::Scalar] {
        if axis < V::DIMENSION { &self.axes[axis][range.start - self.start..range.end - self.start] } else { &[] }
    }

    /// Vector of a particle.
    #[inline(always)]
    pub fn get(&self, index: usize) -> V {
        V::from_axes(|axis| self.axes[axis][index - self.start])
    }
}

/// Mutable range of columns: one slice per axis, padding included.
#[derive(Debug)]
pub struct Span<'a, V: Vector> {
    /// Components along each axis; empty past the dimension.
    pub axes: [&'a mut [V::Scalar]; AXES],
}

impl<V: Vector> Span<'_, V> {
    /// Returns a span without particles.
    #[inline]
    pub fn empty() -> Self {
        Self { axes: std::array::from_fn(|_| &mut [][..]) }
    }

    /// Length along every axis, padding included.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.axes[0].len()
    }

    /// Whether the span is empty.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Splits the span after `length` particles. An empty span gives two empty spans.
    #[must_use]
    #[inline]
    pub fn split_at(mut self, length: usize) -> (Self, Self) {
        let others = std::array::from_fn(|axis| {
            let whole = std::mem::take(&mut self.axes[axis]);
            let (first, others) = whole.split_at_mut(length.min(whole.len()));
            self.axes[axis] = first;
            others
        });
        (self, Self { axes: others })
    }

    /// Read-only view of the span; `start` is the index of its first particle.
    #[inline(always)]
    pub fn view(&self, start: usize) -> View<'_, V> {
        View { start, axes: self.axes.each_ref().map(|axis| &**axis) }
    }

    /// Reborrows the span.
    #[inline(always)]
    pub fn reborrow(&mut self) -> Span<'_, V> {
        Span { axes: self.axes.each_mut().map(|axis| &mut **axis) }
    }

    /// Vector at an index.
    #[inline(always)]
    pub fn get(&self, index: usize) -> V {
        V::from_axes(|axis| self.axes[axis][index])
    }

    /// Writes the vector at an index.
    #[inline(always)]
    pub fn set(&mut self, index: usize, value: V) {
        for axis in 0..V::DIMENSION {
            self.axes[axis][index] = value.axis(axis);
        }
    }

    /// Fills the span with vectors of `from`, beginning at particle `start`.
    #[inline]
    pub fn copy_from(&mut self, from: &View<'_, V>, start: usize) {
        for axis in 0..V::DIMENSION {
            let slice = &mut *self.axes[axis];
            slice.copy_from_slice(from.slice(axis, start..start + slice.len()));
        }
    }
}
