//! Closest points of a vertex and a triangle, and of two edges.
//!
//! Source: C. Ericson, "Real-Time Collision Detection", 2005, sections 5.1.5 and 5.1.9.

use glam::DVec3;

/// Closest points of two elements.
#[derive(Debug, Clone, Copy)]
pub struct Closest {
    /// Weights of the four vertices. The separation of the closest points is p = Σ wᵢ xᵢ, with Σ wᵢ = 0.
    pub weights: [f64; 4],
    /// Separation p [m], from the second element to the first.
    pub separation: DVec3,
    /// Whether both closest points are interior: neither on the boundary of the triangle nor at the end of an edge.
    pub interior: bool,
}

/// Linear combination of four vectors with these weights.
#[inline(always)]
pub fn combined(weights: &[f64; 4], vectors: &[DVec3; 4]) -> DVec3 {
    weights[0] * vectors[0] + weights[1] * vectors[1] + weights[2] * vectors[2] + weights[3] * vectors[3]
}

fn closest(weights: [f64; 4], x: &[DVec3; 4], interior: bool) -> Closest {
    Closest { weights, separation: combined(&weights, x), interior }
}

/// Closest point of the triangle (x₁, x₂, x₃) to x₀.
#[inline]
pub fn vertex_face(x: &[DVec3; 4]) -> Closest {
    let [p, a, b, c] = *x;
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return closest([1.0, -1.0, 0.0, 0.0], x, false);
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return closest([1.0, 0.0, -1.0, 0.0], x, false);
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let along = d1 / (d1 - d3);
        return closest([1.0, along - 1.0, -along, 0.0], x, false);
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return closest([1.0, 0.0, 0.0, -1.0], x, false);
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let along = d2 / (d2 - d6);
        return closest([1.0, along - 1.0, 0.0, -along], x, false);
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let along = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return closest([1.0, 0.0, along - 1.0, -along], x, false);
    }
    let total = va + vb + vc;
    let (v, w) = (vb / total, vc / total);
    closest([1.0, v + w - 1.0, -v, -w], x, true)
}

/// Closest points of the edges (x₀, x₁) and (x₂, x₃).
#[inline]
pub fn edge_edge(x: &[DVec3; 4]) -> Closest {
    let [p1, q1, p2, q2] = *x;
    let (d1, d2, r) = (q1 - p1, q2 - p2, p1 - p2);
    let (a, e, b) = (d1.length_squared(), d2.length_squared(), d1.dot(d2));
    let (c, f) = (d1.dot(r), d2.dot(r));
    let denominator = a * e - b * b;
    // For parallel edges any point of the first edge is as near as the others.
    let mut s = if denominator > f64::EPSILON * a * e { ((b * f - c * e) / denominator).clamp(0.0, 1.0) } else { 0.5 };
    let mut t = (b * s + f) / e;
    if !(0.0..=1.0).contains(&t) {
        t = t.clamp(0.0, 1.0);
        s = ((b * t - c) / a).clamp(0.0, 1.0);
    }
    let inside = |along: f64| along > 0.0 && along < 1.0;
    closest([1.0 - s, s, t - 1.0, -t], x, inside(s) && inside(t))
}
