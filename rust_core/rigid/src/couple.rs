//! Two convex parts at their poses, and what contacts in 2D and 3D share.

use glam::DVec3;

use crate::contact::{ContactPoint, Normal};
use crate::pose::Pose;
use crate::shapes::Part;

/// Gap that counts as closed, relative to the size of the parts. Points closer than that have no direction.
pub(crate) const CLOSED: f64 = 1e-9;
/// Largest depth at which an overlap is resolved, over the depth of the overlap.
const DEEPER: f64 = 4.0;

/// Contact of two discs or balls, if they are within reach [m]. `width` is the number of features of the second shape.
#[inline]
pub(crate) fn of_round(parts: [&Part; 2], poses: [&Pose; 2], reach: f64, width: u32) -> Option<ContactPoint> {
    let points = parts.map(|part| part.vertices[0]);
    let radii = parts.map(|part| part.radius);
    let distance = (poses[1].point(points[1]) - poses[0].point(points[0])).length_squared();
    let limit = reach + radii[0] + radii[1];
    let feature = parts[0].first.wrapping_mul(width).wrapping_add(parts[1].first);
    (distance <= limit * limit && limit >= 0.0).then_some(ContactPoint { points, radii, normal: Normal::Points, feature })
}

/// Distance of the balls around two parts [m], or minus the depth of their overlap.
#[inline]
pub(crate) fn clearance(parts: [&Part; 2], poses: [&Pose; 2]) -> f64 {
    let [(one, r1), (other, r2)] = parts.map(|part| part.ball);
    poses[1].point(other).distance(poses[0].point(one)) - r1 - r2
}

/// Two convex parts of bodies.
pub(crate) struct Couple<'a> {
    pub parts: [&'a Part; 2],
    pub poses: [&'a Pose; 2],
    /// Pose of the other body in the frame of each.
    pub other_in: [Pose; 2],
    /// Largest gap of a contact [m].
    pub reach: f64,
    /// Number of features of the second body's shape.
    pub width: u32,
}

/// Face of one core and the nearest vertex of the other along its normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FaceGap {
    /// Distance of the cores along the normal [m].
    pub gap: f64,
    /// Index of the body that has the face.
    pub owner: usize,
    pub face: usize,
    pub vertex: usize,
}

impl<'a> Couple<'a> {
    /// Parts of two bodies.
    pub fn new(parts: [&'a Part; 2], poses: [&'a Pose; 2], reach: f64, width: u32) -> Self {
        let other_in = [poses[0].relative(poses[1]), poses[1].relative(poses[0])];
        Self { parts, poses, other_in, reach, width }
    }

    /// Sum of the rounding radii [m].
    #[inline]
    pub fn rounding(&self) -> f64 {
        self.parts[0].radius + self.parts[1].radius
    }

    /// Largest gap of the cores at which their parts have a contact [m].
    #[inline]
    pub fn limit(&self) -> f64 {
        self.reach + self.rounding()
    }

    /// Distance below which the cores count as touching [m].
    #[inline]
    pub fn closed(&self) -> f64 {
        CLOSED * (self.parts[0].ball.1 + self.parts[1].ball.1)
    }

    /// Vertex of the core of a body, in the world [m].
    #[inline]
    pub fn vertex(&self, body: usize, vertex: usize) -> DVec3 {
        self.poses[body].point(self.parts[body].vertices[vertex])
    }

    /// Face of `owner` that the other core is farthest in front of, the first of equals; none if the core has no face.
    #[inline]
    pub fn widest(&self, owner: usize) -> Option<FaceGap> {
        self.widest_of(owner, |_| true)
    }

    /// Face with the widest gap of those that `accepts`, the first of equals.
    #[inline]
    fn widest_of(&self, owner: usize, accepts: impl Fn(&FaceGap) -> bool) -> Option<FaceGap> {
        let [reference, incident] = [self.parts[owner], self.parts[1 - owner]];
        let into = &self.other_in[owner];
        let middle = into.point(incident.ball.0);
        // No gap is wider than that of a ball within the other core.
        let most = |face: usize| reference.normals[face].dot(middle) - reference.offsets[face] - incident.inner;
        let gap = |face: usize| {
            let normal = reference.normals[face];
            let (vertex, along) = incident.support(-into.local_vector(normal));
            FaceGap { gap: normal.dot(into.position - reference.corner(face)) - along, owner, face, vertex }
        };
        // The face that may have the widest gap comes first: it excludes most of the others.
        let faces = 0..reference.normals.len();
        let promising = faces.clone().reduce(|one, other| if most(other) > most(one) { other } else { one })?;
        let mut widest = Some(gap(promising)).filter(&accepts);
        for face in faces.filter(|&face| face != promising) {
            let is_beaten = |widest: FaceGap, gap: f64| gap < widest.gap || (gap == widest.gap && face > widest.face);
            if widest.is_some_and(|widest| is_beaten(widest, most(face))) {
                continue;
            }
            let found = gap(face);
            if widest.is_none_or(|widest| !is_beaten(widest, found.gap)) && accepts(&found) {
                widest = Some(found);
            }
        }
        widest
    }

    /// Whether the normal of a face belongs to the surfaces of both bodies.
    pub fn shows(&self, FaceGap { owner, face, vertex, .. }: &FaceGap) -> bool {
        let normal = self.parts[*owner].normals[*face];
        let against = || -self.other_in[*owner].local_vector(normal);
        self.parts[*owner].shows_face(*face) && self.parts[1 - owner].shows_vertex(*vertex, against())
    }

    /// Face with the widest gap whose normal belongs to both surfaces, for cores that overlap by `-gap` [m]. None if it is far
    /// deeper: other parts are nearer to the surface there.
    pub fn widest_shown(&self, gap: f64) -> Option<FaceGap> {
        let [one, other] = [0, 1].map(|owner| self.widest_of(owner, |face| self.shows(face)));
        let widest = [one, other].into_iter().flatten().reduce(|one, other| if other.gap > one.gap { other } else { one });
        widest.filter(|face| face.gap >= DEEPER * gap - self.closed())
    }

    /// Adds a contact between points of the cores in the frames of `body` and of the other.
    #[inline]
    pub fn push(&self, body: usize, points: [DVec3; 2], normal: Normal, features: [u32; 2], contacts: &mut Vec<ContactPoint>) {
        let other = 1 - body;
        let mut ids = [0; 2];
        ids[body] = self.parts[body].first + features[0];
        ids[other] = self.parts[other].first + features[1];
        let feature = ids[0].wrapping_mul(self.width).wrapping_add(ids[1]);
        let points = if body == 0 { points } else { [points[1], points[0]] };
        contacts.push(ContactPoint { points, radii: self.parts.map(|part| part.radius), normal, feature });
    }
}

/// Outward normal of a body's face as the normal of a contact.
#[inline]
pub(crate) fn as_normal(owner: usize, normal: DVec3) -> Normal {
    if owner == 0 { Normal::First(normal) } else { Normal::Second(-normal) }
}
