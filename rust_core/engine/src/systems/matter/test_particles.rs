//! The acceleration field of a scene: that of test particles, which act on nothing.

use glam::{DVec2, DVec3};

use super::dynamics::Dynamics;
use crate::error::{Error, Result};
use crate::forces;
use crate::math::Vector;
use crate::matter::{Columns, Matter, Properties};
use crate::memory;
use crate::parallel::Executor;
use crate::scene::{Body, Item, Scene};
use crate::simd::padded;

/// Memory per test particle [bytes]: its properties, the coefficients of linear forces, position, velocity, force and result.
const BYTES: usize = 500;

/// The acceleration [m/s²] of particles of 1 kg, without charge or radius, at rest at `points` [m], a row of `dimension`
/// numbers each, by forces on single particles at a time [s]; in double precision.
///
/// # Errors
/// If a function of the user's fails, an acceleration is not finite, or there is no memory for so many.
pub fn acceleration(dimension: usize, forces: Vec<Item>, time: f64, points: &[f64], executor: &Executor) -> Result<Vec<f64>> {
    let count = points.len() / dimension;
    memory::check("acceleration.points", BYTES * count, 0, || format!("for {count} points; take fewer at a time"))?;
    let vector = |row: &[f64]| DVec3::from_array(std::array::from_fn(|axis| row.get(axis).copied().unwrap_or(0.0)));
    let positions = points.chunks_exact(dimension).map(vector).collect();
    let bodies = vec![Body { positions, ..Body::default() }];
    let scene = Scene { dimension, bodies, forces, ..Scene::default() };
    match dimension {
        _ if count == 0 => Ok(Vec::new()),
        2 => of_scene::<DVec2>(&scene, time, executor),
        _ => of_scene::<DVec3>(&scene, time, executor),
    }
}

/// The same of the only body of a scene.
fn of_scene<V: Vector>(scene: &Scene, time: f64, executor: &Executor) -> Result<Vec<f64>> {
    let (points, count) = (&scene.bodies[0].positions, scene.count());
    let properties = Properties::<V>::new(vec![1.0; count]);
    let mut forces = Vec::new();
    for item in &scene.forces {
        forces.extend(forces::build(scene, item, &properties, executor)?);
    }
    let mut matter = Matter::zeros(count, 0, padded(count));
    matter.position = Columns::from_fn(count, |index| V::narrow(points[index]));
    let mut dynamics = Dynamics::new(properties, forces, None, matter.block);
    dynamics.prepare(&matter, time, executor)?;
    let mut rows = Vec::with_capacity(V::DIMENSION * count);
    for (index, a) in dynamics.accelerations(&dynamics.view_of(&matter, time, executor)).enumerate() {
        let row = &a.widen().to_array()[..V::DIMENSION];
        if !a.widen().is_finite() {
            return Err(Error::parameter(
                format!("acceleration.points[{index}]"),
                "a place with a finite acceleration",
                format!("{row:?} m/s²"),
            ));
        }
        rows.extend_from_slice(row);
    }
    Ok(rows)
}
