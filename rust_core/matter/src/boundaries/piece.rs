//! Pieces of walls that particles touch one by one: a whole wall or a part of a height field.

use glam::DVec3;

use super::terrain::{Terrain, TerrainPart};
use super::{Gap, Path, Wall};

/// A wall, or a part of one.
#[derive(Debug, Clone, Copy)]
pub enum Piece<'a> {
    /// A convex wall, or a hollow round one.
    Whole(&'a Wall),
    /// A part of a height field.
    Part(&'a Terrain, TerrainPart),
}

impl Wall {
    /// Pieces that a particle of a radius within a box along the axes may touch. A wall that is one piece is always returned.
    #[inline]
    pub fn pieces(&self, lower: DVec3, upper: DVec3, radius: f64) -> impl Iterator<Item = Piece<'_>> {
        let terrain = match self {
            Self::Terrain(terrain) => Some(terrain.as_ref()),
            _ => None,
        };
        let parts = terrain
            .into_iter()
            .flat_map(move |terrain| terrain.parts(lower, upper, radius).map(move |part| Piece::Part(terrain, part)));
        terrain.is_none().then_some(Piece::Whole(self)).into_iter().chain(parts)
    }

    /// Piece with a given part.
    #[inline]
    pub fn piece(&self, part: Option<TerrainPart>) -> Piece<'_> {
        match (self, part) {
            (Self::Terrain(terrain), Some(part)) => Piece::Part(terrain, part),
            _ => Piece::Whole(self),
        }
    }
}

impl Piece<'_> {
    /// Part of the wall; None for a whole wall.
    #[inline]
    pub fn part(&self) -> Option<TerrainPart> {
        match *self {
            Self::Whole(_) => None,
            Self::Part(_, part) => Some(part),
        }
    }

    /// Signed distance from `x` [m] and the normal, even if another piece is nearer.
    #[inline]
    pub fn surface(&self, x: DVec3) -> (f64, DVec3) {
        match *self {
            Self::Whole(wall) => wall.distance(x),
            Self::Part(terrain, part) => {
                let spot = terrain.spot(part, x, f64::NEG_INFINITY);
                (spot.distance, spot.normal)
            }
        }
    }

    /// Signed distance up to `reach` and the normal. The distance is infinite where the piece is not the nearest one locally. The
    /// region of the piece is extended by `roundings`, in units of rounding.
    #[inline]
    pub fn distance(&self, x: DVec3, reach: f64, roundings: f64) -> (f64, DVec3) {
        match *self {
            Self::Whole(wall) => wall.distance(x),
            Self::Part(terrain, part) => {
                let spot = terrain.spot(part, x, reach);
                let is_beyond = spot.beyond > roundings * terrain.rounding(x);
                (if is_beyond { f64::INFINITY } else { spot.distance }, spot.normal)
            }
        }
    }

    /// Rounding error of the normal of a part, which is that of a difference of heights; 0 for a whole wall.
    #[inline]
    pub fn blur(&self) -> f64 {
        match self {
            Self::Whole(_) => 0.0,
            Self::Part(terrain, _) => terrain.blur(),
        }
    }

    /// Curvature, as [`Wall::curvature`].
    #[inline]
    pub fn curvature(&self, x: DVec3, direction: DVec3) -> f64 {
        match *self {
            Self::Whole(wall) => wall.curvature(x, direction),
            Self::Part(terrain, part) => terrain.curvature(part, x, direction),
        }
    }

    /// Time within `duration` of the first contact of a particle on its path, as [`Gap::first_contact`].
    #[inline]
    pub fn first_contact(&self, path: &Path, radius: f64, touching: bool, duration: f64) -> Option<f64> {
        match *self {
            Self::Whole(wall) => Gap::new(wall, path, radius, touching).first_contact(duration),
            Self::Part(terrain, part) => terrain.first_contact(part, path, radius, touching, duration),
        }
    }
}
