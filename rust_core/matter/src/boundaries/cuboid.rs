//! Box along the axes; in 2D a rectangle.

use std::sync::Arc;

use glam::DVec3;

use super::{Boundary, Polytope, Wall};
use crate::error::Result;
use crate::math::AXES;
use crate::scene::{Item, Value};

/// Inside or outside of a box; `Box` in scenes.
#[derive(Debug)]
pub struct Cuboid {
    walls: Vec<Wall>,
}

impl Cuboid {
    /// Box between the item's corners `lower` and `upper` [m]. Matter stays `inside`, or else outside.
    pub fn new(item: &Item, dimension: usize, origin: DVec3) -> Result<Self> {
        let (lower, upper) = (item.vector("lower")?, item.vector("upper")?);
        if (0..dimension).any(|axis| lower[axis] >= upper[axis]) {
            return Err(item.wrong("upper", &format!("more than lower, {lower}, along every axis"), Some(&Value::Vector(upper))));
        }
        if item.values.contains_key("inside") && !item.flag("inside")? {
            let corner = |bits: usize| {
                let part = |axis: usize| if bits >> axis & 1 == 0 { lower[axis] } else { upper[axis] };
                DVec3::new(part(0), part(1), part(2)) - origin
            };
            let corners: Vec<DVec3> = (0..1 << dimension).map(corner).collect();
            let solid = Polytope::hull(&corners, dimension, 0.0).map(|hull| Wall::Solid(Arc::new(hull)));
            let walls = solid.ok_or_else(|| item.wrong("upper", "a corner that is not flat", Some(&Value::Vector(upper))))?;
            return Ok(Self { walls: vec![walls] });
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
