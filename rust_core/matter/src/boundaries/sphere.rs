//! Sphere that confines particles to its inside or outside; in 2D a circle.

use glam::DVec3;

use super::{Boundary, Wall};
use crate::error::Result;
use crate::scene::{Item, Value};

/// Inside or outside of a sphere.
#[derive(Debug)]
pub struct Sphere {
    wall: [Wall; 1],
}

impl Sphere {
    /// Sphere around the item's `center` [m] with its `radius` [m]. Matter stays `inside`, or else outside.
    #[inline]
    pub fn new(item: &Item, origin: DVec3) -> Result<Self> {
        let radius = item.number("radius")?;
        if radius <= 0.0 {
            return Err(item.wrong("radius", "a number > 0", Some(&Value::Number(radius))));
        }
        Ok(Self { wall: [Wall::Sphere { center: item.vector("center")? - origin, radius, inside: item.flag("inside")? }] })
    }
}

impl Boundary for Sphere {
    fn name(&self) -> &'static str {
        "sphere"
    }

    fn walls(&self) -> &[Wall] {
        &self.wall
    }
}
