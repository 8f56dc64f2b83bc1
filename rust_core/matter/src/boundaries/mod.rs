//! Boundaries, one file each. To add one: write its file, which defines its walls, and add its line to [`build`].
//!
//! A boundary is an intersection of [`Wall`]s. Every wall has a signed distance. Its [`Gap`] to a particle along a parabolic path
//! gives the time of the first contact, so that no particle can tunnel.

use std::fmt::Debug;

use glam::DVec3;

use crate::error::Result;
use crate::scene::{self, Item};

mod cuboid;
mod gap;
mod height_field;
mod piece;
mod plane;
mod polynomial;
mod polytope;
mod solid;
mod sphere;
mod terrain;
mod wall;
mod wrapping;

pub use cuboid::Cuboid;
pub use gap::{Gap, Path};
pub use height_field::HeightField;
pub use piece::Piece;
pub use plane::Plane;
pub use polytope::{Feature, Nearest, Polytope};
pub use solid::Solid;
pub use sphere::Sphere;
pub use terrain::{Terrain, TerrainPart};
pub use wall::Wall;

/// A domain that confines particles.
pub trait Boundary: Debug + Send + Sync {
    /// Name in the plan, such as `plane`.
    fn name(&self) -> &'static str;

    /// Walls of the boundary. The allowed side is where all their signed distances are positive.
    fn walls(&self) -> &[Wall];

    /// Signed distance from `x` to the nearest wall [m], positive on the allowed side, and the unit normal into that side.
    fn distance(&self, x: DVec3) -> (f64, DVec3) {
        let distances = self.walls().iter().map(|wall| wall.distance(x));
        distances
            .reduce(|nearest, other| if other.0 < nearest.0 { other } else { nearest })
            .unwrap_or((f64::INFINITY, DVec3::ZERO))
    }
}

/// Builds the boundary of an item in a scene of `dimension` axes, in coordinates relative to `origin`.
///
/// # Errors
/// If there is no boundary of that kind, or one of its parameters is not acceptable.
pub fn build(item: &Item, dimension: usize, origin: DVec3) -> Result<Box<dyn Boundary>> {
    match item.kind.as_str() {
        "Plane" => Ok(Box::new(Plane::new(item, origin)?)),
        "Box" => Ok(Box::new(Cuboid::new(item, dimension, origin)?)),
        "Sphere" => Ok(Box::new(Sphere::new(item, origin)?)),
        "Capsule" => Ok(Box::new(Solid::capsule(item, origin)?)),
        "ConvexHull" => Ok(Box::new(Solid::hull(item, dimension, origin)?)),
        "HeightField" => Ok(Box::new(HeightField::new(item, dimension, origin)?)),
        _ => Err(scene::unknown(item, "a boundary: Plane, Box, Sphere, Capsule, ConvexHull or HeightField")),
    }
}
