//! Shapes as scenes declare them.

use glam::{DMat3, DQuat, DVec3};
use physcore_base::error::{Error, Result};
use physcore_base::scene::{Item, Value, unknown};

use super::outline::Outline;
use super::{MassProperties, Part, hull, mesh};
use crate::pose::Pose;

/// Convex parts and mass properties of a shape, in the given coordinates.
pub(super) fn parts(item: &Item, dimension: usize) -> Result<(Vec<Part>, MassProperties)> {
    let one = |part: Part, mass: MassProperties| Ok((vec![part], mass));
    match (item.kind.as_str(), dimension) {
        ("Disc", 2) => {
            let radius = positive(item, "radius")?;
            one(Part::round(DVec3::ZERO, radius), MassProperties::disc(radius))
        }
        ("Ball", 3) => {
            let radius = positive(item, "radius")?;
            one(Part::round(DVec3::ZERO, radius), MassProperties::ball(radius))
        }
        ("Rectangle", 2) => {
            let half = 0.5 * DVec3::new(positive(item, "width")?, positive(item, "height")?, 0.0);
            one(Part::rectangle(half), MassProperties::cuboid(2.0 * half))
        }
        ("Cuboid", 3) => {
            let edges = DVec3::new(positive(item, "a")?, positive(item, "b")?, positive(item, "c")?);
            one(Part::cuboid(0.5 * edges), MassProperties::cuboid(edges))
        }
        ("Polygon", 2) => polygon(item),
        ("Capsule", _) => {
            let [length, radius] = [positive(item, "length")?, positive(item, "radius")?];
            let end = DVec3::AXES[2 * (dimension - 2)] * (0.5 * length);
            one(Part::capsule([-end, end], radius, dimension), MassProperties::capsule(length, radius, dimension))
        }
        ("Hull", 3) => {
            let part = hull(item, &finite_rows(item, "points", 3)?)?;
            let mass = MassProperties::polyhedron(&part.triangles());
            one(part, mass)
        }
        ("MeshShape", 3) => mesh::parts(item),
        ("Compound", _) => compound(item, dimension),
        _ => {
            let known = if dimension == 2 {
                "a shape in 2D: Disc, Rectangle, Polygon, Capsule or Compound"
            } else {
                "a shape in 3D: Ball, Cuboid, Capsule, Hull, MeshShape or Compound"
            };
            Err(unknown(item, known))
        }
    }
}

/// Reads a number above zero.
pub(super) fn positive(item: &Item, name: &str) -> Result<f64> {
    match item.number(name)? {
        number if number > 0.0 => Ok(number),
        number => Err(item.wrong(name, "a number > 0", Some(&Value::Number(number)))),
    }
}

/// Reads rows of finite numbers, at least one.
pub(super) fn finite_rows(item: &Item, name: &str, dimension: usize) -> Result<Vec<DVec3>> {
    let rows = item.vectors(name, None, dimension)?;
    match rows.iter().find(|row| !row.is_finite()) {
        Some(row) => Err(Error::parameter(item.path_of(name), "finite numbers", row)),
        None if rows.is_empty() => Err(Error::parameter(item.path_of(name), "points", "none")),
        None => Ok(rows),
    }
}

/// Hull of the item's `points` in space.
pub(super) fn hull(item: &Item, points: &[DVec3]) -> Result<Part> {
    hull::polyhedron(points).ok_or_else(|| Error::parameter(item.path_of("points"), "points that span a volume", "flat ones"))
}

/// Hull of the item's `points` in the plane.
pub(super) fn planar_hull(item: &Item, points: &[DVec3]) -> Result<Part> {
    hull::polygon(points).ok_or_else(|| Error::parameter(item.path_of("points"), "points that span an area", "flat ones"))
}

/// Union of the item's `shapes`, each turned by its angle or orientation and moved to its position.
fn compound(item: &Item, dimension: usize) -> Result<(Vec<Part>, MassProperties)> {
    let shapes = item.records("shapes")?;
    if shapes.is_empty() {
        return Err(Error::parameter(item.path_of("shapes"), "at least one shape", 0));
    }
    let poses = poses(item, shapes.len(), dimension)?;
    let (mut parts, mut masses) = (Vec::new(), Vec::new());
    for (index, (shape, pose)) in shapes.iter().zip(&poses).enumerate() {
        let mut shape = shape.clone();
        if shape.path.is_empty() {
            shape.path = format!("{}[{index}]", item.path_of("shapes"));
        }
        let (ones, mass) = self::parts(&shape, dimension)?;
        parts.extend(ones.into_iter().map(|part| part.moved(pose)));
        masses.push((mass, pose.rotation, pose.position));
    }
    Ok((parts, MassProperties::union(masses.into_iter())))
}

/// Poses of the parts of a compound: its `positions`, and its `angles` in 2D or `orientations` (w, x, y, z) in 3D.
fn poses(item: &Item, count: usize, dimension: usize) -> Result<Vec<Pose>> {
    let positions = item.vectors("positions", Some(count), dimension)?;
    if let Some(position) = positions.iter().find(|position| !position.is_finite()) {
        return Err(Error::parameter(item.path_of("positions"), "finite positions", position));
    }
    let rotations: Vec<DMat3> = if dimension == 2 {
        item.numbers("angles", count)?.iter().map(|&angle| about_z(angle)).collect()
    } else {
        orientations(item, count)?.into_iter().map(|turn| DMat3::from_quat(turn)).collect()
    };
    if !rotations.iter().all(DMat3::is_finite) {
        let name = if dimension == 2 { "angles" } else { "orientations" };
        return Err(item.wrong(name, "finite numbers, and orientations that are not 0", item.values.get(name)));
    }
    Ok(positions.into_iter().zip(rotations).map(|(position, rotation)| Pose { position, rotation }).collect())
}

fn about_z(angle: f64) -> DMat3 {
    let [sin, cos] = [libm::sin(angle), libm::cos(angle)];
    DMat3::from_cols(DVec3::new(cos, sin, 0.0), DVec3::new(-sin, cos, 0.0), DVec3::Z)
}

/// Unit quaternions of the item's `orientations` (w, x, y, z), of any length but 0.
fn orientations(item: &Item, count: usize) -> Result<Vec<DQuat>> {
    match item.values.get("orientations") {
        Some(Value::Numbers(array)) if array.shape == [count, 4] => {
            let quaternions = array.entries.as_chunks::<4>().0.iter();
            Ok(quaternions.map(|&[w, x, y, z]| DQuat::from_xyzw(x, y, z, w).normalize()).collect())
        }
        other => Err(item.wrong("orientations", &format!("{count} rows of 4 components"), other)),
    }
}

/// Polygon of the item's `vertices`, in either order, cut into convex parts.
fn polygon(item: &Item) -> Result<(Vec<Part>, MassProperties)> {
    let wrong = |expected: &str, found: String| Err(Error::parameter(item.path_of("vertices"), expected, found));
    let mut vertices = Outline::distinct(&finite_rows(item, "vertices", 2)?);
    if vertices.len() < 3 {
        return wrong("at least 3 different vertices", vertices.len().to_string());
    }
    if let Some([one, other]) = Outline::crossing(&vertices) {
        return wrong("a polygon that does not meet itself", format!("edges {one} and {other} that cross or touch"));
    }
    let mut mass = MassProperties::polygon(&vertices);
    if mass.size < 0.0 {
        vertices.reverse();
        mass = MassProperties::polygon(&vertices);
    }
    match Outline::new(vertices) {
        Some(outline) => Ok((outline.parts(), mass)),
        None => wrong("vertices that span an area", "flat ones".to_owned()),
    }
}
