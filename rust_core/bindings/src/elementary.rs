//! Elementary functions of arrays, by the `libm` crate: equal bits on every processor.

#![expect(clippy::needless_pass_by_value, reason = "PyO3 hands arguments over by value")]

use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

type Numbers<'py> = PyReadonlyArray1<'py, f64>;
type Results<'py> = PyResult<Bound<'py, PyArray1<f64>>>;

/// Exponential function e^x.
#[pyfunction]
pub fn exp<'py>(py: Python<'py>, x: Numbers<'py>) -> Results<'py> {
    of_each(py, &x, libm::exp)
}

/// Natural logarithm of x.
#[pyfunction]
pub fn log<'py>(py: Python<'py>, x: Numbers<'py>) -> Results<'py> {
    of_each(py, &x, libm::log)
}

/// Sine of x.
#[pyfunction]
pub fn sin<'py>(py: Python<'py>, x: Numbers<'py>) -> Results<'py> {
    of_each(py, &x, libm::sin)
}

/// Cosine of x.
#[pyfunction]
pub fn cos<'py>(py: Python<'py>, x: Numbers<'py>) -> Results<'py> {
    of_each(py, &x, libm::cos)
}

/// Angle of (x, y) from the x axis, from −π to π.
#[pyfunction]
pub fn arctan2<'py>(py: Python<'py>, y: Numbers<'py>, x: Numbers<'py>) -> Results<'py> {
    of_pairs(py, &y, &x, libm::atan2)
}

/// Power x^y.
#[pyfunction]
pub fn power<'py>(py: Python<'py>, x: Numbers<'py>, y: Numbers<'py>) -> Results<'py> {
    of_pairs(py, &x, &y, libm::pow)
}

fn of_each<'py>(py: Python<'py>, x: &Numbers<'py>, function: fn(f64) -> f64) -> Results<'py> {
    let x = x.as_slice()?;
    Ok(PyArray1::from_vec(py, py.detach(|| x.iter().map(|&x| function(x)).collect())))
}

fn of_pairs<'py>(py: Python<'py>, x: &Numbers<'py>, y: &Numbers<'py>, function: fn(f64, f64) -> f64) -> Results<'py> {
    let (x, y) = (x.as_slice()?, y.as_slice()?);
    if x.len() != y.len() {
        return Err(PyValueError::new_err(format!("must have equal lengths, got {} and {}", x.len(), y.len())));
    }
    Ok(PyArray1::from_vec(py, py.detach(|| x.iter().zip(y).map(|(&x, &y)| function(x, y)).collect())))
}
