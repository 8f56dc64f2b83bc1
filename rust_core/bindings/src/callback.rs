//! User-defined functions. They are called with copies of the state, and their results are checked.

use std::sync::Arc;

use numpy::{PyArrayDescrMethods, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArray, PyUntypedArrayMethods, ToPyArray};
use physcore_engine::error::Cause;
use physcore_engine::scene::{Argument, Callback, Failure};
use pyo3::exceptions::{PyException, PyKeyError, PyValueError};
use pyo3::gc::{PyTraverseError, PyVisit};
use pyo3::prelude::*;
use pyo3::types::{PyFloat, PyInt, PyList, PyTuple};

use crate::scene::array;

/// Depth of lists that are looked through entry by entry.
const NESTED: usize = 3;

/// Python function, called with vectors of this dimension.
pub struct PythonFunction {
    function: Py<PyAny>,
    dimension: usize,
}

impl PythonFunction {
    pub fn new(function: Py<PyAny>, dimension: usize) -> Self {
        Self { function, dimension }
    }

    /// Visits the Python references, for the garbage collector.
    pub fn traverse(&self, visit: &PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(&self.function)
    }
}

impl Callback for PythonFunction {
    fn call(&self, arguments: &[Argument<'_>], what: &str, shape: &[usize]) -> Result<Vec<f64>, Failure> {
        let expected = if shape.is_empty() { what.to_owned() } else { format!("{what} of shape {}", tuple(shape)) };
        let numbers = Python::attach(|py| {
            let object = |argument: &Argument<'_>| match *argument {
                Argument::Number(number) => Ok(PyFloat::new(py, number).into_any()),
                Argument::Vectors(vectors) => Ok(array(py, vectors, self.dimension)?.into_any()),
                Argument::Array { numbers, shape } => Ok(numbers.to_pyarray(py).reshape(shape.to_vec())?.into_any()),
            };
            let objects = arguments.iter().map(object).collect::<PyResult<Vec<_>>>()?;
            let given = self.function.bind(py).call1(PyTuple::new(py, objects)?)?;
            real(&given, shape, &expected)
        });
        numbers.map_err(failure)
    }
}

/// Reason for refusing a result.
enum Reason {
    Raised(PyErr),
    Refused { expected: String, found: String, hint: String },
}

impl From<PyErr> for Reason {
    fn from(error: PyErr) -> Self {
        Self::Raised(error)
    }
}

fn failure(reason: Reason) -> Failure {
    match reason {
        Reason::Raised(error) => Failure::Raised(Cause(Arc::new(error))),
        Reason::Refused { expected, found, hint } => Failure::Refused { expected, found, hint },
    }
}

/// Converts the result of a function to numbers, row by row. Accepts any regular array of real numbers with this shape, or a
/// sequence that converts to one.
fn real(given: &Bound<'_, PyAny>, shape: &[usize], expected: &str) -> Result<Vec<f64>, Reason> {
    let py = given.py();
    let hinted = |found, hint| Reason::Refused { expected: format!("{expected}, of real numbers"), found, hint };
    let refused = |found| hinted(found, String::new());
    if given.is_none() {
        return Err(hinted("None".to_owned(), "does it end with return?".to_owned()));
    }
    if is_masked(given)? {
        return Err(refused("masked entries".to_owned()));
    }
    let numpy = py.import("numpy")?;
    let array = numpy.call_method1("asarray", (given,)).map_err(|error| {
        let irregular = error.is_instance_of::<PyValueError>(py);
        if irregular { refused(format!("what is no regular array ({})", error.value(py))) } else { error.into() }
    })?;
    let array = array.cast_into::<PyUntypedArray>().map_err(PyErr::from)?;
    if !b"iuf".contains(&array.dtype().kind()) {
        return Err(refused(format!("an array of {}, made of {}", array.dtype(), given.get_type().name()?)));
    }
    if array.shape() != shape {
        return Err(hinted(format!("the shape {}", tuple(array.shape())), remedy(array.shape(), shape)));
    }
    let numbers = numpy.call_method1("ascontiguousarray", (array, "float64"))?;
    Ok(numbers.extract::<PyReadonlyArrayDyn<'_, f64>>()?.as_array().iter().copied().collect())
}

/// Remedy of a result that has another shape than expected; empty if none is likely to be meant.
fn remedy(given: &[usize], expected: &[usize]) -> String {
    let (transposed, size) = (given.iter().rev().eq(expected), |shape: &[usize]| shape.iter().product::<usize>());
    match expected {
        [] if given.iter().all(|&length| length == 1) => "take its only entry, by value.item()".to_owned(),
        [] => "one number is needed, such as the sum of these".to_owned(),
        _ if expected.ends_with(given) => format!("return np.broadcast_to(value, {})", tuple(expected)),
        _ if transposed => "return value.T".to_owned(),
        _ if size(given) == size(expected) => {
            format!("if the order is right, return value.reshape({})", tuple(expected))
        }
        _ => String::new(),
    }
}

/// Whether any entry is masked; false if `numpy.ma` is not loaded.
fn is_masked(given: &Bound<'_, PyAny>) -> PyResult<bool> {
    let py = given.py();
    if is_plain(given, NESTED) {
        return Ok(false);
    }
    let modules = py.import("sys")?.getattr("modules")?;
    let masked = match modules.get_item("numpy.ma") {
        Err(error) if error.is_instance_of::<PyKeyError>(py) => return Ok(false),
        other => other?,
    };
    if given.is_instance_of::<PyUntypedArray>() {
        return masked.call_method1("is_masked", (given,))?.is_truthy();
    }
    match masked.call_method1("array", (given,)) {
        // A list may hold masked arrays; an irregular list is refused as such. An interrupt is no `Exception` and passes through.
        Err(error) if error.is_instance_of::<PyException>(py) => Ok(false),
        whole => masked.call_method1("is_masked", (whole?,))?.is_truthy(),
    }
}

/// Whether a result consists of numbers, of arrays of no derived type, or of lists and tuples of these up to a depth. None of
/// them has masks, but `numpy.ma` takes longer to say so than most functions take.
fn is_plain(given: &Bound<'_, PyAny>, depth: usize) -> bool {
    if given.is_exact_instance_of::<PyTuple>() || given.is_exact_instance_of::<PyList>() {
        let is_plain = |entry: PyResult<Bound<'_, PyAny>>| entry.is_ok_and(|entry| is_plain(&entry, depth - 1));
        return depth > 0 && given.try_iter().is_ok_and(|mut entries| entries.all(is_plain));
    }
    given.is_exact_instance_of::<PyUntypedArray>()
        || given.is_exact_instance_of::<PyFloat>()
        || given.is_exact_instance_of::<PyInt>()
}

/// Formats a shape in Python's notation.
fn tuple(shape: &[usize]) -> String {
    match shape {
        [one] => format!("({one},)"),
        _ => format!("({})", shape.iter().map(ToString::to_string).collect::<Vec<String>>().join(", ")),
    }
}
