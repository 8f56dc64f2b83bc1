//! Errors of the engine as the exceptions defined in `physcore.errors`.

use physcore_engine::error::{Cause, Divergence, Error};
use pyo3::exceptions::{PyException, PyKeyboardInterrupt};
use pyo3::prelude::*;
use pyo3::types::PyDict;

pyo3::import_exception!(physcore.errors, PhyscoreError);
pyo3::import_exception!(physcore.errors, SceneError);
pyo3::import_exception!(physcore.errors, FileError);
pyo3::import_exception!(physcore.errors, InternalError);

/// Returns the exception for an error.
pub fn exception(py: Python<'_>, error: Error) -> PyErr {
    match error {
        Error::Parameter { .. } | Error::Undefined { .. } | Error::State(_) | Error::Memory { .. } => {
            SceneError::new_err(error.to_string())
        }
        Error::Callback { ref cause, .. } => raised(py, &error, cause),
        Error::Diverged(divergence) => diverged(py, &divergence).unwrap_or_else(|failure| failure),
        // If the signal handler raised an exception of its own, that exception is used.
        Error::Interrupted => PyErr::take(py).unwrap_or_else(|| PyKeyboardInterrupt::new_err("the run was interrupted")),
    }
}

/// Returns the exception for an error raised by a user-defined function, with this error as its cause. An error that is no
/// `Exception`, such as `SystemExit`, passes unchanged.
fn raised(py: Python<'_>, error: &Error, cause: &Cause) -> PyErr {
    let cause = cause.0.downcast_ref::<PyErr>().map(|raised| raised.clone_ref(py));
    match cause {
        Some(raised) if !raised.is_instance_of::<PyException>(py) => raised,
        cause => {
            let explained = SceneError::new_err(error.to_string());
            explained.set_cause(py, cause);
            explained
        }
    }
}

fn diverged(py: Python<'_>, divergence: &Divergence) -> PyResult<PyErr> {
    let attributes = PyDict::new(py);
    attributes.set_item("step", divergence.step)?;
    attributes.set_item("time", divergence.time)?;
    attributes.set_item("particle", divergence.index)?;
    attributes.set_item("element", &divergence.element)?;
    attributes.set_item("quantity", divergence.quantity)?;
    attributes.set_item("cause", &divergence.cause)?;
    attributes.set_item("hint", &divergence.hint)?;
    let class = py.import("physcore.errors")?.getattr("SimulationDiverged")?;
    Ok(PyErr::from_value(class.call((divergence.to_string(),), Some(&attributes))?))
}
