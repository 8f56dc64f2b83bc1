//! Distances by iteration over all differences of vertices.

use glam::DVec3;
use physcore_rigid::pose::Pose;

/// Convex body of a test: the points within a radius of the hull of vertices.
#[derive(Debug, Clone)]
pub struct Convex {
    pub vertices: Vec<DVec3>,
    pub radius: f64,
}

impl Convex {
    /// Farthest extent along a direction [m].
    pub fn support(&self, pose: &Pose, direction: DVec3) -> f64 {
        let along = self.vertices.iter().map(|vertex| direction.dot(pose.point(*vertex)));
        along.fold(f64::NEG_INFINITY, f64::max) + self.radius * direction.length()
    }
}

/// Gap between two bodies along a unit direction; negative if their shadows overlap.
pub fn gap_along(bodies: [(&Convex, &Pose); 2], direction: DVec3) -> f64 {
    -bodies[0].0.support(bodies[0].1, direction) - bodies[1].0.support(bodies[1].1, -direction)
}

/// Distance of the cores by Gilbert's algorithm with away steps: the point of the Minkowski difference nearest to the origin.
/// Returns the distance and a certified lower bound.
pub fn distance(bodies: [(&Convex, &Pose); 2]) -> (f64, f64) {
    let points = bodies.map(|(body, pose)| body.vertices.iter().map(|vertex| pose.point(*vertex)).collect::<Vec<_>>());
    let mut differences: Vec<DVec3> = Vec::new();
    for one in &points[0] {
        differences.extend(points[1].iter().map(|other| *other - *one));
    }
    let mut weights = vec![0.0; differences.len()];
    let start = (0..differences.len()).min_by(|&a, &b| differences[a].length().total_cmp(&differences[b].length())).unwrap();
    weights[start] = 1.0;
    let mut nearest = differences[start];
    for _ in 0..100_000 {
        let along = |index: usize| differences[index].dot(nearest);
        let toward = (0..differences.len()).min_by(|&a, &b| along(a).total_cmp(&along(b))).unwrap();
        let active = (0..differences.len()).filter(|&index| weights[index] > 0.0);
        let away = active.max_by(|&a, &b| along(a).total_cmp(&along(b))).unwrap();
        if along(away) - along(toward) <= 1e-15 {
            break;
        }
        // Pairwise step: weight moves from the vertex farthest along to the one least along.
        let way = differences[toward] - differences[away];
        let step = (-way.dot(nearest) / way.length_squared()).clamp(0.0, weights[away]);
        weights[toward] += step;
        weights[away] = if step >= weights[away] { 0.0 } else { weights[away] - step };
        nearest += way * step;
    }
    let length = nearest.length();
    let bound =
        if length > 0.0 { differences.iter().map(|d| d.dot(nearest) / length).fold(f64::INFINITY, f64::min) } else { 0.0 };
    let rounding = bodies[0].0.radius + bodies[1].0.radius;
    (length - rounding, bound - rounding)
}
