//! Nearest points of edges and vertices.

use glam::DVec3;

use super::edges::SKEW;
use crate::contact::{ContactPoint, Normal};
use crate::couple::Couple;

/// Cosine of the normals of contacts along one line.
const ALIKE: f64 = 0.99;
/// Difference of gaps that counts, relative to the lengths of the edges.
const NEARER: f64 = 1e-6;

/// Point of an edge of each core; of a core without edges, its vertex.
#[derive(Debug, Clone, Copy)]
pub(super) struct NearPair {
    /// Distance of the points [m].
    pub distance: f64,
    edges: [usize; 2],
    /// Places of the points along the edges, from 0 to 1.
    along: [f64; 2],
}

impl NearPair {
    /// Points in the frames of their bodies [m].
    pub fn points(&self, couple: &Couple) -> [DVec3; 2] {
        [0, 1].map(|body| {
            let [from, to] = couple.parts[body].edge(self.edges[body]);
            match self.along[body] {
                1.0 => to,
                along => from + (to - from) * along,
            }
        })
    }

    /// Whether the points are within their edges.
    fn is_within(&self) -> [bool; 2] {
        self.along.map(|along| along > 0.0 && along < 1.0)
    }

    /// Whether the edges are far from parallel.
    fn is_skew(&self, couple: &Couple) -> bool {
        let [one, other] = in_world(couple, self.edges).map(|[from, to]| to - from);
        one.cross(other).length_squared() > SKEW * SKEW * one.length_squared() * other.length_squared()
    }

    /// Unit normal from the first body to the second, in the world.
    pub fn normal(&self, couple: &Couple) -> DVec3 {
        let [one, other] = self.points(couple);
        let way = couple.poses[1].point(other) - couple.poses[0].point(one);
        let ways = in_world(couple, self.edges).map(|[from, to]| to - from);
        // The cross product of the edges is accurate even if the points are close to each other.
        let across = ways[0].cross(ways[1]);
        let is_close = self.distance <= couple.closed();
        match across.try_normalize() {
            Some(across) if is_close || self.is_skew(couple) && self.is_within() == [true; 2] => {
                if across.dot(way) < 0.0 {
                    -across
                } else {
                    across
                }
            }
            _ if !is_close => way.normalize(),
            _ => ways.into_iter().find_map(DVec3::try_normalize).unwrap_or(DVec3::Z).any_orthonormal_vector(),
        }
    }

    /// Whether the normal belongs to the surfaces of both bodies.
    pub fn is_shown(&self, couple: &Couple) -> bool {
        if couple.parts.iter().all(|part| part.skin.is_none()) {
            return true;
        }
        let normal = self.normal(couple);
        let shows = |body: usize, normal: DVec3| {
            let (part, direction) = (couple.parts[body], couple.poses[body].local_vector(normal));
            let Some(edge) = part.net.edges.get(self.edges[body]) else { return part.shows_vertex(0, direction) };
            match self.along[body] {
                0.0 => part.shows_vertex(edge.ends[0] as usize, direction),
                1.0 => part.shows_vertex(edge.ends[1] as usize, direction),
                _ => part.shows_edge(self.edges[body], direction),
            }
        };
        shows(0, normal) && shows(1, -normal)
    }

    /// Features of the points: vertices or edges.
    pub fn features(&self, couple: &Couple) -> [u32; 2] {
        [0, 1].map(|body| {
            let part = couple.parts[body];
            match (part.net.edges.get(self.edges[body]), self.along[body]) {
                (None, _) => 0,
                (Some(edge), 0.0) => edge.ends[0],
                (Some(edge), 1.0) => edge.ends[1],
                _ => part.edge_feature(self.edges[body]),
            }
        })
    }

    /// Adds a contact of the points, if they are within reach.
    fn add(&self, couple: &Couple, contacts: &mut Vec<ContactPoint>) {
        if self.distance > couple.limit() {
            return;
        }
        let way = |body: usize| {
            let [from, to] = couple.parts[body].edge(self.edges[body]);
            (to - from).normalize()
        };
        let normal = match self.is_within() {
            [true, false] => Normal::FirstLine(way(0)),
            [false, true] => Normal::SecondLine(way(1)),
            [true, true] if self.is_skew(couple) => {
                super::of_edges(couple, self.edges, couple.poses[0].local_vector(self.normal(couple)))
            }
            _ => Normal::Points,
        };
        couple.push(0, self.points(couple), normal, self.features(couple), contacts);
    }
}

/// Edges of both cores in the world.
fn in_world(couple: &Couple, edges: [usize; 2]) -> [[DVec3; 2]; 2] {
    [0, 1].map(|body| couple.parts[body].edge(edges[body]).map(|end| couple.poses[body].point(end)))
}

/// Nearest points of two edges.
pub(super) fn of_edges(couple: &Couple, edges: [usize; 2]) -> NearPair {
    let (distance, along) = between(in_world(couple, edges));
    NearPair { distance, edges, along }
}

/// Nearest points of two cores without faces.
pub(super) fn of_segments(couple: &Couple) -> NearPair {
    of_edges(couple, [0, 0])
}

/// Adds the contact of a pair of points; of nearly parallel edges also the ends of the part that they share.
pub(super) fn add_pair(couple: &Couple, pair: &NearPair, contacts: &mut Vec<ContactPoint>) {
    let [one, other] = in_world(couple, pair.edges);
    let [way, across] = [one[1] - one[0], other[1] - other[0]];
    if way == DVec3::ZERO || across == DVec3::ZERO || pair.is_skew(couple) {
        return pair.add(couple, contacts);
    }
    // Places of the second edge's ends along the first.
    let place = |point: DVec3| way.dot(point - one[0]) / way.length_squared();
    let places = other.map(place);
    let [low, high] = if places[0] <= places[1] { [0, 1] } else { [1, 0] };
    if places[low] >= 1.0 || places[high] <= 0.0 {
        return pair.add(couple, contacts);
    }
    let end = |of_first: bool, own: f64, end: usize| {
        let (distance, along) = if of_first {
            let point = one[0] + way * own;
            let (distance, along) = between([[point; 2], other]);
            (distance, [own, along[1]])
        } else {
            let (distance, along) = between([one, [other[end]; 2]]);
            (distance, [along[0], end as f64])
        };
        NearPair { distance, along, edges: pair.edges }
    };
    let normal = pair.normal(couple);
    let ends = [end(places[low] <= 0.0, 0.0, low), end(places[high] >= 1.0, 1.0, high)];
    // Cores that cross have ends on both sides.
    let beside = || ends.iter().filter(|end| end.normal(couple).dot(normal) > ALIKE);
    beside().for_each(|end| end.add(couple, contacts));
    let margin = NEARER * way.length().max(across.length());
    if beside().all(|end| pair.distance < end.distance - margin) {
        pair.add(couple, contacts);
    }
}

/// Nearest points of two cores that are apart by at least `gap` along a unit normal in the world.
pub(super) fn closest(couple: &Couple, gap: f64, normal: DVec3) -> NearPair {
    let locals = [couple.poses[0].local_vector(normal), couple.poses[1].local_vector(-normal)];
    let supports = [0, 1].map(|body| couple.parts[body].support(locals[body]));
    let farthest = couple.vertex(0, supports[0].0).distance(couple.vertex(1, supports[1].0));
    let mut best = NearPair { distance: f64::INFINITY, edges: [0, 0], along: [0.0, 0.0] };
    let mut limit = farthest;
    // Points nearer than `limit` are no deeper below the supports than its excess over the gap.
    let lowest = |body: usize, limit: f64| supports[body].1 - (limit - gap) - couple.closed();
    let near = |body: usize| {
        let edges = 0..couple.parts[body].net.edges.len().max(1);
        edges.filter_map(move |edge| {
            let ends = couple.parts[body].edge(edge);
            let height = ends.map(|end| end.dot(locals[body]));
            let height = height[0].max(height[1]);
            (height >= lowest(body, farthest)).then(|| (edge, height, ends.map(|end| couple.poses[body].point(end))))
        })
    };
    let others: Vec<(usize, f64, [DVec3; 2])> = near(1).collect();
    for (one, height, ends) in near(0) {
        if height < lowest(0, limit) {
            continue;
        }
        for &(other, height, across) in &others {
            if height >= lowest(1, limit) {
                let (distance, along) = between([ends, across]);
                if distance < best.distance {
                    best = NearPair { distance, edges: [one, other], along };
                    limit = limit.min(distance);
                }
            }
        }
    }
    best
}

/// Distance of two segments, and the places of their nearest points (Ericson, "Real-time collision detection", section 5.1.9).
fn between([[p, p1], [q, q1]]: [[DVec3; 2]; 2]) -> (f64, [f64; 2]) {
    let (u, v, r) = (p1 - p, q1 - q, p - q);
    let [a, e] = [u.length_squared(), v.length_squared()];
    let [b, c, f] = [u.dot(v), u.dot(r), v.dot(r)];
    let along = if a == 0.0 && e == 0.0 {
        [0.0, 0.0]
    } else if a == 0.0 {
        [0.0, (f / e).clamp(0.0, 1.0)]
    } else if e == 0.0 {
        [(-c / a).clamp(0.0, 1.0), 0.0]
    } else {
        let area = u.cross(v).length_squared();
        let s = if area > 0.0 { ((b * f - c * e) / area).clamp(0.0, 1.0) } else { 0.0 };
        let t = (b * s + f) / e;
        if t < 0.0 {
            [(-c / a).clamp(0.0, 1.0), 0.0]
        } else if t > 1.0 {
            [((b - c) / a).clamp(0.0, 1.0), 1.0]
        } else {
            [s, t]
        }
    };
    ((p + u * along[0]).distance(q + v * along[1]), along)
}
