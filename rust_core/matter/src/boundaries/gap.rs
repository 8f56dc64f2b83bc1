//! Time of first contact of a particle on a parabolic path with a wall, to rounding, or a certificate that there is none.
//!
//! The gap to a plane or a sphere is a polynomial in time ([`super::polynomial`]). A convex solid lies behind the plane through
//! its point nearest to the particle, normal to their separation. No contact comes before the path meets that plane. The next
//! plane follows from the particle's position there. On a facet the second plane is the last. Elsewhere this is Newton's method
//! for a convex function.

use std::sync::Arc;

use glam::DVec3;

use super::polynomial::Polynomial;
use super::{Polytope, Terrain, Wall};

/// Maximum number of supporting planes. Only rounding at a grazing contact could need more, which then counts as a contact. This
/// is harmless, because a particle that recedes from a wall is not reflected.
const PLANES: usize = 128;
/// Gap that counts as closed, in units of rounding of the operands.
const CLOSED: f64 = 2.0;

/// Parabolic path x(t) = x₀ + v t + a t²/2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Path {
    /// Initial position x₀ [m].
    pub position: DVec3,
    /// Initial slope v [m/s].
    pub velocity: DVec3,
    /// Acceleration a [m/s²].
    pub acceleration: DVec3,
}

impl Path {
    /// Position after `time`.
    #[inline]
    pub fn at(&self, time: f64) -> DVec3 {
        self.position + (self.velocity + self.acceleration * (0.5 * time)) * time
    }

    /// Slope after `time`.
    #[inline]
    pub fn slope(&self, time: f64) -> DVec3 {
        self.velocity + self.acceleration * time
    }

    /// Corners of a box along the axes that contains the path up to a time.
    #[inline]
    pub fn bounds(&self, end: f64) -> (DVec3, DVec3) {
        let [first, middle, last] = self.control(0.0, end);
        (first.min(middle).min(last), first.max(middle).max(last))
    }

    /// Bernstein control points between two times.
    pub(super) fn control(&self, start: f64, end: f64) -> [DVec3; 3] {
        let first = self.at(start);
        [first, first + self.slope(start) * (0.5 * (end - start)), self.at(end)]
    }
}

/// Gap between a particle on its path and a wall.
#[derive(Debug, Clone)]
pub enum Gap {
    /// Gap to a plane or a sphere.
    Smooth(Polynomial),
    /// Gap to a solid.
    Solid(Approach),
    /// Gap to the nearest part of a height field.
    Terrain(Arc<Terrain>, Path, f64, bool),
}

/// A particle on its path towards a solid.
#[derive(Debug, Clone)]
pub struct Approach {
    solid: Arc<Polytope>,
    path: Path,
    radius: f64,
    touching: bool,
}

impl Gap {
    /// Gap of a particle of radius `radius` to `wall`. If the particle is `touching` at the start and does not approach, the gap
    /// is taken as zero, and only a later contact counts.
    #[inline]
    pub fn new(wall: &Wall, path: &Path, radius: f64, touching: bool) -> Self {
        match *wall {
            Wall::Plane { normal, offset } => Self::Smooth(Polynomial::plane((normal, offset), path, radius, touching)),
            Wall::Sphere { center, radius: size, inside } => {
                Self::Smooth(Polynomial::sphere((center, size, inside), path, radius, touching))
            }
            Wall::Solid(ref solid) => Self::Solid(Approach { solid: Arc::clone(solid), path: *path, radius, touching }),
            Wall::Terrain(ref terrain) => Self::Terrain(Arc::clone(terrain), *path, radius, touching),
        }
    }

    /// Time of first contact within `duration` [s]. None is certain.
    pub fn first_contact(&self, duration: f64) -> Option<f64> {
        match self {
            Self::Smooth(polynomial) => polynomial.first_contact(duration),
            Self::Solid(approach) => approach.first_contact(duration),
            Self::Terrain(terrain, path, radius, touching) => {
                let (lower, upper) = path.bounds(duration);
                let parts = terrain.parts(lower - *radius, upper + *radius, *radius);
                let times = parts.filter_map(|part| terrain.first_contact(part, path, *radius, *touching, duration));
                times.reduce(f64::min)
            }
        }
    }
}

impl Approach {
    fn first_contact(&self, duration: f64) -> Option<f64> {
        let Self { solid, path, radius, touching } = self;
        let nearest = |x| {
            let nearest = solid.nearest(x);
            (nearest.distance, nearest.normal)
        };
        first_contact_with_convex(nearest, solid.extent(), path, *radius, *touching, duration)
    }
}

/// Time of first contact with a convex set of an `extent`. The distance and the normal at a point are returned by `nearest`.
pub(super) fn first_contact_with_convex(
    nearest: impl Fn(DVec3) -> (f64, DVec3),
    extent: f64,
    path: &Path,
    radius: f64,
    touching: bool,
    duration: f64,
) -> Option<f64> {
    let mut time = 0.0;
    for plane in 0..PLANES {
        let ahead = Path { position: path.at(time), velocity: path.slope(time), ..*path };
        let (distance, normal) = nearest(ahead.position);
        let gap = distance - radius;
        let touching = touching && plane == 0;
        let operands = ahead.position.abs().max_element() + extent + radius;
        if !touching && gap <= CLOSED * f64::EPSILON * operands {
            return Some(time);
        }
        let offset = normal.dot(ahead.position) - gap;
        let way = Polynomial::plane((normal, offset), &ahead, 0.0, touching).first_contact(duration - time)?;
        if plane > 0 && way == 0.0 {
            return Some(time);
        }
        time += way;
    }
    Some(time)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Random solids: hulls of vertices with coordinates below 1 m, rounded by up to 0.3 m, or capsules.
    fn solid() -> impl Strategy<Value = Polytope> {
        let point = || prop::array::uniform3(-1.0..1.0_f64).prop_map(DVec3::from_array);
        let hull = (prop::collection::vec(point(), 4..12), 0.0..0.3_f64)
            .prop_filter_map("flat", |(points, rounding)| Polytope::hull(&points, 3, rounding));
        let capsule = (point(), point(), 0.1..0.5_f64).prop_map(|(start, end, radius)| Polytope::capsule([start, end], radius));
        prop_oneof![hull, capsule]
    }

    /// Numbers of up to 30 m are rounded, and a distance is a sum of a few products of them.
    const ROUNDING: f64 = 100.0 * 30.0 * f64::EPSILON;

    proptest! {
        /// The gap is open up to the first contact, and closed there. None means open to the end.
        #[test]
        fn the_first_contact_with_a_solid_is_the_first(
            solid in solid(),
            [x, v, a] in prop::array::uniform3(prop::array::uniform3(-3.0..3.0_f64).prop_map(DVec3::from_array)),
            radius in 0.0..0.3_f64,
        ) {
            let path = Path { position: x, velocity: v, acceleration: a };
            prop_assume!(solid.nearest(x).distance > radius + 0.01);
            let solid = Arc::new(solid);
            let contact = Gap::new(&Wall::Solid(Arc::clone(&solid)), &path, radius, false).first_contact(2.0);
            for sample in 0..=200 {
                let x = path.at(contact.unwrap_or(2.0) * f64::from(sample) / 200.0);
                prop_assert!(solid.nearest(x).distance - radius > -ROUNDING);
            }
            if let Some(time) = contact {
                prop_assert!((solid.nearest(path.at(time)).distance - radius).abs() < ROUNDING);
            }
        }

        /// The nearest point of the surface is on the solid, and no farther than any other of its points.
        #[test]
        fn the_nearest_point_is_the_nearest(
            points in prop::collection::vec(prop::array::uniform3(-1.0..1.0_f64).prop_map(DVec3::from_array), 4..12),
            x in prop::array::uniform3(-3.0..3.0_f64).prop_map(DVec3::from_array),
            weights in prop::collection::vec(prop::collection::vec(0.01..1.0_f64, 12), 50),
        ) {
            let Some(solid) = Polytope::hull(&points, 3, 0.0) else { return Ok(()) };
            let nearest = solid.nearest(x);
            for weights in weights {
                let total: f64 = weights.iter().take(points.len()).sum();
                let inner = points.iter().zip(&weights).map(|(point, weight)| *point * *weight).sum::<DVec3>() / total;
                if nearest.distance > 0.0 {
                    // The solid lies behind the plane through the nearest point, and x at the distance in front of it.
                    prop_assert!(nearest.normal.dot(x - inner) >= nearest.distance - ROUNDING);
                }
                prop_assert!(solid.nearest(inner).distance <= ROUNDING);
            }
            if nearest.distance > 0.0 {
                prop_assert!(solid.nearest(x - nearest.distance * nearest.normal).distance.abs() < ROUNDING);
            }
        }
    }
}
