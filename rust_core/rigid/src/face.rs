//! Faces of networks that meet bodies: triangles between particles, or edges.
//!
//! A face has no mass of its own. Its point at coordinates (x, y) has weights w = (1 − x − y, x, y), by which it stands and moves
//! between its corners. An impulse J at this point is shared among them by the same weights, so that momentum and angular
//! momentum are kept to rounding:
//!
//!     x = Σ wᵢ xᵢ,   v = Σ wᵢ vᵢ,   vᵢ ← vᵢ + wᵢ J / mᵢ,   1/m = Σ wᵢ² / mᵢ
//!
//! In rows a face stands in place of the second body, and coordinates in place of an arm. The particles at the corners meet bodies
//! by themselves. Of the faces along an edge, one has its contacts. Bodies slide over faces as over a plane: contacts at edges and
//! corners count only if no point of a face beside them is nearer.

use std::ops::Index;

use arrayvec::ArrayVec;
use glam::{DMat3, DVec3};

use crate::collision;
use crate::contact::{ContactPoint, Normal};
use crate::mover::{Mover, perpendicular};
use crate::pose::Pose;
use crate::shapes::{Part, SolidShape};

/// Number of the first face among the bodies of a group.
pub const FACES: usize = 1 << 31;

/// Weight below which a point is at the side of a face, and least weight of a point of a face.
const SIDE: f64 = 1e-9;
const OUTSIDE: f64 = -1e-6;
/// Sine of the angle by which the normal of a contact at a side or a corner may lean over a face there.
const LEANING: f64 = 0.3;
/// Sine of the largest angle between the normal of a contact within a face and that of the face.
const SLANTED: f64 = 0.7;
/// Depth of an overlap that counts whatever its normal is, over the size of the body.
const DEEP: f64 = 1e-4;

/// Triangle between particles, or an edge, whose third corner is its second. Indices are those of movers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NetFace<I = u32> {
    /// Corners, of a triangle in order.
    pub corners: [I; 3],
    /// Corner beyond each side, of the face across it; sides begin at the corners.
    pub beyond: [Option<I>; 3],
    /// Whether contacts at each side are contacts of this face.
    pub owns: [bool; 3],
    /// Half the thickness [m].
    pub radius: f64,
}

/// Weights of the corners at a point of a face.
#[inline]
pub fn weights(point: DVec3) -> [f64; 3] {
    [1.0 - point.x - point.y, point.x, point.y]
}

/// Movers of a body by its number: itself, or the corners of a face.
pub fn movers_of(body: usize, faces: &[NetFace]) -> ArrayVec<usize, 3> {
    match body.checked_sub(FACES) {
        Some(face) => faces[face].corners.map(|corner| corner as usize).into(),
        None => ArrayVec::from_iter([body]),
    }
}

/// Largest value of the movers of a body.
pub fn largest_of(body: usize, movers: &[Mover], faces: &[NetFace], of: impl Fn(&Mover) -> f64) -> f64 {
    movers_of(body, faces).into_iter().map(|mover| of(&movers[mover])).fold(0.0, f64::max)
}

/// Adds an impulse at coordinates of a face, by its number, to the velocities of its corners.
pub fn push(face: usize, at: DVec3, impulse: DVec3, movers: &mut [Mover], faces: &[NetFace]) {
    for (corner, weight) in faces[face - FACES].corners.into_iter().zip(weights(at)) {
        let mover = &mut movers[corner as usize];
        mover.velocity += weight * mover.inverse_mass * impulse;
    }
}

impl<I: Copy + PartialEq> NetFace<I> {
    /// Face with other indices; None if an index of a corner has none.
    pub fn map<J>(&self, mut of: impl FnMut(I) -> Option<J>) -> Option<NetFace<J>> {
        let [a, b, c] = self.corners;
        let corners = [of(a)?, of(b)?, of(c)?];
        let beyond = self.beyond.map(|corner| corner.and_then(&mut of));
        Some(NetFace { corners, beyond, owns: self.owns, radius: self.radius })
    }

    /// Corners of the face, and those beyond its sides.
    pub fn particles(&self) -> impl Iterator<Item = I> {
        self.corners.into_iter().chain(self.beyond.into_iter().flatten())
    }

    /// Whether the face is an edge.
    fn is_edge(&self) -> bool {
        self.corners[1] == self.corners[2]
    }

    /// Frame of the face, in which its points have their coordinates. It is not rigid: its axes are the sides from the first corner,
    /// and the unit normal.
    pub fn pose(&self, position: impl Fn(I) -> DVec3) -> Pose {
        let [a, b, c] = self.corners.map(position);
        let way = b - a;
        let [second, third] = if self.is_edge() {
            perpendicular(way.try_normalize().unwrap_or(DVec3::X))
        } else {
            [c - a, way.cross(c - a).normalize_or_zero()]
        };
        Pose { position: a, rotation: DMat3::from_cols(way, second, third) }
    }

    /// Bound on the way of the points of the face against its first corner, since an earlier pose [m].
    pub fn way_from(&self, pose: &Pose, before: &Pose) -> f64 {
        let way = |axis: usize| (pose.rotation.col(axis) - before.rotation.col(axis)).length();
        if self.is_edge() { way(0) } else { way(0).max(way(1)) }
    }

    /// Coordinates of the point of a face that is nearest to a point of the world, in its plane or on its line.
    pub fn coordinates(&self, pose: &Pose, point: DVec3) -> DVec3 {
        let local = pose.rotation.inverse() * (point - pose.position);
        DVec3::new(local.x, if self.is_edge() { 0.0 } else { local.y }, 0.0)
    }

    /// Shape of the face at a pose, and the rigid pose of this shape.
    fn solid(&self, pose: &Pose, dimension: usize) -> (SolidShape, Pose) {
        let DMat3 { x_axis, y_axis, z_axis } = pose.rotation;
        let part = if self.is_edge() || z_axis == DVec3::ZERO {
            Part::capsule([DVec3::ZERO, x_axis], self.radius, dimension)
        } else {
            Part::leaf(vec![DVec3::ZERO, x_axis, y_axis], z_axis).rounded(self.radius)
        };
        (SolidShape::of([part]), Pose { position: pose.position, rotation: DMat3::IDENTITY })
    }

    /// Whether balls around a body and the face are farther apart than a reach [m].
    fn is_apart(&self, (shape, place): (&SolidShape, &Pose), pose: &Pose, reach: f64) -> bool {
        let corners =
            [DVec3::ZERO, pose.rotation.x_axis, if self.is_edge() { pose.rotation.x_axis } else { pose.rotation.y_axis }];
        let middle = (corners[1] + corners[2]) / 3.0;
        let radius = corners.iter().map(|corner| corner.distance(middle)).fold(0.0, f64::max) + self.radius;
        let limit = shape.reach() + radius + reach;
        (pose.position + middle).distance_squared(place.position) > limit * limit
    }

    /// Replaces `found` by the distance of a body from the face and its normal, unless it is beyond a reach [m].
    pub fn separations(
        &self,
        body: (&SolidShape, &Pose),
        pose: &Pose,
        (reach, dimension): (f64, usize),
        found: &mut Vec<(f64, DVec3)>,
    ) {
        found.clear();
        if !self.is_apart(body, pose, reach) {
            let (shape, place) = self.solid(pose, dimension);
            collision::separations(body, (&shape, &place), reach, dimension, found);
        }
    }

    /// Replaces `points` by the contacts of a body with the face within `reach` [m], without those of its corners and of sides that
    /// are not its own. Points of the face have its coordinates.
    pub fn contacts(
        &self,
        body: (&SolidShape, &Pose),
        (pose, position): (&Pose, impl Fn(I) -> DVec3),
        (reach, dimension): (f64, usize),
        points: &mut Vec<ContactPoint>,
    ) {
        points.clear();
        if pose.rotation.determinant() == 0.0 || self.is_apart(body, pose, reach) {
            return;
        }
        let (shape, place) = self.solid(pose, dimension);
        collision::contacts(body, (&shape, &place), reach, dimension, points);
        let inverse = pose.rotation.inverse();
        points.retain_mut(|contact| {
            contact.points[1] = inverse * contact.points[1];
            contact.normal = match contact.normal {
                Normal::Second(normal) => Normal::Second(inverse * normal),
                Normal::SecondLine(line) => Normal::SecondLine(inverse * line),
                Normal::Edges(one, other) => Normal::Edges(one, inverse * other),
                other => other,
            };
            let weights = weights(contact.points[1]);
            let is_corner = weights.iter().filter(|&&weight| weight <= SIDE).count() > 1;
            if is_corner || weights.iter().any(|&weight| weight < OUTSIDE) {
                return false;
            }
            let touch = contact.at([body.1, pose], DVec3::ZERO);
            let (toward, is_deep) = (-touch.normal, touch.gap < -DEEP * body.0.reach());
            let DMat3 { x_axis, y_axis, z_axis } = pose.rotation;
            if self.is_edge() {
                return is_deep || toward.project_onto(x_axis).length() < SLANTED;
            }
            let Some(side) = (0..3).find(|side| weights[(side + 2) % 3] <= SIDE) else {
                return is_deep || toward.reject_from(z_axis).length() < SLANTED;
            };
            let corners = [DVec3::ZERO, x_axis, y_axis];
            let along = corners[(side + 1) % 3] - corners[side];
            let leans = |corner: DVec3| leans(toward, (corner - corners[side]).reject_from(along));
            let beyond = self.beyond[side].map(|corner| position(corner) - pose.position);
            self.owns[side] && (is_deep || !leans(corners[(side + 2) % 3]) && !beyond.is_some_and(leans))
        });
    }
}

/// Whether a direction from a point of a surface leans over a part of it that lies on a way from there: a point of this is nearer.
fn leans(direction: DVec3, way: DVec3) -> bool {
    direction.dot(way) > LEANING * way.length()
}

/// Whether a contact of a body with a particle leans over faces at it, with the corners of these beside it.
fn is_hidden(
    contact: &ContactPoint,
    (shape, body): (&SolidShape, &Pose),
    particle: &Pose,
    mut beside: impl Iterator<Item = DVec3>,
) -> bool {
    let touch = contact.at([body, particle], DVec3::ZERO);
    touch.gap >= -DEEP * shape.reach() && beside.any(|corner| leans(-touch.normal, corner - particle.position))
}

/// Second member of a pair: a body or a particle, or a face.
pub enum SecondSide<'a> {
    /// Body or particle.
    Body(&'a SolidShape),
    /// Face.
    Face(&'a NetFace),
}

impl SecondSide<'_> {
    /// Replaces `points` by the contacts with a body within `reach` [m], without those that faces at a particle hide. The corners
    /// of these beside the particle are given with the positions of all movers. Returns a lower bound of the distance [m] if it
    /// finds one.
    pub fn contacts(
        &self,
        body: (&SolidShape, &Pose),
        (pose, (beside, position)): (&Pose, (&[u32], impl Fn(u32) -> DVec3)),
        (reach, dimension): (f64, usize),
        points: &mut Vec<ContactPoint>,
    ) -> Option<f64> {
        points.clear();
        match self {
            Self::Body(shape) => {
                let clearance = collision::contacts(body, (shape, pose), reach, dimension, points);
                if !beside.is_empty() {
                    points.retain(|point| !is_hidden(point, body, pose, beside.iter().map(|&corner| position(corner))));
                }
                clearance
            }
            Self::Face(face) => {
                face.contacts(body, (pose, position), (reach, dimension), points);
                None
            }
        }
    }
}

/// Values of the bodies of a group, and of its faces.
#[derive(Debug, Clone)]
pub struct GroupValues<T> {
    /// Values of the bodies.
    pub bodies: Vec<T>,
    /// Values of the faces.
    pub faces: Vec<T>,
}

impl<T> Default for GroupValues<T> {
    fn default() -> Self {
        Self { bodies: Vec::new(), faces: Vec::new() }
    }
}

impl<T> Index<usize> for GroupValues<T> {
    type Output = T;

    #[inline]
    fn index(&self, body: usize) -> &T {
        self.bodies.get(body).unwrap_or_else(|| &self.faces[body - FACES])
    }
}
