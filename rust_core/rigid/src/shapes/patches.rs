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
/// Number of finer patches along each direction of a patch, by which its open area is found.
const FINE: usize = 8;
/// Points of a circle about the axis of a ball or capsule.
const AROUND: usize = 16;
/// Nodes and weights of Gauss–Legendre quadrature on the interval from 0 to 1.
const PAIR: [(f64, f64); 2] = [(0.211_324_865_405_187_13, 0.5), (0.788_675_134_594_812_9, 0.5)];
const TRIPLE: [(f64, f64); 3] =
    [(0.112_701_665_379_258_31, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];

impl SolidShape {
    /// Patches of the surface, from pieces of at most `size` [m] along flat faces. They integrate functions of second degree
    /// over each piece exactly, and have the symmetries of each face. Where parts of a compound overlap, the area of a patch is that
    /// outside of other parts, except inside a mesh; of faces that coincide, the first counts.
    pub fn patches(&self, size: f64, planar: bool) -> Vec<SurfacePatch> {
        let ShapeForm::ConvexParts(parts) = &self.form else { return Vec::new() };
        let solid: Vec<(usize, &Part)> = parts.all.iter().enumerate().filter(|(_, part)| part.leaf_corners().is_none()).collect();
        let mut patches = Vec::new();
        for (index, part) in parts.all.iter().enumerate() {
            let mut own = part.pieces((size, 1), planar);
            let meets = |other: &Part| part.ball.0.distance(other.ball.0) <= part.ball.1 + other.ball.1;
            let others: Vec<(usize, &Part)> =
                solid.iter().filter(|(other, part)| *other != index && meets(part)).copied().collect();
            if !others.is_empty() {
                let is_open = |patch: &SurfacePatch| {
                    let [outside, inside] = [COVER, -COVER].map(|way| patch.point + way * self.reach * patch.normal);
                    let covers =
                        |(other, part): &(usize, &Part)| part.contains(outside) || *other < index && part.contains(inside);
                    !others.iter().any(covers)
                };
                keep_open(&mut own, &part.pieces((size, FINE), planar), self.reach, is_open);
            }
            patches.extend(own);
        }
        patches
    }
}

/// Reduces the areas of patches to their open parts, as found by finer ones of the same surface; removes those that are covered.
fn keep_open(patches: &mut Vec<SurfacePatch>, fine: &[SurfacePatch], reach: f64, is_open: impl Fn(&SurfacePatch) -> bool) {
    let mut areas = vec![[0.0; 2]; patches.len()];
    for each in fine {
        let away = |patch: &SurfacePatch| {
            patch.point.distance_squared(each.point) + reach * reach * patch.normal.distance_squared(each.normal)
        };
        let nearest = (0..patches.len()).min_by(|&one, &other| away(&patches[one]).total_cmp(&away(&patches[other])));
        if let Some(nearest) = nearest {
            areas[nearest][0] += each.area;
            areas[nearest][1] += if is_open(each) { each.area } else { 0.0 };
        }
    }
    patches.iter_mut().zip(areas).for_each(|(patch, [all, open])| patch.area *= if all > 0.0 { open / all } else { 0.0 });
    patches.retain(|patch| patch.area > 0.0);
}

impl Part {
    /// Patches of the surface of the part, along each direction `fineness` times as many as from pieces of at most `size` [m].
    fn pieces(&self, (size, fineness): (f64, usize), planar: bool) -> Vec<SurfacePatch> {
        let (size, mut patches) = (size / fineness as f64, Vec::new());
        if planar {
            self.outline((size, fineness), &mut patches);
        } else {
            self.surface((size, fineness), &mut patches);
        }
        patches
    }

    /// Adds the patches of the outline of a part in the plane.
    fn outline(&self, (size, fineness): (f64, usize), patches: &mut Vec<SurfacePatch>) {
        let count = self.vertices.len();
        if let [center] = self.vertices[..] {
            arc(center, (self.radius, DVec3::X), TAU, fineness, patches);
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
                arc(to, (self.radius, normal), if turn < 0.0 { turn + TAU } else { turn }, fineness, patches);
            }
        }
    }

    /// Adds the patches of the surface of a part in space.
    fn surface(&self, (size, fineness): (f64, usize), patches: &mut Vec<SurfacePatch>) {
        match self.vertices[..] {
            [center] => {
                [DVec3::Z, DVec3::NEG_Z].iter().for_each(|axis| dome(center, (self.radius, *axis), fineness, patches));
            }
            [from, to] => {
                let axis = (to - from).normalize();
                dome(from, (self.radius, -axis), fineness, patches);
                dome(to, (self.radius, axis), fineness, patches);
                let pieces = (from.distance(to) / size).ceil().max(1.0);
                for piece in 0..pieces as usize {
                    for (node, weight) in PAIR {
                        let center = from.lerp(to, (piece as f64 + node) / pieces);
                        let part = TAU / (AROUND * fineness) as f64;
                        let area = weight * part * self.radius * from.distance(to) / pieces;
                        let of = |normal| SurfacePatch { point: center + self.radius * normal, normal, area };
                        patches.extend(circle(axis, AROUND * fineness).map(of));
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

/// Adds the patches of an arc of a circle of a radius [m], from the direction `start` through an angle [rad].
fn arc(center: DVec3, (radius, start): (f64, DVec3), angle: f64, fineness: usize, patches: &mut Vec<SurfacePatch>) {
    let pieces = (2.0 * angle / FRAC_PI_8 - 1e-9).ceil().max(1.0) * fineness as f64;
    for piece in 0..pieces as usize {
        let (sin, cos) = libm::sincos(angle * (piece as f64 + 0.5) / pieces);
        let normal = cos * start + sin * DVec3::new(-start.y, start.x, 0.0);
        patches.push(SurfacePatch { point: center + radius * normal, normal, area: radius * angle / pieces });
    }
}

/// Adds the patches of half a sphere of a radius [m] on the side of a unit axis. Its area over heights is uniform.
fn dome(center: DVec3, (radius, axis): (f64, DVec3), fineness: usize, patches: &mut Vec<SurfacePatch>) {
    let around = AROUND * fineness;
    for (layer, (node, weight)) in (0..fineness).flat_map(|layer| TRIPLE.map(|point| (layer, point))) {
        let height = (layer as f64 + node) / fineness as f64;
        let across = (1.0 - height * height).sqrt();
        let area = weight * TAU * radius * radius / (around * fineness) as f64;
        let normals = circle(axis, around).map(|outward| height * axis + across * outward);
        patches.extend(normals.map(|normal| SurfacePatch { point: center + radius * normal, normal, area }));
    }
}

/// Unit vectors around an axis, at `count` equal angles.
fn circle(axis: DVec3, count: usize) -> impl Iterator<Item = DVec3> {
    let (first, second) = axis.any_orthonormal_pair();
    let frame = DMat3::from_cols(first, second, axis);
    (0..count).map(move |index| {
        let (sin, cos) = libm::sincos(TAU * index as f64 / count as f64);
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
    use crate::pose::Pose;
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

    /// Parts that overlap count once, also where their faces coincide. A cut is found within half of a fine piece, of `size`
    /// over 16 or a fine part of a turn. The sum of the normals vanishes as well.
    #[test]
    fn overlapping_parts_have_the_surface_of_their_union() {
        let moved = |part: Part, x: f64, y: f64| part.moved(&Pose { position: DVec3::new(x, y, 0.0), ..Pose::WORLD });
        let box_at =
            |half: DVec3, x: f64, y: f64| moved(if half.z > 0.0 { Part::cuboid(half) } else { Part::rectangle(half) }, x, y);
        let (flat, solid) = (DVec3::new(0.5, 0.5, 0.0), DVec3::splat(0.5));
        // Two circles whose centers are 2 r cos φ apart lose 2 φ of their turns each, and two spheres caps of the height r (1 − cos φ).
        let (radius, phi) = (0.5, 1.0_f64);
        let rounds = |apart: f64| [0.0, apart].map(|x| Part::round(DVec3::new(x, 0.0, 0.0), radius)).to_vec();
        let apart = 2.0 * radius * libm::cos(phi);
        let spheres = 2.0 * (2.0 * TAU * radius * radius - TAU * radius * radius * (1.0 - libm::cos(phi)));
        let cases = [
            ("in line", vec![box_at(flat, 0.0, 0.0), box_at(flat, 0.63, 0.0)], 2, 2.0 * (1.63 + 1.0), 4.0),
            ("aslant", vec![box_at(flat, 0.0, 0.0), box_at(flat, 0.63, 0.41)], 2, 2.0 * (1.63 + 1.41), 4.0),
            ("twice", vec![box_at(flat, 0.0, 0.0), box_at(flat, 0.0, 0.0)], 2, 4.0, 0.0),
            ("discs", rounds(apart), 2, 2.0 * (TAU - 2.0 * phi) * radius, 4.0),
            ("cuboids", vec![box_at(solid, 0.0, 0.0), box_at(solid, 0.63, 0.0)], 3, 4.0 * 1.63 + 2.0, 16.0),
            ("balls", rounds(apart), 3, spheres, 2.0 * TAU * radius * libm::sin(phi)),
        ];
        for (name, parts, dimension, expected, cuts) in cases {
            let (shape, size) = (SolidShape::of(parts), 0.5);
            let patches = shape.patches(size, dimension == 2);
            let area: f64 = patches.iter().map(|patch| patch.area).sum();
            let fine = size / (2.0 * FINE as f64);
            assert!((area - expected).abs() <= 1e-12 + cuts * fine, "{name}: {area} {expected}");
            let closed: DVec3 = patches.iter().map(|patch| patch.area * patch.normal).sum();
            assert!(closed.length() <= 1e-12 + cuts * fine, "{name}: {closed}");
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
