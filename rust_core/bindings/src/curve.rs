//! Curves for Python.

#![expect(clippy::needless_pass_by_value, reason = "PyO3 hands arguments over by value")]

use glam::DVec3;
use numpy::{PyArray2, PyReadonlyArray2};
use physcore_engine::math::spline::CubicSpline;
use pyo3::prelude::*;

use crate::arrays::rows;

/// Points (S, 3) of the cubic spline through points (K, 3), `parts` in each interval, and the last one.
#[pyfunction]
pub fn spline_points<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    closed: bool,
    parts: u32,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let count = points.as_array().nrows();
    let given: Vec<DVec3> = rows::<f64, 3>(&points, count, "points")?.iter().copied().map(DVec3::from_array).collect();
    let sampled = CubicSpline::through(&given, closed).sampled(parts);
    Ok(PyArray2::from_vec2(py, &sampled.iter().map(|point| point.to_array().to_vec()).collect::<Vec<_>>())?)
}
