//! Contacts and separation of two shapes.

use glam::DVec3;

use crate::contact::ContactPoint;
use crate::couple::{self, Couple};
use crate::ground::GroundContact;
use crate::pose::Pose;
use crate::shapes::{Part, SolidShape};
use crate::{planar, spatial, thinning};

/// Shape at a pose.
type Placed<'a> = (&'a SolidShape, &'a Pose);

/// Adds the contacts whose gap is at most `reach` [m] between two shapes at their poses. The reach of a fast body may be many
/// times its size. Returns a lower bound of the distance of the shapes [m] if it finds one.
pub fn contacts(first: Placed, second: Placed, reach: f64, dimension: usize, points: &mut Vec<ContactPoint>) -> Option<f64> {
    let poses = [first.1, second.1];
    let width = second.0.features;
    let of_pair = |parts: [&Part; 2], points: &mut Vec<ContactPoint>| {
        if parts.iter().all(|part| part.vertices.len() == 1) {
            points.extend(couple::of_round(parts, poses, reach, width));
            return None;
        }
        let clearance = couple::clearance(parts, poses);
        if clearance > reach {
            return Some(clearance);
        }
        let couple = Couple::new(parts, poses, reach, width);
        if dimension == 2 {
            planar::contacts(&couple, points);
            return None;
        }
        Some(spatial::contacts(&couple, points))
    };
    match [first, second].map(|(shape, _)| (shape.single(), shape.is_ground())) {
        [(Some(one), _), (Some(other), _)] => return of_pair([one, other], points),
        [(_, true), (_, true)] => {}
        [(_, true), _] => GroundContact::each(first, second, 0, reach, |ground| ground.add_contacts(reach, width, points)),
        [_, (_, true)] => GroundContact::each(second, first, 1, reach, |ground| ground.add_contacts(reach, width, points)),
        _ => {
            let start = points.len();
            each_pair(first, second, reach, |parts| {
                of_pair(parts, points);
            });
            thinning::thin(points, start, poses, dimension);
        }
    }
    None
}

/// Calls `visit` with the pairs of parts of two shapes whose boxes are within `reach` [m].
fn each_pair(first: Placed, second: Placed, reach: f64, mut visit: impl FnMut([&Part; 2])) {
    let in_first = first.1.relative(second.1);
    let in_second = second.1.relative(first.1);
    first.0.near(&second.0.bounds(&in_first).grown(reach), &mut |one| {
        second.0.near(&one.bounds(&in_second).grown(reach), &mut |other| visit([one, other]));
    });
}

/// Distance of two convex parts, and the unit normal from the first to the second.
fn distance(parts: [&Part; 2], poses: [&Pose; 2], dimension: usize) -> (f64, DVec3) {
    let couple = Couple::new(parts, poses, f64::INFINITY, 0);
    if dimension == 2 { planar::separation(&couple) } else { spatial::separation(&couple) }
}

/// Replaces `found` by the distances of all pairs of convex parts that may be within `reach` [m]. Each has its unit normal from
/// the first shape to the second. A plane across the normal separates the two parts.
pub fn separations(first: Placed, second: Placed, reach: f64, dimension: usize, found: &mut Vec<(f64, DVec3)>) {
    found.clear();
    let poses = [first.1, second.1];
    match [first, second].map(|(shape, _)| shape.is_ground()) {
        [true, true] => {}
        [true, false] => GroundContact::each(first, second, 0, reach, |ground| found.push(ground.distance())),
        [false, true] => GroundContact::each(second, first, 1, reach, |ground| found.push(ground.distance())),
        _ => each_pair(first, second, reach, |parts| {
            if couple::clearance(parts, poses) <= reach {
                found.push(distance(parts, poses, dimension));
            }
        }),
    }
}

/// Lower bound of the distance between two shapes [m], exact when small, and the unit normal from the first to the second. Where
/// two convex parts overlap, it is minus their depth along the least axis. Where a shape is within a mesh, it is minus the
/// distance from the surface.
pub fn separation(first: Placed, second: Placed, dimension: usize) -> (f64, DVec3) {
    if let [Some(one), Some(other)] = [first, second].map(|(shape, _)| shape.single()) {
        return distance([one, other], [first.1, second.1], dimension);
    }
    let is_ground = first.0.is_ground() || second.0.is_ground();
    let reach = if is_ground { f64::INFINITY } else { first.0.reach().min(second.0.reach()) };
    let mut found = Vec::new();
    separations(first, second, reach, dimension, &mut found);
    let way = (second.1.position - first.1.position).try_normalize().unwrap_or(DVec3::X);
    let (gap, normal) = found.into_iter().fold((reach, way), |least, one| if one.0 < least.0 { one } else { least });
    let contains = |one: Placed, other: Placed| one.0.encloses(one.1.local_point(other.1.position));
    let is_inside = gap > 0.0 && !is_ground && (contains(first, second) || contains(second, first));
    if is_inside { (-gap, normal) } else { (gap, normal) }
}
