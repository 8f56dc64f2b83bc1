//! Pieces of walls: what particles touch one by one, a whole wall or a part of a height field.

use glam::DVec3;

use super::terrain::{Part, Terrain};
use super::{Gap, Path, Wall};

/// A wall, or a part of one.
#[derive(Debug, Clone, Copy)]
pub enum Piece<'a> {
    /// A wall that is convex, or hollow and round.
    Whole(&'a Wall),
    /// A part of a height field.
    Part(&'a Terrain, Part),
}

impl Wall {
    /// The pieces that a particle of a radius within a box along the axes may touch; a wall that is one piece, wherever it is.
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

    /// A piece by its part.
    pub fn piece(&self, part: Option<Part>) -> Piece<'_> {
        match (self, part) {
            (Self::Terrain(terrain), Some(part)) => Piece::Part(terrain, part),
            _ => Piece::Whole(self),
        }
    }
}

impl Piece<'_> {
    /// The part of the wall; None for all of it.
    pub fn part(&self) -> Option<Part> {
        match *self {
            Self::Whole(_) => None,
            Self::Part(_, part) => Some(part),
        }
    }

    /// The signed distance from `x` [m] and the normal, also where another piece is nearer.
    pub fn surface(&self, x: DVec3) -> (f64, DVec3) {
        match *self {
            Self::Whole(wall) => wall.distance(x),
            Self::Part(terrain, part) => {
                let spot = terrain.spot(part, x, f64::NEG_INFINITY);
                (spot.distance, spot.normal)
            }
        }
    }

    /// The same up to a distance of `reach` where the piece is the nearest one locally; else the distance is infinite. `roundings` is
    /// how far beyond that region it is still there, in units of rounding.
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

    /// The rounding error of a normal of a part, which is that of a difference of heights; 0 of a whole wall.
    pub fn blur(&self) -> f64 {
        match self {
            Self::Whole(_) => 0.0,
            Self::Part(terrain, _) => terrain.blur(),
        }
    }

    /// The curvature, as of a wall.
    pub fn curvature(&self, x: DVec3, direction: DVec3) -> f64 {
        match *self {
            Self::Whole(wall) => wall.curvature(x, direction),
            Self::Part(terrain, part) => terrain.curvature(part, x, direction),
        }
    }

    /// The time within `duration` of the first contact of a particle on its path, as of a gap.
    pub fn first_contact(&self, path: &Path, radius: f64, touching: bool, duration: f64) -> Option<f64> {
        match *self {
            Self::Whole(wall) => Gap::new(wall, path, radius, touching).first_contact(duration),
            Self::Part(terrain, part) => terrain.first_contact(part, path, radius, touching, duration),
        }
    }
}
