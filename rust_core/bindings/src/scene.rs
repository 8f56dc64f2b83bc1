//! Scenes as Python describes them: lists of records. Also conversions of arrays of vectors in both directions.

use std::sync::Arc;

use glam::DVec3;
use numpy::{PyArray2, PyReadonlyArray1};
use physcore_engine::memory;
use physcore_engine::scene::{Body, Scene, corners};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::callback::PythonFunction;
use crate::errors::{SceneError, exception};
use crate::record::{Reader, bytes};

/// Reads a scene, with its user-defined functions.
pub fn read(scene: &Bound<'_, PyDict>) -> PyResult<(Scene, Vec<Arc<PythonFunction>>)> {
    let (py, dimension) = (scene.py(), entry(scene, "dimension")?.extract()?);
    let arrays = |name: &str| -> PyResult<usize> { entry(scene, name)?.try_iter()?.map(|record| bytes(&record?)).sum() };
    // Vectors have three components in the engine.
    let needed = arrays("bodies")? / 2 * 3 + arrays("systems")?;
    memory::check("scene", needed, 0, || "for a copy of its arrays; take fewer particles or cells".to_owned())
        .map_err(|error| exception(py, error))?;
    let mut reader = Reader { dimension, functions: Vec::new() };
    let mut items = |name: &str| reader.items(&entry(scene, name)?, name);
    let (bodies, forces, boundaries) = (items("bodies")?, items("forces")?, items("boundaries")?);
    let (constraints, systems, probes) = (items("constraints")?, items("systems")?, items("probes")?);
    let domain = entry(scene, "periodic")?;
    let domain = if domain.is_none() { None } else { Some(reader.item(&domain, "periodic".to_owned())?) };
    let scene = py.detach(|| {
        let bodies = bodies.into_iter().map(|item| Body::new(item, dimension)).collect::<Result<_, _>>()?;
        let periodic = domain.map(|item| corners(&item, dimension)).transpose()?;
        Ok(Scene { dimension, bodies, forces, boundaries, constraints, systems, probes, periodic })
    });
    Ok((scene.map_err(|error| exception(py, error))?, reader.functions))
}

fn entry<'py>(dictionary: &Bound<'py, PyDict>, name: &str) -> PyResult<Bound<'py, PyAny>> {
    dictionary.get_item(name)?.ok_or_else(|| SceneError::new_err(format!("scene: {name} is missing")))
}

/// Copies an array. The interpreter is free meanwhile.
pub fn copied<T: numpy::Element + Clone + Sync>(array: &PyReadonlyArray1<'_, T>) -> PyResult<Vec<T>> {
    let (py, numbers) = (array.py(), array.as_array());
    let copy = py.detach(|| numbers.to_vec());
    py.check_signals()?;
    Ok(copy)
}

/// Converts vectors to an (N, D) array.
pub fn array<'py>(py: Python<'py>, vectors: &[DVec3], dimension: usize) -> PyResult<Bound<'py, PyArray2<f64>>> {
    rows(py, flat(vectors, dimension), dimension)
}

/// Components of vectors, one vector after the other.
pub fn flat(vectors: &[DVec3], dimension: usize) -> Vec<f64> {
    vectors.iter().flat_map(|vector| vector.to_array().into_iter().take(dimension)).collect()
}

/// Converts components to an (N, D) array without copying.
pub fn rows(py: Python<'_>, numbers: Vec<f64>, dimension: usize) -> PyResult<Bound<'_, PyArray2<f64>>> {
    let array = numpy::ndarray::Array2::from_shape_vec((numbers.len() / dimension, dimension), numbers);
    Ok(PyArray2::from_owned_array(py, array.map_err(|error| SceneError::new_err(error.to_string()))?))
}
