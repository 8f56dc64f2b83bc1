//! Contacts and separation of two shapes.

use arrayvec::ArrayVec;
use glam::DVec3;

use crate::contact::{ContactPoint, Normal};
use crate::couple::{Couple, as_normal};
use crate::pose::Pose;
use crate::shapes::{Form, Part, Shape};
use crate::{planar, spatial};

/// Adds the contacts whose gap is at most `reach` [m] between two shapes at their poses. The reach of a fast body may be many
/// times its size.
pub fn contacts(first: (&Shape, &Pose), second: (&Shape, &Pose), reach: f64, dimension: usize, points: &mut Vec<ContactPoint>) {
    let poses = [first.1, second.1];
    let width = second.0.features;
    match [&first.0.form, &second.0.form] {
        [Form::Parts(ones), Form::Parts(others)] => {
            for one in ones {
                for other in others {
                    let couple = Couple::new([one, other], poses, reach, width);
                    if dimension == 2 { planar::contacts(&couple, points) } else { spatial::contacts(&couple, points) }
                }
            }
        }
        [ground, Form::Parts(parts)] => {
            parts.iter().for_each(|part| on_ground(&Ground { form: ground, owner: 0, poses, part }, reach, width, points));
        }
        [Form::Parts(parts), ground] => {
            parts.iter().for_each(|part| on_ground(&Ground { form: ground, owner: 1, poses, part }, reach, width, points));
        }
        _ => {}
    }
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
    match [&first.0.form, &second.0.form] {
        [Form::Parts(ones), Form::Parts(others)] => {
            for one in ones {
                for other in others {
                    let couple = Couple::new([one, other], poses, f64::INFINITY, 0);
                    nearer(if dimension == 2 { planar::separation(&couple) } else { spatial::separation(&couple) });
                }
            }
        }
        [form, Form::Parts(parts)] => parts.iter().for_each(|part| nearer(Ground { form, owner: 0, poses, part }.distance())),
        [Form::Parts(parts), form] => parts.iter().for_each(|part| nearer(Ground { form, owner: 1, poses, part }.distance())),
        _ => {}
    }
    least
}

/// Part of a body and the half-space or the hollow of another, the `owner`.
struct Ground<'a> {
    form: &'a Form,
    owner: usize,
    poses: [&'a Pose; 2],
    part: &'a Part,
}

impl Ground<'_> {
    /// Gap of a vertex of the part, and the unit normal into the free side, in the frame of the owner; None for a vertex at the
    /// center of a hollow.
    fn gap(&self, point: DVec3) -> (f64, Option<DVec3>) {
        match *self.form {
            Form::HalfSpace(normal) => (normal.dot(point) - self.part.radius, Some(normal)),
            Form::Hollow(radius) => (radius - point.length() - self.part.radius, (-point).try_normalize()),
            Form::Parts(_) => (f64::INFINITY, None),
        }
    }

    /// Gap of the part, its vertex nearest to the ground, and the normal there, in the frame of the owner.
    fn nearest(&self, into: &Pose) -> (f64, usize, Option<DVec3>) {
        let gaps = self.part.vertices.iter().map(|vertex| self.gap(into.point(*vertex))).enumerate();
        let least = gaps.reduce(|one, other| if other.1.0 < one.1.0 { other } else { one });
        least.map_or((f64::INFINITY, 0, None), |(vertex, (gap, normal))| (gap, vertex, normal))
    }

    /// Distance of the part, and the unit normal from the first body to the second.
    fn distance(&self) -> (f64, DVec3) {
        let [ground, body] = [self.poses[self.owner], self.poses[1 - self.owner]];
        let (gap, _, normal) = self.nearest(&ground.relative(body));
        let outward = ground.rotation * normal.unwrap_or(DVec3::X);
        (gap, if self.owner == 0 { outward } else { -outward })
    }
}

/// Adds the contacts of a part with a half-space or a hollow: of the face on which it rests.
fn on_ground(pair: &Ground, reach: f64, width: u32, contacts: &mut Vec<ContactPoint>) {
    let Ground { form, owner, poses, part } = *pair;
    let into = poses[owner].relative(poses[1 - owner]);
    let (gap, lowest, normal) = pair.nearest(&into);
    if gap > reach {
        return;
    }
    let up = into.local_vector(normal.unwrap_or(DVec3::X));
    let resting: ArrayVec<u32, 4> = spatial::resting(part, lowest, up);
    for vertex in resting {
        let local = part.vertices[vertex as usize];
        let point = into.point(local);
        if pair.gap(point).0 > reach {
            continue;
        }
        let (foot, radius, normal) = match *form {
            Form::HalfSpace(normal) => (point - normal.dot(point) * normal, 0.0, as_normal(owner, normal)),
            Form::Hollow(radius) => (DVec3::ZERO, -radius, Normal::Hollow),
            Form::Parts(_) => continue,
        };
        let [high, low] = in_order(owner, [0, part.first + vertex]);
        contacts.push(ContactPoint {
            points: in_order(owner, [foot, local]),
            radii: in_order(owner, [radius, part.radius]),
            normal,
            feature: high.wrapping_mul(width).wrapping_add(low),
        });
    }
}

/// Values of a body and of the other, in the order of the bodies.
fn in_order<T>(body: usize, [own, other]: [T; 2]) -> [T; 2] {
    if body == 0 { [own, other] } else { [other, own] }
}
