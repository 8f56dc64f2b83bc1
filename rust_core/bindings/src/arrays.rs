//! `NumPy` arrays as slices, or an error with the expected shape.

use numpy::{PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Converts an (N, W) array to N rows of W values.
pub(crate) fn rows<'a, T: numpy::Element, const W: usize>(
    array: &'a PyReadonlyArray2<'_, T>,
    count: usize,
    name: &str,
) -> PyResult<&'a [[T; W]]> {
    let values = array.as_slice().map_err(|_| PyValueError::new_err(format!("{name}: must be C-contiguous")))?;
    let (rows, rest) = values.as_chunks::<W>();
    if array.shape() != [count, W] || !rest.is_empty() {
        return Err(PyValueError::new_err(format!("{name}: must have the shape ({count}, {W}), got {:?}", array.shape())));
    }
    Ok(rows)
}

/// Converts an array of N values to a slice.
pub(crate) fn column<'a>(array: &'a PyReadonlyArray1<'_, f32>, count: usize, name: &str) -> PyResult<&'a [f32]> {
    let values = array.as_slice().map_err(|_| PyValueError::new_err(format!("{name}: must be C-contiguous")))?;
    if values.len() != count {
        return Err(PyValueError::new_err(format!("{name}: must have the shape ({count},), got ({},)", values.len())));
    }
    Ok(values)
}

/// Converts the optional depths of N shapes to a slice.
pub(crate) fn depth<'a>(depths: Option<&'a PyReadonlyArray1<'_, f32>>, count: usize) -> PyResult<Option<&'a [f32]>> {
    depths.map(|depths| column(depths, count, "depths")).transpose()
}

/// Converts an (R, C) array to a slice, row by row.
pub(crate) fn plane<'a, T: numpy::Element>(
    array: &'a PyReadonlyArray2<'_, T>,
    shape: [usize; 2],
    name: &str,
) -> PyResult<&'a [T]> {
    if array.shape() != shape {
        return Err(PyValueError::new_err(format!("{name}: must have the shape {shape:?}, got {:?}", array.shape())));
    }
    array.as_slice().map_err(|_| PyValueError::new_err(format!("{name}: must be C-contiguous")))
}
