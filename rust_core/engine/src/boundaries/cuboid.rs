//! A box along the axes; in 2D a rectangle.

use glam::DVec3;

use super::{Boundary, Wall};
use crate::error::Result;
use crate::math::AXES;
use crate::scene::{Item, Value};

/// The inside of a box; `Box` in scenes.
#[derive(Debug)]
pub struct Cuboid {
    walls: Vec<Wall>,
}

impl Cuboid {
    /// The box between the item's corners `lower` and `upper` [m].
    pub fn new(item: &Item, dimension: usize, origin: DVec3) -> Result<Self> {
        let (lower, upper) = (item.vector("lower")?, item.vector("upper")?);
        if (0..dimension).any(|axis| lower[axis] >= upper[axis]) {
            return Err(item.wrong("upper", &format!("more than lower, {lower}, along every axis"), Some(&Value::Vector(upper))));
        }
        let walls = DVec3::AXES[..dimension.min(AXES)].iter().flat_map(|&normal| {
            let offset = |point: DVec3, normal: DVec3| Wall::Plane { normal, offset: normal.dot(point - origin) };
            [offset(lower, normal), offset(upper, -normal)]
        });
        Ok(Self { walls: walls.collect() })
    }
}

impl Boundary for Cuboid {
    fn name(&self) -> &'static str {
        "box"
    }

    fn walls(&self) -> &[Wall] {
        &self.walls
    }
}
