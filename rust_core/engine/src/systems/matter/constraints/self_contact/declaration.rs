//! Contacts and strain limits as a scene declares them: the bodies that meet, their rules, their triangles and free edges.

use super::super::{Declaration, MESHES, refuse};
use super::limits::StrainLimit;
use super::mesh::{ContactRule, NONE};
use super::{KIND, SelfContacts};
use crate::catalog::Space;
use crate::error::{Error, Result};
use crate::forces::springs;
use crate::scene::{Body, Item, Scene, Value};

/// Triangles and free edges of a body, with the springs along the sides of each.
#[derive(Debug, Clone, Default)]
pub struct BodySurface {
    pub faces: Vec<([u32; 3], Vec<u32>)>,
    pub edges: Vec<([u32; 2], Vec<u32>)>,
}

impl SelfContacts {
    /// Builds the contacts and strain limits that a scene declares; None if there are none.
    ///
    /// # Errors
    /// If a value is wrong, two items concern the same bodies, or the method does not carry them.
    pub fn declared<V: Space>(declared: &Declaration<'_, V>) -> Result<Option<Self>> {
        let Declaration { scene, springs, properties, .. } = declared;
        let items: Vec<&Item> = scene.constraints.iter().filter(|item| item.kind == KIND).collect();
        let limits = StrainLimit::declared(scene, springs)?;
        let Some(path) = items.first().map(|item| item.path.as_str()).or((!limits.is_empty()).then_some("strain_limit")) else {
            return Ok(None);
        };
        if scene.dimension != 3 && !items.is_empty() {
            return Err(Error::parameter(path, "a scene in 3D", format!("one in {}D", scene.dimension)));
        }
        if scene.periodic.is_some() {
            return Err(Error::parameter(path, "no Periodic domain", "one")
                .with_hint("contacts and lengths are those of the bodies themselves, not of their images"));
        }
        let mut bodies: Vec<usize> = Vec::new();
        let mut place = |body: usize| {
            bodies.iter().position(|&known| known == body).unwrap_or_else(|| {
                bodies.push(body);
                bodies.len() - 1
            })
        };
        let (mut rules, mut pairs) = (Vec::new(), Vec::new());
        for item in items {
            let own = own_body(item)?;
            let thickness = item.number("thickness")?;
            if thickness <= 0.0 {
                return Err(item.wrong("thickness", "a number > 0", Some(&Value::Number(thickness))));
            }
            let restitution = item.number("restitution")?;
            rules.push(ContactRule { thickness, friction: item.non_negative("friction")?, restitution });
            let one = place(own);
            for other in item.on.iter().flatten().copied().chain([own]) {
                pairs.push((item, one, place(other), rules.len() as u32 - 1));
            }
        }
        let size = bodies.len();
        let mut table = vec![NONE; size * size];
        for (item, one, other, rule) in pairs {
            if table[one * size + other] != NONE {
                return Err(Error::parameter(&item.path, "one SelfContact for two bodies", "a second one"));
            }
            (table[one * size + other], table[other * size + one]) = (rule, rule);
        }
        let engine = properties.engine();
        let surfaces: Vec<BodySurface> = bodies.iter().map(|&body| surface(scene, body, &engine)).collect::<Result<_>>()?;
        let inverse_mass = properties.mass.iter().map(|mass| 1.0 / mass).collect();
        let start = properties.relative(&scene.positions());
        let mut contacts = Self { rules, table, surfaces, limits, inverse_mass, start, ..Self::default() };
        contacts.leave_out_broken(&[]);
        refuse(MESHES, declared.method)?;
        Ok(Some(contacts))
    }
}

/// Bodies that a scene declares in contact with others, as indices in ascending order.
///
/// # Errors
/// If an item names no body.
pub fn bodies(scene: &Scene) -> Result<Vec<usize>> {
    let mut bodies = Vec::new();
    for item in scene.constraints.iter().filter(|item| item.kind == KIND) {
        bodies.push(own_body(item)?);
        bodies.extend(item.on.iter().flatten().copied());
    }
    bodies.sort_unstable();
    bodies.dedup();
    Ok(bodies)
}

/// Number of triangles and free edges that a scene declares in contact with others.
///
/// # Errors
/// If an item names no body.
pub fn elements(scene: &Scene) -> Result<usize> {
    let of = |body: &usize| {
        let item = &scene.bodies[*body].item;
        match item.tuples::<3>("faces") {
            Ok(faces) if !faces.is_empty() => Ok(faces.len()),
            _ => item.tuples::<2>("pairs").map(<[_]>::len),
        }
    };
    bodies(scene)?.iter().map(of).sum()
}

/// Body of an item, as an index.
fn own_body(item: &Item) -> Result<usize> {
    match item.values.get("body") {
        Some(Value::Indices(array)) if array.entries.len() == 1 => Ok(array.entries[0] as usize),
        other => Err(item.wrong("body", "a body", other)),
    }
}

/// Triangles of a body, or its springs if it has none, with particles in the engine's order.
///
/// # Errors
/// If its triangles or springs are wrong.
pub fn surface(scene: &Scene, body: usize, engine: &[u32]) -> Result<BodySurface> {
    let first = scene.first(body);
    let networks = scene.bodies[..body].iter().filter(|body| body.item.kind == springs::KIND);
    let spring: usize = networks.map(|body| body.item.tuples::<2>("pairs").map(<[_]>::len)).sum::<Result<usize>>()?;
    let Body { item, .. } = &scene.bodies[body];
    let pairs = item.tuples::<2>("pairs")?;
    let number = |index: &u32| engine[first + *index as usize];
    let faces = item.tuples::<3>("faces").unwrap_or(&[]);
    let mut springs: Vec<([u32; 2], u32)> =
        pairs.iter().zip(spring as u32..).map(|(&[a, b], spring)| ([a.min(b), a.max(b)], spring)).collect();
    springs.sort_unstable();
    let along = |a: u32, b: u32| {
        let key = [a.min(b), a.max(b)];
        let from = springs.partition_point(|(ends, _)| *ends < key);
        springs[from..].iter().take_while(move |(ends, _)| *ends == key).map(|&(_, spring)| spring).collect::<Vec<u32>>()
    };
    let face = |corners: &[u32; 3]| {
        let sides = (0..3).flat_map(|corner| along(corners[corner], corners[(corner + 1) % 3])).collect();
        (corners.map(|corner| number(&corner)), sides)
    };
    let edge = |ends: &[u32; 2]| (ends.map(|end| number(&end)), along(ends[0], ends[1]));
    let edges = if faces.is_empty() { pairs.iter().map(edge).collect() } else { Vec::new() };
    Ok(BodySurface { faces: faces.iter().map(face).collect(), edges })
}
