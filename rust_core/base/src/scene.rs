//! Scene description: plain numbers in double precision, in the caller's order, independent of numerical methods.

use glam::DVec3;

use crate::error::{Error, Result};

mod body;
mod callback;
mod item;

pub use body::{Body, PARTICLES, RIGID_BODIES};
pub use callback::{Argument, Callback, Failure};
pub use item::{Array, Item, Value};

/// Complete description of a scene.
#[derive(Debug, Clone, Default)]
pub struct Scene {
    /// Number of dimensions, 2 or 3. In 2D the third component of every vector is 0.
    pub dimension: usize,
    /// Bodies, in the order in which results concatenate them.
    pub bodies: Vec<Body>,
    /// Forces other than those that belong to bodies.
    pub forces: Vec<Item>,
    /// Boundaries.
    pub boundaries: Vec<Item>,
    /// Constraints.
    pub constraints: Vec<Item>,
    /// Systems other than matter.
    pub systems: Vec<Item>,
    /// Pressure probes.
    pub probes: Vec<Item>,
    /// Periodic domain: its lower and upper corner [m], infinite along an axis that is not periodic.
    pub periodic: Option<[DVec3; 2]>,
}

impl Scene {
    /// Number of particles.
    pub fn count(&self) -> usize {
        self.bodies.iter().map(|body| body.positions.len()).sum()
    }

    /// Approximate cost of reading the scene, in entries: particles, rows of the longest array of each body, and grid cells of
    /// each further system.
    pub fn rows(&self) -> usize {
        let rows = |value: &Value| match value {
            Value::Numbers(Array { shape, .. }) | Value::Indices(Array { shape, .. }) => shape.first().copied().unwrap_or(0),
            _ => 0,
        };
        let longest = |body: &Body| body.item.values.values().map(rows).max().unwrap_or(0);
        self.count() + self.bodies.iter().map(longest).sum::<usize>() + self.systems.iter().map(Item::cells).sum::<usize>()
    }

    /// Index of the first particle of a body.
    pub fn first(&self, body: usize) -> usize {
        self.bodies[..body].iter().map(|body| body.positions.len()).sum()
    }

    /// Positions of all particles, body by body [m].
    pub fn positions(&self) -> Vec<DVec3> {
        self.bodies.iter().flat_map(|body| &body.positions).copied().collect()
    }

    /// Whether an item acts on each particle.
    pub fn members(&self, item: &Item) -> Vec<bool> {
        if let Some(members) = &item.members {
            return members.clone();
        }
        let bodies = self.bodies.iter().enumerate();
        bodies.flat_map(|(index, body)| std::iter::repeat_n(item.acts_on(index), body.positions.len())).collect()
    }
}

/// Corners of the periodic domain that an item declares [m]. In 2D the third axis is not periodic.
///
/// # Errors
/// If a corner is missing.
pub fn corners(item: &Item, dimension: usize) -> Result<[DVec3; 2]> {
    let corner = |name: &str, open: f64| match item.values.get(name) {
        Some(Value::Vector(corner)) if !corner.is_nan() => Ok(if dimension == 2 { corner.with_z(open) } else { *corner }),
        other => Err(item.wrong(name, "a corner", other)),
    };
    Ok([corner("lower", f64::NEG_INFINITY)?, corner("upper", f64::INFINITY)?])
}

/// Returns the error that an item is of an unknown kind.
pub fn unknown(item: &Item, expected: &str) -> Error {
    Error::parameter(&item.path, expected, &item.kind)
}
