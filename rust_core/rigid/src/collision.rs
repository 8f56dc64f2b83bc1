//! Contacts and separation of two shapes.

use glam::DVec3;

use crate::contact::ContactPoint;
use crate::couple::{Couple, of_face};
use crate::planar;
use crate::pose::Pose;
use crate::shapes::{Form, Part, Shape};
use crate::spatial;

/// Adds the contacts whose gap is at most `reach` [m] between two shapes at their poses. The reach of a fast body may be many
/// times its size.
pub fn contacts(first: (&Shape, &Pose), second: (&Shape, &Pose), reach: f64, dimension: usize, points: &mut Vec<ContactPoint>) {
    let poses = [first.1, second.1];
    let width = second.0.features;
    match (&first.0.form, &second.0.form) {
        (Form::Parts(ones), Form::Parts(others)) => {
            for one in ones {
                for other in others {
                    let couple = Couple::new([one, other], poses, reach, width);
                    if dimension == 2 { planar::contacts(&couple, points) } else { spatial::contacts(&couple, points) }
                }
            }
        }
        (Form::HalfSpace(normal), Form::Parts(parts)) => {
            parts.iter().for_each(|part| above(*normal, part, poses, 0, reach, width, points));
        }
        (Form::Parts(parts), Form::HalfSpace(normal)) => {
            parts.iter().for_each(|part| above(*normal, part, poses, 1, reach, width, points));
        }
        (Form::HalfSpace(_), Form::HalfSpace(_)) => {}
    }
}

/// Adds the contacts of a part with the half-space of `owner`.
fn above(normal: DVec3, part: &Part, poses: [&Pose; 2], owner: usize, reach: f64, width: u32, points: &mut Vec<ContactPoint>) {
    let other = 1 - owner;
    let into = poses[owner].relative(poses[other]);
    let direction = into.local_vector(normal);
    let lowest = normal.dot(into.position) - part.support(-direction).1;
    if lowest - part.radius > reach {
        return;
    }
    let gap = |vertex: DVec3| normal.dot(into.point(vertex)) - part.radius;
    for vertex in spatial::resting(part, direction) {
        let local = part.vertices[vertex as usize];
        if gap(local) <= reach {
            let point = into.point(local);
            let foot = point - normal.dot(point) * normal;
            let mut pair = ([foot, local], [0.0, part.radius], [0, part.first + vertex]);
            if owner == 1 {
                pair = (swapped(pair.0), swapped(pair.1), swapped(pair.2));
            }
            let feature = pair.2[0].wrapping_mul(width).wrapping_add(pair.2[1]);
            points.push(ContactPoint { points: pair.0, radii: pair.1, normal: of_face(owner, normal), feature });
        }
    }
}

fn swapped<T: Copy>([one, other]: [T; 2]) -> [T; 2] {
    [other, one]
}

/// Lower bound of the distance between two shapes [m], exact when small, and the unit normal from the first to the second. Where
/// they overlap, it is minus the depth along the least axis.
pub fn separation(first: (&Shape, &Pose), second: (&Shape, &Pose), dimension: usize) -> (f64, DVec3) {
    let poses = [first.1, second.1];
    let mut least = (f64::INFINITY, DVec3::X);
    let mut nearer = |other: (f64, DVec3)| {
        if other.0 < least.0 {
            least = other;
        }
    };
    match (&first.0.form, &second.0.form) {
        (Form::Parts(ones), Form::Parts(others)) => {
            for one in ones {
                for other in others {
                    let couple = Couple::new([one, other], poses, f64::INFINITY, 0);
                    nearer(if dimension == 2 { planar::separation(&couple) } else { spatial::separation(&couple) });
                }
            }
        }
        (Form::HalfSpace(normal), Form::Parts(parts)) => parts.iter().for_each(|part| nearer(height(*normal, part, poses, 0))),
        (Form::Parts(parts), Form::HalfSpace(normal)) => parts.iter().for_each(|part| nearer(height(*normal, part, poses, 1))),
        (Form::HalfSpace(_), Form::HalfSpace(_)) => {}
    }
    least
}

/// Height of a part above the half-space of `owner`, and the normal from the first body to the second.
fn height(normal: DVec3, part: &Part, poses: [&Pose; 2], owner: usize) -> (f64, DVec3) {
    let into = poses[owner].relative(poses[1 - owner]);
    let lowest = normal.dot(into.position) - part.support(-into.local_vector(normal)).1;
    let outward = poses[owner].rotation * normal;
    (lowest - part.radius, if owner == 0 { outward } else { -outward })
}
