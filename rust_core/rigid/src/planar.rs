//! Contacts in the plane: convex polygons with a radius, of which discs have one vertex and capsules two.
//!
//! The face with the widest gap is clipped against the face of the other core that looks at it most. Where two vertices are the
//! nearest points, they are the contact (Gregorius, "The separating axis test between convex polyhedra", GDC 2013; Catto,
//! `Box2D` v3).

use arrayvec::ArrayVec;
use glam::DVec3;

use crate::contact::{ContactPoint, Normal};
use crate::couple::{Couple, FaceGap, as_normal};
use crate::shapes::Part;

/// Nearest features of two cores.
#[derive(Debug, Clone, Copy, PartialEq)]
enum NearestFeatures {
    /// Vertices of the first and the second core.
    Vertices([usize; 2]),
    /// Face of one core and vertex of the other, with their distance, or minus their depth.
    Face(FaceGap),
}

/// Adds the contacts of two parts of which at most one is a disc.
pub(crate) fn contacts(couple: &Couple, contacts: &mut Vec<ContactPoint>) {
    let Some(widest) = widest(couple) else { return };
    if widest.gap > couple.limit() {
        return;
    }
    match nearest(couple, &widest) {
        NearestFeatures::Vertices(vertices) if shows(couple, vertices) => add_points(couple, vertices, contacts),
        NearestFeatures::Face(face) if couple.shows(&face) => Clip::new(couple, &face).add(couple, contacts),
        // Overlaps are resolved along the surface, of whatever parts it consists.
        NearestFeatures::Face(face) if face.gap <= couple.closed() => {
            if let Some(face) = couple.widest_shown(face.gap) {
                Clip::new(couple, &face).add(couple, contacts);
            }
        }
        _ => {}
    }
}

/// Whether the way between two vertices is normal to the surfaces of both bodies.
fn shows(couple: &Couple, vertices: [usize; 2]) -> bool {
    let way = (couple.vertex(1, vertices[1]) - couple.vertex(0, vertices[0])).normalize_or_zero();
    let shows = |body: usize, way: DVec3| couple.parts[body].shows_vertex(vertices[body], couple.poses[body].local_vector(way));
    shows(0, way) && shows(1, -way)
}

/// Adds the contact between two vertices, if it is within reach.
fn add_points(couple: &Couple, vertices: [usize; 2], contacts: &mut Vec<ContactPoint>) {
    let points = [0, 1].map(|body| couple.parts[body].vertices[vertices[body]]);
    let distance = couple.vertex(0, vertices[0]).distance_squared(couple.vertex(1, vertices[1]));
    let limit = couple.limit();
    if distance <= limit * limit && limit >= 0.0 {
        couple.push(0, points, Normal::Points, vertices.map(|vertex| vertex as u32), contacts);
    }
}

/// Face with the widest gap, of the first body if equal.
fn widest(couple: &Couple) -> Option<FaceGap> {
    match [0, 1].map(|owner| couple.widest(owner)) {
        [Some(one), Some(other)] => Some(if other.gap > one.gap { other } else { one }),
        [one, other] => one.or(other),
    }
}

/// Nearest features of the cores; of cores that overlap, the face of the least depth.
fn nearest(couple: &Couple, widest: &FaceGap) -> NearestFeatures {
    let is_flat = couple.parts.iter().all(|part| part.vertices.len() <= 2);
    // Two segments on a line have no gap along a face.
    if widest.gap <= couple.closed() && !(is_flat && widest.gap >= -couple.closed()) {
        return NearestFeatures::Face(*widest);
    }
    if Clip::new(couple, widest).gap() <= widest.gap + couple.closed() {
        return NearestFeatures::Face(*widest);
    }
    let (distance, features) = closest(couple, widest);
    if distance <= couple.closed() { NearestFeatures::Face(*widest) } else { features }
}

/// Least distance between a vertex of a core and an edge or vertex of the other, which have a gap along a face.
fn closest(couple: &Couple, widest: &FaceGap) -> (f64, NearestFeatures) {
    let FaceGap { gap, owner, face, vertex } = *widest;
    let [reference, other] = [couple.parts[owner], couple.parts[1 - owner]];
    let into = &couple.other_in[owner];
    let (normal, start) = (reference.normals[face], reference.vertices[face]);
    let farthest = to_edge(reference, face, into.point(other.vertices[vertex])).0 + couple.closed();
    // Points nearer than that are not deeper below the face, and not higher above it.
    let is_near = |body: usize, vertex: usize| {
        if body == owner {
            normal.dot(reference.vertices[vertex] - start) >= gap - farthest
        } else {
            normal.dot(into.point(other.vertices[vertex]) - start) <= farthest
        }
    };
    let mut best = (f64::INFINITY, NearestFeatures::Face(*widest));
    for owner in [0, 1] {
        let [polygon, other] = [couple.parts[owner], couple.parts[1 - owner]];
        let count = polygon.normals.len();
        for vertex in (0..other.vertices.len()).filter(|&vertex| is_near(1 - owner, vertex)) {
            let point = couple.other_in[owner].point(other.vertices[vertex]);
            for face in (0..count).filter(|&face| is_near(owner, face) || is_near(owner, (face + 1) % count)) {
                let (gap, end) = to_edge(polygon, face, point);
                if gap < best.0 {
                    let vertices = |end| if owner == 0 { [end, vertex] } else { [vertex, end] };
                    let face = NearestFeatures::Face(FaceGap { gap, owner, face, vertex });
                    best = (gap, end.map_or(face, |end| NearestFeatures::Vertices(vertices(end))));
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
    fn new(couple: &Couple, &FaceGap { owner, face, vertex, .. }: &FaceGap) -> Self {
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

/// Ends of the edge at a vertex that looks most against a direction; twice the vertex of a disc, or if the edge is within a body.
fn facing(part: &Part, vertex: usize, direction: DVec3) -> [usize; 2] {
    let count = part.vertices.len();
    if count == 1 {
        return [0, 0];
    }
    let before = (vertex + count - 1) % count;
    let is_before = part.normals[before].dot(direction) < part.normals[vertex].dot(direction);
    let edge = if is_before { before } else { vertex };
    if part.shows_face(edge) { [edge, (edge + 1) % count] } else { [vertex, vertex] }
}

/// Distance of two parts, or minus their depth, and the unit normal from the first to the second.
pub(crate) fn separation(couple: &Couple) -> (f64, DVec3) {
    let between = |vertices: [usize; 2]| {
        let way = couple.vertex(1, vertices[1]) - couple.vertex(0, vertices[0]);
        (way.length() - couple.rounding(), way.try_normalize().unwrap_or(DVec3::X))
    };
    let Some(widest) = widest(couple) else { return between([0, 0]) };
    match nearest(couple, &widest) {
        NearestFeatures::Vertices(vertices) => between(vertices),
        NearestFeatures::Face(FaceGap { gap, owner, face, .. }) => {
            let normal = couple.poses[owner].rotation * couple.parts[owner].normals[face];
            (gap - couple.rounding(), if owner == 0 { normal } else { -normal })
        }
    }
}
