//! Contacts of two faces: one is clipped against the other along the normal of the contact.

use arrayvec::ArrayVec;
use glam::DVec3;

use super::edges::EdgeGap;
use super::nearest;
use crate::contact::{ContactPoint, Normal};
use crate::couple::{Couple, FaceGap, as_normal};
use crate::shapes::Part;

/// Largest number of points that [`spread`] chooses.
const MOST: usize = 5;
/// Least cosine between the normal of two edges and their faces, at which these are clipped.
const FLAT: f64 = 0.95;
/// Relative excess by which a later point must be better than an earlier one, so that rounding changes no choice.
const BETTER: f64 = 1e-6;
/// Difference of gaps that count as equal, relative to the size of the face.
const LEVEL: f64 = 1e-6;
/// Largest differences of gaps in each tier of points, relative to the size of the face. Lower tiers come first.
const TIERS: [f64; 3] = [LEVEL, 1e-2, f64::MAX];
/// Difference of gaps that is rounding, relative to the size of the face.
const EQUAL: f64 = 1e-11;

/// Corner of the clipped face.
#[derive(Debug, Clone, Copy)]
struct ClipCorner {
    /// Position in the frame of the body with the other face [m].
    point: DVec3,
    /// Features of that body and of the one whose face is clipped.
    features: [u32; 2],
    /// Side from here to the next corner.
    side: ClipSide,
}

/// Side of the clipped face.
#[derive(Debug, Clone, Copy)]
enum ClipSide {
    /// Side of the face itself, by its first vertex.
    Own(u32),
    /// Side of the face that it is clipped against, by its place.
    Other(usize),
}

/// Face of a body against which another is clipped along a normal.
struct Reference<'a> {
    owner: usize,
    part: &'a Part,
    face: usize,
    /// Unit normal from the owner to the other body, in the frame of the owner.
    normal: DVec3,
}

impl Reference<'_> {
    /// Start of each side, and the direction across it into the face.
    fn sides(&self) -> impl Iterator<Item = (DVec3, DVec3)> {
        let corners = self.part.net.face(self.face);
        let corner = |place: usize| self.part.vertices[corners[place] as usize];
        (0..corners.len()).map(move |place| {
            let start = corner(place);
            (start, self.normal.cross(corner(following(place, corners.len())) - start))
        })
    }

    /// Distance of a point from the face along the normal [m].
    fn gap(&self, point: DVec3) -> f64 {
        let normal = self.part.normals[self.face];
        normal.dot(point - self.part.corner(self.face)) / normal.dot(self.normal)
    }

    /// Clips a face to the sides of this one.
    fn clip(&self, mut polygon: Vec<ClipCorner>, whole: u32) -> Vec<ClipCorner> {
        let corners = self.part.net.face(self.face);
        let mut kept = Vec::with_capacity(polygon.capacity());
        for (place, (start, inward)) in self.sides().enumerate() {
            let depth = |corner: &ClipCorner| inward.dot(corner.point - start);
            let Some(first) = polygon.first().map(depth) else { break };
            let mut here = first;
            for (index, corner) in polygon.iter().enumerate() {
                let next = &polygon[following(index, polygon.len())];
                let there = if index + 1 < polygon.len() { depth(next) } else { first };
                if here >= 0.0 {
                    kept.push(*corner);
                }
                // A segment has one side, not two.
                if (here >= 0.0) != (there >= 0.0) && (polygon.len() > 2 || index == 0) {
                    let point = corner.point + (next.point - corner.point) * (here / (here - there));
                    let features = match corner.side {
                        ClipSide::Own(vertex) => [corners[place], vertex],
                        ClipSide::Other(side) => {
                            [corners[if following(place, corners.len()) == side { side } else { place }], whole]
                        }
                    };
                    let side = if there >= 0.0 { corner.side } else { ClipSide::Other(place) };
                    kept.push(ClipCorner { point, features, side });
                }
                here = there;
            }
            std::mem::swap(&mut polygon, &mut kept);
            kept.clear();
        }
        polygon
    }
}

/// Whether a point is above or below a face along its normal.
pub(super) fn is_over(part: &Part, face: usize, point: DVec3) -> bool {
    let reference = Reference { owner: 0, part, face, normal: part.normals[face] };
    reference.sides().all(|(start, inward)| inward.dot(point - start) >= 0.0)
}

/// Place of the next corner of a polygon.
fn following(place: usize, count: usize) -> usize {
    if place + 1 < count { place + 1 } else { 0 }
}

/// Contacts of a face with the face of the other body that looks at it most.
pub(super) fn of_face<'a>(couple: &Couple<'a>, FaceGap { owner, face, vertex, .. }: FaceGap) -> Manifold<'a> {
    let [part, incident] = [couple.parts[owner], couple.parts[1 - owner]];
    let normal = part.normals[face];
    let direction = couple.other_in[owner].local_vector(normal);
    let facing = facing(incident, direction, |corners| corners.contains(&(vertex as u32)));
    Manifold::new(couple, Reference { owner, part, face, normal }, facing)
}

/// Adds the contacts along the normal of a face; at least one of the nearest vertex, if the face is not far.
pub(super) fn add_face(couple: &Couple, gap: FaceGap, manifold: &Manifold, contacts: &mut Vec<ContactPoint>) {
    let FaceGap { owner, face, vertex, .. } = gap;
    let normal = couple.parts[owner].normals[face];
    if !manifold.add(couple, as_normal(owner, normal), contacts) {
        let local = couple.parts[1 - owner].vertices[vertex];
        let foot = couple.other_in[owner].point(local) - gap.gap * normal;
        let features = [couple.parts[owner].face_feature(face), vertex as u32];
        couple.push(owner, [foot, local], as_normal(owner, normal), features, contacts);
    }
}

/// Adds the contacts along the normal of two edges: of the faces beside them if one is nearly flat, else of the edges. An edge
/// that lies across the border of a face would rock over it.
pub(super) fn add_edges(couple: &Couple, gap: EdgeGap, contacts: &mut Vec<ContactPoint>) {
    let normals = [gap.normal, -couple.other_in[0].local_vector(gap.normal)];
    let faces = [0, 1].map(|body| {
        let part = couple.parts[body];
        let ends = part.net.edges[gap.edges[body]].ends;
        facing(part, -normals[body], |corners| ends.iter().all(|end| corners.contains(end)))
    });
    for owner in [0, 1] {
        let part = couple.parts[owner];
        if let Some(face) = faces[owner].filter(|&face| part.normals[face].dot(normals[owner]) > FLAT) {
            // The normal of edges that are nearly parallel would turn much farther than they do.
            let normal = as_normal(owner, normals[owner]);
            let reference = Reference { owner, part, face, normal: normals[owner] };
            if Manifold::new(couple, reference, faces[1 - owner]).add(couple, normal, contacts) {
                return;
            }
        }
    }
    let pair = nearest::of_edges(couple, gap.edges);
    if gap.gap > couple.closed() {
        nearest::add_pair(couple, &pair, contacts);
    } else {
        let normal = if gap.is_skew { super::of_edges(couple, gap.edges, normals[0]) } else { as_normal(0, normals[0]) };
        couple.push(0, pair.points(couple), normal, pair.features(couple), contacts);
    }
}

/// Face that looks most against a direction, of those that a condition on their vertices selects.
fn facing(part: &Part, direction: DVec3, selects: impl Fn(&[u32]) -> bool) -> Option<usize> {
    let faces = (0..part.normals.len()).filter(|&face| selects(part.net.face(face)));
    faces.reduce(|one, other| if part.normals[other].dot(direction) < part.normals[one].dot(direction) { other } else { one })
}

/// Points of a face, clipped to a face of the other body.
pub(super) struct Manifold<'a> {
    reference: Reference<'a>,
    corners: Vec<ClipCorner>,
}

impl<'a> Manifold<'a> {
    /// Clips a face of the other body, or its whole core if it has no faces.
    fn new(couple: &Couple, reference: Reference<'a>, facing: Option<usize>) -> Self {
        let incident = couple.parts[1 - reference.owner];
        let into = &couple.other_in[reference.owner];
        let corner = |vertex: u32| ClipCorner {
            point: into.point(incident.vertices[vertex as usize]),
            features: [reference.part.face_feature(reference.face), vertex],
            side: ClipSide::Own(vertex),
        };
        let own = facing.map(|face| incident.net.face(face));
        let count = own.map_or(incident.vertices.len(), <[u32]>::len);
        // Each side of a convex face adds at most one corner.
        let mut polygon = Vec::with_capacity(count + reference.part.net.face(reference.face).len());
        polygon.extend((0..count).map(|place| corner(own.map_or(place as u32, |own| own[place]))));
        let whole = facing.map_or(0, |face| incident.face_feature(face));
        let corners = reference.clip(polygon, whole);
        Self { reference, corners }
    }

    /// Smallest gap of the cores; infinite if nothing is left of the clipped face.
    pub fn gap(&self) -> f64 {
        self.corners.iter().map(|corner| self.reference.gap(corner.point)).fold(f64::INFINITY, f64::min)
    }

    /// Adds the contacts within reach. Returns whether there are any.
    fn add(&self, couple: &Couple, normal: Normal, contacts: &mut Vec<ContactPoint>) -> bool {
        let Self { reference, corners } = self;
        let places = corners.iter().map(|corner| (corner.point, reference.gap(corner.point), corner.features));
        let near: Vec<(DVec3, f64, [u32; 2])> = places.filter(|place| place.1 <= couple.limit()).collect();
        for index in spread(near.len(), |index| (near[index].0, near[index].1), reference.normal, 3) {
            let (point, gap, features) = near[index];
            let local = couple.other_in[reference.owner].local_point(point);
            let foot = point - gap * reference.normal;
            couple.push(reference.owner, [foot, local], normal, features, contacts);
        }
        !near.is_empty()
    }
}

/// Well-spread points of a `count`, given with their gaps: at most four, or two in 2D. The first is the outermost of those with
/// nearly the smallest gap, the second the one farthest from it. The others are farthest from the line between these, on each
/// side. The point with the smallest gap is always among them, if need be as one more. Points with larger gaps follow where the
/// others are too few.
pub(crate) fn spread(
    count: usize,
    place: impl Fn(usize) -> (DVec3, f64),
    normal: DVec3,
    dimension: usize,
) -> ArrayVec<usize, MOST> {
    let most = 2 * (dimension - 1);
    if count <= most {
        return (0..count).collect();
    }
    let point = |index: usize| place(index).0;
    let gap = &|index: usize| place(index).1;
    let size = (0..count).map(|index| point(index).distance(point(0))).fold(0.0, f64::max);
    let deepest = (1..count).fold(0, |best, one| if gap(one) < gap(best) { one } else { best });
    let lowest = gap(deepest);
    let within = |tier: f64| (0..count).filter(move |&index| gap(index) <= lowest + tier * size);
    // All points of a tier are chosen, or some of the first that has too many.
    let few = TIERS.iter().take_while(|&&tier| within(tier).count() <= most).count();
    let tier = TIERS[few.min(TIERS.len() - 1)];
    let best = |measure: &dyn Fn(usize) -> f64| {
        let better = |best: (usize, f64), one: usize| {
            let found = measure(one);
            if found > best.1 + BETTER * size { (one, found) } else { best }
        };
        within(tier).fold((deepest, f64::NEG_INFINITY), better).0
    };
    let middle = (0..count).map(point).sum::<DVec3>() / count as f64;
    let first = best(&|index| if gap(index) <= lowest + LEVEL * size { point(index).distance(middle) } else { -1.0 });
    let from = point(first);
    let second = best(&|index| point(index).distance(from));
    let across = normal.cross(point(second) - from).normalize_or_zero();
    let sides = [1.0, -1.0].map(|side| best(&|index| side * across.dot(point(index) - from)));
    let mut chosen: ArrayVec<usize, MOST> = if few > 0 { within(TIERS[few - 1]).collect() } else { ArrayVec::from_iter([first]) };
    for index in [second, sides[0], sides[1]] {
        if chosen.len() < most && !chosen.contains(&index) {
            chosen.push(index);
        }
    }
    if chosen.iter().all(|&index| gap(index) > lowest + EQUAL * size) {
        chosen.push(deepest);
    }
    chosen.sort_unstable();
    chosen
}
