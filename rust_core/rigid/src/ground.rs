//! Contacts with half-spaces and hollows, which are fixed.

use arrayvec::ArrayVec;
use glam::DVec3;

use crate::contact::{ContactPoint, Normal};
use crate::couple::as_normal;
use crate::pose::Pose;
use crate::shapes::{BoundingBox, Part, ShapeForm, SolidShape};
use crate::spatial;

/// Half-space or hollow of one body, the `owner`, and part of the other.
pub(crate) struct GroundContact<'a> {
    form: &'a ShapeForm,
    owner: usize,
    poses: [&'a Pose; 2],
    part: &'a Part,
    /// Pose of the other body in the frame of the owner.
    into: Pose,
}

impl GroundContact<'_> {
    /// Calls `visit` with the parts of a shape that may be within `reach` of the ground [m]. The ground is the shape of `owner`.
    pub fn each(
        ground: (&SolidShape, &Pose),
        other: (&SolidShape, &Pose),
        owner: usize,
        reach: f64,
        mut visit: impl FnMut(GroundContact),
    ) {
        let poses = if owner == 0 { [ground.1, other.1] } else { [other.1, ground.1] };
        let into = ground.1.relative(other.1);
        let form = &ground.0.form;
        other.0.near(&BoundingBox::EVERYWHERE, &mut |part| {
            let near = GroundContact { form, owner, poses, part, into };
            // A ball around the part is beyond reach of most.
            let (center, radius) = part.ball;
            if near.gap(into.point(center)).0 + part.radius - radius <= reach {
                visit(near);
            }
        });
    }

    /// Gap of a point of the core, and the unit normal into the free side, in the frame of the owner; None at the center of a
    /// hollow.
    fn gap(&self, point: DVec3) -> (f64, Option<DVec3>) {
        match *self.form {
            ShapeForm::HalfSpace(normal) => (normal.dot(point) - self.part.radius, Some(normal)),
            ShapeForm::Hollow(radius) => (radius - point.length() - self.part.radius, (-point).try_normalize()),
            ShapeForm::ConvexParts(_) | ShapeForm::GroundProfile(_) => (f64::INFINITY, None),
        }
    }

    /// Gap of the part, its vertex nearest to the ground, and the normal there, in the frame of the owner.
    fn nearest(&self) -> (f64, usize, Option<DVec3>) {
        let gaps = self.part.vertices.iter().map(|vertex| self.gap(self.into.point(*vertex))).enumerate();
        let least = gaps.reduce(|one, other| if other.1.0 < one.1.0 { other } else { one });
        least.map_or((f64::INFINITY, 0, None), |(vertex, (gap, normal))| (gap, vertex, normal))
    }

    /// Distance of the part, and the unit normal from the first body to the second.
    pub fn distance(&self) -> (f64, DVec3) {
        let (gap, _, normal) = self.nearest();
        let outward = self.poses[self.owner].rotation * normal.unwrap_or(DVec3::X);
        (gap, if self.owner == 0 { outward } else { -outward })
    }

    /// Adds the contacts of the face on which the part rests.
    pub fn add_contacts(&self, reach: f64, width: u32, contacts: &mut Vec<ContactPoint>) {
        let Self { form, owner, part, into, .. } = *self;
        let (gap, lowest, normal) = self.nearest();
        if gap > reach {
            return;
        }
        let up = into.local_vector(normal.unwrap_or(DVec3::X));
        let resting: ArrayVec<u32, 5> = spatial::resting(part, lowest, up);
        for vertex in resting {
            let local = part.vertices[vertex as usize];
            let point = into.point(local);
            if self.gap(point).0 > reach {
                continue;
            }
            let (foot, radius, normal) = match *form {
                ShapeForm::HalfSpace(normal) => (point - normal.dot(point) * normal, 0.0, as_normal(owner, normal)),
                ShapeForm::Hollow(radius) => (DVec3::ZERO, -radius, Normal::Hollow),
                ShapeForm::ConvexParts(_) | ShapeForm::GroundProfile(_) => continue,
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
}

/// Values of a body and of the other, in the order of the bodies.
fn in_order<T>(body: usize, [own, other]: [T; 2]) -> [T; 2] {
    if body == 0 { [own, other] } else { [other, own] }
}
