//! Quadrature of the surface of a shape: points with normals and areas, for forces on its surface.

use std::f64::consts::{FRAC_PI_8, TAU};

use glam::{DMat3, DVec3};

use super::plane::Planar;
use super::{Part, ShapeForm, SolidShape};

/// Piece of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePatch {
    /// Point of the surface in the frame of the body [m].
    pub point: DVec3,
    /// Outward unit normal there.
    pub normal: DVec3,
    /// Area that the point stands for [m²]; in 2D the length [m].
    pub area: f64,
}

/// Distance from the surface at which a part covers a point, over the size of the shape.
const COVER: f64 = 1e-6;
/// Points of a circle about the axis of a ball or capsule.
const AROUND: usize = 16;
/// Nodes and weights of Gauss–Legendre quadrature on the interval from 0 to 1.
const PAIR: [(f64, f64); 2] = [(0.211_324_865_405_187_13, 0.5), (0.788_675_134_594_812_9, 0.5)];
const TRIPLE: [(f64, f64); 3] =
    [(0.112_701_665_379_258_31, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];

impl SolidShape {
    /// Patches of the surface, from pieces of at most `size` [m] along flat faces. They integrate functions of second degree
    /// over each piece exactly, and have the symmetries of each face. Parts of a compound that lie inside another part are left out, except inside a mesh.
    pub fn patches(&self, size: f64, planar: bool) -> Vec<SurfacePatch> {
        let ShapeForm::ConvexParts(parts) = &self.form else { return Vec::new() };
        let solid: Vec<(usize, &Part)> = parts.all.iter().enumerate().filter(|(_, part)| part.leaf_corners().is_none()).collect();
        let mut patches = Vec::new();
        for (index, part) in parts.all.iter().enumerate() {
            let mut own = Vec::new();
            if planar {
                part.outline(size, &mut own);
            } else {
                part.surface(size, &mut own);
            }
            let is_open = |patch: &SurfacePatch| {
                let outside = patch.point + COVER * self.reach * patch.normal;
                !solid.iter().any(|(other, part)| *other != index && part.covers(outside))
            };
            patches.extend(own.into_iter().filter(is_open));
        }
        patches
    }
}

impl Part {
    /// Whether the part contains a point.
    fn covers(&self, point: DVec3) -> bool {
        if point.distance(self.ball.0) > self.ball.1 {
            return false;
        }
        match self.vertices[..] {
            [center] => point.distance(center) <= self.radius,
            [one, other] => {
                let along = ((point - one).dot(other - one) / (other - one).length_squared()).clamp(0.0, 1.0);
                point.distance(one.lerp(other, along)) <= self.radius
            }
            _ => (0..self.normals.len()).all(|face| self.normals[face].dot(point - self.corner(face)) <= self.radius),
        }
    }

    /// Adds the patches of the outline of a part in the plane.
    fn outline(&self, size: f64, patches: &mut Vec<SurfacePatch>) {
        let count = self.vertices.len();
        if let [center] = self.vertices[..] {
            arc(center, self.radius, DVec3::X, TAU, patches);
            return;
        }
        for face in (0..count).filter(|&face| self.shows_face(face)) {
            let normal = self.normals[face];
            let [from, to] = [face, (face + 1) % count].map(|corner| self.vertices[corner]);
            let pieces = (from.distance(to) / size).ceil().max(1.0);
            for piece in 0..pieces as usize {
                for (node, weight) in PAIR {
                    let point = from.lerp(to, (piece as f64 + node) / pieces) + self.radius * normal;
                    patches.push(SurfacePatch { point, normal, area: weight * from.distance(to) / pieces });
                }
            }
            if self.radius > 0.0 {
                let next = self.normals[(face + 1) % count];
                let turn = libm::atan2(normal.across(next), normal.dot(next));
                arc(to, self.radius, normal, if turn < 0.0 { turn + TAU } else { turn }, patches);
            }
        }
    }

    /// Adds the patches of the surface of a part in space.
    fn surface(&self, size: f64, patches: &mut Vec<SurfacePatch>) {
        match self.vertices[..] {
            [center] => [DVec3::Z, DVec3::NEG_Z].iter().for_each(|axis| dome(center, self.radius, *axis, patches)),
            [from, to] => {
                let axis = (to - from).normalize();
                dome(from, self.radius, -axis, patches);
                dome(to, self.radius, axis, patches);
                let pieces = (from.distance(to) / size).ceil().max(1.0);
                for piece in 0..pieces as usize {
                    for (node, weight) in PAIR {
                        let (center, part) = (from.lerp(to, (piece as f64 + node) / pieces), TAU / AROUND as f64);
                        let area = weight * part * self.radius * from.distance(to) / pieces;
                        let of = |normal| SurfacePatch { point: center + self.radius * normal, normal, area };
                        patches.extend(circle(axis).map(of));
                    }
                }
            }
            _ => {
                for face in (0..self.normals.len()).filter(|&face| self.shows_face(face)) {
                    let corners: Vec<DVec3> = self.net.face(face).iter().map(|&corner| self.vertices[corner as usize]).collect();
                    // A fan around the middle has the symmetries of the face.
                    let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
                    let fan = |from: usize| [middle, corners[from], corners[(from + 1) % corners.len()]];
                    match corners[..] {
                        [a, b, c] => divide([a, b, c], self.normals[face], size, patches),
                        _ => (0..corners.len()).for_each(|from| divide(fan(from), self.normals[face], size, patches)),
                    }
                }
            }
        }
    }
}

/// Adds the patches of an arc of a circle, from the direction `start` through an angle [rad].
fn arc(center: DVec3, radius: f64, start: DVec3, angle: f64, patches: &mut Vec<SurfacePatch>) {
    let pieces = (2.0 * angle / FRAC_PI_8 - 1e-9).ceil().max(1.0);
    for piece in 0..pieces as usize {
        let (sin, cos) = libm::sincos(angle * (piece as f64 + 0.5) / pieces);
        let normal = cos * start + sin * DVec3::new(-start.y, start.x, 0.0);
        patches.push(SurfacePatch { point: center + radius * normal, normal, area: radius * angle / pieces });
    }
}

/// Adds the patches of half a sphere on the side of a unit axis. Its area over heights is uniform.
fn dome(center: DVec3, radius: f64, axis: DVec3, patches: &mut Vec<SurfacePatch>) {
    for (height, weight) in TRIPLE {
        let across = (1.0 - height * height).sqrt();
        let area = weight * TAU * radius * radius / AROUND as f64;
        let normals = circle(axis).map(|outward| height * axis + across * outward);
        patches.extend(normals.map(|normal| SurfacePatch { point: center + radius * normal, normal, area }));
    }
}

/// Unit vectors around an axis, at equal angles.
fn circle(axis: DVec3) -> impl Iterator<Item = DVec3> {
    let (first, second) = axis.any_orthonormal_pair();
    let frame = DMat3::from_cols(first, second, axis);
    (0..AROUND).map(move |index| {
        let (sin, cos) = libm::sincos(TAU * index as f64 / AROUND as f64);
        frame * DVec3::new(cos, sin, 0.0)
    })
}

/// Adds the patches of a triangle, cut into n² triangles whose sides are at most `size`.
fn divide([a, b, c]: [DVec3; 3], normal: DVec3, size: f64, patches: &mut Vec<SurfacePatch>) {
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    let count = (longest / size).ceil().max(1.0) as usize;
    let [along, aside] = [(b - a) / count as f64, (c - a) / count as f64];
    let area = along.cross(aside).length() / 6.0;
    let mut add = |corners: [DVec3; 3]| {
        let middle = corners.iter().sum::<DVec3>() / 3.0;
        patches.extend(corners.map(|corner| SurfacePatch { point: middle.lerp(corner, 0.5), normal, area }));
    };
    for row in 0..count {
        for place in 0..count - row {
            let corner = a + place as f64 * along + row as f64 * aside;
            add([corner, corner + along, corner + aside]);
            if place + row + 1 < count {
                add([corner + along, corner + along + aside, corner + aside]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use physcore_base::scene::{Item, Value};

    use super::*;
    use crate::tests::laboratory::{cuboid, rectangle, round};

    fn patches(item: &Item, dimension: usize) -> (Vec<SurfacePatch>, f64) {
        let (shape, mass) = SolidShape::declared(item, dimension).unwrap();
        (shape.patches(0.5 * shape.reach(), dimension == 2), mass.size)
    }

    fn capsule() -> Item {
        Item::new("Capsule", [("length", Value::Number(0.8)), ("radius", Value::Number(0.3))])
    }

    /// The sum of the areas is the surface, the sum of the normals vanishes, and ∫ x·n dA is the dimension times the size. Points
    /// at the middle of arcs of an angle δ err by δ²/24, which is 1.6e-3 of their part here.
    #[test]
    fn surfaces_are_closed() {
        let pi = std::f64::consts::PI;
        let cases = [
            (round("Disc", 0.7), 2, TAU * 0.7),
            (rectangle(0.4, 1.3), 2, 3.4),
            (capsule(), 2, 1.6 + TAU * 0.3),
            (round("Ball", 0.7), 3, 2.0 * TAU * 0.49),
            (cuboid(0.4, 0.7, 1.3), 3, 2.0 * (0.28 + 0.52 + 0.91)),
            (capsule(), 3, 2.0 * pi * 0.3 * 0.8 + 4.0 * pi * 0.09),
        ];
        for (item, dimension, expected) in cases {
            let (patches, size) = patches(&item, dimension);
            let area: f64 = patches.iter().map(|patch| patch.area).sum();
            let closed: DVec3 = patches.iter().map(|patch| patch.area * patch.normal).sum();
            let flux: f64 = patches.iter().map(|patch| patch.area * patch.normal.dot(patch.point)).sum();
            assert!((area / expected - 1.0).abs() < 1e-14, "{}: {area} {expected}", item.kind);
            assert!(closed.length() < 1e-14 * area, "{}: {closed}", item.kind);
            let error = (flux / (dimension as f64 * size) - 1.0).abs();
            assert!(
                error < if (item.kind.as_str(), dimension) == ("Capsule", 2) { 1e-3 } else { 1e-14 },
                "{}: {error}",
                item.kind
            );
        }
    }

    /// The drag of a ball by the pressure |q| q is π r² in each direction, and that of a disc 8 r/3.
    #[test]
    fn pressure_on_round_shapes() {
        let drag = |patches: &[SurfacePatch], along: DVec3| -> f64 {
            patches.iter().map(|patch| patch.area * patch.normal.dot(along).abs().powi(3)).sum()
        };
        for along in [DVec3::Z, DVec3::X, DVec3::new(0.6, 0.0, 0.8), DVec3::new(0.36, 0.48, 0.8)] {
            let value = drag(&patches(&round("Ball", 0.5), 3).0, along) / (0.25 * std::f64::consts::PI);
            assert!((value - 1.0).abs() < 5e-3, "{along}: {value}");
        }
        let value = drag(&patches(&round("Disc", 0.5), 2).0, DVec3::new(0.6, 0.8, 0.0)) / (8.0 * 0.5 / 3.0);
        assert!((value - 1.0).abs() < 1e-4, "{value}");
    }
}
