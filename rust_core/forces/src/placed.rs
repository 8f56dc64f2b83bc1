//! User-defined functions of the time and of positions, with one vector or one number per position.

use std::sync::Arc;

use glam::DVec3;

use crate::error::{Error, Result};
use crate::scene::{Argument, Callback};

/// Displacement for differences of a field, as a fraction of the extent of its points: about the cube root of ε.
const DISPLACEMENT: f64 = 1e-5;

/// User-defined field.
#[derive(Clone)]
pub struct PlacedFunction {
    /// Function that returns one row of numbers for each position.
    pub function: Arc<dyn Callback>,
    /// Path of the function in the scene.
    pub path: String,
    /// Name of the values in errors, such as `the field`.
    pub what: &'static str,
    /// Number of dimensions of the scene.
    pub dimension: usize,
    /// Whether the field has only a z component.
    pub axial: bool,
}

impl PlacedFunction {
    /// Values at positions, finite.
    ///
    /// # Errors
    /// If the function fails, or a value is not finite.
    pub fn at(&self, time: f64, positions: &[DVec3]) -> Result<Vec<DVec3>> {
        let shape = [positions.len(), self.dimension];
        let shape = if self.axial { &shape[..1] } else { &shape[..] };
        let arguments = [Argument::Number(time), Argument::Vectors(positions)];
        let numbers = self.function.call(&arguments, self.what, shape).map_err(|failure| failure.at(self.path.clone()))?;
        let rows = numbers.chunks_exact(if self.axial { 1 } else { self.dimension }).zip(positions).enumerate();
        rows.map(|(row, (numbers, place))| {
            if let Some(found) = numbers.iter().find(|number| !number.is_finite()) {
                let place = &place.to_array()[..self.dimension];
                let found = format!("{found} in row {row}, for the position {place:?} m");
                return Err(Error::undefined(self.path.clone(), "finite numbers", found));
            }
            let component = |axis: usize| numbers.get(axis).copied().unwrap_or(0.0);
            Ok(if self.axial { DVec3::Z * numbers[0] } else { DVec3::new(component(0), component(1), component(2)) })
        })
        .collect()
    }

    /// Norms of the gradients at positions, by central differences.
    ///
    /// # Errors
    /// If the function fails, or a value is not finite.
    pub fn gradient_norms(&self, time: f64, positions: &[DVec3]) -> Result<Vec<f64>> {
        let Some(&first) = positions.first() else { return Ok(Vec::new()) };
        let extent = positions.iter().map(|place| (*place - first).length().max(place.length())).fold(0.0, f64::max);
        let step = DISPLACEMENT * if extent > 0.0 { extent } else { 1.0 };
        let mut squares = vec![0.0; positions.len()];
        for axis in 0..self.dimension {
            let along = DVec3::from_array(std::array::from_fn(|other| if other == axis { step } else { 0.0 }));
            let moved = |sign: f64| positions.iter().map(|&place| place + sign * along).collect::<Vec<_>>();
            let (before, after) = (self.at(time, &moved(-1.0))?, self.at(time, &moved(1.0))?);
            for (square, (before, after)) in squares.iter_mut().zip(before.into_iter().zip(after)) {
                *square += ((after - before) / (2.0 * step)).length_squared();
            }
        }
        Ok(squares.into_iter().map(f64::sqrt).collect())
    }
}
