//! Mass properties of the shapes of rigid bodies, for Python.

use numpy::{PyArray1, PyArray2};
use physcore_rigid::shapes::SolidShape;
use pyo3::prelude::*;

use crate::errors::exception;
use crate::record::Reader;

/// Area or volume, center of mass (3,) [m], and inertia tensor (3, 3) about it per unit density.
type ShapeProperties<'py> = (f64, Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>);

/// Mass properties of the shape that a record declares.
#[pyfunction]
pub fn shape_properties<'py>(py: Python<'py>, record: &Bound<'py, PyAny>, dimension: usize) -> PyResult<ShapeProperties<'py>> {
    let mut reader = Reader { dimension, functions: Vec::new() };
    let kind: String = record.get_item("kind")?.extract()?;
    let item = reader.item(record, kind)?;
    let (_, mass) = SolidShape::declared(&item, dimension).map_err(|error| exception(py, error))?;
    let rows: Vec<Vec<f64>> = mass.inertia.transpose().to_cols_array_2d().map(|row| row.to_vec()).to_vec();
    Ok((mass.size, PyArray1::from_slice(py, &mass.center.to_array()), PyArray2::from_vec2(py, &rows)?))
}
