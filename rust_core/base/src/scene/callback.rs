//! User-defined functions.

use glam::DVec3;

use crate::error::{Cause, Error};

/// Argument of a user-defined function.
#[derive(Debug, Clone, Copy)]
pub enum Argument<'a> {
    /// Number.
    Number(f64),
    /// Array with one vector per row.
    Vectors(&'a [DVec3]),
    /// Array of numbers with any shape, row by row.
    Array {
        /// Entries of the array.
        numbers: &'a [f64],
        /// Length of each axis.
        shape: &'a [usize],
    },
}

/// User-defined function that returns numbers.
pub trait Callback: Send + Sync {
    /// Calls the function and returns its numbers, row by row, not necessarily finite. They form an array of this shape, or a
    /// single number if the shape is empty. `what` names them in errors.
    fn call(&self, arguments: &[Argument<'_>], what: &str, shape: &[usize]) -> Result<Vec<f64>, Failure>;
}

/// Failure of a user-defined function.
#[derive(Debug)]
pub enum Failure {
    /// The function raised an error.
    Raised(Cause),
    /// The function returned an invalid value.
    Refused {
        /// Description of the expected value.
        expected: String,
        /// Description of the returned value.
        found: String,
        /// Remedy; empty if obvious.
        hint: String,
    },
}

impl Failure {
    /// Returns the error of the function at `path`.
    pub fn at(self, path: String) -> Error {
        match self {
            Self::Raised(cause) => Error::Callback { path, cause },
            Self::Refused { expected, found, hint } => Error::parameter(path, expected, found).with_hint(hint),
        }
    }
}
