//! Records: descriptions of the items of a scene, converted from Python to the engine.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DVec3;
use numpy::ndarray::ArrayViewD;
use numpy::{Element, PyReadonlyArrayDyn};
use physcore_engine::scene::{Array, Item, Value};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyList, PyString, PyTuple};

use crate::callback::PythonFunction;
use crate::errors::SceneError;

/// Reader of the records of a scene of a given dimension; collects the functions that they hold.
pub struct Reader {
    pub dimension: usize,
    pub functions: Vec<Arc<PythonFunction>>,
}

/// Record of an item. The bodies on which it acts are given by index, and some of their particles by a mask.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct Record<'py> {
    kind: String,
    name: Option<String>,
    on: Option<Vec<usize>>,
    members: Option<PyReadonlyArrayDyn<'py, bool>>,
    values: Bound<'py, PyDict>,
}

impl Reader {
    /// Reads the items of the list at `path`.
    pub fn items(&mut self, list: &Bound<'_, PyAny>, path: &str) -> PyResult<Vec<Item>> {
        let entries = list.cast::<PyList>()?.iter().enumerate();
        entries.map(|(index, entry)| self.item(&entry, format!("{path}[{index}]"))).collect()
    }

    /// Reads the item that a record declares.
    pub fn item(&mut self, record: &Bound<'_, PyAny>, path: String) -> PyResult<Item> {
        let Record { kind, name, on, members, values: given } = record.extract()?;
        let members = members.map(|given| array(&given, |&flag| flag)).transpose()?.map(|array| array.entries);
        let mut item = Item { path, kind, name, on, members, values: BTreeMap::new() };
        for (name, value) in given.iter().filter(|(_, value)| !value.is_none()) {
            let name: String = name.extract()?;
            let value = self.value(&value, item.path_of(&name))?;
            item.values.insert(name, value);
        }
        Ok(item)
    }

    fn value(&mut self, value: &Bound<'_, PyAny>, path: String) -> PyResult<Value> {
        if let Ok(flag) = value.cast::<PyBool>() {
            return Ok(Value::Flag(flag.is_true()));
        }
        if let Ok(text) = value.cast::<PyString>() {
            return Ok(Value::Text(text.extract()?));
        }
        if value.is_instance_of::<PyDict>() {
            return Ok(Value::Record(Box::new(self.item(value, path)?)));
        }
        if let Ok(given) = value.extract() {
            return Ok(Value::Numbers(array(&given, |&number: &f64| number)?));
        }
        if let Ok(given) = value.extract() {
            return Ok(Value::Indices(indices(&given, &path)?));
        }
        if let Ok(given) = value.extract() {
            return Ok(Value::Flags(array(&given, |&flag: &bool| flag)?));
        }
        if value.is_callable() {
            let function = Arc::new(PythonFunction::new(value.clone().unbind(), self.dimension));
            self.functions.push(Arc::clone(&function));
            return Ok(Value::Callback(function));
        }
        if let Ok(number) = value.extract() {
            return Ok(Value::Number(number));
        }
        if let Ok(entries) = value.cast::<PyTuple>() {
            if entries.iter().any(|entry| entry.is_instance_of::<PyDict>()) {
                // A word among items is the kind of an item without values.
                let items = entries.iter().enumerate().map(|(index, entry)| match entry.cast::<PyString>() {
                    Ok(word) => Ok(Item::from(word.extract::<String>()?.as_str())),
                    Err(_) => self.item(&entry, format!("{path}[{index}]")),
                });
                return Ok(Value::Records(items.collect::<PyResult<_>>()?));
            }
            if entries.get_item(0).is_ok_and(|first| first.is_instance_of::<PyString>()) {
                return Ok(Value::Texts(entries.extract()?));
            }
        }
        match value.extract::<Vec<f64>>()?[..] {
            [x] => Ok(Value::Vector(DVec3::new(x, 0.0, 0.0))),
            [x, y] => Ok(Value::Vector(DVec3::new(x, y, 0.0))),
            [x, y, z] => Ok(Value::Vector(DVec3::new(x, y, z))),
            ref other => Err(SceneError::new_err(format!("{path}: must have up to 3 components, got {}", other.len()))),
        }
    }
}

/// Size of the arrays of a record [bytes].
pub fn bytes(record: &Bound<'_, PyAny>) -> PyResult<usize> {
    let values = record.get_item("values")?.cast_into::<PyDict>()?.values();
    values.iter().map(|value| value.getattr("nbytes").map_or(Ok(0), |bytes| bytes.extract())).sum()
}

/// Copies an array with each entry converted. The interpreter is free meanwhile.
fn array<T: Element + Sync, U: Send>(given: &PyReadonlyArrayDyn<'_, T>, convert: impl Fn(&T) -> U + Sync) -> PyResult<Array<U>> {
    let (py, view): (_, ArrayViewD<'_, T>) = (given.py(), given.as_array());
    let entries = py.detach(|| match view.as_slice() {
        Some(slice) => slice.iter().map(&convert).collect(),
        None => view.iter().map(&convert).collect(),
    });
    py.check_signals()?;
    Ok(Array { shape: view.shape().to_vec(), entries })
}

/// Copies an array of indices, refusing indices out of range.
fn indices(given: &PyReadonlyArrayDyn<'_, i64>, path: &str) -> PyResult<Array<u32>> {
    let view = given.as_array();
    if let Some(index) = view.iter().find(|&&index| u32::try_from(index).is_err()) {
        return Err(SceneError::new_err(format!("{path}: must hold indices from 0 to {}, got {index}", u32::MAX)));
    }
    array(given, |&index| index as u32)
}
