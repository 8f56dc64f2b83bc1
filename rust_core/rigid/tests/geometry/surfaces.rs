//! Surfaces that are not convex: contacts only where a point of the surface is nearest to the other body.

use std::f64::consts::TAU;

use glam::DVec3;
use physcore_base::scene::{Array, Item, Value};
use physcore_rigid::collision::{contacts, separation, separations};
use physcore_rigid::contact::Touch;
use physcore_rigid::pose::Pose;
use physcore_rigid::shapes::{SolidShape, walls};
use proptest::prelude::*;

use crate::samples::{convex, item, point, pointed, pose, rows, shape, turned};

/// Shape with its surface: segments in 2D, triangles in 3D, whose corners are in the frame of the shape.
#[derive(Debug, Clone)]
struct FacetedBody {
    shape: SolidShape,
    facets: Vec<Vec<DVec3>>,
}

/// Rounding errors of lengths of a few meters.
const ROUNDING: f64 = 1e-11;

/// Corners of a polygon around the origin, at distances from it.
fn star(distances: &[f64]) -> Vec<DVec3> {
    let count = distances.len() as f64;
    let at = |(index, distance): (usize, &f64)| {
        let angle = TAU * index as f64 / count;
        DVec3::new(angle.cos(), angle.sin(), 0.0) * *distance
    };
    distances.iter().enumerate().map(at).collect()
}

/// Polygons that are rarely convex.
fn polygon() -> impl Strategy<Value = FacetedBody> {
    prop::collection::vec(0.2..1.0_f64, 5..12).prop_map(|distances| {
        let corners = star(&distances);
        let (shape, mass) = SolidShape::declared(&pointed("Polygon", "vertices", &corners, 2), 2).unwrap();
        let at = |index: usize| corners[index % corners.len()] - mass.center;
        FacetedBody { shape, facets: (0..corners.len()).map(|index| vec![at(index), at(index + 1)]).collect() }
    })
}

/// Octahedra, cut finer once, whose corners are at random distances from the origin.
fn mesh() -> impl Strategy<Value = FacetedBody> {
    prop::collection::vec(0.3..1.0_f64, 18).prop_map(|distances| {
        let mut corners: Vec<DVec3> = DVec3::AXES.iter().flat_map(|axis| [*axis, -*axis]).collect();
        let signs = (0..8).map(|bits: usize| [0, 1, 2].map(|axis| 2 * axis + (bits >> axis & 1)));
        let mut faces: Vec<[usize; 3]> = Vec::new();
        for [a, b, c] in signs {
            let mut middle = |from: usize, to: usize| {
                let at = (corners[from] + corners[to]).normalize();
                corners.iter().position(|corner| corner.distance(at) < 1e-9).unwrap_or_else(|| {
                    corners.push(at);
                    corners.len() - 1
                })
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            faces.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        for face in &mut faces {
            let [a, b, c] = face.map(|corner| corners[corner]);
            if a.dot(b.cross(c)) < 0.0 {
                face.swap(1, 2);
            }
        }
        corners.iter_mut().zip(&distances).for_each(|(corner, distance)| *corner *= *distance);
        let mut item = pointed("MeshShape", "vertices", &corners, 3);
        let entries = faces.iter().flatten().map(|corner| *corner as u32).collect();
        item.values.insert("faces".to_owned(), Value::Indices(Array { shape: vec![faces.len(), 3], entries }));
        let (shape, mass) = SolidShape::declared(&item, 3).unwrap();
        let facet = |face: &[usize; 3]| face.iter().map(|corner| corners[*corner] - mass.center).collect();
        FacetedBody { shape, facets: faces.iter().map(facet).collect() }
    })
}

fn boundary(kind: &str, values: Vec<(&'static str, Value)>) -> Item {
    let mut item = item(kind, &[("friction", 0.5), ("restitution", 0.1)]);
    "boundaries[0]".clone_into(&mut item.path);
    item.values.extend(values.into_iter().map(|(name, value)| (name.to_owned(), value)));
    item
}

/// Ground below heights, at node spacings of 0.5 m, with its middle at the origin.
pub fn ground(heights: &[f64], shape: &[usize]) -> (SolidShape, Pose) {
    let origin = |count: usize| -0.25 * (count - 1) as f64;
    let corner = DVec3::new(origin(shape[0]), shape.get(1).map_or(0.0, |count| origin(*count)), 0.0);
    let heights = Value::Numbers(Array { shape: shape.to_vec(), entries: heights.to_vec() });
    let values = vec![("heights", heights), ("spacing", Value::Number(0.5)), ("origin", Value::Vector(corner))];
    let wall = walls(&boundary("HeightField", values), 0, shape.len() + 1).unwrap().remove(0);
    (wall.shape, wall.pose)
}

/// Point of a segment or triangle that is nearest to another.
fn nearest(facet: &[DVec3], point: DVec3) -> DVec3 {
    let on_segment = |from: DVec3, to: DVec3| {
        let way = to - from;
        from + way * (way.dot(point - from) / way.length_squared()).clamp(0.0, 1.0)
    };
    let sides = (0..facet.len()).map(|index| on_segment(facet[index], facet[(index + 1) % facet.len()]));
    let mut best = sides.reduce(|a, b| if b.distance(point) < a.distance(point) { b } else { a }).unwrap();
    if let [a, b, c] = *facet {
        let normal = (b - a).cross(c - a).normalize();
        let foot = point - normal * normal.dot(point - a);
        let is_in = [[a, b], [b, c], [c, a]].into_iter().all(|[from, to]| (to - from).cross(foot - from).dot(normal) >= 0.0);
        if is_in && foot.distance(point) < best.distance(point) {
            best = foot;
        }
    }
    best
}

/// Contacts of two shapes at their poses.
fn touches(first: (&SolidShape, &Pose), second: (&SolidShape, &Pose), reach: f64, dimension: usize) -> Vec<Touch> {
    let mut points = Vec::new();
    contacts(first, second, reach, dimension, &mut points);
    points.iter().map(|point| point.at([first.1, second.1], DVec3::ZERO)).collect()
}

/// Checks the contacts of a small ball, or disc, outside of a surface.
fn check_ball(body: &FacetedBody, pose: &Pose, center: DVec3, dimension: usize) -> Result<(), TestCaseError> {
    let radius = 0.01;
    let ball = shape(&item(if dimension == 2 { "Disc" } else { "Ball" }, &[("radius", radius)]), dimension);
    let place = Pose { position: center, ..Pose::WORLD };
    let local = pose.local_point(center);
    let feet: Vec<DVec3> = body.facets.iter().map(|facet| nearest(facet, local)).collect();
    let distance = feet.iter().map(|foot| foot.distance(local)).fold(f64::INFINITY, f64::min);
    let found = touches((&body.shape, pose), (&ball, &place), 5.0, dimension);
    let least = found.iter().map(|touch| touch.gap).fold(f64::INFINITY, f64::min);
    prop_assert!((least - distance + radius).abs() < ROUNDING, "gap {least}, distance {distance}");
    for touch in found {
        let foot = pose.local_point(center - touch.normal * (touch.gap + radius));
        // No point of the surface beside the foot is nearer: the foot is the nearest point of each facet that it is on.
        let mut count = 0;
        for (facet, other) in body.facets.iter().zip(&feet) {
            if nearest(facet, foot).distance(foot) < ROUNDING {
                count += 1;
                // Normals of a vertex or an edge count as long as they are within 1e-6 of its cone.
                prop_assert!(other.distance(foot) < 1e-5, "gap {}: nearer to {other} than to {foot}", touch.gap);
            }
        }
        prop_assert!(count > 0, "gap {}: no facet has the foot {foot}", touch.gap);
    }
    Ok(())
}

/// Whether a point is inside a closed surface: the sum of its solid angles, or of angles in 2D.
fn is_inside(body: &FacetedBody, point: DVec3) -> bool {
    let angle = |facet: &Vec<DVec3>| {
        let ways: Vec<DVec3> = facet.iter().map(|corner| *corner - point).collect();
        if let [a, b] = ways[..] {
            return a.cross(b).z.atan2(a.dot(b)) / TAU;
        }
        let (a, b, c) = (ways[0], ways[1], ways[2]);
        let [x, y, z] = [a.length(), b.length(), c.length()];
        a.dot(b.cross(c)).atan2(x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y) / TAU
    };
    body.facets.iter().map(angle).sum::<f64>() > 0.5
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1000, ..ProptestConfig::default() })]

    #[test]
    fn a_disc_touches_a_polygon_only_where_that_is_nearest(body in polygon(), pose in pose(2, 1.0), center in point(2)) {
        prop_assume!(!is_inside(&body, pose.local_point(center * 1.5)));
        check_ball(&body, &pose, center * 1.5, 2)?;
    }

    #[test]
    fn a_ball_touches_a_mesh_only_where_that_is_nearest(body in mesh(), pose in pose(3, 1.0), center in point(3)) {
        prop_assume!(!is_inside(&body, pose.local_point(center * 1.5)));
        check_ball(&body, &pose, center * 1.5, 3)?;
    }

    #[test]
    fn a_disc_touches_the_ground_only_where_that_is_nearest(
        heights in prop::collection::vec(-0.4..0.4_f64, 2..9), center in point(2),
    ) {
        let (shape, pose) = ground(&heights, &[heights.len()]);
        let node = |index: usize| DVec3::new(0.5 * index as f64, heights[index], 0.0);
        let last = heights.len() - 1;
        let mut facets: Vec<Vec<DVec3>> = (0..last).map(|index| vec![node(index), node(index + 1)]).collect();
        facets.extend([0, last].map(|end| vec![node(end), node(end).with_y(-10.0)]));
        let local = pose.local_point(center * 1.5);
        let cell = (local.x / 0.5).floor().clamp(0.0, last as f64 - 1.0) as usize;
        let height = node(cell).lerp(node(cell + 1), local.x / 0.5 - cell as f64).y;
        prop_assume!(local.x < 0.0 || local.x > node(last).x || local.y > height);
        check_ball(&FacetedBody { shape, facets }, &pose, center * 1.5, 2)?;
    }

    #[test]
    fn a_ball_touches_the_ground_only_where_that_is_nearest(
        (heights, shape) in (2..6_usize, 2..6_usize).prop_flat_map(|(nx, ny)| {
            (prop::collection::vec(prop_oneof![-0.4..0.4_f64, Just(0.0)], nx * ny), Just([nx, ny]))
        }),
        center in point(3),
    ) {
        let [nx, ny] = shape;
        let (shape, pose) = ground(&heights, &shape);
        let node = |i: usize, j: usize| DVec3::new(0.5 * i as f64, 0.5 * j as f64, heights[i * ny + j]);
        let mut facets: Vec<Vec<DVec3>> = Vec::new();
        for i in 0..nx - 1 {
            for j in 0..ny - 1 {
                let [a, b, c, d] = [node(i, j), node(i + 1, j), node(i, j + 1), node(i + 1, j + 1)];
                let rising = a.z + d.z >= b.z + c.z;
                facets.extend(if rising { [vec![a, b, d], vec![a, d, c]] } else { [vec![a, b, c], vec![b, d, c]] });
            }
        }
        let mut side = |from: DVec3, to: DVec3| {
            facets.extend([vec![from, to, to.with_z(-10.0)], vec![from, to.with_z(-10.0), from.with_z(-10.0)]]);
        };
        for i in 0..nx - 1 {
            side(node(i + 1, 0), node(i, 0));
            side(node(i, ny - 1), node(i + 1, ny - 1));
        }
        for j in 0..ny - 1 {
            side(node(0, j), node(0, j + 1));
            side(node(nx - 1, j + 1), node(nx - 1, j));
        }
        let center = center * 1.5;
        let local = pose.local_point(center);
        // Above the ground, or beside it: a ray upward meets the ground an even number of times.
        let above = facets.iter().filter(|facet| {
            let flat = |corner: DVec3| corner.with_z(0.0);
            let [a, b, c] = [facet[0], facet[1], facet[2]];
            let area = |p: DVec3, q: DVec3, r: DVec3| (flat(q) - flat(p)).cross(flat(r) - flat(p)).z;
            let parts = [area(local, b, c), area(local, c, a), area(local, a, b)];
            let whole = area(a, b, c);
            whole > 0.0 && parts.iter().all(|part| *part >= 0.0)
                && (a.z * parts[0] + b.z * parts[1] + c.z * parts[2]) / whole > local.z
        }).count();
        prop_assume!(above == 0);
        check_ball(&FacetedBody { shape, facets }, &pose, center, 3)?;
    }

    /// The nearest pair of points of two bodies is a contact, whatever parts they are on.
    #[test]
    fn the_least_gap_is_the_distance(
        (dimension, body, (other, _), poses) in prop_oneof![
            (Just(2), polygon().boxed(), convex(2), [pose(2, 2.0), pose(2, 2.0)].boxed()),
            (Just(3), mesh().boxed(), convex(3), [pose(3, 2.0), pose(3, 2.0)].boxed()),
        ],
    ) {
        let (first, second) = ((&body.shape, &poses[0]), (&other, &poses[1]));
        let (distance, normal) = separation(first, second, dimension);
        // A body inside of a mesh that touches no triangle is at its center.
        prop_assert!(dimension == 2 || distance < 0.0 || !is_inside(&body, poses[0].local_point(poses[1].position)));
        prop_assume!(distance > 1e-6);
        let found = touches(first, second, 3.0, dimension);
        let least = found.iter().min_by(|a, b| a.gap.total_cmp(&b.gap));
        if let Some(least) = least {
            prop_assert!(least.gap >= distance - ROUNDING);
        }
        // Beyond the size of the bodies the distance is a bound.
        if distance < 0.3 && distance < body.shape.reach().min(other.reach()) {
            prop_assert!(least.is_some_and(|least| least.gap - distance < ROUNDING && least.normal.dot(normal) > 0.999),
                "{distance} {normal}, {found:?}");
            let mut all = Vec::new();
            separations(first, second, 0.3, dimension, &mut all);
            let nearest = all.iter().map(|one| one.0).fold(f64::INFINITY, f64::min);
            prop_assert!((nearest - distance).abs() < ROUNDING);
        }
    }

    /// A box on flat ground feels no edge between its parts, and rests on four corners, or two in 2D.
    #[test]
    fn flat_ground_is_flat(
        shape in prop_oneof![Just(vec![9]), Just(vec![9, 9])], at in point(3), angle in 0.0..6.0_f64, sizes in [0.1..1.2_f64, 0.1..1.2],
        gap in prop_oneof![Just(0.0), -1e-4..1e-2_f64],
    ) {
        let dimension = shape.len() + 1;
        let (terrain, pose) = ground(&vec![0.0; shape.iter().product()], &shape);
        let up = DVec3::AXES[dimension - 1];
        let [a, c] = sizes;
        let block = match dimension {
            2 => crate::samples::shape(&item("Rectangle", &[("width", a), ("height", c)]), 2),
            _ => crate::samples::shape(&item("Cuboid", &[("a", a), ("b", 0.3), ("c", c)]), 3),
        };
        let position = (at * 0.9).reject_from(up).with_z(0.0) + up * (0.5 * c + gap);
        let place = turned(if dimension == 2 { position.with_z(0.0) } else { position }, if dimension == 2 { 0.0 } else { angle });
        let found = touches((&terrain, &pose), (&block, &place), 0.05, dimension);
        prop_assert_eq!(found.len(), 2 * (dimension - 1));
        for touch in &found {
            prop_assert!((touch.gap - gap).abs() < ROUNDING && touch.normal.dot(up) > 1.0 - 1e-12, "{touch:?}");
        }
        // The contacts are the corners: their distance is the diagonal of the base.
        let base = if dimension == 2 { a } else { a.hypot(0.3) };
        let widest = found.iter().map(|touch| touch.point.distance(found[0].point)).fold(0.0, f64::max);
        prop_assert!((widest - base).abs() < 1e-4 * base, "{widest} of {base}");
    }
}

#[test]
fn a_polygon_that_crosses_itself_is_refused_with_the_edges() {
    let corners = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]].map(|[x, y]| DVec3::new(x, y, 0.0));
    let error = SolidShape::declared(&pointed("Polygon", "vertices", &corners, 2), 2).unwrap_err().to_string();
    assert!(error.starts_with("bodies[0].shape.vertices: expected a polygon that does not meet itself"), "{error}");
    assert!(error.contains("edges 0 and 2"), "{error}");
    let _ = rows(&corners, 2);
}
