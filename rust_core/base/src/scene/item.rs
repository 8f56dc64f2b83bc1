//! Items of a scene: a kind with named values. Only the code that builds the declared object knows the names.

use std::collections::BTreeMap;
use std::fmt::{Debug, Formatter};
use std::sync::Arc;

use glam::DVec3;

use super::Callback;
use crate::error::{Error, Result};

/// Body, force, boundary or other item, as the user declared it.
#[derive(Debug, Clone, Default)]
pub struct Item {
    /// Path of the item in the scene, such as `forces[2]`.
    pub path: String,
    /// Kind of the item; in Python, the name of its class.
    pub kind: String,
    /// Name given by the user.
    pub name: Option<String>,
    /// Indices of the bodies on which the item acts; None for all.
    pub on: Option<Vec<usize>>,
    /// Whether the item acts on each particle of the scene, in the caller's order; None if it acts on whole bodies.
    pub members: Option<Vec<bool>>,
    /// Values by name; values left open are absent.
    pub values: BTreeMap<String, Value>,
}

/// Items are equal if their contents are, wherever they stand in the scene.
impl PartialEq for Item {
    fn eq(&self, other: &Self) -> bool {
        (&self.kind, &self.name, &self.on, &self.members, &self.values)
            == (&other.kind, &other.name, &other.on, &other.members, &other.values)
    }
}

/// Value of an item.
#[derive(Clone)]
pub enum Value {
    /// Number.
    Number(f64),
    /// Vector of up to three components; missing components are 0.
    Vector(DVec3),
    /// Boolean.
    Flag(bool),
    /// Text.
    Text(String),
    /// Array of numbers.
    Numbers(Array<f64>),
    /// Array of indices.
    Indices(Array<u32>),
    /// Array of booleans.
    Flags(Array<bool>),
    /// User-defined function.
    Callback(Arc<dyn Callback>),
    /// Texts.
    Texts(Vec<String>),
    /// Item within the item.
    Record(Box<Item>),
    /// Items within the item.
    Records(Vec<Item>),
}

/// Array with any number of axes, the last of which varies fastest.
#[derive(Clone, PartialEq)]
pub struct Array<T> {
    /// Length of each axis.
    pub shape: Vec<usize>,
    /// Entries; their number is the product of the lengths.
    pub entries: Vec<T>,
}

impl<T> Debug for Array<T> {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "an array of shape {:?}", self.shape)
    }
}

impl<T> From<Vec<T>> for Array<T> {
    fn from(entries: Vec<T>) -> Self {
        Self { shape: vec![entries.len()], entries }
    }
}

impl Debug for Value {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Number(number) => write!(formatter, "{number}"),
            Self::Vector(vector) => write!(formatter, "{vector}"),
            Self::Flag(flag) => write!(formatter, "{flag}"),
            Self::Text(text) => write!(formatter, "{text}"),
            Self::Numbers(array) => write!(formatter, "{array:?} of numbers"),
            Self::Indices(array) => write!(formatter, "{array:?} of indices"),
            Self::Flags(array) => write!(formatter, "{array:?} of true and false"),
            Self::Callback(_) => write!(formatter, "a function"),
            Self::Texts(texts) => write!(formatter, "{texts:?}"),
            Self::Record(item) => write!(formatter, "{}", item.kind),
            Self::Records(items) => write!(formatter, "{} items", items.len()),
        }
    }
}

/// Functions are equal if they are identical.
impl PartialEq for Value {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Number(one), Self::Number(other)) => one == other,
            (Self::Vector(one), Self::Vector(other)) => one == other,
            (Self::Flag(one), Self::Flag(other)) => one == other,
            (Self::Text(one), Self::Text(other)) => one == other,
            (Self::Numbers(one), Self::Numbers(other)) => one == other,
            (Self::Indices(one), Self::Indices(other)) => one == other,
            (Self::Flags(one), Self::Flags(other)) => one == other,
            (Self::Callback(one), Self::Callback(other)) => Arc::ptr_eq(one, other),
            (Self::Texts(one), Self::Texts(other)) => one == other,
            (Self::Record(one), Self::Record(other)) => one == other,
            (Self::Records(one), Self::Records(other)) => one == other,
            _ => false,
        }
    }
}

/// Converts a kind to an item without values.
impl From<&str> for Item {
    fn from(kind: &str) -> Self {
        Self { kind: kind.to_owned(), ..Self::default() }
    }
}

impl Item {
    /// Returns an item of a kind with these values, which acts on all bodies.
    pub fn new(kind: &str, values: impl IntoIterator<Item = (&'static str, Value)>) -> Self {
        let values = values.into_iter().map(|(name, value)| (name.to_owned(), value)).collect();
        Self { kind: kind.to_owned(), values, ..Self::default() }
    }

    /// Whether the item acts on a body, or on some of its particles.
    pub fn acts_on(&self, body: usize) -> bool {
        self.on.as_ref().is_none_or(|bodies| bodies.contains(&body))
    }

    /// Number of cells of the largest grid of the item: the product of a vector `cells`, here or in an item within it.
    pub fn cells(&self) -> usize {
        let cells = |(name, value): (&String, &Value)| match value {
            Value::Vector(cells) if name == "cells" => {
                cells.to_array().iter().map(|&count| count.max(1.0)).product::<f64>() as usize
            }
            Value::Record(item) => item.cells(),
            _ => 0,
        };
        self.values.iter().map(cells).max().unwrap_or(0)
    }

    /// Reads a number that must be present and finite.
    pub fn number(&self, name: &str) -> Result<f64> {
        match self.values.get(name) {
            Some(Value::Number(number)) if number.is_finite() => Ok(*number),
            other => Err(self.wrong(name, "a finite number", other)),
        }
    }

    /// Reads a number that must be present, finite and at least 0.
    pub fn non_negative(&self, name: &str) -> Result<f64> {
        match self.number(name)? {
            number if number >= 0.0 => Ok(number),
            number => Err(self.wrong(name, "a number ≥ 0", Some(&Value::Number(number)))),
        }
    }

    /// Reads a vector that must be present and finite.
    pub fn vector(&self, name: &str) -> Result<DVec3> {
        match self.values.get(name) {
            Some(Value::Vector(vector)) if vector.is_finite() => Ok(*vector),
            other => Err(self.wrong(name, "a finite vector", other)),
        }
    }

    /// Reads an optional vector.
    pub fn optional_vector(&self, name: &str) -> Result<Option<DVec3>> {
        if self.values.contains_key(name) { self.vector(name).map(Some) } else { Ok(None) }
    }

    /// Reads a boolean.
    pub fn flag(&self, name: &str) -> Result<bool> {
        match self.values.get(name) {
            Some(Value::Flag(flag)) => Ok(*flag),
            other => Err(self.wrong(name, "true or false", other)),
        }
    }

    /// Reads one of several words.
    pub fn word(&self, name: &str, known: &[&'static str]) -> Result<&'static str> {
        let given = self.values.get(name);
        let found = known.iter().find(|word| matches!(given, Some(Value::Text(text)) if text == *word));
        found.copied().ok_or_else(|| self.wrong(name, &known.join(" or "), given))
    }

    /// Reads a list of `count` numbers.
    pub fn numbers(&self, name: &str, count: usize) -> Result<&[f64]> {
        match self.values.get(name) {
            Some(Value::Numbers(array)) if array.shape == [count] => Ok(&array.entries),
            other => Err(self.wrong(name, &format!("{count} numbers"), other)),
        }
    }

    /// Reads rows of `dimension` numbers, 2 or 3, as vectors: `count` of them, if given.
    pub fn vectors(&self, name: &str, count: Option<usize>, dimension: usize) -> Result<Vec<DVec3>> {
        let fits =
            |array: &Array<f64>| matches!(array.shape[..], [rows, width] if width == dimension && rows == count.unwrap_or(rows));
        match self.values.get(name) {
            Some(Value::Numbers(array)) if fits(array) => Ok(match dimension {
                3 => array.entries.as_chunks().0.iter().map(|&row| DVec3::from_array(row)).collect(),
                _ => array.entries.as_chunks().0.iter().map(|&[x, y]| DVec3::new(x, y, 0.0)).collect(),
            }),
            other => Err(self.wrong(name, &format!("rows of {dimension} components, one for each"), other)),
        }
    }

    /// Reads rows of N indices each.
    pub fn tuples<const N: usize>(&self, name: &str) -> Result<&[[u32; N]]> {
        match self.values.get(name) {
            Some(Value::Indices(array)) if matches!(array.shape[..], [_, width] if width == N) => Ok(array.entries.as_chunks().0),
            other => Err(self.wrong(name, &format!("rows of {N} indices"), other)),
        }
    }

    /// Reads an item within the item.
    pub fn record(&self, name: &str) -> Result<&Self> {
        match self.values.get(name) {
            Some(Value::Record(item)) => Ok(item),
            other => Err(self.wrong(name, "an item", other)),
        }
    }

    /// Reads items within the item; none if absent.
    pub fn records(&self, name: &str) -> Result<&[Self]> {
        match self.values.get(name) {
            None => Ok(&[]),
            Some(Value::Records(items)) => Ok(items),
            other => Err(self.wrong(name, "some items", other)),
        }
    }

    /// Reads `count` texts, each one of several words. Of items in their place, the kinds are read.
    pub fn words(&self, name: &str, count: usize, known: &[&'static str]) -> Result<Vec<&'static str>> {
        let given = self.values.get(name);
        let expected = || self.wrong(name, &format!("{count} times {}", known.join(" or ")), given);
        let texts: Vec<&String> = match given {
            Some(Value::Texts(texts)) => texts.iter().collect(),
            Some(Value::Records(items)) => items.iter().map(|item| &item.kind).collect(),
            _ => return Err(expected()),
        };
        let found: Option<Vec<_>> = texts.into_iter().map(|text| known.iter().copied().find(|word| word == text)).collect();
        found.filter(|found| found.len() == count).ok_or_else(expected)
    }

    /// Reads a user-defined function.
    pub fn callback(&self, name: &str) -> Result<Arc<dyn Callback>> {
        match self.values.get(name) {
            Some(Value::Callback(callback)) => Ok(Arc::clone(callback)),
            other => Err(self.wrong(name, "a function", other)),
        }
    }

    /// Reads an optional user-defined function.
    pub fn optional_callback(&self, name: &str) -> Result<Option<Arc<dyn Callback>>> {
        if self.values.contains_key(name) { self.callback(name).map(Some) } else { Ok(None) }
    }

    /// Path of a value, such as `forces[2].stiffness`; of an entry of a mapping, which has no kind, such as `initial['u']`.
    pub fn path_of(&self, name: &str) -> String {
        let Self { path, kind, .. } = self;
        if kind.is_empty() { format!("{path}['{name}']") } else { format!("{path}.{name}") }
    }

    /// Returns the error that a value is not as expected.
    pub fn wrong(&self, name: &str, expected: &str, found: Option<&Value>) -> Error {
        let found = found.map_or_else(|| "nothing".to_owned(), |value| format!("{value:?}"));
        Error::parameter(self.path_of(name), expected, found)
    }
}
