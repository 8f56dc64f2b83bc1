//! Rounded convex polytopes: all points within a radius of the convex hull of given points. Capsules and boxes are examples.

use std::collections::BTreeSet;

use glam::DVec3;

use super::wrapping::Wrapping;

/// Largest distance of a point from a plane through others to count as a point of it, relative to their extent.
pub(super) const FLAT: f64 = 1e-9;
/// Distance below which no direction is defined, relative to the extent.
const DIRECTED: f64 = f64::EPSILON;

/// Convex hull of points, in 2D at z = 0, with a rounding radius.
#[derive(Debug, Clone, PartialEq)]
pub struct Polytope {
    /// Vertices [m].
    vertices: Vec<DVec3>,
    facets: Vec<Facet>,
    /// Edges by their ends; in 2D the vertices.
    edges: Vec<[u32; 2]>,
    /// Rounding radius [m].
    rounding: f64,
    /// Largest coordinate [m].
    extent: f64,
}

/// Facet of the hull; in 2D a side.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Facet {
    /// Outward unit normal n, and n·x of the facet's points.
    pub(super) normal: DVec3,
    pub(super) offset: f64,
    /// Vertices, counterclockwise as seen from outside.
    pub(super) loops: Vec<u32>,
    /// Inward unit normals of the sides within the plane of the facet, and their products with points of the sides.
    sides: Vec<(DVec3, f64)>,
}

/// Part of the surface that is nearest to a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Feature {
    /// Facet, which is flat.
    Facet,
    /// Edge, with its unit direction.
    Edge(DVec3),
    /// Vertex.
    Vertex,
}

impl Feature {
    /// Curvature [1/m] along a unit direction of the surface at a distance [m]; for a zero direction, the largest curvature.
    pub(super) fn curvature(self, distance: f64, direction: DVec3) -> f64 {
        let straight = match self {
            Self::Facet => return 0.0,
            Self::Edge(edge) => edge.dot(direction).powi(2),
            Self::Vertex => 0.0,
        };
        (1.0 - straight).max(0.0) / distance.max(f64::MIN_POSITIVE)
    }
}

/// Surface nearest to a point.
#[derive(Debug, Clone, Copy)]
pub struct Nearest {
    /// Signed distance [m], positive outside.
    pub distance: f64,
    /// Outward unit normal.
    pub normal: DVec3,
    /// Feature of the surface that contains the nearest point.
    pub feature: Feature,
}

impl Polytope {
    /// Rounded hull of `points`; None if they span no area in 2D, or no volume in 3D.
    pub fn hull(points: &[DVec3], dimension: usize, rounding: f64) -> Option<Self> {
        let extent = extent(points);
        let size = points.iter().map(|point| (*point - points[0]).length()).fold(0.0, f64::max);
        let tolerance = FLAT * size;
        let facets = Wrapping { points, dimension, tolerance, size }.facets()?;
        let flat = |facet: &Facet| points.iter().all(|point| facet.offset - facet.normal.dot(*point) <= tolerance);
        if facets.len() <= dimension || facets.iter().any(flat) {
            return None;
        }
        let (mut edges, mut known) = (Vec::new(), BTreeSet::new());
        for Facet { loops, .. } in &facets {
            for (place, &from) in loops.iter().enumerate() {
                let to = loops[(place + 1) % loops.len()];
                let ends = if dimension == 2 { [from, from] } else { [from.min(to), from.max(to)] };
                if known.insert(ends) {
                    edges.push(ends);
                }
            }
        }
        Some(Self { vertices: points.to_vec(), facets, edges, rounding, extent })
    }

    /// Capsule: all points within `radius` of the segment between two points.
    #[inline]
    pub fn capsule(ends: [DVec3; 2], radius: f64) -> Self {
        let extent = extent(&ends);
        Self { vertices: ends.to_vec(), facets: Vec::new(), edges: vec![[0, 1]], rounding: radius, extent }
    }

    /// Largest coordinate [m].
    #[inline]
    pub fn extent(&self) -> f64 {
        self.extent + self.rounding
    }

    /// Vertices of every facet, counterclockwise as seen from outside.
    #[inline]
    pub fn loops(&self) -> impl Iterator<Item = &[u32]> {
        self.facets.iter().map(|facet| facet.loops.as_slice())
    }

    /// Planes n·x = offset of the facets, including the rounding.
    #[inline]
    pub fn planes(&self) -> impl Iterator<Item = (DVec3, f64)> {
        self.facets.iter().map(|facet| (facet.normal, facet.offset + self.rounding))
    }

    /// Center and radius of a ball around the polytope.
    #[inline]
    pub fn ball(&self) -> (DVec3, f64) {
        let center = self.vertices.iter().sum::<DVec3>() / self.vertices.len() as f64;
        (center, self.rounding + self.vertices.iter().map(|vertex| (*vertex - center).length()).fold(0.0, f64::max))
    }

    /// Surface nearest to `x`.
    pub fn nearest(&self, x: DVec3) -> Nearest {
        let heights = self.facets.iter().map(|facet| (facet.normal.dot(x) - facet.offset, facet));
        let highest = heights.clone().reduce(|one, other| if other.0 > one.0 { other } else { one });
        let of_facet = |(height, facet): (f64, &Facet)| Nearest {
            distance: height - self.rounding,
            normal: facet.normal,
            feature: Feature::Facet,
        };
        if let Some(facet) = highest.filter(|(height, _)| *height <= 0.0) {
            return of_facet(facet);
        }
        if let Some(facet) = heights.filter(|(height, _)| *height > 0.0).find(|(_, facet)| facet.is_over(x)) {
            return of_facet(facet);
        }
        let points = self.edges.iter().map(|&[from, to]| on_segment(x, [from, to].map(|end| self.vertices[end as usize])));
        let nearer = |one: (DVec3, Feature), other: (DVec3, Feature)| {
            if (x - other.0).length_squared() < (x - one.0).length_squared() { other } else { one }
        };
        let (point, feature) = points.reduce(nearer).unwrap_or((self.vertices[0], Feature::Vertex));
        let away = x - point;
        let length = away.length();
        if let Some(facet) = highest.filter(|_| length <= DIRECTED * self.extent) {
            return of_facet(facet);
        }
        let normal = match feature {
            _ if length > 0.0 => away / length,
            Feature::Edge(direction) if direction.z == 0.0 => DVec3::new(-direction.y, direction.x, 0.0),
            Feature::Edge(direction) => direction.any_orthonormal_vector(),
            _ => DVec3::X,
        };
        Nearest { distance: length - self.rounding, normal, feature }
    }

    /// Curvature [1/m] along a unit direction of the surface at the distance of `x`; for a zero direction, the largest curvature.
    #[inline]
    pub fn curvature(&self, x: DVec3, direction: DVec3) -> f64 {
        let Nearest { distance, feature, .. } = self.nearest(x);
        feature.curvature(distance + self.rounding, direction)
    }
}

impl Facet {
    pub(super) fn new(normal: DVec3, offset: f64, points: &[DVec3], tolerance: f64, dimension: usize) -> Self {
        let along = if dimension == 2 { normal.cross(DVec3::Z) } else { normal.any_orthonormal_vector() };
        let on = (0..).zip(points).filter(|(_, point)| offset - normal.dot(**point) <= tolerance);
        let mut loops: Vec<u32> = on.map(|(index, _)| index).collect();
        let at = |index: u32| points[index as usize];
        if dimension == 2 {
            loops.sort_by(|&one, &other| along.dot(at(one)).total_cmp(&along.dot(at(other))));
            loops = vec![loops[0], loops[loops.len() - 1]];
            let sides = [(along, along.dot(at(loops[0]))), (-along, -along.dot(at(loops[1])))];
            return Self { normal, offset, loops, sides: sides.to_vec() };
        }
        let center = loops.iter().map(|&index| at(index)).sum::<DVec3>() / loops.len() as f64;
        let across = normal.cross(along);
        let angle = |index: u32| libm::atan2(across.dot(at(index) - center), along.dot(at(index) - center));
        loops.sort_by(|&one, &other| angle(one).total_cmp(&angle(other)));
        // Points within a side, or within the facet, are no vertices.
        let is_corner = |loops: &[u32], place: usize| {
            let count = loops.len();
            let [before, here, after] = [place + count - 1, place, place + 1].map(|place| at(loops[place % count]));
            (here - before).cross(after - here).dot(normal) > tolerance * (here - before).length()
        };
        while let Some(place) = (0..loops.len()).find(|&place| !is_corner(&loops, place)) {
            loops.remove(place);
        }
        let side = |place: usize| {
            let [from, to] = [place, place + 1].map(|place| at(loops[place % loops.len()]));
            let inward = normal.cross(to - from).normalize();
            (inward, inward.dot(from))
        };
        let sides = (0..loops.len()).map(side).collect();
        Self { normal, offset, loops, sides }
    }

    /// Whether a point is above the facet along its normal.
    fn is_over(&self, x: DVec3) -> bool {
        self.sides.iter().all(|(inward, offset)| inward.dot(x) >= *offset)
    }
}

/// Largest coordinate.
fn extent(points: &[DVec3]) -> f64 {
    points.iter().map(|point| point.abs().max_element()).fold(0.0, f64::max)
}

/// Point of a segment nearest to `x`, and its feature.
fn on_segment(x: DVec3, [from, to]: [DVec3; 2]) -> (DVec3, Feature) {
    let way = to - from;
    let along = way.dot(x - from);
    if along <= 0.0 {
        (from, Feature::Vertex)
    } else if along >= way.length_squared() {
        (to, Feature::Vertex)
    } else {
        (from + way * (along / way.length_squared()), Feature::Edge(way.normalize()))
    }
}
