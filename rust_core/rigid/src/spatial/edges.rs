//! Gaps of two polyhedra along the cross products of their edges.

use glam::DVec3;

use super::cuboids;
use crate::couple::Couple;
use crate::pose::Pose;
use crate::shapes::Part;

/// Smallest sine of the angle of two edges whose cross product is a direction.
pub(super) const PARALLEL: f64 = 1e-6;

/// Product of two sines that may be zero but for rounding.
const ROUNDING: f64 = 1e-15;

/// Sine of the angle of two edges from which on they are far from parallel.
pub(super) const SKEW: f64 = 0.05;

/// Edge of each core, and the gap along their common normal.
#[derive(Debug, Clone, Copy)]
pub(super) struct EdgeGap {
    /// Distance of the cores along the normal [m].
    pub gap: f64,
    /// Edges of the first and the second core.
    pub edges: [usize; 2],
    /// Unit normal from the first to the second, in the frame of the first body.
    pub normal: DVec3,
    /// Whether the edges are far from parallel.
    pub is_skew: bool,
    /// Whether their common normal meets both edges, so that the gap is the distance of the cores.
    pub is_exact: bool,
}

impl EdgeGap {
    /// Whether the normal belongs to the surfaces of both bodies.
    pub fn is_shown(&self, couple: &Couple) -> bool {
        let against = -couple.other_in[0].local_vector(self.normal);
        couple.parts[0].shows_edge(self.edges[0], self.normal) && couple.parts[1].shows_edge(self.edges[1], against)
    }
}

/// Edge in the frame of the first body.
#[derive(Debug, Clone, Copy)]
struct Ridge {
    edge: usize,
    start: DVec3,
    way: DVec3,
    /// Normals of the faces on the left and on the right.
    normals: [DVec3; 2],
}

impl Ridge {
    /// Edge of a part at a pose, by its ends.
    fn of(part: &Part, ends: [usize; 2], pose: &Pose) -> Option<Self> {
        let edge = part.net.edges.iter().position(|edge| edge.ends.map(|end| end as usize) == ends)?;
        let [start, end] = part.edge(edge);
        let normals = part.net.edges[edge].faces.map(|face| pose.rotation * part.normals[face as usize]);
        Some(Self { edge, start: pose.point(start), way: pose.rotation * (end - start), normals })
    }

    /// Direction between the normals, even if they are opposite.
    fn outward(&self) -> DVec3 {
        let [left, right] = self.normals;
        (left + right) * self.way.length() + self.way.cross(left - right)
    }
}

/// Edges of a part that may separate it by more than `least` from a core that contains a ball.
fn ridges(
    part: &Part,
    (center, radius): (DVec3, f64),
    least: f64,
) -> impl Iterator<Item = (usize, DVec3, DVec3, [DVec3; 2])> + '_ {
    let edges = part.net.edges.iter().enumerate();
    edges.filter_map(move |(index, edge)| {
        let [start, end] = edge.ends.map(|vertex| part.vertices[vertex as usize]);
        let normals = edge.faces.map(|face| part.normals.get(face as usize).copied().unwrap_or(DVec3::ZERO));
        (highest(start, end - start, normals, center, least + radius) >= least + radius).then_some((
            index,
            start,
            end - start,
            normals,
        ))
    })
}

/// Upper bound of n·(x − edge) over the unit normals n of an edge, if it may be at least `least`.
#[inline]
fn highest(start: DVec3, way: DVec3, [left, right]: [DVec3; 2], x: DVec3, least: f64) -> f64 {
    let up = x - start;
    let of_faces = left.dot(up).max(right.dot(up));
    // Below both faces, x is nearest to one of these. A segment without faces has all normals.
    if of_faces < 0.0 || of_faces >= least {
        return of_faces;
    }
    let is_between = left.cross(up).dot(way) >= 0.0 && up.cross(right).dot(way) >= 0.0;
    if is_between || left == DVec3::ZERO { up.reject_from(way).length() } else { of_faces }
}

/// Pair of edges along whose normal the cores are farthest apart, by more than `least`.
pub(super) fn widest(couple: &Couple, least: f64) -> Option<EdgeGap> {
    let [one, other] = couple.parts;
    if one.net.edges.is_empty() || other.net.edges.is_empty() {
        return None;
    }
    let into = &couple.other_in[0];
    if let [Some(half), Some(across)] = [one, other].map(|part| part.half) {
        let apart = into.point(other.ball.0) - one.ball.0;
        let pair = cuboids::widest(apart, [half, across.map(|edge| into.rotation * edge)], least)?;
        if let Some(found) = between(&Ridge::of(one, pair[0], &Pose::WORLD)?, &Ridge::of(other, pair[1], into)?, least) {
            return Some(found);
        }
    }
    let mut others = Vec::with_capacity(other.net.edges.len());
    let near = ridges(other, (couple.other_in[1].point(one.ball.0), one.inner), least);
    others.extend(near.map(|(edge, start, way, normals)| Ridge {
        edge,
        start: into.point(start),
        way: into.rotation * way,
        normals: normals.map(|normal| into.rotation * normal),
    }));
    if others.is_empty() {
        return None;
    }
    let mut best: Option<EdgeGap> = None;
    let mut limit = least;
    for (edge, start, way, normals) in ridges(one, (into.point(other.ball.0), other.inner), least) {
        let here = Ridge { edge, start, way, normals };
        for there in others.iter().filter(|there| may_cross(&here, there) && may_cross(there, &here)) {
            if let Some(found) = between(&here, there, limit) {
                limit = found.gap;
                best = Some(found);
            }
        }
    }
    best
}

/// Gap along the normal of two edges, if it is a normal of both and the gap is more than `least`.
fn between(one: &Ridge, other: &Ridge, least: f64) -> Option<EdgeGap> {
    let across = one.way.cross(other.way);
    let sizes = one.way.length_squared() * other.way.length_squared();
    if across.length_squared() <= PARALLEL * PARALLEL * sizes {
        return None;
    }
    let is_segment = [one, other].map(|ridge| ridge.normals[0] == DVec3::ZERO);
    let apart = other.start - one.start;
    // Sign of the cross product along the outward normals of the first, or against those of the second.
    let sign = match is_segment {
        [false, _] => across.dot(one.outward()),
        [true, false] => -across.dot(other.outward()),
        [true, true] => across.dot(apart),
    };
    let outward = if sign < 0.0 { -across } else { across };
    if !is_outward(one, outward) || !is_outward(other, -outward) {
        return None;
    }
    let normal = outward.normalize();
    let gap = normal.dot(apart);
    if gap <= least {
        return None;
    }
    let area = across.length_squared();
    let along = [apart.cross(other.way).dot(across) / area, apart.cross(one.way).dot(across) / area];
    let is_skew = area > SKEW * SKEW * sizes;
    let is_exact = along.iter().all(|part| (0.0..=1.0).contains(part));
    Some(EdgeGap { gap, edges: [one.edge, other.edge], normal, is_skew, is_exact })
}

/// Whether a normal of `other` between those of its faces may be normal to the way of an edge.
#[inline]
fn may_cross(ridge: &Ridge, other: &Ridge) -> bool {
    let [left, right] = other.normals.map(|normal| normal.dot(ridge.way));
    left * right <= ROUNDING * ridge.way.length_squared()
}

/// Whether a normal of an edge is between those of its faces.
fn is_outward(ridge: &Ridge, normal: DVec3) -> bool {
    let [left, right] = ridge.normals;
    left == DVec3::ZERO || (left.cross(normal).dot(ridge.way) >= 0.0 && normal.cross(right).dot(ridge.way) >= 0.0)
}

#[cfg(test)]
mod tests {
    use glam::{DMat3, DQuat};

    use super::*;

    /// Axes of cuboids are found from their half edges as from their faces. Poses are far apart from each other, so that no two
    /// axes have equal gaps.
    #[test]
    fn cuboids_have_the_edges_of_polyhedra() {
        let cuboids = [DVec3::new(0.5, 0.4, 0.3), DVec3::new(0.2, 0.7, 0.3)].map(Part::cuboid);
        let polyhedra = cuboids.clone().map(|part| Part { half: None, ..part });
        let mut found = 0;
        for index in 0..1000 {
            let number = |place: usize| (0.5 + f64::from(index) * (0.1 + 0.618_034 * place as f64)).fract() - 0.5;
            let turn = DQuat::from_xyzw(number(1), number(2), number(3), number(4)).normalize();
            let position = DVec3::new(number(5), number(6), number(7)) * 2.5;
            let there = Pose { position, rotation: DMat3::from_quat(turn) };
            let [fast, slow] = [&cuboids, &polyhedra].map(|[one, other]| {
                let couple = Couple::new([one, other], [&Pose::WORLD, &there], 0.0, 0);
                widest(&couple, -0.2).map(|gap| (gap.edges, gap.gap, gap.normal))
            });
            assert_eq!(fast, slow, "{index}");
            found += usize::from(fast.is_some());
        }
        assert!((100..900).contains(&found), "{found}");
    }
}
