//! Convex hulls of points.

use glam::DVec3;

use super::{Part, Planar};

/// Distance from a plane within which a point counts as on it, relative to the size of the points.
const FLAT: f64 = 1e-9;

/// Largest distance of a point from the first.
fn size(points: &[DVec3]) -> f64 {
    points.iter().map(|point| point.distance(points[0])).fold(0.0, f64::max)
}

/// Convex hull of points in the plane: a polygon without straight corners. None if they span no area.
pub(super) fn polygon(points: &[DVec3]) -> Option<Part> {
    let tolerance = FLAT * size(points);
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    // Lower side from left to right, then upper side from right to left.
    let side = |points: &mut dyn Iterator<Item = DVec3>| {
        let mut chain: Vec<DVec3> = Vec::new();
        for point in points {
            while let [.., before, last] = chain[..]
                && (last - before).across(point - before) <= tolerance * (point - before).length()
            {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let mut vertices = side(&mut sorted.iter().copied());
    vertices.extend(side(&mut sorted.iter().rev().copied()));
    (vertices.len() > 2).then(|| Part::polygon(vertices, 0.0))
}

/// Triangle of a hull that is being built.
#[derive(Debug, Clone, Copy)]
struct HullTriangle {
    corners: [u32; 3],
    normal: DVec3,
}

/// Convex hull of points in space: a polyhedron without flat edges. None if they span no volume.
pub(super) fn polyhedron(points: &[DVec3]) -> Option<Part> {
    let tolerance = FLAT * size(points);
    let triangles: Vec<[u32; 3]> = triangles(points, tolerance)?.iter().map(|triangle| triangle.corners).collect();
    let whole = || triangles.iter().map(|corners| corners.to_vec()).collect::<Vec<_>>();
    Part::compact(points, &faces(points, &triangles, tolerance)).or_else(|| Part::compact(points, &whole()))
}

/// Triangles of the hull, counterclockwise as seen from outside, one point at a time.
fn triangles(points: &[DVec3], tolerance: f64) -> Option<Vec<HullTriangle>> {
    let triangle = |corners: [u32; 3]| {
        let [a, b, c] = corners.map(|corner| points[corner as usize]);
        HullTriangle { corners, normal: (b - a).cross(c - a).normalize_or_zero() }
    };
    let height =
        |triangle: &HullTriangle, point: u32| triangle.normal.dot(points[point as usize] - points[triangle.corners[0] as usize]);
    let start = tetrahedron(points, tolerance)?;
    let [a, b, c, d] = start;
    let mut hull = [[a, b, c], [a, d, b], [b, d, c], [c, d, a]].map(triangle).to_vec();
    let mut left: Vec<u32> = (0..points.len() as u32).filter(|point| !start.contains(point)).collect();
    // The points farthest out come first, so that few triangles are made in vain.
    let middle = start.iter().map(|&corner| points[corner as usize]).sum::<DVec3>() / 4.0;
    left.sort_by(|&one, &other| points[other as usize].distance(middle).total_cmp(&points[one as usize].distance(middle)));
    for point in left {
        let sees: Vec<bool> = hull.iter().map(|triangle| height(triangle, point) > tolerance).collect();
        let seen = || hull.iter().zip(&sees).filter(|(_, sees)| **sees).map(|(triangle, _)| triangle.corners);
        let sides: Vec<[u32; 2]> = seen().flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
        let horizon = sides.iter().filter(|[from, to]| !sides.contains(&[*to, *from]));
        let new: Vec<HullTriangle> = horizon.map(|&[from, to]| triangle([from, to, point])).collect();
        let mut kept = sees.iter();
        hull.retain(|_| kept.next() == Some(&false));
        hull.extend(new);
    }
    Some(hull)
}

/// Four points that span a volume, the last behind the plane of the first three. None if there are none.
fn tetrahedron(points: &[DVec3], tolerance: f64) -> Option<[u32; 4]> {
    let farthest = |measure: &dyn Fn(DVec3) -> f64| {
        let best = (0..points.len()).reduce(|best, one| if measure(points[one]) > measure(points[best]) { one } else { best })?;
        (measure(points[best]) > tolerance).then_some(best)
    };
    let a = 0;
    let b = farthest(&|point| point.distance(points[a]))?;
    let way = (points[b] - points[a]).normalize();
    let c = farthest(&|point| (point - points[a]).reject_from_normalized(way).length())?;
    let normal = way.cross(points[c] - points[a]).normalize();
    let d = farthest(&|point| normal.dot(point - points[a]).abs())?;
    let behind = normal.dot(points[d] - points[a]) < 0.0;
    Some((if behind { [a, b, c, d] } else { [a, c, b, d] }).map(|corner| corner as u32))
}

/// Faces of a convex surface: loops around the triangles that lie in one plane, without straight corners.
pub(super) fn faces(points: &[DVec3], triangles: &[[u32; 3]], tolerance: f64) -> Vec<Vec<u32>> {
    let at = |corner: u32| points[corner as usize];
    let area = |[a, b, c]: [u32; 3]| (at(b) - at(a)).cross(at(c) - at(a));
    // A thin triangle has no reliable plane: the largest take the others in.
    let mut order: Vec<usize> = (0..triangles.len()).collect();
    order.sort_by(|&one, &other| area(triangles[other]).length_squared().total_cmp(&area(triangles[one]).length_squared()));
    let mut is_free = vec![true; triangles.len()];
    let mut loops: Vec<Vec<u32>> = Vec::new();
    for &first in &order {
        if !is_free[first] {
            continue;
        }
        let (normal, origin) = (area(triangles[first]).normalize(), at(triangles[first][0]));
        let is_level = |corner: u32| normal.dot(at(corner) - origin).abs() <= tolerance;
        let mut sides: Vec<[u32; 2]> = Vec::new();
        for &other in &order {
            if is_free[other] && triangles[other].iter().all(|&corner| is_level(corner)) {
                is_free[other] = false;
                let [a, b, c] = triangles[other];
                sides.extend([[a, b], [b, c], [c, a]]);
            }
        }
        let outer: Vec<[u32; 2]> = sides.iter().copied().filter(|&[from, to]| !sides.contains(&[to, from])).collect();
        let mut corners = vec![outer[0][0]];
        while let Some(&[_, to]) = outer.iter().find(|side| side[0] == corners[corners.len() - 1])
            && to != corners[0]
            && corners.len() <= outer.len()
        {
            corners.push(to);
        }
        loops.push(corners);
    }
    // A vertex of two faces is within a straight edge.
    let mut count = vec![0; points.len()];
    loops.iter().flatten().for_each(|&corner| count[corner as usize] += 1);
    loops.iter_mut().for_each(|corners| corners.retain(|&corner| count[corner as usize] > 2));
    loops.retain(|corners| corners.len() > 2);
    loops
}
