//! Vectors of a scene that may be functions of time: gravity, and the velocity of the wind.

use std::sync::Arc;

use glam::DVec3;

use crate::error::{Error, Result};
use crate::scene::{Argument, Callback, Item, Value};

/// Vector, constant or a user-defined function of the time.
#[derive(Clone)]
pub struct TimedVector {
    /// Value at the last time.
    pub value: DVec3,
    function: Option<(Arc<dyn Callback>, String)>,
    dimension: usize,
}

impl std::fmt::Debug for TimedVector {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.value.fmt(formatter)
    }
}

impl TimedVector {
    /// Reads a vector or a function, with its value at the time 0. A missing vector is zero.
    ///
    /// # Errors
    /// If the value is neither, or the function fails.
    pub fn declared(item: &Item, name: &str, dimension: usize) -> Result<Self> {
        let Some(Value::Callback(function)) = item.values.get(name) else {
            let value = item.optional_vector(name)?.unwrap_or(DVec3::ZERO);
            return Ok(Self { value, function: None, dimension });
        };
        let path = format!("{}.{name}", item.path);
        let mut timed = Self { value: DVec3::ZERO, function: Some((Arc::clone(function), path)), dimension };
        timed.update(0.0)?;
        Ok(timed)
    }

    /// Whether the vector is a function.
    pub fn varies(&self) -> bool {
        self.function.is_some()
    }

    /// Value at a time [s].
    ///
    /// # Errors
    /// If the function fails.
    pub fn at(&self, time: f64) -> Result<DVec3> {
        let Some((function, path)) = &self.function else { return Ok(self.value) };
        let numbers = function.call(&[Argument::Number(time)], "one vector", &[self.dimension]);
        let numbers = numbers.map_err(|failure| failure.at(path.clone()))?;
        let value = DVec3::from_array(std::array::from_fn(|axis| numbers.get(axis).copied().unwrap_or(0.0)));
        if value.is_finite() {
            return Ok(value);
        }
        Err(Error::undefined(path.clone(), "a finite vector", format!("{:?} at {time:?} s", &value.to_array()[..self.dimension])))
    }

    /// Sets the value to that at a time [s].
    ///
    /// # Errors
    /// If the function fails.
    pub fn update(&mut self, time: f64) -> Result<()> {
        self.value = self.at(time)?;
        Ok(())
    }
}
