//! Samples of the volume of a shape near its surface, on a grid in the frame of the body.
//!
//! A cell that the surface cuts has the volume and the center of its part within the shape, by counting points. All volumes are
//! scaled, so that their sum is that of the shape: what they displace in a fluid has its volume and center.

use std::ops::Range;

use glam::{DQuat, DVec3};

use super::{BoundingBox, Part, ShapeForm, SolidShape};
use crate::pose::Pose;

/// Points per axis in a cell, in 2D and in 3D.
const POINTS: [usize; 2] = [16, 6];
/// Largest number of points.
const MOST: usize = 400_000_000;

/// Part of the volume of a shape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VolumeSample {
    /// Center [m].
    pub point: DVec3,
    /// Volume [m^D].
    pub volume: f64,
}

/// Samples of a shape.
#[derive(Debug, Clone, PartialEq)]
pub struct ShapeSamples {
    /// Samples near the surface.
    pub samples: Vec<VolumeSample>,
    /// Area of the faces between cells of the shape and others [m^(D−1)].
    pub surface: f64,
}

/// Grid over the bounding box of a shape.
struct SampleGrid {
    lower: DVec3,
    /// Edges of a cell [m].
    cell: DVec3,
    /// Number of cells along each axis.
    count: [usize; 3],
    /// Points along each axis of a cell.
    points: [usize; 3],
}

impl SampleGrid {
    /// Grid with cells of about this edge [m]; None if it has too many points.
    fn new(shape: &SolidShape, spacing: f64, dimension: usize) -> Option<Self> {
        let bounds = shape.bounds(&Pose::WORLD);
        let extent = bounds.upper - bounds.lower;
        let number = |axis: usize| if axis < dimension { (extent[axis] / spacing).round().max(1.0) } else { 1.0 };
        let points = [0, 1, 2].map(|axis| if axis < dimension { POINTS[dimension - 2] } else { 1 });
        let all: f64 = (0..3).map(|axis| number(axis) * points[axis] as f64).product();
        let cell = DVec3::from_array([0, 1, 2].map(|axis| extent[axis] / number(axis)));
        (all <= MOST as f64).then(|| Self {
            lower: bounds.lower,
            cell,
            count: [0, 1, 2].map(|axis| number(axis) as usize),
            points,
        })
    }

    /// Coordinate along an axis of a point of the grid.
    fn at(&self, axis: usize, point: usize) -> f64 {
        if self.points[axis] == 1 {
            return 0.0;
        }
        self.lower[axis] + (point as f64 + 0.5) / self.points[axis] as f64 * self.cell[axis]
    }

    /// Number of points in the shape and the sum of their positions, for each cell; x varies fastest.
    fn fill(&self, shape: &SolidShape) -> Vec<(f64, DVec3)> {
        let [nx, ny, nz] = self.count;
        let [px, py, pz] = self.points;
        let mut cells = vec![(0.0, DVec3::ZERO); nx * ny * nz];
        let along: Vec<f64> = (0..nx * px).map(|point| self.at(0, point)).collect();
        let mut inside = vec![false; along.len()];
        for z in 0..nz * pz {
            for y in 0..ny * py {
                let row = DVec3::new(0.0, self.at(1, y), self.at(2, z));
                shape.contains_row(row, &along, &mut inside);
                let first = (z / pz * ny + y / py) * nx;
                for (x, _) in inside.iter().enumerate().filter(|(_, inside)| **inside) {
                    let (count, sum) = &mut cells[first + x / px];
                    *count += 1.0;
                    *sum += DVec3::new(along[x], row.y, row.z);
                }
            }
        }
        cells
    }

    /// Area of the faces between filled and empty cells [m^(D−1)].
    fn surface(&self, cells: &[(f64, DVec3)]) -> f64 {
        let [nx, ny, _] = self.count;
        let stride = [1, nx, nx * ny];
        let is_filled = |index: usize| cells[index].0 > 0.0;
        let faces = |index: usize, axis: usize| {
            let place = index / stride[axis] % self.count[axis];
            let after = place + 1 < self.count[axis] && is_filled(index + stride[axis]);
            let before = place > 0 && is_filled(index - stride[axis]);
            f64::from(2 - u8::from(after) - u8::from(before))
        };
        let axes: Vec<usize> = (0..3).filter(|&axis| self.points[axis] > 1).collect();
        let area = |axis: usize| axes.iter().filter(|&&other| other != axis).map(|&other| self.cell[other]).product::<f64>();
        let total = |axis: usize| (0..cells.len()).filter(|&index| is_filled(index)).map(|index| faces(index, axis)).sum::<f64>();
        axes.iter().map(|&axis| area(axis) * total(axis)).sum()
    }

    /// Whether a cell has an empty one, or the edge of the grid, within `depth` [m].
    fn is_near_surface(&self, cells: &[(f64, DVec3)], index: usize, depth: f64) -> bool {
        let [nx, ny, _] = self.count;
        let place = [index % nx, index / nx % ny, index / (nx * ny)];
        let reach = [0, 1, 2].map(|axis| if self.points[axis] == 1 { 0 } else { (depth / self.cell[axis]).ceil() as usize });
        let range = |axis: usize| place[axis].saturating_sub(reach[axis])..=(place[axis] + reach[axis]).min(self.count[axis] - 1);
        let is_at_edge =
            |axis: usize| reach[axis] > 0 && (place[axis] < reach[axis] || place[axis] + reach[axis] >= self.count[axis]);
        let mut others = range(2).flat_map(|z| range(1).flat_map(move |y| range(0).map(move |x| (z * ny + y) * nx + x)));
        (0..3).any(is_at_edge) || others.any(|other| cells[other].0 == 0.0)
    }
}

impl SolidShape {
    /// Samples of the shape of this size [m^D] in cells of an edge of about `spacing` [m], down to a `depth` [m] below the
    /// surface. None for a shape without volume, or with too many samples.
    pub fn samples(&self, size: f64, spacing: f64, depth: f64, dimension: usize) -> Option<ShapeSamples> {
        let grid = SampleGrid::new(self, spacing, dimension)?;
        let cells = grid.fill(self);
        let volume = size / cells.iter().map(|(count, _)| count).sum::<f64>();
        let sample = |(index, (count, sum)): (usize, &(f64, DVec3))| {
            let is_sample = *count > 0.0 && grid.is_near_surface(&cells, index, depth);
            is_sample.then(|| VolumeSample { point: *sum / *count, volume: volume * count })
        };
        volume.is_finite().then(|| ShapeSamples {
            samples: cells.iter().enumerate().filter_map(sample).collect(),
            surface: grid.surface(&cells),
        })
    }

    /// Whether a point in the frame of the body is in the shape.
    pub fn contains(&self, point: DVec3) -> bool {
        let mut inside = [false];
        self.contains_row(DVec3::new(0.0, point.y, point.z), &[point.x], &mut inside);
        inside[0]
    }

    /// Whether a point in the world is in the shape at one of these positions, with these rotations.
    pub fn contains_at(&self, mut poses: impl Iterator<Item = (DVec3, DQuat)>, point: DVec3) -> bool {
        poses.any(|(center, rotation)| {
            let away = point - center;
            away.length_squared() <= self.reach * self.reach && self.contains(rotation.inverse() * away)
        })
    }

    /// Finds whether the points (x, y, z) of a row along x, with y and z of `row`, are in the shape.
    fn contains_row(&self, row: DVec3, along: &[f64], inside: &mut [bool]) {
        inside.fill(false);
        let ShapeForm::ConvexParts(parts) = &self.form else { return };
        let mut crossings: Vec<f64> = Vec::new();
        let line =
            BoundingBox { lower: DVec3::new(f64::NEG_INFINITY, row.y, row.z), upper: DVec3::new(f64::INFINITY, row.y, row.z) };
        parts.near(&line, &mut |part| match part.leaf_corners() {
            Some(corners) => crossings.extend(crossing(corners, row)),
            None => inside[part.chord(row, along)].fill(true),
        });
        crossings.sort_by(f64::total_cmp);
        for ends in crossings.as_chunks::<2>().0 {
            let within = along.iter().zip(&mut *inside).filter(|(x, _)| (ends[0]..ends[1]).contains(x));
            within.for_each(|(_, inside)| *inside = true);
        }
    }
}

impl Part {
    /// Points (x, y, z) of a row along x that are in the part. There is at most one run of them.
    fn chord(&self, row: DVec3, along: &[f64]) -> Range<usize> {
        let is_inside = |index: usize| self.contains(DVec3::new(along[index], row.y, row.z));
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        let mut clip = |end: f64, slope: f64| if slope > 0.0 { high = high.min(end) } else { low = low.max(end) };
        let (center, radius) = self.ball;
        let half = (radius * radius - (row.y - center.y).powi(2) - (row.z - center.z).powi(2)).max(0.0).sqrt();
        clip(center.x + half, 1.0);
        clip(center.x - half, -1.0);
        // One point is tested faster by itself: the first face that it is beyond is enough.
        if along.len() > 1 {
            for (face, normal) in self.normals.iter().enumerate().filter(|(_, normal)| normal.x != 0.0) {
                clip((self.radius - normal.dot(row - self.corner(face))) / normal.x, normal.x);
            }
        }
        // Rounding has moved the ends by a point or less.
        let mut first = along.partition_point(|&x| x < low);
        let mut last = along.partition_point(|&x| x <= high).max(first);
        while first > 0 && is_inside(first - 1) {
            first -= 1;
        }
        while last < along.len() && is_inside(last) {
            last += 1;
        }
        while first < last && !is_inside(first) {
            first += 1;
        }
        while first < last && !is_inside(last - 1) {
            last -= 1;
        }
        first..last
    }

    /// Whether a point in the frame of the body is in the part. A core with a radius has two vertices at most.
    pub fn contains(&self, point: DVec3) -> bool {
        if point.distance_squared(self.ball.0) > self.ball.1 * self.ball.1 {
            return false;
        }
        if let [from, rest @ ..] = &self.vertices[..]
            && rest.len() <= 1
        {
            let way = rest.first().map_or(DVec3::ZERO, |to| to - from);
            let along = if way == DVec3::ZERO { 0.0 } else { (way.dot(point - from) / way.length_squared()).clamp(0.0, 1.0) };
            return point.distance_squared(from + along * way) <= self.radius * self.radius;
        }
        self.normals.iter().enumerate().all(|(face, normal)| normal.dot(point - self.corner(face)) <= self.radius)
    }
}

/// Coordinate x at which a line along x meets a triangle. Lines through an edge of two triangles meet one of them.
fn crossing(corners: [DVec3; 3], row: DVec3) -> Option<f64> {
    let sides = [0, 1, 2].map(|side| {
        let [from, to] = [corners[side], corners[(side + 1) % 3]];
        // Both triangles at an edge find the same number.
        let [low, high] = if (from.z, from.y, from.x) < (to.z, to.y, to.x) { [from, to] } else { [to, from] };
        let passes = (low.z <= row.z) != (high.z <= row.z);
        passes && low.y + (row.z - low.z) / (high.z - low.z) * (high.y - low.y) > row.y
    });
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    let meets = normal.x != 0.0 && sides.iter().filter(|side| **side).count() % 2 == 1;
    meets.then(|| corners[0].x - (normal.y * (row.y - corners[0].y) + normal.z * (row.z - corners[0].z)) / normal.x)
}

#[cfg(test)]
mod tests {
    use physcore_base::scene::{Array, Item, Value};

    use super::*;

    fn declared(kind: &str, values: &[(&'static str, f64)], dimension: usize) -> (SolidShape, f64) {
        let values = values.iter().map(|(name, number)| (*name, Value::Number(*number)));
        let (shape, mass) = SolidShape::declared(&Item::new(kind, values.collect::<Vec<_>>()), dimension).unwrap();
        (shape, mass.size)
    }

    /// Second moment Σ V x² of samples.
    fn second(samples: &[VolumeSample]) -> f64 {
        samples.iter().map(|sample| sample.volume * sample.point.x * sample.point.x).sum()
    }

    #[test]
    fn samples_of_a_rectangle_are_whole_cells() {
        let (shape, size) = declared("Rectangle", &[("width", 0.4), ("height", 0.2)], 2);
        let ShapeSamples { samples, surface } = shape.samples(size, 0.021, 1.0, 2).unwrap();
        assert!((surface - 1.2).abs() < 1e-12);
        assert_eq!(samples.len(), 19 * 10);
        assert!(samples.iter().all(|sample| (sample.volume - size / 190.0).abs() < 1e-15));
        // Σ V x² of n cells of width a is V L²/12 (1 − 1/n²).
        let expected = size * 0.16 / 12.0 * (1.0 - 1.0 / 361.0);
        assert!((second(&samples) - expected).abs() < 1e-12);
    }

    #[test]
    fn samples_of_round_shapes_have_their_volume_and_second_moment() {
        let cases = [("Disc", 2, 0.25), ("Ball", 3, 0.2)];
        for (kind, dimension, factor) in cases {
            let (shape, size) = declared(kind, &[("radius", 1.0)], dimension);
            let samples = shape.samples(size, 0.2, 10.0, dimension).unwrap().samples;
            let total: f64 = samples.iter().map(|sample| sample.volume).sum();
            assert!((total - size).abs() < 1e-12 * size);
            // Cells of edge a lack a²/12 of the second moment, and counting points is exact to a percent.
            let expected = factor * size - size * 0.04 / 12.0;
            assert!((second(&samples) / expected - 1.0).abs() < 0.01, "{kind}: {} {expected}", second(&samples));
        }
    }

    #[test]
    fn samples_leave_out_what_is_deep_in_a_body() {
        let (shape, size) = declared("Cuboid", &[("a", 1.0), ("b", 1.0), ("c", 1.0)], 3);
        let samples = shape.samples(size, 0.1, 0.2, 3).unwrap().samples;
        // Two layers of cells.
        assert_eq!(samples.len(), 10 * 10 * 10 - 6 * 6 * 6);
    }

    #[test]
    fn rows_of_a_convex_part_are_those_of_its_points() {
        let along: Vec<f64> = (0..40).map(|index| -1.1 + 0.055 * f64::from(index)).collect();
        let shapes = [
            declared("Ball", &[("radius", 0.7)], 3),
            declared("Cuboid", &[("a", 1.1), ("b", 0.9), ("c", 0.55)], 3),
            declared("Capsule", &[("length", 0.8), ("radius", 0.3)], 3),
            declared("Capsule", &[("length", 0.8), ("radius", 0.3)], 2),
        ];
        let mut found = 0;
        for ((shape, _), step) in shapes.iter().flat_map(|shape| (0..400).map(move |step| (shape, step))) {
            let ShapeForm::ConvexParts(parts) = &shape.form else { unreachable!() };
            let flat = if parts.all[0].normals.len() == 2 { 0.0 } else { 1.0 };
            let row = DVec3::new(0.0, -1.0 + 0.1 * f64::from(step % 20), flat * (-1.0 + 0.1 * f64::from(step / 20)));
            let chord = parts.all[0].chord(row, &along);
            for (index, &x) in along.iter().enumerate() {
                assert_eq!(chord.contains(&index), parts.all[0].contains(DVec3::new(x, row.y, row.z)), "{row} {x}");
            }
            found += chord.len();
        }
        assert!(found > 1000);
    }

    #[test]
    fn a_mesh_and_its_convex_parts_have_the_same_samples() {
        // An L of two cuboids, as triangles.
        let outline = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        let vertices: Vec<f64> = [0.0, 1.0].iter().flat_map(|z| outline.iter().flat_map(move |[x, y]| [*x, *y, *z])).collect();
        let caps = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]];
        let bottom = caps.iter().flat_map(|&[a, b, c]| [a, c, b]);
        let top = caps.iter().flat_map(|corners| corners.map(|corner| corner + 6));
        let sides = (0..6_u32).flat_map(|from| {
            let to = (from + 1) % 6;
            [from, to, to + 6, from, to + 6, from + 6]
        });
        let faces: Vec<u32> = bottom.chain(top).chain(sides).collect();
        let shape_of = |count: usize| vec![count / 3, 3];
        let item = Item::new(
            "MeshShape",
            [
                ("faces", Value::Indices(Array { shape: shape_of(faces.len()), entries: faces })),
                ("vertices", Value::Numbers(Array { shape: shape_of(vertices.len()), entries: vertices })),
            ],
        );
        let (shape, mass) = SolidShape::declared(&item, 3).unwrap();
        let samples = shape.samples(mass.size, 0.25, 10.0, 3).unwrap().samples;
        assert!((mass.size - 3.0).abs() < 1e-12);
        assert_eq!(samples.len(), 3 * 4 * 4 * 4);
        assert!(samples.iter().all(|sample| (sample.volume - 0.25_f64.powi(3)).abs() < 1e-12));
    }
}
