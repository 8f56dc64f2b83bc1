//! Bodies: the columns that all particles have, and the item with the kind and all other values.

use glam::DVec3;

use super::{Item, Value};
use crate::error::Result;

/// Body made of particles.
#[derive(Debug, Clone)]
pub struct Body {
    /// Positions [m].
    pub positions: Vec<DVec3>,
    /// Velocities [m/s].
    pub velocities: Vec<DVec3>,
    /// Masses [kg].
    pub mass: Vec<f64>,
    /// Charges [C].
    pub charge: Vec<f64>,
    /// Radii [m].
    pub radius: Vec<f64>,
    /// Whether each particle is fixed: it keeps its velocity whatever forces act on it.
    pub fixed: Vec<bool>,
    /// Kind of the body, with all other values.
    pub item: Item,
}

/// Kind of a body without further structure.
pub const PARTICLES: &str = "Particles";
/// Kind of a body whose particles are the centers of mass of rigid bodies.
pub const RIGID_BODIES: &str = "RigidBodies";

impl Default for Body {
    fn default() -> Self {
        Self {
            positions: Vec::new(),
            velocities: Vec::new(),
            mass: Vec::new(),
            charge: Vec::new(),
            radius: Vec::new(),
            fixed: Vec::new(),
            item: Item::new(PARTICLES, []),
        }
    }
}

impl Body {
    /// Reads the body that an item declares.
    ///
    /// # Errors
    /// If a column is missing, or does not have one row per particle.
    pub fn new(mut item: Item, dimension: usize) -> Result<Self> {
        let positions = vectors(&mut item, "positions", None, dimension)?;
        let count = positions.len();
        Ok(Self {
            velocities: vectors(&mut item, "velocities", Some(count), dimension)?,
            mass: numbers(&mut item, "mass", count)?,
            charge: numbers(&mut item, "charge", count)?,
            radius: numbers(&mut item, "radius", count)?,
            fixed: match item.values.remove("fixed") {
                Some(Value::Flags(array)) if array.shape == [count] => array.entries,
                other => return Err(item.wrong("fixed", &format!("true or false for {count} particles"), other.as_ref())),
            },
            positions,
            item,
        })
    }
}

/// Takes rows of vectors out of an item.
fn vectors(item: &mut Item, name: &str, count: Option<usize>, dimension: usize) -> Result<Vec<DVec3>> {
    let vectors = item.vectors(name, count, dimension)?;
    item.values.remove(name);
    Ok(vectors)
}

/// Takes one number for each particle out of an item.
fn numbers(item: &mut Item, name: &str, count: usize) -> Result<Vec<f64>> {
    match item.values.remove(name) {
        Some(Value::Numbers(array)) if array.shape == [count] => Ok(array.entries),
        other => Err(item.wrong(name, &format!("{count} numbers"), other.as_ref())),
    }
}
