//! Solid obstacles: capsules and convex hulls.

use std::sync::Arc;

use glam::DVec3;

use super::{Boundary, Polytope, Wall};
use crate::error::{Error, Result};
use crate::scene::{Item, Value};

/// Outside of a convex solid.
#[derive(Debug)]
pub struct Solid {
    name: &'static str,
    wall: [Wall; 1],
}

impl Solid {
    /// Capsule: all points within the item's `radius` [m] of the segment from its `start` to its `end` [m].
    #[inline]
    pub fn capsule(item: &Item, origin: DVec3) -> Result<Self> {
        let radius = item.number("radius")?;
        if radius <= 0.0 {
            return Err(item.wrong("radius", "a number > 0", Some(&Value::Number(radius))));
        }
        let ends = [item.vector("start")? - origin, item.vector("end")? - origin];
        Ok(Self::new("capsule", Polytope::capsule(ends, radius)))
    }

    /// Hull of the item's `points` [m], in rows of `dimension` numbers.
    #[inline]
    pub fn hull(item: &Item, dimension: usize, origin: DVec3) -> Result<Self> {
        let points: Vec<DVec3> = item.vectors("points", None, dimension)?.into_iter().map(|point| point - origin).collect();
        let hull = Polytope::hull(&points, dimension, 0.0);
        let spanned = if dimension == 2 { "points that span an area" } else { "points that span a volume" };
        let flat = || Error::parameter(format!("{}.points", item.path), spanned, "flat ones");
        Ok(Self::new("convex hull", hull.ok_or_else(flat)?))
    }

    fn new(name: &'static str, polytope: Polytope) -> Self {
        Self { name, wall: [Wall::Solid(Arc::new(polytope))] }
    }
}

impl Boundary for Solid {
    fn name(&self) -> &'static str {
        self.name
    }

    fn walls(&self) -> &[Wall] {
        &self.wall
    }
}
