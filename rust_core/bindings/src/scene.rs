//! A scene as Python describes it: dictionaries of numbers and arrays.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DVec3;
use numpy::{PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use physcore_engine::memory;
use physcore_engine::scene::{Body, Fluid, Scene, Spring, Term, Value};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyList};

use crate::callback::Function;
use crate::errors::{SceneError, exception};

/// Reads a scene, with the functions that it holds.
pub fn read(scene: &Bound<'_, PyDict>) -> PyResult<(Scene, Vec<Arc<Function>>)> {
    let dimension: usize = item(scene, "dimension")?.extract()?;
    let list = |name: &str| -> PyResult<Vec<Bound<'_, PyDict>>> {
        item(scene, name)?.cast::<PyList>()?.iter().map(|entry| Ok(entry.cast_into()?)).collect()
    };
    let bodies = list("bodies")?;
    let arrays = bodies.iter().map(bytes).sum::<PyResult<usize>>()?;
    // Vectors have three components here.
    memory::check("scene", arrays / 2 * 3, 0, || "for a copy of its arrays; take fewer particles".to_owned())
        .map_err(|error| exception(scene.py(), error))?;
    let mut functions = Vec::new();
    let mut terms = |name: &str| -> PyResult<Vec<Term>> {
        list(name)?
            .iter()
            .enumerate()
            .map(|(index, entry)| term(entry, format!("{name}[{index}]"), dimension, &mut functions))
            .collect()
    };
    let scene = Scene {
        dimension,
        bodies: bodies.iter().map(body).collect::<PyResult<_>>()?,
        forces: terms("forces")?,
        boundaries: terms("boundaries")?,
        periodic: periodic(&item(scene, "periodic")?)?,
    };
    Ok((scene, functions))
}

/// The bytes that the arrays of a body take.
fn bytes(entry: &Bound<'_, PyDict>) -> PyResult<usize> {
    entry.values().iter().map(|value| value.getattr("nbytes").map_or(Ok(0), |bytes| bytes.extract())).sum()
}

/// The corners of the periodic domain, or nothing. In 2D the third axis is not periodic.
fn periodic(corners: &Bound<'_, PyAny>) -> PyResult<Option<[DVec3; 2]>> {
    let corners: Option<[Vec<f64>; 2]> = corners.extract()?;
    Ok(corners.map(|[lower, upper]| {
        let mut ends = [DVec3::NEG_INFINITY, DVec3::INFINITY];
        for (end, corner) in ends.iter_mut().zip([lower, upper]) {
            (0..3).zip(corner).for_each(|(axis, component)| end[axis] = component);
        }
        ends
    }))
}

fn item<'py>(dictionary: &Bound<'py, PyDict>, name: &str) -> PyResult<Bound<'py, PyAny>> {
    dictionary.get_item(name)?.ok_or_else(|| SceneError::new_err(format!("scene: {name} is missing")))
}

fn body(entry: &Bound<'_, PyDict>) -> PyResult<Body> {
    let numbers = |name: &str| -> PyResult<Vec<f64>> { copied(&item(entry, name)?.extract()?) };
    let fixed = copied(&item(entry, "fixed")?.extract::<PyReadonlyArray1<'_, bool>>()?)?;
    let positions = vectors(&item(entry, "positions")?)?;
    Ok(Body {
        velocities: vectors(&item(entry, "velocities")?)?,
        mass: numbers("mass")?,
        charge: numbers("charge")?,
        radius: numbers("radius")?,
        springs: springs(entry, positions.len())?,
        positions,
        fixed,
        fluid: fluid(&item(entry, "fluid")?)?,
    })
}

/// What makes a body a fluid, or nothing.
fn fluid(entry: &Bound<'_, PyAny>) -> PyResult<Option<Fluid>> {
    if entry.is_none() {
        return Ok(None);
    }
    let entry = entry.cast::<PyDict>()?;
    let number = |name: &str| -> PyResult<f64> { item(entry, name)?.extract() };
    Ok(Some(Fluid {
        spacing: number("spacing")?,
        density: number("density")?,
        viscosity: number("viscosity")?,
        sound_speed: item(entry, "sound_speed")?.extract()?,
        artificial_viscosity: number("artificial_viscosity")?,
        density_diffusion: number("density_diffusion")?,
        surface_tension: number("surface_tension")?,
        shifting: number("shifting")?,
        summation: item(entry, "summation")?.extract()?,
        kernel: item(entry, "kernel")?.extract()?,
        smoothing: number("smoothing")?,
        obstacles: item(entry, "obstacles")?.extract()?,
    }))
}

fn springs(entry: &Bound<'_, PyDict>, count: usize) -> PyResult<Vec<Spring>> {
    let pairs = item(entry, "pairs")?.extract::<PyReadonlyArray2<'_, i64>>()?;
    let numbers = |name: &str| -> PyResult<Vec<f64>> { copied(&item(entry, name)?.extract()?) };
    let (stiffness, damping, rest_length) = (numbers("stiffness")?, numbers("damping")?, numbers("rest_length")?);
    let end = |index: i64| u32::try_from(index).ok().filter(|&index| (index as usize) < count);
    let spring = |(index, pair): (usize, numpy::ndarray::ArrayView1<'_, i64>)| match (end(pair[0]), end(pair[1])) {
        (Some(one), Some(other)) => Ok(Spring {
            ends: [one, other],
            stiffness: stiffness[index],
            damping: damping[index],
            rest_length: rest_length[index],
        }),
        _ => Err(SceneError::new_err(format!(
            "pairs[{index}]: must name two of {count} particles, got [{}, {}]",
            pair[0], pair[1]
        ))),
    };
    let (py, pairs) = (entry.py(), pairs.as_array());
    let mut springs = Vec::with_capacity(pairs.nrows());
    while springs.len() < pairs.nrows() {
        let part = py.detach(|| -> PyResult<Vec<Spring>> {
            pairs.outer_iter().enumerate().skip(springs.len()).take(PART).map(spring).collect()
        });
        springs.extend(part?);
        py.check_signals()?;
    }
    Ok(springs)
}

/// Springs that are read between two looks at whether the user interrupts.
const PART: usize = 1 << 18;

/// A copy of an array, with the interpreter free meanwhile.
pub fn copied<T: numpy::Element + Clone + Sync>(array: &PyReadonlyArray1<'_, T>) -> PyResult<Vec<T>> {
    let (py, numbers) = (array.py(), array.as_array());
    let copy = py.detach(|| numbers.to_vec());
    py.check_signals()?;
    Ok(copy)
}

/// The rows of an (N, 2) or (N, 3) array, the third component 0 where there is none.
pub fn vectors(array: &Bound<'_, PyAny>) -> PyResult<Vec<DVec3>> {
    let (py, array) = (array.py(), array.extract::<PyReadonlyArray2<'_, f64>>()?);
    let rows = array.as_array();
    let vectors = py.detach(|| rows.outer_iter().map(|row| vector(row.iter().copied())).collect());
    py.check_signals()?;
    Ok(vectors)
}

fn vector(components: impl Iterator<Item = f64>) -> DVec3 {
    let mut all = [0.0; 3];
    all.iter_mut().zip(components).for_each(|(slot, component)| *slot = component);
    DVec3::from_array(all)
}

/// An (N, D) array of vectors.
pub fn array<'py>(py: Python<'py>, vectors: &[DVec3], dimension: usize) -> PyResult<Bound<'py, PyArray2<f64>>> {
    rows(py, flat(vectors, dimension), dimension)
}

/// The components of vectors, one vector after the other.
pub fn flat(vectors: &[DVec3], dimension: usize) -> Vec<f64> {
    vectors.iter().flat_map(|vector| vector.to_array().into_iter().take(dimension)).collect()
}

/// An (N, D) array that takes over these components.
pub fn rows(py: Python<'_>, numbers: Vec<f64>, dimension: usize) -> PyResult<Bound<'_, PyArray2<f64>>> {
    let array = numpy::ndarray::Array2::from_shape_vec((numbers.len() / dimension, dimension), numbers);
    Ok(PyArray2::from_owned_array(py, array.map_err(|error| SceneError::new_err(error.to_string()))?))
}

/// A term of the scene; a function in it comes with its potential, which stands beside it, and is added to `functions`.
fn term(entry: &Bound<'_, PyDict>, path: String, dimension: usize, functions: &mut Vec<Arc<Function>>) -> PyResult<Term> {
    let mut values = BTreeMap::new();
    for (name, value) in entry.iter() {
        let name: String = name.extract()?;
        if ["type", "on", "potential"].contains(&name.as_str()) || value.is_none() {
            continue;
        }
        let value = if value.is_callable() {
            let potential = entry.get_item("potential")?.filter(|potential| !potential.is_none());
            let function = Arc::new(Function::new(value.unbind(), potential.map(Bound::unbind), dimension));
            functions.push(Arc::clone(&function));
            Value::Callback(function)
        } else {
            parameter(&value)?
        };
        values.insert(name, value);
    }
    Ok(Term { path, kind: item(entry, "type")?.extract()?, on: item(entry, "on")?.extract()?, values })
}

/// A parameter of a term.
fn parameter(value: &Bound<'_, PyAny>) -> PyResult<Value> {
    if let Ok(flag) = value.cast::<PyBool>() {
        return Ok(Value::Flag(flag.is_true()));
    }
    if let Ok(number) = value.extract::<f64>() {
        return Ok(Value::Number(number));
    }
    Ok(Value::Vector(vector(value.extract::<Vec<f64>>()?.into_iter())))
}
