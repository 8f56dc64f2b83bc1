//! Contacts in the plane: convex polygons with a radius, of which discs have one vertex and capsules two.
//!
//! The face with the widest gap is clipped against the face of the other core that looks at it most. Where two vertices are the
//! nearest points, they are the contact (Gregorius, "The separating axis test between convex polyhedra", GDC 2013; Catto,
//! Box2D v3).

use arrayvec::ArrayVec;
use glam::DVec3;

use crate::contact::{ContactPoint, Normal};
use crate::couple::{Couple, FaceGap, as_normal};
use crate::shapes::Part;

/// Pair of features of two cores.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Nearest {
    /// Vertices of the first and the second core.
    Vertices([usize; 2]),
    /// Face of one core and vertex of the other.
    Face(FaceKey),
}

/// Face of the core of `owner` and vertex of the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FaceKey {
    pub owner: usize,
    pub face: usize,
    pub vertex: usize,
}

/// Adds the contacts of two parts.
#[inline]
pub(crate) fn contacts(couple: &Couple, points: &mut Vec<ContactPoint>) {
    let [one, other] = couple.parts;
    if one.vertices.len() == 1 && other.vertices.len() == 1 {
        add_points(couple, [0, 0], points);
    } else if !couple.is_apart() {
        add_polygons(couple, points);
    }
}

/// Adds the contact between two vertices.
#[inline]
fn add_points(couple: &Couple, vertices: [usize; 2], contacts: &mut Vec<ContactPoint>) {
    let points = [0, 1].map(|body| couple.parts[body].vertices[vertices[body]]);
    let distance = couple.poses[0].point(points[0]).distance_squared(couple.poses[1].point(points[1]));
    let limit = couple.limit();
    if distance <= limit * limit && limit >= 0.0 {
        couple.push(0, points, Normal::Points, vertices.map(|vertex| vertex as u32), contacts);
    }
}

fn add_polygons(couple: &Couple, contacts: &mut Vec<ContactPoint>) {
    let Some(widest) = widest(couple) else { return };
    if widest.gap > couple.limit() {
        return;
    }
    match nearest(couple, &widest) {
        (_, Nearest::Vertices(vertices)) => add_points(couple, vertices, contacts),
        (_, Nearest::Face(key)) => Clip::new(couple, key).add(couple, contacts),
    }
}

/// Face with the widest gap, of the first body if equal.
fn widest(couple: &Couple) -> Option<FaceGap> {
    match [0, 1].map(|owner| couple.widest(owner)) {
        [Some(one), Some(other)] => Some(if other.gap > one.gap { other } else { one }),
        [one, other] => one.or(other),
    }
}

/// Distance of the cores and their nearest features. If the cores overlap, minus their depth, and the face of the least depth.
fn nearest(couple: &Couple, widest: &FaceGap) -> (f64, Nearest) {
    let key = FaceKey { owner: widest.owner, face: widest.face, vertex: widest.vertex };
    let is_flat = couple.parts.iter().all(|part| part.vertices.len() <= 2);
    if widest.gap <= couple.closed() && !is_flat {
        return (widest.gap, Nearest::Face(key));
    }
    // Two segments cross.
    if widest.gap < -couple.closed() || Clip::new(couple, key).gap() <= widest.gap + couple.closed() {
        return (widest.gap, Nearest::Face(key));
    }
    let (distance, features) = closest(couple, key);
    if distance <= couple.closed() { (widest.gap, Nearest::Face(key)) } else { (distance, features) }
}

/// Least distance between a vertex of a core and an edge or vertex of the other, starting from a face and a vertex.
fn closest(couple: &Couple, key: FaceKey) -> (f64, Nearest) {
    let from_face = |key: FaceKey| {
        let [face, point] = [couple.parts[key.owner], couple.parts[1 - key.owner]];
        let point = couple.other_in[key.owner].point(point.vertices[key.vertex]);
        let (distance, end) = to_edge(face, key.face, point);
        let vertices = |end| if key.owner == 0 { [end, key.vertex] } else { [key.vertex, end] };
        (distance, end.map_or(Nearest::Face(key), |end| Nearest::Vertices(vertices(end))))
    };
    let mut best = from_face(key);
    for owner in [0, 1] {
        let [face, point] = [couple.parts[owner], couple.parts[1 - owner]];
        for index in 0..face.normals.len() {
            for vertex in 0..point.vertices.len() {
                let other = from_face(FaceKey { owner, face: index, vertex });
                if other.0 < best.0 {
                    best = other;
                }
            }
        }
    }
    best
}

/// Distance of a point from an edge of a polygon, and the vertex that is nearest if it is an end.
fn to_edge(polygon: &Part, face: usize, point: DVec3) -> (f64, Option<usize>) {
    let next = (face + 1) % polygon.vertices.len();
    let [from, to] = [polygon.vertices[face], polygon.vertices[next]];
    let way = to - from;
    let along = way.dot(point - from);
    if along <= 0.0 {
        (point.distance(from), Some(face))
    } else if along >= way.length_squared() {
        (point.distance(to), Some(next))
    } else {
        (polygon.normals[face].dot(point - from).abs(), None)
    }
}

/// Edge of a core that looks at a face of the other most, clipped to that face.
struct Clip {
    owner: usize,
    /// Normal of the face, in the frame of its body.
    normal: DVec3,
    /// Points of the edge, in the frames of their body and of the face's, and their gap.
    ends: ArrayVec<(DVec3, DVec3, f64), 2>,
    /// Vertices next to each point: of the face, and of the edge.
    features: ArrayVec<[u32; 2], 2>,
    /// Whether the edge is beside the face, so that nothing is left of it but a vertex.
    is_beside: bool,
}

impl Clip {
    fn new(couple: &Couple, FaceKey { owner, face, vertex }: FaceKey) -> Self {
        let [reference, incident] = [couple.parts[owner], couple.parts[1 - owner]];
        let into = &couple.other_in[owner];
        let normal = reference.normals[face];
        let to = (face + 1) % reference.vertices.len();
        let start = reference.vertices[face];
        let length = start.distance(reference.vertices[to]);
        let along = (reference.vertices[to] - start) / length;
        let place = |local: DVec3| along.dot(into.point(local) - start);
        // The edge runs the other way.
        let [last, first] = facing(incident, vertex, into.local_vector(normal));
        let [from, till] = [first, last].map(|vertex| incident.vertices[vertex]);
        let [low, high] = [from, till].map(place);
        let is_beside = high < 0.0 || low > length;
        let mut clip = Self { owner, normal, ends: ArrayVec::new(), features: ArrayVec::new(), is_beside };
        let mut push = |local: DVec3, features: [usize; 2]| {
            let point = into.point(local);
            clip.ends.push((local, point, normal.dot(point - start)));
            clip.features.push(features.map(|vertex| vertex as u32));
        };
        if first == last || is_beside {
            let end = if place(incident.vertices[vertex]) > 0.5 * length { to } else { face };
            push(incident.vertices[vertex], [end, vertex]);
        } else {
            let cut = |at: f64| from + (till - from) * ((at - low) / (high - low));
            push(if low < 0.0 { cut(0.0) } else { from }, [face, first]);
            push(if high > length { cut(length) } else { till }, [to, last]);
        }
        clip
    }

    /// Smallest gap of the points of the edge before the face; infinite if there are none.
    fn gap(&self) -> f64 {
        if self.is_beside {
            return f64::INFINITY;
        }
        self.ends.iter().map(|end| end.2).fold(f64::INFINITY, f64::min)
    }

    /// Adds the points within reach as contacts.
    fn add(&self, couple: &Couple, contacts: &mut Vec<ContactPoint>) {
        for (&(local, point, gap), &features) in self.ends.iter().zip(&self.features) {
            if gap <= couple.limit() {
                let foot = point - gap * self.normal;
                couple.push(self.owner, [foot, local], as_normal(self.owner, self.normal), features, contacts);
            }
        }
    }
}

/// Ends of the edge at a vertex that looks most against a direction; twice the vertex of a disc.
fn facing(part: &Part, vertex: usize, direction: DVec3) -> [usize; 2] {
    let count = part.vertices.len();
    if count == 1 {
        return [0, 0];
    }
    let before = (vertex + count - 1) % count;
    let is_before = part.normals[before].dot(direction) < part.normals[vertex].dot(direction);
    if is_before { [before, vertex] } else { [vertex, (vertex + 1) % count] }
}

/// Distance of two parts, or minus their depth, and the unit normal from the first to the second.
pub(crate) fn separation(couple: &Couple) -> (f64, DVec3) {
    let between = |vertices: [usize; 2]| {
        let way = couple.vertex(1, vertices[1]) - couple.vertex(0, vertices[0]);
        (way.length() - couple.rounding(), way.try_normalize().unwrap_or(DVec3::X))
    };
    let Some(widest) = widest(couple) else { return between([0, 0]) };
    match nearest(couple, &widest) {
        (_, Nearest::Vertices(vertices)) => between(vertices),
        (distance, Nearest::Face(FaceKey { owner, face, .. })) => {
            let normal = couple.poses[owner].rotation * couple.parts[owner].normals[face];
            (distance - couple.rounding(), if owner == 0 { normal } else { -normal })
        }
    }
}
