//! State of a wave function.

use std::ops::Range;

use super::fourier::{Complex, FourierReal, norm};
use crate::error::{Error, Result};
use crate::grid::{Grid, Padding};
use crate::math::Real;

/// Complex zero.
pub fn zero<T: Real>() -> Complex<T> {
    Complex { re: T::ZERO, im: T::ZERO }
}

/// Values of ψ in all cells, and amounts exchanged since the start.
#[derive(Debug, Clone)]
pub struct QuantumState<T> {
    pub values: Vec<Complex<T>>,
    /// Probability that has left through edges.
    pub removed: f64,
    /// Energy that layers have absorbed [J].
    pub dissipated: f64,
    /// Probability supplied from outside.
    pub supplied: f64,
    /// Energy supplied from outside [J].
    pub work: f64,
}

impl<T> Default for QuantumState<T> {
    fn default() -> Self {
        Self { values: Vec::new(), removed: 0.0, dissipated: 0.0, supplied: 0.0, work: 0.0 }
    }
}

impl<T: Real> QuantumState<T> {
    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        size_of_val(self.values.as_slice())
    }

    /// Tallies of the exchanged amounts.
    pub fn tallies(&self) -> [f64; 4] {
        [self.removed, self.dissipated, self.supplied, self.work]
    }

    /// Mutable tallies, in the order of [`Self::tallies`].
    pub fn tallies_mut(&mut self) -> [&mut f64; 4] {
        [&mut self.removed, &mut self.dissipated, &mut self.supplied, &mut self.work]
    }
}

/// Ranges of the rows of the user's grid within all cells.
pub fn rows(padding: &Padding) -> impl Iterator<Item = Range<usize>> {
    let length = padding.inner.row_length();
    (0..padding.inner.rows()).map(move |row| {
        let first = padding.outward(row * length);
        first..first + length
    })
}

/// Converts pairs of numbers to ψ.
///
/// # Errors
/// If a number is not finite in this precision, or all are 0.
pub fn narrow<T: FourierReal>(pairs: &[f64], grid: &Grid, path: &str) -> Result<Vec<Complex<T>>> {
    let values: Vec<Complex<T>> =
        pairs.as_chunks::<2>().0.iter().map(|pair| Complex { re: T::from_f64(pair[0]), im: T::from_f64(pair[1]) }).collect();
    if let Some(cell) = values.iter().position(|value| !(value.re.is_finite() && value.im.is_finite())) {
        let found = format!("{} + {}i", pairs[2 * cell], pairs[2 * cell + 1]);
        return Err(Error::parameter(
            format!("{path} at {}", grid.name(cell)),
            format!("a finite number that {} holds", T::NAME),
            found,
        ));
    }
    let norm = grid.content() * norm(&values);
    if norm > 0.0 && norm.is_finite() {
        return Ok(values);
    }
    Err(Error::parameter(path, format!("a norm Σ |ψ|² h^D that is finite and above 0 in {}", T::NAME), norm))
}
