//! Medium: coefficients of the discrete wave operator, a [Laplacian] with w = r c²/h² [1/s²]. The density relative to the largest
//! one ρ is r. The energy is
//!
//! ```text
//!     E = ½ ρ h^D [Σ r v² + Σ w (uᵢ − uⱼ)² + Σ κ uᵢ²],    ρ h^D L u = −∂E/∂u,    u'' = L u / r
//! ```
//!
//! The coefficient w of a face is the harmonic mean of both sides. Thus u and ρ c² ∂u/∂n are continuous where ρ or c jumps.
//!
//! The operator of order 4 along each axis a is Lₐ (1 − Lₐ / (12 w)). It applies three-point differences twice: edges and walls
//! need no other rule, and the operator remains symmetric.

use std::ops::Range;

use super::parameters::Parameters;
use crate::grid::{CellCoefficients, Laplacian, RowTable};
use crate::math::{AXES, Real};

/// Wave operator, with the additional coefficients of varying densities and of differences of order 4.
#[derive(Debug)]
pub struct Medium<T> {
    pub laplacian: Laplacian<T>,
    pub density: Option<DensityField<T>>,
    pub fourth: Option<Fourth<T>>,
}

/// Density that varies from cell to cell.
#[derive(Debug)]
pub struct DensityField<T> {
    /// Density r relative to the largest one.
    pub relative: RowTable<T>,
    /// Inverse 1/r.
    pub inverse: RowTable<T>,
}

impl<T: Real> DensityField<T> {
    /// Whether the precision does not hold an inverse.
    pub fn overflows(&self) -> bool {
        self.inverse.different().iter().any(|inverse: &T| !inverse.is_finite())
    }
}

/// Additional coefficients of the operator of order 4.
#[derive(Debug)]
pub struct Fourth<T> {
    /// Coefficients κ along each axis [1/s²].
    pub anchors: [RowTable<T>; AXES],
    /// Coefficient h²/(12 r c²) [s²]; 0 where c is 0.
    pub slowness: RowTable<T>,
}

impl<T: Real> Medium<T> {
    /// Returns the coefficients for a wave with these parameters.
    pub fn new(parameters: &Parameters) -> Self {
        let speed = &parameters.speed;
        let density = parameters.relative_density.as_ref();
        let square = |row: usize, column: usize| {
            let square = (speed.row(row)[column] / parameters.grid.spacing).powi(2);
            density.map_or(square, |density| density.row(row)[column] * square)
        };
        let cells = CellCoefficients {
            grid: &parameters.grid,
            edges: parameters.edges,
            walls: parameters.walls.as_deref(),
            of: &square,
            same: density.is_none() && speed.different().iter().all(|&other| other == speed.row(0)[0]),
        };
        let fourth = (parameters.order == 4).then(|| Fourth {
            anchors: std::array::from_fn(|axis| cells.along(axis, &|row, column| cells.anchor(row, column, axis))),
            slowness: cells.table(&|row, column| {
                let square = square(row, column);
                if square > 0.0 { 1.0 / (12.0 * square) } else { 0.0 }
            }),
        });
        let density = density.map(|density| DensityField {
            relative: cells.table(&|row, column| density.row(row)[column]),
            inverse: cells.table(&|row, column| 1.0 / density.row(row)[column]),
        });
        Self { laplacian: Laplacian::new(&cells), density, fourth }
    }

    /// Density of a cell relative to the largest one.
    #[inline]
    pub fn relative_density(&self, row: usize, column: usize) -> f64 {
        self.density.as_ref().map_or(1.0, |density| density.relative.row(row)[column].to_f64())
    }

    /// Divides rates in the cells `range` of a row by the relative density.
    #[inline]
    pub fn divide(&self, row: usize, range: Range<usize>, rates: &mut [T]) {
        if let Some(density) = &self.density {
            rates.iter_mut().zip(&density.inverse.row(row)[range]).for_each(|(rate, &inverse)| *rate *= inverse);
        }
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        let fourth = self.fourth.iter().flat_map(|fourth| fourth.anchors.iter().chain([&fourth.slowness]));
        let density = self.density.iter().flat_map(|density| [&density.relative, &density.inverse]);
        self.laplacian.bytes() + fourth.chain(density).map(RowTable::bytes).sum::<usize>()
    }
}
