//! What the precision of a run cannot hold, and is refused: no number of the scene becomes infinite or nothing on the way.

use glam::DVec3;

use crate::error::{Error, Result};
use crate::math::{Real, Vector};
use crate::matter::Properties;
use crate::scene::{Scene, Spring, Value};

/// f32 is refused where the distance between neighboring positions exceeds this fraction of a rest length.
const COARSEST: f64 = 1e-4;

/// Refuses what the precision cannot hold.
pub fn check<V: Vector>(scene: &Scene, springs: &[Spring], properties: &Properties<V>) -> Result<()> {
    refuse_large::<V::Scalar>(scene, properties.origin)?;
    refuse_coarse::<V::Scalar>(scene, springs, properties.origin)?;
    refuse_extreme_masses(properties)
}

/// Refuses numbers that the precision makes infinite.
fn refuse_large<T: Real>(scene: &Scene, origin: DVec3) -> Result<()> {
    let holds = |path: &dyn Fn() -> String, given: f64, kept: f64| {
        let error = || Error::parameter(path(), format!("a number in the range of {}", T::NAME), format!("{given:e}"));
        if T::from_f64(kept).is_finite() { Ok(()) } else { Err(error().with_hint("precision=\"f64\" holds it")) }
    };
    let check = |path: &dyn Fn() -> String, value: f64| holds(path, value, value);
    let check_vector =
        |path: &dyn Fn() -> String, vector: DVec3| vector.to_array().into_iter().try_for_each(|value| check(path, value));
    for (index, body) in scene.bodies.iter().enumerate() {
        let path = |name: &'static str| move || format!("bodies[{index}].{name}");
        for spring in &body.springs {
            check(&path("stiffness"), spring.stiffness)?;
            check(&path("damping"), spring.damping)?;
            check(&path("rest_length"), spring.rest_length)?;
        }
        for (given, kept) in body.positions.iter().flat_map(|&at| at.to_array().into_iter().zip((at - origin).to_array())) {
            holds(&path("positions"), given, kept)?;
        }
        body.velocities.iter().try_for_each(|&velocity| check_vector(&path("velocities"), velocity))?;
        body.radius.iter().try_for_each(|&radius| check(&path("radius"), radius))?;
        if let Some(fluid) = &body.fluid {
            check(&path("density"), fluid.density)?;
            check(&path("viscosity"), fluid.viscosity)?;
            check(&path("sound_speed"), fluid.sound_speed.unwrap_or(0.0))?;
            check(&path("surface_tension"), fluid.surface_tension)?;
        }
    }
    for term in &scene.forces {
        for (name, value) in &term.values {
            let path = || format!("{}.{name}", term.path);
            match *value {
                Value::Number(number) => check(&path, number)?,
                Value::Vector(vector) => check_vector(&path, vector)?,
                Value::Flag(_) | Value::Callback(_) => {}
            }
        }
    }
    Ok(())
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

/// Refuses masses whose inverse is infinite, or nothing: they would not move at all.
fn refuse_extreme_masses<V: Vector>(properties: &Properties<V>) -> Result<()> {
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
