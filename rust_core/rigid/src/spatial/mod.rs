//! Contacts in space: convex polyhedra with a radius, of which balls have one vertex and capsules two.
//!
//! Cores are separated along the normal of a face, or of an edge of each (Gregorius, "The separating axis test between convex
//! polyhedra", GDC 2013). Their faces along this normal are clipped against each other. Where the nearest points are on an edge
//! or a vertex, these are the contact.

use arrayvec::ArrayVec;
use glam::DVec3;

use crate::contact::{ContactPoint, Normal};
use crate::couple::{Couple, FaceGap};
use crate::shapes::Part;

mod clip;
mod cuboids;
mod edges;
mod nearest;

pub(crate) use clip::spread;
use edges::EdgeGap;
use nearest::NearPair;

/// Adds the contacts of two parts; returns a lower bound of their distance [m].
pub(crate) fn contacts(couple: &Couple, points: &mut Vec<ContactPoint>) -> f64 {
    let add_pair = |pair: &NearPair, points: &mut Vec<ContactPoint>| {
        if pair.is_shown(couple) {
            nearest::add_pair(couple, pair, points);
        }
    };
    let Some(axis) = axis(couple) else {
        let pair = nearest::of_segments(couple);
        add_pair(&pair, points);
        return pair.distance - couple.rounding();
    };
    if axis.gap() > couple.limit() {
        return axis.gap() - couple.rounding();
    }
    let manifold = match axis {
        SeparatingAxis::Face(face) => Some(clip::of_face(couple, face)),
        SeparatingAxis::Edges(_) => None,
    };
    let is_exact = manifold.as_ref().is_some_and(|manifold| manifold.gap() <= axis.gap() + couple.closed());
    let pair = if is_exact { None } else { axis.nearest(couple) };
    match (axis, pair, manifold) {
        (_, Some(pair), _) => add_pair(&pair, points),
        (SeparatingAxis::Face(face), _, Some(manifold)) if couple.shows(&face) => clip::add_face(couple, face, &manifold, points),
        (SeparatingAxis::Edges(edges), ..) if edges.is_shown(couple) => clip::add_edges(couple, edges, points),
        // Overlaps are resolved along the surface, of whatever parts it consists.
        _ if axis.gap() <= couple.closed() => {
            if let Some(face) = couple.widest_shown(axis.gap()) {
                clip::add_face(couple, face, &clip::of_face(couple, face), points);
            }
        }
        _ => {}
    }
    pair.map_or(axis.gap(), |pair| pair.distance) - couple.rounding()
}

/// Direction along which two cores are farthest apart, or overlap least.
#[derive(Debug, Clone, Copy)]
enum SeparatingAxis {
    Face(FaceGap),
    Edges(EdgeGap),
}

/// Excess of the gap along two edges over that of a face, from which on it counts, relative to the size of the parts.
const EDGE: f64 = 1e-9;

/// Axis of two cores. None if neither has a face.
fn axis(couple: &Couple) -> Option<SeparatingAxis> {
    let first = couple.widest(0);
    if let Some(face) = first.filter(|face| face.gap > couple.limit()) {
        return Some(SeparatingAxis::Face(face));
    }
    let face = match [first, couple.widest(1)] {
        [Some(one), Some(other)] => {
            if other.gap > one.gap + couple.closed() {
                other
            } else {
                one
            }
        }
        [one, other] => one.or(other)?,
    };
    if face.gap > couple.limit() {
        return Some(SeparatingAxis::Face(face));
    }
    // A face has the widest gap of all directions if it is the distance of the cores.
    if face.gap > couple.closed() && is_distance(couple, &face) {
        return Some(SeparatingAxis::Face(face));
    }
    let size = couple.parts[0].ball.1 + couple.parts[1].ball.1;
    Some(edges::widest(couple, face.gap + EDGE * size).map_or(SeparatingAxis::Face(face), SeparatingAxis::Edges))
}

/// Whether the nearest vertex is over the face, so that a gap is the distance of the cores.
fn is_distance(couple: &Couple, &FaceGap { owner, face, vertex, .. }: &FaceGap) -> bool {
    let point = couple.other_in[owner].point(couple.parts[1 - owner].vertices[vertex]);
    clip::is_over(couple.parts[owner], face, point)
}

/// Whether the nearest vertex of a face's body is over a face of the other that is parallel to it.
fn is_over_parallel(couple: &Couple, face: &FaceGap) -> bool {
    couple.widest(1 - face.owner).is_some_and(|other| other.gap >= face.gap - couple.closed() && is_distance(couple, &other))
}

impl SeparatingAxis {
    fn gap(&self) -> f64 {
        match self {
            Self::Face(face) => face.gap,
            Self::Edges(edges) => edges.gap,
        }
    }

    /// Unit normal from the first body to the second, in the world.
    fn normal(&self, couple: &Couple) -> DVec3 {
        match *self {
            Self::Face(FaceGap { owner, face, .. }) => {
                let normal = couple.poses[owner].rotation * couple.parts[owner].normals[face];
                if owner == 0 { normal } else { -normal }
            }
            Self::Edges(edges) => couple.poses[0].rotation * edges.normal,
        }
    }

    /// Nearest points of two cores that are apart, if they are not on the axis.
    fn nearest(&self, couple: &Couple) -> Option<NearPair> {
        let is_exact = match self {
            Self::Face(_) => false,
            Self::Edges(edges) => edges.is_exact,
        };
        if is_exact || self.gap() <= couple.closed() {
            return None;
        }
        Some(nearest::closest(couple, self.gap(), self.normal(couple)))
    }

    /// Distance of two cores and their normal, or minus their depth.
    fn distance(&self, couple: &Couple) -> (f64, DVec3) {
        let is_exact = match *self {
            Self::Face(face) => is_distance(couple, &face) || is_over_parallel(couple, &face),
            Self::Edges(edges) => edges.is_exact,
        };
        let pair = (!is_exact).then(|| self.nearest(couple)).flatten();
        pair.map_or_else(|| (self.gap(), self.normal(couple)), |pair| (pair.distance, pair.normal(couple)))
    }
}

/// Vertices of the face on which a part rests on its lowest vertex, at most four; `up` is the ground's normal in its frame.
pub(crate) fn resting(part: &Part, lowest: usize, up: DVec3) -> ArrayVec<u32, 5> {
    if part.net.starts.is_empty() {
        return flat_resting(part, lowest, up);
    }
    let lowest = lowest as u32;
    let faces = (0..part.normals.len()).filter(|&face| part.net.face(face).contains(&lowest));
    let Some(face) = faces.reduce(|one, other| if part.normals[other].dot(up) < part.normals[one].dot(up) { other } else { one })
    else {
        return [lowest].into_iter().collect();
    };
    let corners = part.net.face(face);
    let place = |index: usize| {
        let vertex = part.vertices[corners[index] as usize];
        (vertex, vertex.dot(up))
    };
    clip::spread(corners.len(), place, part.normals[face], 3).into_iter().map(|place| corners[place]).collect()
}

/// Vertices of the edge on which a polygon or a segment rests.
fn flat_resting(part: &Part, lowest: usize, up: DVec3) -> ArrayVec<u32, 5> {
    let count = part.vertices.len();
    let beside = [(lowest + count - 1) % count, (lowest + 1) % count];
    let [before, after] = beside.map(|vertex| part.vertices[vertex].dot(up));
    let mut both = [lowest, if before < after { beside[0] } else { beside[1] }];
    both.sort_unstable();
    both[..count.min(2)].iter().map(|&vertex| vertex as u32).collect()
}

/// Distance of two parts, or minus their depth, and the unit normal from the first to the second.
pub(crate) fn separation(couple: &Couple) -> (f64, DVec3) {
    let pair = || nearest::of_segments(couple);
    let (distance, normal) = axis(couple).map_or_else(|| (pair().distance, pair().normal(couple)), |axis| axis.distance(couple));
    (distance - couple.rounding(), normal)
}

/// Normal of two edges, in an order whose cross product points along a normal in the frame of the first body.
fn of_edges(couple: &Couple, edges: [usize; 2], normal: DVec3) -> Normal {
    let [one, other] = [0, 1].map(|body| {
        let [from, to] = couple.parts[body].edge(edges[body]);
        to - from
    });
    let across = one.cross(couple.other_in[0].rotation * other);
    if across.dot(normal) < 0.0 { Normal::Edges(-one, other) } else { Normal::Edges(one, other) }
}
