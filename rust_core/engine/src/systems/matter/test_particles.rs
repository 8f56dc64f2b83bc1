//! Fields in space, sampled by test particles that act on nothing.

use glam::{DVec2, DVec3};

use super::dynamics::Dynamics;
use crate::catalog::{Catalog, Space};
use crate::error::{Error, Result};
use crate::forces::{PART, Reach, Strength, VelocityDependence};
use crate::matter::{Columns, Matter, Properties};
use crate::memory;
use crate::parallel::Executor;
use crate::scene::{Body, Item, Scene, Value};
use crate::simd::{LANES, padded};
use crate::systems::{Quantity, Sample};

/// Memory per test particle [bytes]: properties, coefficients of linear forces, position, velocity, force and result.
const BYTES: usize = 500;

/// Samples a quantity at points, in double precision, by test particles at rest. A test particle has a mass of 1 kg and no
/// radius. Its charge is 1 C for the fields of charges, and 0 for accelerations. Forces on single particles and the charges
/// of bodies act on it.
///
/// # Errors
/// If a user-defined function fails, or a value is not finite. If a potential is requested of a field without one. If there
/// is no memory for so many points.
pub fn sample(
    (dimension, catalog): (usize, Catalog),
    forces: Vec<Item>,
    bodies: Vec<Body>,
    Sample { quantity, time, points, .. }: &Sample<'_>,
    executor: &Executor,
) -> Result<Vec<f64>> {
    let count = points.len() / dimension;
    memory::check(quantity.name(), BYTES * count, 0, || format!("for {count} points; take fewer at a time"))?;
    let vector = |row: &[f64]| DVec3::from_array(std::array::from_fn(|axis| row.get(axis).copied().unwrap_or(0.0)));
    let charge = if *quantity == Quantity::Acceleration { 0.0 } else { 1.0 };
    let positions = points.chunks_exact(dimension).map(vector).collect();
    let points = Body { positions, charge: vec![charge; count], ..Body::default() };
    let sources = bodies.len() as u32;
    let alone = |item: Item| {
        let given = item.values.get("sources").cloned();
        let next = match given {
            Some(Value::Indices(array)) => Value::Indices(array.entries.iter().map(|body| body + 1).collect::<Vec<u32>>().into()),
            Some(Value::Flags(array)) => Value::Flags([vec![false; count], array.entries].concat().into()),
            _ => Value::Indices((1..=sources).collect::<Vec<u32>>().into()),
        };
        let mut item = Item { on: Some(vec![0]), members: None, ..item };
        if catalog.forces.is_between_pairs(&item) {
            item.values.insert("sources".to_owned(), next);
            // The sum is exact: its error need not be measured.
            item.values.insert("opening_angle".to_owned(), Value::Number(0.0));
        }
        item
    };
    let forces = forces.into_iter().map(alone).collect();
    let scene = Scene { dimension, bodies: std::iter::once(points).chain(bodies).collect(), forces, ..Scene::default() };
    match dimension {
        _ if count == 0 => Ok(Vec::new()),
        2 => of_scene::<DVec2>(&scene, catalog, (*quantity, *time), executor),
        _ => of_scene::<DVec3>(&scene, catalog, (*quantity, *time), executor),
    }
}

/// Samples a quantity at the particles of the first body of a scene; the others do not move.
fn of_scene<V: Space>(
    scene: &Scene,
    catalog: Catalog,
    (quantity, time): (Quantity, f64),
    executor: &Executor,
) -> Result<Vec<f64>> {
    let (count, all) = (scene.bodies[0].positions.len(), scene.count());
    let mut properties = Properties::<V>::new((0..all).map(|index| if index < count { 1.0 } else { f64::INFINITY }).collect());
    properties.charge = scene.bodies.iter().flat_map(|body| &body.charge).copied().collect();
    let owners = scene.bodies.iter().zip(0..).flat_map(|(body, owner)| std::iter::repeat_n(owner, body.positions.len()));
    properties.body = owners.collect();
    let mut forces = Vec::new();
    for item in &scene.forces {
        forces.extend(V::forces(catalog).build(scene, item, &properties, executor)?);
    }
    let mut matter = Matter::zeros(all, 0, padded(all));
    let positions = scene.positions();
    matter.position = Columns::from_fn(all, |index| V::narrow(positions[index]));
    let mut dynamics = Dynamics::new(catalog, properties, forces, None, matter.block);
    dynamics.prepare(&matter, time, executor)?;
    let at = dynamics.view_of(&matter, time, executor);
    let (values, width) = match quantity {
        Quantity::Acceleration | Quantity::ElectricField => {
            let vectors = dynamics.accelerations(&at).take(count);
            (vectors.flat_map(|a| a.widen().to_array().into_iter().take(V::DIMENSION)).collect(), V::DIMENSION)
        }
        Quantity::MagneticField => {
            let mut values = Vec::with_capacity(3 * count);
            for start in (0..count).step_by(PART) {
                let mut strength = Strength::<V>::default();
                dynamics.magnetic(start..(start + PART).min(all.next_multiple_of(LANES)), &at, &mut strength);
                values.extend((0..PART.min(count - start)).flat_map(|place| strength.get(place).to_array()));
            }
            (values, 3)
        }
        Quantity::ElectricPotential => {
            let gyroscopic = VelocityDependence::Gyroscopic;
            let electric = || dynamics.forces().iter().filter(|force| force.about().velocity != gyroscopic);
            if let Some(force) = electric().find(|force| {
                force.about().callback || (force.about().potential.is_none() && force.about().reach == Reach::Pointwise)
            }) {
                return Err(Error::parameter(quantity.name(), "electric fields with a potential", force.about().name)
                    .with_hint("functions and fields that change in time have none"));
            }
            let mut sums = vec![0.0; all];
            electric().for_each(|force| force.potentials(&at, &mut sums));
            sums.truncate(count);
            (sums, 1)
        }
    };
    if let Some(wrong) = values.iter().position(|value| !value.is_finite()) {
        let (index, name) = (wrong / width, quantity.name());
        let row = &values[index * width..(index + 1) * width];
        let expected = format!("a place with a finite {}", name.replace('_', " "));
        return Err(Error::parameter(format!("{name}.points[{index}]"), expected, format!("{row:?} in SI units")));
    }
    Ok(values)
}
