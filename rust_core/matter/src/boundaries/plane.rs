//! Plane, such as a floor; in 2D a line.

use glam::DVec3;

use super::{Boundary, Wall};
use crate::error::Result;
use crate::scene::{Item, Value};

/// Half-space above a plane.
#[derive(Debug)]
pub struct Plane {
    wall: [Wall; 1],
}

impl Plane {
    /// Plane through the item's `point` [m]. Its `normal`, of any length, points to the allowed side.
    #[inline]
    pub fn new(item: &Item, origin: DVec3) -> Result<Self> {
        let direction = item.vector("normal")?;
        // The vector is scaled first, so that squares of very long or short normals neither overflow nor underflow.
        let largest = direction.abs().max_element();
        let Some(normal) = (direction / largest).try_normalize() else {
            return Err(item.wrong("normal", "a vector that is not zero", Some(&Value::Vector(direction))));
        };
        Ok(Self { wall: [Wall::Plane { normal, offset: normal.dot(item.vector("point")? - origin) }] })
    }
}

impl Boundary for Plane {
    fn name(&self) -> &'static str {
        "plane"
    }

    fn walls(&self) -> &[Wall] {
        &self.wall
    }
}
