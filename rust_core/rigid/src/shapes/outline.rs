//! Polygons that need not be convex, cut into convex parts.

use glam::DVec3;

use super::skin::{Corner, Skin};
use super::tree::PartTree;
use super::{BoundingBox, Part, Planar};

/// Sine of the angle of a corner that counts as straight.
const STRAIGHT: f64 = 1e-9;

/// Closed outline with the interior on its left.
pub(super) struct Outline {
    vertices: Vec<DVec3>,
}

impl Outline {
    /// Vertices without those that equal the one before them.
    pub fn distinct(vertices: &[DVec3]) -> Vec<DVec3> {
        let count = vertices.len();
        (0..count)
            .filter(|&place| vertices[place] != vertices[(place + count - 1) % count])
            .map(|place| vertices[place])
            .collect()
    }

    /// Outline without its straight corners; None if nothing is left of it.
    pub fn new(mut vertices: Vec<DVec3>) -> Option<Self> {
        loop {
            let count = vertices.len();
            if count < 3 {
                return None;
            }
            let is_straight = |place: &usize| {
                let [before, here, after] = [place + count - 1, *place, place + 1].map(|place| vertices[place % count]);
                let [to, from] = [here - before, after - here];
                to.across(from).abs() <= STRAIGHT * to.length() * from.length()
            };
            match (0..count).find(is_straight) {
                Some(place) => vertices.remove(place),
                None => return Some(Self { vertices }),
            };
        }
    }

    /// Two edges that cross or touch, each by the index of its first vertex, unless they are neighbors.
    pub fn crossing(vertices: &[DVec3]) -> Option<[usize; 2]> {
        let count = vertices.len();
        let edge = |index: usize| [vertices[index], vertices[(index + 1) % count]];
        let around = |ends: [DVec3; 2]| BoundingBox { lower: ends[0].min(ends[1]), upper: ends[0].max(ends[1]) };
        let boxes: Vec<BoundingBox> = (0..count).map(|index| around(edge(index))).collect();
        let tree = PartTree::new(&boxes);
        let mut found: Option<[usize; 2]> = None;
        for one in 0..count {
            tree.near(&boxes[one], |other| {
                let is_apart = other > one + 1 && (other + 1) % count != one;
                if is_apart && meet([edge(one), edge(other)]) && found.is_none_or(|[_, least]| other < least) {
                    found = Some([one, other]);
                }
            });
            if found.is_some() {
                break;
            }
        }
        found
    }

    /// Convex parts: ears, joined where the union is convex (S. Hertel and K. Mehlhorn, 1983).
    pub fn parts(&self) -> Vec<Part> {
        let vertices = &self.vertices;
        let whole: Vec<u32> = (0..vertices.len() as u32).collect();
        if self.is_convex(&whole) {
            return vec![Part::polygon(vertices.clone(), 0.0)];
        }
        self.joined(self.ears(whole)).into_iter().map(|corners| self.part(&corners)).collect()
    }

    fn at(&self, index: u32) -> DVec3 {
        self.vertices[index as usize]
    }

    /// Twice the area of a triangle, negative if it is clockwise.
    fn area(&self, [a, b, c]: [u32; 3]) -> f64 {
        (self.at(b) - self.at(a)).across(self.at(c) - self.at(a))
    }

    fn is_convex(&self, corners: &[u32]) -> bool {
        let count = corners.len();
        (0..count).all(|place| self.area([0, 1, 2].map(|step| corners[(place + step) % count])) > 0.0)
    }

    /// Triangles of a polygon: of all convex corners without a vertex in their triangle, the one whose triangle is widest.
    fn ears(&self, mut left: Vec<u32>) -> Vec<Vec<u32>> {
        let mut triangles = Vec::new();
        while left.len() > 3 {
            let count = left.len();
            let triangle = |place: usize| [0, 1, 2].map(|step| left[(place + count - 1 + step) % count]);
            // Height over the longest side: thin triangles come last.
            let width = |corners: [u32; 3]| {
                let sides = [0, 1, 2].map(|side| self.at(corners[side]).distance(self.at(corners[(side + 1) % 3])));
                self.area(corners) / sides.into_iter().fold(0.0, f64::max)
            };
            let is_empty = |corners: [u32; 3]| {
                let is_in = |vertex: u32| {
                    let sides = [0, 1, 2].map(|side| [corners[side], corners[(side + 1) % 3], vertex]);
                    sides.into_iter().all(|side| self.area(side) >= 0.0)
                };
                left.iter().all(|vertex| corners.contains(vertex) || !is_in(*vertex))
            };
            let ears = (0..count).filter(|&place| self.area(triangle(place)) > 0.0 && is_empty(triangle(place)));
            let widest = ears.reduce(|one, other| if width(triangle(other)) > width(triangle(one)) { other } else { one });
            let place = widest.unwrap_or(0);
            triangles.push(triangle(place).to_vec());
            left.remove(place);
        }
        triangles.push(left);
        triangles.retain(|corners| self.area([corners[0], corners[1], corners[2]]) > 0.0);
        triangles
    }

    /// Joins polygons that share an edge, as long as the union is convex.
    fn joined(&self, mut polygons: Vec<Vec<u32>>) -> Vec<Vec<u32>> {
        let union = |one: &[u32], other: &[u32]| {
            let count = one.len();
            let shared = (0..count).find_map(|place| {
                let [from, to] = [one[place], one[(place + 1) % count]];
                let back = (0..other.len()).find(|&back| other[back] == to && other[(back + 1) % other.len()] == from)?;
                Some((place, back))
            })?;
            let mut corners: Vec<u32> = (1..=count).map(|step| one[(shared.0 + step) % count]).collect();
            corners.extend((2..other.len()).map(|step| other[(shared.1 + step) % other.len()]));
            self.is_convex(&corners).then_some(corners)
        };
        let mut one = 0;
        while one < polygons.len() {
            let found = (one + 1..polygons.len()).find_map(|other| Some((other, union(&polygons[one], &polygons[other])?)));
            match found {
                Some((other, corners)) => {
                    polygons[one] = corners;
                    polygons.remove(other);
                }
                None => one += 1,
            }
        }
        polygons
    }

    /// Convex part with the surface of the whole polygon.
    fn part(&self, corners: &[u32]) -> Part {
        let count = self.vertices.len() as u32;
        let faces = corners.iter().enumerate().map(|(place, &from)| corners[(place + 1) % corners.len()] == (from + 1) % count);
        let corner = |&vertex: &u32| {
            let beside = [(vertex + count - 1) % count, (vertex + 1) % count];
            let ways = beside.map(|other| (self.at(other) - self.at(vertex)).normalize());
            Some(Corner { outward: ways[1].outward() - ways[0].outward(), ways: ways.to_vec() })
        };
        let skin = Skin { faces: faces.collect(), edges: Vec::new(), vertices: corners.iter().map(corner).collect() };
        let part = Part::polygon(corners.iter().map(|&corner| self.at(corner)).collect(), 0.0);
        Part { skin: Some(Box::new(skin)), ..part }
    }
}

/// Whether two segments have a point in common.
fn meet([[a, b], [c, d]]: [[DVec3; 2]; 2]) -> bool {
    let side = |from: DVec3, to: DVec3, point: DVec3| (to - from).across(point - from);
    let [c_side, d_side, a_side, b_side] = [side(a, b, c), side(a, b, d), side(c, d, a), side(c, d, b)];
    if c_side == 0.0 && d_side == 0.0 {
        let overlap = |axis: usize| {
            let [low, high] = [a[axis].min(b[axis]), a[axis].max(b[axis])];
            c[axis].max(d[axis]) >= low && c[axis].min(d[axis]) <= high
        };
        return overlap(0) && overlap(1);
    }
    let opposite = |one: f64, other: f64| (one >= 0.0 && other <= 0.0) || (one <= 0.0 && other >= 0.0);
    opposite(c_side, d_side) && opposite(a_side, b_side)
}
