//! Boundaries of a scene as fixed shapes.

use glam::{DMat3, DVec3};
use physcore_base::error::Result;
use physcore_base::scene::{Item, Value, unknown};

use super::declared::{finite_rows, hull, planar_hull, positive};
use super::{GroundProfile, Part, SolidShape};
use crate::pose::Pose;

/// Fixed shape of a boundary.
#[derive(Debug, Clone, PartialEq)]
pub struct WallShape {
    /// Shape.
    pub shape: SolidShape,
    /// Pose of the shape.
    pub pose: Pose,
    /// Coefficient of friction.
    pub friction: f64,
    /// Coefficient of restitution.
    pub restitution: f64,
    /// Index of the boundary in the scene.
    pub boundary: usize,
}

/// Fixed shapes of the boundary with an index.
///
/// # Errors
/// If there is no boundary of that kind for rigid bodies, or one of its parameters is not acceptable.
pub fn walls(item: &Item, boundary: usize, dimension: usize) -> Result<Vec<WallShape>> {
    let friction = item.non_negative("friction")?;
    let restitution = item.non_negative("restitution")?;
    let shapes = match item.kind.as_str() {
        "Plane" => vec![plane(item)?],
        "Box" => cuboid(item, dimension)?,
        "Sphere" => {
            let radius = positive(item, "radius")?;
            let shape = if item.flag("inside")? {
                SolidShape::hollow(radius)
            } else {
                SolidShape::of([Part::round(DVec3::ZERO, radius)])
            };
            vec![(shape, item.vector("center")?)]
        }
        "Capsule" => {
            let [start, end] = [item.vector("start")?, item.vector("end")?];
            let middle = 0.5 * (start + end);
            let part = Part::bar([start - middle, end - middle], positive(item, "radius")?, dimension);
            vec![(SolidShape::of([part]), middle)]
        }
        "ConvexHull" => {
            let points = finite_rows(item, "points", dimension)?;
            let middle = points.iter().sum::<DVec3>() / points.len() as f64;
            let points: Vec<DVec3> = points.into_iter().map(|point| point - middle).collect();
            let part = if dimension == 2 { planar_hull(item, &points)? } else { hull(item, &points)? };
            vec![(SolidShape::of([part]), middle)]
        }
        "HeightField" => {
            let (terrain, corner) = GroundProfile::declared(item, dimension)?;
            vec![(SolidShape::terrain(terrain), corner)]
        }
        _ => return Err(unknown(item, "a boundary for rigid bodies: Plane, Box, Sphere, Capsule, ConvexHull or HeightField")),
    };
    let wall = |(shape, position)| {
        let pose = Pose { position, rotation: DMat3::IDENTITY };
        WallShape { shape, pose, friction, restitution, boundary }
    };
    Ok(shapes.into_iter().map(wall).collect())
}

/// Half-space below the item's plane.
fn plane(item: &Item) -> Result<(SolidShape, DVec3)> {
    let direction = item.vector("normal")?;
    // The vector is scaled first, so that squares of very long or short normals neither overflow nor underflow.
    let largest = direction.abs().max_element();
    let Some(normal) = (direction / largest).try_normalize() else {
        return Err(item.wrong("normal", "a vector that is not zero", Some(&Value::Vector(direction))));
    };
    Ok((SolidShape::half_space(normal), item.vector("point")?))
}

/// Half-spaces around the item's box, or the box itself.
fn cuboid(item: &Item, dimension: usize) -> Result<Vec<(SolidShape, DVec3)>> {
    let (lower, upper) = (item.vector("lower")?, item.vector("upper")?);
    if (0..dimension).any(|axis| lower[axis] >= upper[axis]) {
        return Err(item.wrong("upper", &format!("more than lower, {lower}, along every axis"), Some(&Value::Vector(upper))));
    }
    if item.values.contains_key("inside") && !item.flag("inside")? {
        let (middle, half) = (0.5 * (lower + upper), 0.5 * (upper - lower));
        let part = if dimension == 2 { Part::rectangle(half) } else { Part::cuboid(half) };
        return Ok(vec![(SolidShape::of([part]), middle)]);
    }
    let sides = DVec3::AXES[..dimension].iter();
    Ok(sides.flat_map(|&axis| [(SolidShape::half_space(axis), lower), (SolidShape::half_space(-axis), upper)]).collect())
}
