//! Methods and the kinds of items that they can advance, for Python.

use physcore_engine::systems;
use pyo3::prelude::*;

use crate::laws::CATALOG;
use crate::record::Reader;

/// Whether a method can advance all bodies ("bodies"), or a system of a kind.
#[pyfunction]
pub fn advances(kind: &str, method: &Bound<'_, PyAny>) -> PyResult<bool> {
    let mut reader = Reader { dimension: 2, functions: Vec::new() };
    Ok(systems::advances(kind, &reader.item(method, "integrator".to_owned())?, CATALOG))
}
