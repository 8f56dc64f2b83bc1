//! Anchors of a scene: which particles are tied to which bodies.

use glam::DVec3;
use physcore_rigid::world::{RigidWorld, SolidBody};

use super::declaration::JOINTS;
use super::ties::{TiedBody, TiedPart};
use crate::catalog::Space;
use crate::error::{Error, Result};
use crate::forces::springs;
use crate::scene::{Item, Scene};
use crate::systems::matter::constraints::{Declaration, rods, self_contact};

/// Kind of the items.
const ANCHOR: &str = "Anchor";

/// Ties of a scene.
#[derive(Debug, Default)]
pub struct Ties {
    pub bodies: Vec<TiedBody>,
    /// Body that each particle is tied to, in the caller's order.
    pub owners: Vec<Option<usize>>,
    /// Number of ties.
    pub count: usize,
}

impl Ties {
    /// Ties that a scene declares, given the body of each of its particles. Replaces the bodies by those with their particles.
    ///
    /// # Errors
    /// If a value is wrong, or something else holds a particle.
    pub fn declared<V: Space>(
        declared: &mut Declaration<'_, V>,
        world: &mut RigidWorld,
        places: &[Option<usize>],
    ) -> Result<Self> {
        let (scene, properties) = (declared.scene, declared.properties);
        let (engine, starts) = (properties.engine(), scene.positions());
        let held = held(declared)?;
        let mut ties = Self { owners: vec![None; scene.count()], ..Self::default() };
        for item in scene.constraints.iter().filter(|item| item.kind == ANCHOR) {
            let center = item.number("body")? as usize;
            let Some(body) = places.get(center).copied().flatten() else {
                return Err(item.wrong("body", "a rigid body of the scene", item.values.get("body")));
            };
            let place = ties.bodies.iter().position(|tied| tied.body == body).unwrap_or(ties.bodies.len());
            if place == ties.bodies.len() {
                let particle = engine[center] as usize;
                let part = TiedPart::new(particle, properties.mass[particle], starts[center]);
                let is_fixed = properties.is_fixed(particle);
                ties.bodies.push(TiedBody { body, is_fixed, parts: vec![part], rows: Vec::new() });
            }
            for &[caller] in item.tuples::<1>("network")? {
                let caller = caller as usize;
                refuse(item, caller, &held, &ties.owners, places)?;
                let particle = engine[caller] as usize;
                let tied = &mut ties.bodies[place];
                tied.parts.push(TiedPart::new(particle, properties.mass[particle], starts[caller]));
                tied.rows.push(ties.count);
                ties.owners[caller] = Some(body);
                ties.count += 1;
            }
        }
        for tied in &mut ties.bodies {
            unite(tied, world);
        }
        if let Some(walls) = declared.walls.as_deref_mut() {
            let tied = ties.bodies.iter().flat_map(|tied| &tied.parts[1..]);
            walls.leave_out(&tied.map(|part| part.particle as u32).collect::<Vec<_>>());
        }
        Ok(ties)
    }

    /// Position of each particle at the start in the caller's order [m]; of a body with its particles, their common center.
    pub fn centers(&self, world: &RigidWorld, scene: &Scene, places: &[Option<usize>]) -> Vec<DVec3> {
        let mut centers = scene.positions();
        for (center, place) in centers.iter_mut().zip(places) {
            if let Some(tied) = self.bodies.iter().find(|tied| Some(tied.body) == *place) {
                *center -= tied.offset(&world.rotation(tied.body));
            }
        }
        centers
    }
}

/// Replaces a body by one with its particles, and the positions of the parts by their places.
fn unite(tied: &mut TiedBody, world: &mut RigidWorld) {
    let (rotation, turning) = (world.rotation(tied.body), world.angular_velocity(tied.body));
    let weight = |part: &TiedPart| if tied.is_fixed { 0.0 } else { part.mass };
    let mass: f64 = tied.parts.iter().map(weight).sum();
    let center = tied.parts[0].place;
    let moment: DVec3 = tied.parts.iter().map(|part| weight(part) * (part.place - center)).sum();
    let common = if tied.is_fixed { center } else { center + moment / mass };
    tied.parts.iter_mut().for_each(|part| part.place = rotation.transpose() * (part.place - common));
    if tied.is_fixed {
        return;
    }
    let masses: Vec<(f64, DVec3)> = tied.parts.iter().map(|part| (part.mass, part.place)).collect();
    let SolidBody { mut surface, inertia, .. } = world.bodies[tied.body];
    let shape = world.shapes[surface.shape].moved(tied.parts[0].place);
    surface.shape = world.shapes.len();
    world.shapes.push(shape);
    world.bodies.set(tied.body, SolidBody { surface, inverse_mass: 1.0 / mass, inertia: inertia.with(&masses) });
    world.turn(tied.body, world.state.turns[tied.body].orientation, turning);
}

/// Other items that hold each particle, in the caller's order.
fn held<V: Space>(declared: &Declaration<'_, V>) -> Result<Vec<Option<&'static str>>> {
    let Declaration { scene, springs: declared_springs, properties, .. } = declared;
    let mut held = vec![None; scene.count()];
    let mut hold = |particle: u32, what| held[properties.caller[particle as usize] as usize] = Some(what);
    let meshes = self_contact::bodies(scene)?;
    for particle in 0..properties.count() as u32 {
        if properties.is_fixed(particle as usize) {
            hold(particle, "which is fixed");
        } else if meshes.contains(&(properties.body[particle as usize] as usize)) {
            hold(particle, "on which SelfContact acts too");
        }
    }
    let strains = springs::strains(scene, "strain_limit")?;
    for (spring, strain) in declared_springs.iter().zip(strains) {
        if rods::is_rod(spring) {
            spring.ends.iter().for_each(|&end| hold(end, "on which a rod acts too"));
        } else if strain.is_finite() {
            spring.ends.iter().for_each(|&end| hold(end, "on which a strain limit acts too"));
        }
    }
    for wire in scene.constraints.iter().filter(|item| item.kind == "Wire") {
        let members = scene.members(wire).into_iter().enumerate().filter(|(_, member)| *member);
        members.for_each(|(caller, _)| held[caller] = Some("on which a wire acts too"));
    }
    for joint in scene.constraints.iter().filter(|item| JOINTS.contains(&item.kind.as_str())) {
        for end in ["one", "other"].into_iter().filter(|end| joint.values.contains_key(*end)) {
            if let Some(slot) = held.get_mut(joint.number(end)? as usize) {
                *slot = Some("which a joint holds too");
            }
        }
    }
    Ok(held)
}

/// Refuses a particle that cannot be tied.
fn refuse(
    item: &Item,
    caller: usize,
    held: &[Option<&'static str>],
    owners: &[Option<usize>],
    places: &[Option<usize>],
) -> Result<()> {
    let other = match (held.get(caller), owners.get(caller), places.get(caller)) {
        (Some(Some(other)), ..) => other,
        (_, Some(Some(_)), _) => "which is tied already",
        (_, _, Some(Some(_))) => "which is a rigid body",
        (Some(None), ..) => return Ok(()),
        _ => "which is not in the scene",
    };
    let found = format!("particle {caller}, {other}");
    Err(Error::parameter(item.path_of("indices"), "particles that nothing else holds", found))
}
