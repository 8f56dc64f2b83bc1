//! Convex hulls for Python.

#![expect(clippy::needless_pass_by_value, reason = "PyO3 hands arguments over by value")]

use glam::DVec3;
use numpy::{PyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use physcore_engine::boundaries::Polytope;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Vertices of every facet of the convex hull of points (V, 2) or (V, 3), counterclockwise as seen from outside. Empty if the
/// points are degenerate (flat).
#[pyfunction]
pub fn convex_hull<'py>(py: Python<'py>, points: PyReadonlyArray2<'py, f64>) -> PyResult<Vec<Bound<'py, PyArray1<i64>>>> {
    let refused = || PyValueError::new_err(format!("points: must have the shape (V, 2) or (V, 3), got {:?}", points.shape()));
    let rows: Vec<DVec3> = match points.shape()[1] {
        2 => points.as_array().rows().into_iter().map(|row| DVec3::new(row[0], row[1], 0.0)).collect(),
        3 => points.as_array().rows().into_iter().map(|row| DVec3::new(row[0], row[1], row[2])).collect(),
        _ => return Err(refused()),
    };
    let hull = Polytope::hull(&rows, points.shape()[1], 0.0);
    let loops = hull.iter().flat_map(Polytope::loops);
    Ok(loops.map(|facet| PyArray1::from_iter(py, facet.iter().map(|&vertex| i64::from(vertex)))).collect())
}
