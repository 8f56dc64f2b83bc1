//! Mass properties: size, center of mass and inertia of bodies of uniform density.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};

use super::plane::Planar;

/// Size, center of mass and inertia at unit density.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MassProperties {
    /// Area [m²] in 2D, volume [m³] in 3D.
    pub size: f64,
    /// Center of mass [m].
    pub center: DVec3,
    /// Inertia tensor about the center of mass, per unit density. In 2D it is that of a lamina, of which `z_axis.z` counts.
    pub inertia: DMat3,
}

/// Tensor |a|² 1 − a aᵀ: inertia of a unit mass at `a`.
fn of_point(a: DVec3) -> DMat3 {
    of_moments(DMat3::from_cols(a * a.x, a * a.y, a * a.z))
}

/// Inertia tensor tr(M) 1 − M from the second moments M = ∫ x xᵀ.
fn of_moments(moments: DMat3) -> DMat3 {
    let trace = moments.x_axis.x + moments.y_axis.y + moments.z_axis.z;
    DMat3::from_diagonal(DVec3::splat(trace)) - moments
}

impl MassProperties {
    /// Body about the origin with these second moments ∫ x², ∫ y², ∫ z².
    fn symmetric(size: f64, moments: DVec3) -> Self {
        Self { size, center: DVec3::ZERO, inertia: of_moments(DMat3::from_diagonal(moments)) }
    }

    /// Disc of a radius [m].
    pub fn disc(radius: f64) -> Self {
        let area = PI * radius * radius;
        Self::symmetric(area, DVec3::new(1.0, 1.0, 0.0) * (0.25 * area * radius * radius))
    }

    /// Ball of a radius [m].
    pub fn ball(radius: f64) -> Self {
        let volume = 4.0 / 3.0 * PI * radius * radius * radius;
        Self::symmetric(volume, DVec3::splat(0.2 * volume * radius * radius))
    }

    /// Cuboid with these edges [m]; in 2D a rectangle, with the third edge 0.
    pub fn cuboid(edges: DVec3) -> Self {
        let size = edges.x * edges.y * if edges.z == 0.0 { 1.0 } else { edges.z };
        Self::symmetric(size, edges * edges * (size / 12.0))
    }

    /// Capsule with a length between the centers of its ends and a radius [m]; in 2D along x, in 3D along z.
    pub fn capsule(length: f64, radius: f64, dimension: usize) -> Self {
        let [square, half] = [radius * radius, 0.5 * length];
        if dimension == 2 {
            let [middle, ends] = [2.0 * radius * length, PI * square];
            // The half discs have their centers of mass at 4 r / 3 π from their diameters.
            let along = ends * (half * half + length * 4.0 * radius / (3.0 * PI) + 0.25 * square);
            let moments = DVec3::new(middle * length * length / 12.0 + along, middle * square / 3.0 + 0.25 * ends * square, 0.0);
            return Self::symmetric(middle + ends, moments);
        }
        let [middle, ends] = [PI * square * length, 4.0 / 3.0 * PI * square * radius];
        // The half balls have their centers of mass at 3 r / 8 from their flat sides.
        let along = middle * length * length / 12.0 + ends * (half * half + length * 0.375 * radius + 0.2 * square);
        let across = 0.25 * middle * square + 0.2 * ends * square;
        Self::symmetric(middle + ends, DVec3::new(across, across, along))
    }

    /// Interior of a polygon in the plane z = 0. A clockwise polygon has a negative size.
    pub fn polygon(vertices: &[DVec3]) -> Self {
        let edges = || vertices.iter().enumerate().map(|(index, &from)| [from, vertices[(index + 1) % vertices.len()]]);
        // Triangles from the first vertex, then from the center of mass, so that large coordinates do not cancel.
        let twice = |[from, to]: [DVec3; 2], origin: DVec3| (from - origin).across(to - origin);
        let origin = vertices[0];
        let size = 0.5 * edges().map(|edge| twice(edge, origin)).sum::<f64>();
        let way = edges().map(|edge| (edge[0] + edge[1] - 2.0 * origin) * twice(edge, origin)).sum::<DVec3>() / (6.0 * size);
        let center = origin + way;
        let moments = edges().map(|edge| {
            let [a, b] = edge.map(|end| end - center);
            (square(a) + square(b) + square(a + b)) * (twice(edge, center) / 24.0)
        });
        Self { size, center, inertia: of_moments(moments.fold(DMat3::ZERO, |sum, one| sum + one)) }
    }

    /// Interior of a closed surface of triangles, counterclockwise as seen from outside. An inverted surface has a negative size.
    pub fn polyhedron(triangles: &(impl Iterator<Item = [DVec3; 3]> + Clone)) -> Self {
        // Tetrahedra from a point of the surface, then from the center of mass, so that large coordinates do not cancel.
        let six = |[a, b, c]: [DVec3; 3]| a.dot(b.cross(c));
        let origin = triangles.clone().next().map_or(DVec3::ZERO, |triangle| triangle[0]);
        let about = |origin: DVec3| triangles.clone().map(move |corners| corners.map(|corner| corner - origin));
        let size = about(origin).map(six).sum::<f64>() / 6.0;
        let way = about(origin).map(|[a, b, c]| (a + b + c) * six([a, b, c])).sum::<DVec3>() / (24.0 * size);
        let center = origin + way;
        let moments = about(center).map(|corners| {
            let [a, b, c] = corners;
            (square(a) + square(b) + square(c) + square(a + b + c)) * (six(corners) / 120.0)
        });
        Self { size, center, inertia: of_moments(moments.fold(DMat3::ZERO, |sum, one| sum + one)) }
    }

    /// Body of several parts, each turned and then moved. Where parts overlap, both count.
    pub fn union(parts: impl Iterator<Item = (Self, DMat3, DVec3)> + Clone) -> Self {
        let size = parts.clone().map(|(part, ..)| part.size).sum::<f64>();
        let at = |(part, turn, shift): (Self, DMat3, DVec3)| shift + turn * part.center;
        let center = parts.clone().map(|part| at(part) * part.0.size).sum::<DVec3>() / size;
        let inertia = parts.fold(DMat3::ZERO, |sum, one| {
            let (part, turn, _) = one;
            sum + turn * part.inertia * turn.transpose() + of_point(at(one) - center) * part.size
        });
        Self { size, center, inertia }
    }

    /// Whether size and inertia are positive and finite. Very large or small bodies have others.
    pub fn is_proper(&self, dimension: usize) -> bool {
        let diagonal = DVec3::new(self.inertia.x_axis.x, self.inertia.y_axis.y, self.inertia.z_axis.z);
        let smallest = if dimension == 2 { diagonal.z } else { diagonal.min_element() };
        self.size > 0.0 && self.size.is_finite() && smallest > 0.0 && self.inertia.is_finite() && self.center.is_finite()
    }
}

/// Matrix a aᵀ.
fn square(a: DVec3) -> DMat3 {
    DMat3::from_cols(a * a.x, a * a.y, a * a.z)
}
