//! Velocity of a medium, such as the wind: constant, a function of the time, or a function of the time and of positions.

use glam::DVec3;

use super::placed::PlacedFunction;
use super::timed::TimedVector;
use crate::error::Result;
use crate::scene::Item;

/// Velocity of a medium at the points where it acts.
#[derive(Clone)]
pub enum Stream {
    /// Velocity in uniform motion.
    Uniform(TimedVector),
    /// Velocity that depends on the position.
    Placed {
        /// Function of the time and of positions.
        field: PlacedFunction,
        /// Velocities at the points of the last evaluation [m/s].
        values: Vec<DVec3>,
    },
}

impl std::fmt::Debug for Stream {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Uniform(velocity) => velocity.fmt(formatter),
            Self::Placed { values, .. } => values.fmt(formatter),
        }
    }
}

impl Stream {
    /// Reads a velocity, for `points` points. The flag `by_place` says whether a function takes positions too.
    ///
    /// # Errors
    /// If the value is neither a vector nor a function, or a function of the time fails.
    pub fn declared(item: &Item, name: &str, dimension: usize, points: usize) -> Result<Self> {
        if !(item.values.contains_key(BY_PLACE) && item.flag(BY_PLACE)?) {
            return Ok(Self::Uniform(TimedVector::declared(item, name, dimension)?));
        }
        let (function, path) = (item.callback(name)?, format!("{}.{name}", item.path));
        let field = PlacedFunction { function, path, what: "velocities", dimension, axial: false };
        Ok(Self::Placed { field, values: vec![DVec3::ZERO; points] })
    }

    /// Whether the velocity is a function.
    pub fn varies(&self) -> bool {
        match self {
            Self::Uniform(velocity) => velocity.varies(),
            Self::Placed { .. } => true,
        }
    }

    /// Memory of the velocities [bytes].
    pub fn bytes(&self) -> usize {
        match self {
            Self::Uniform(_) => 0,
            Self::Placed { values, .. } => size_of_val(values.as_slice()),
        }
    }

    /// Velocity at a point at the last evaluation [m/s].
    #[inline]
    pub fn value(&self, point: usize) -> DVec3 {
        match self {
            Self::Uniform(velocity) => velocity.value,
            Self::Placed { values, .. } => values[point],
        }
    }

    /// Evaluates the velocity at a time [s], at the positions of its points [m].
    ///
    /// # Errors
    /// If a function fails.
    pub fn update(&mut self, time: f64, positions: impl FnOnce() -> Vec<DVec3>) -> Result<()> {
        match self {
            Self::Uniform(velocity) => velocity.update(time)?,
            Self::Placed { values, .. } if values.is_empty() => {}
            Self::Placed { field, values } => *values = field.at(time, &positions())?,
        }
        Ok(())
    }

    /// Velocity at the points at a time [m/s], with the norms of its gradients [1/s].
    ///
    /// # Errors
    /// If a function fails.
    pub fn with_gradients(&self, time: f64, positions: impl FnOnce() -> Vec<DVec3>) -> Result<Gradients> {
        match self {
            Self::Uniform(velocity) => Ok(Gradients::Uniform(velocity.at(time)?)),
            Self::Placed { values, .. } if values.is_empty() => Ok(Gradients::Placed(Vec::new(), Vec::new())),
            Self::Placed { field, .. } => {
                let positions = positions();
                Ok(Gradients::Placed(field.at(time, &positions)?, field.gradient_norms(time, &positions)?))
            }
        }
    }
}

/// Flag of an item whose function takes positions.
const BY_PLACE: &str = "by_place";

/// Velocities at points, and the norms of their gradients.
#[derive(Debug)]
pub enum Gradients {
    /// Velocity in uniform motion [m/s].
    Uniform(DVec3),
    /// Velocity at each point [m/s], and the norm of its gradient [1/s].
    Placed(Vec<DVec3>, Vec<f64>),
}

impl Gradients {
    /// Velocity at a point [m/s], and the norm of its gradient [1/s].
    pub fn at(&self, point: usize) -> (DVec3, f64) {
        match self {
            Self::Uniform(velocity) => (*velocity, 0.0),
            Self::Placed(velocities, norms) => (velocities[point], norms[point]),
        }
    }
}
