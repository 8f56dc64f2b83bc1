//! Medium: coefficients of the discrete wave operator, a [Laplacian] with w = c²/h² [1/s²]. The energy is
//!
//! ```text
//!     E = ½ ρ h^D [Σ w (uᵢ − uⱼ)² + Σ κ uᵢ²],    ρ h^D L u = −∂E/∂u
//! ```
//!
//! The operator of order 4 along each axis a is Lₐ (1 − Lₐ / (12 w)). It applies three-point differences twice: edges and walls
//! need no other rule, and the operator remains symmetric.

use super::parameters::Parameters;
use crate::grid::{CellCoefficients, Laplacian, RowTable};
use crate::math::{AXES, Real};

/// Wave operator, with the additional coefficients of differences of order 4.
#[derive(Debug)]
pub struct Medium<T> {
    pub laplacian: Laplacian<T>,
    pub fourth: Option<Fourth<T>>,
}

/// Additional coefficients of the operator of order 4.
#[derive(Debug)]
pub struct Fourth<T> {
    /// Coefficients κ along each axis [1/s²].
    pub anchors: [RowTable<T>; AXES],
    /// Coefficient h²/(12c²) [s²]; 0 where c is 0.
    pub slowness: RowTable<T>,
}

impl<T: Real> Medium<T> {
    /// Returns the coefficients for a wave with these parameters.
    pub fn new(parameters: &Parameters) -> Self {
        let speed = &parameters.speed;
        let square = |row: usize, column: usize| (speed.row(row)[column] / parameters.grid.spacing).powi(2);
        let cells = CellCoefficients {
            grid: &parameters.grid,
            edges: parameters.edges,
            walls: parameters.walls.as_deref(),
            of: &square,
            same: speed.different().iter().all(|&other| other == speed.row(0)[0]),
        };
        let fourth = (parameters.order == 4).then(|| Fourth {
            anchors: std::array::from_fn(|axis| cells.along(axis, &|row, column| cells.anchor(row, column, axis))),
            slowness: cells.table(&|row, column| {
                let square = square(row, column);
                if square > 0.0 { 1.0 / (12.0 * square) } else { 0.0 }
            }),
        });
        Self { laplacian: Laplacian::new(&cells), fourth }
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        let fourth = self.fourth.iter().flat_map(|fourth| fourth.anchors.iter().chain([&fourth.slowness]));
        self.laplacian.bytes() + fourth.map(RowTable::bytes).sum::<usize>()
    }
}
