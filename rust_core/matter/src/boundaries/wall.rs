//! Walls: the surfaces of boundaries.

use std::sync::Arc;

use glam::DVec3;

use super::polytope::Polytope;
use super::terrain::Terrain;

/// A surface with an allowed side.
#[derive(Debug, Clone, PartialEq)]
pub enum Wall {
    /// Plane with the allowed side n·x ≥ offset.
    Plane {
        /// Unit normal n into the allowed side.
        normal: DVec3,
        /// Distance of the plane from the origin along n [m].
        offset: f64,
    },
    /// Sphere with the allowed side |x − c| ≤ R if `inside`, else |x − c| ≥ R.
    Sphere {
        /// Center c [m].
        center: DVec3,
        /// Radius R [m].
        radius: f64,
        /// Whether the inside is the allowed side.
        inside: bool,
    },
    /// Outside of a rounded convex polytope.
    Solid(Arc<Polytope>),
    /// Space above a height field.
    Terrain(Arc<Terrain>),
}

impl Wall {
    /// Signed distance from the wall to `x` [m], positive on the allowed side, and the unit normal into that side.
    pub fn distance(&self, x: DVec3) -> (f64, DVec3) {
        match *self {
            Self::Terrain(ref terrain) => terrain.distance(x, f64::INFINITY),
            Self::Solid(ref solid) => {
                let nearest = solid.nearest(x);
                (nearest.distance, nearest.normal)
            }
            Self::Plane { normal, offset } => (normal.dot(x) - offset, normal),
            Self::Sphere { center, radius, inside } => {
                let away = x - center;
                let length = away.length();
                // At the center every direction is normal.
                let outward = if length > 0.0 { away / length } else { DVec3::X };
                if inside { (radius - length, -outward) } else { (length - radius, outward) }
            }
        }
    }

    /// Signed distance and unit normal, up to the distance `reach` [m]; beyond it, the distance may be infinite.
    #[inline]
    pub fn distance_within(&self, x: DVec3, reach: f64) -> (f64, DVec3) {
        match self {
            Self::Terrain(terrain) => terrain.distance(x, reach),
            _ => self.distance(x),
        }
    }

    /// Whether `x` is in the ground of a height field, deeper than `depth` [m].
    #[inline]
    pub fn covers(&self, x: DVec3, depth: f64) -> bool {
        matches!(self, Self::Terrain(terrain) if terrain.inside(x).is_some_and(|(distance, _)| distance < -depth))
    }

    /// Curvature κ [1/m] of the surface at the wall's distance from `x` along a unit direction. Motion along it with velocity v
    /// changes the distance by d'' = n·a + κ v². For a zero direction, the curvature of the largest magnitude.
    pub fn curvature(&self, x: DVec3, direction: DVec3) -> f64 {
        match *self {
            Self::Solid(ref solid) => solid.curvature(x, direction),
            Self::Plane { .. } | Self::Terrain(_) => 0.0,
            Self::Sphere { center, inside, .. } => {
                let length = (x - center).length();
                let curvature = if length > 0.0 { 1.0 / length } else { 0.0 };
                if inside { -curvature } else { curvature }
            }
        }
    }

    /// Magnitude of the operands of a distance near the surface [m], the scale of its rounding error.
    #[inline]
    pub fn extent(&self) -> f64 {
        match *self {
            Self::Solid(ref solid) => solid.extent(),
            Self::Terrain(ref terrain) => terrain.extent(),
            Self::Plane { offset, .. } => offset.abs(),
            Self::Sphere { center, radius, .. } => center.abs().max_element() + radius,
        }
    }
}
