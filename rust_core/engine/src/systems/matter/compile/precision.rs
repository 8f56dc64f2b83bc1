//! Refusal of scenes outside the range of the run's precision: no number of the scene overflows or underflows.

use glam::DVec3;

use crate::catalog::Space;
use crate::error::{Error, Result};
use crate::forces::springs::Spring;
use crate::math::Real;
use crate::matter::Properties;
use crate::scene::{Item, Scene, Value};

/// Largest spacing of f32 numbers at a position, in units of a rest length.
const COARSEST: f64 = 1e-4;

/// Refuses a scene outside the range of the precision.
pub fn check<V: Space>(scene: &Scene, springs: &[Spring], properties: &Properties<V>) -> Result<()> {
    refuse_large::<V::Scalar>(scene, properties.origin)?;
    refuse_coarse::<V::Scalar>(scene, springs, properties.origin)?;
    refuse_extreme_masses(properties)
}

/// Refuses numbers that overflow.
fn refuse_large<T: Real>(scene: &Scene, origin: DVec3) -> Result<()> {
    for (index, body) in scene.bodies.iter().enumerate() {
        let path = |name: &'static str| move || format!("bodies[{index}].{name}");
        check_item::<T>(&body.item)?;
        for (given, kept) in body.positions.iter().flat_map(|&at| at.to_array().into_iter().zip((at - origin).to_array())) {
            check_result::<T>(path("positions"), given, kept)?;
        }
        body.velocities.iter().try_for_each(|&velocity| check_vector::<T>(path("velocities"), velocity))?;
        body.radius.iter().try_for_each(|&radius| check_number::<T>(path("radius"), radius))?;
    }
    scene.forces.iter().try_for_each(check_item::<T>)
}

/// Refuses an item with a number that the precision makes infinite.
fn check_item<T: Real>(item: &Item) -> Result<()> {
    for (name, value) in &item.values {
        let path = || format!("{}.{name}", item.path);
        match value {
            Value::Number(number) => check_number::<T>(path, *number)?,
            Value::Vector(vector) => check_vector::<T>(path, *vector)?,
            Value::Numbers(array) => array.entries.iter().try_for_each(|&number| check_number::<T>(path, number))?,
            Value::Record(inner) => check_item::<T>(inner)?,
            Value::Records(inner) => inner.iter().try_for_each(check_item::<T>)?,
            Value::Flag(_) | Value::Text(_) | Value::Texts(_) | Value::Indices(_) | Value::Flags(_) | Value::Callback(_) => {}
        }
    }
    Ok(())
}

/// Refuses a number that overflows. Infinite numbers are intended, as the stiffness of a rod, and pass.
fn check_number<T: Real>(path: impl Fn() -> String, value: f64) -> Result<()> {
    if value.is_infinite() { Ok(()) } else { check_result::<T>(path, value, value) }
}

fn check_vector<T: Real>(path: impl Fn() -> String, vector: DVec3) -> Result<()> {
    vector.to_array().into_iter().try_for_each(|value| check_number::<T>(&path, value))
}

/// Refuses a number if the precision makes the part that is kept infinite.
fn check_result<T: Real>(path: impl Fn() -> String, given: f64, kept: f64) -> Result<()> {
    if T::from_f64(kept).is_finite() {
        return Ok(());
    }
    let error = Error::parameter(path(), format!("a number in the range of {}", T::NAME), format!("{given:e}"));
    Err(error.with_hint("precision=\"f64\" holds it"))
}

fn refuse_coarse<T: Real>(scene: &Scene, springs: &[Spring], origin: DVec3) -> Result<()> {
    let positions = scene.bodies.iter().flat_map(|body| &body.positions);
    let extent = positions.map(|&position| (position - origin).abs().max_element()).fold(0.0, f64::max);
    let shortest = springs.iter().map(|spring| spring.rest_length).filter(|&length| length > 0.0).fold(f64::INFINITY, f64::min);
    if T::NAME == "f32" && T::EPSILON * extent > COARSEST * shortest {
        let found = format!("{} for a scene that reaches {extent:.3e} m with a rest length of {shortest:.3e} m", T::NAME);
        return Err(Error::parameter("precision", "f64", found)
            .with_hint("neighboring f32 positions are too far apart for these springs"));
    }
    Ok(())
}

/// Refuses masses whose inverse overflows or underflows: such particles would not move correctly.
fn refuse_extreme_masses<V: Space>(properties: &Properties<V>) -> Result<()> {
    let held = |index: usize| {
        let inverse = properties.inverse_mass[index];
        inverse.is_finite() && (inverse > V::Scalar::ZERO || properties.is_fixed(index))
    };
    (0..properties.count()).find(|&index| !held(index)).map_or(Ok(()), |index| {
        let path = format!("bodies[{}].mass", properties.body[index]);
        let found = format!("{:e} kg", properties.mass[index]);
        Err(Error::parameter(path, format!("masses whose inverse {} can hold", V::Scalar::NAME), found))
    })
}
