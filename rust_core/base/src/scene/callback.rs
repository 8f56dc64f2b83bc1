//! Functions of the user's.

use glam::DVec3;

use crate::error::{Cause, Error};

/// What a function of the user's is called with.
#[derive(Debug, Clone, Copy)]
pub enum Argument<'a> {
    /// A number.
    Number(f64),
    /// An array with a vector in each row.
    Vectors(&'a [DVec3]),
    /// An array of numbers of a shape, row by row.
    Array {
        /// The numbers.
        numbers: &'a [f64],
        /// The length of each axis.
        shape: &'a [usize],
    },
}

/// A function of the user's, which gives numbers.
pub trait Callback: Send + Sync {
    /// The numbers that it gives for these arguments, row by row and not necessarily finite: an array of this shape, a single
    /// number where that is empty. `what` names them for errors.
    fn call(&self, arguments: &[Argument<'_>], what: &str, shape: &[usize]) -> Result<Vec<f64>, Failure>;
}

/// How a function of the user's failed.
#[derive(Debug)]
pub enum Failure {
    /// It raised an error.
    Raised(Cause),
    /// It gave something else than was expected.
    Refused {
        /// What was expected.
        expected: String,
        /// What it gave.
        found: String,
    },
}

impl Failure {
    /// The error of the function at `path`.
    pub fn at(self, path: String) -> Error {
        match self {
            Self::Raised(cause) => Error::Callback { path, cause },
            Self::Refused { expected, found } => Error::parameter(path, expected, found),
        }
    }
}
