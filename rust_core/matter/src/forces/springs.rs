//! Springs and rods as scenes declare them.

use std::ops::Range;

use crate::error::{Error, Result};
use crate::scene::{Array, Body, Item, Scene, Value};

/// Name of the force in plans and energy budgets.
pub const NAME: &str = "springs";
/// Kind of the bodies whose particles are connected by springs.
pub const KIND: &str = "SpringNetwork";

/// A damped spring between two particles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spring {
    /// Particle indices of the two ends.
    pub ends: [u32; 2],
    /// Stiffness k [N/m].
    pub stiffness: f64,
    /// Damping c along the spring [N·s/m].
    pub damping: f64,
    /// Rest length L [m].
    pub rest_length: f64,
}

impl Spring {
    /// Item of a body with these springs, whose ends are indices within the body.
    pub fn network(springs: &[Self]) -> Item {
        let column = |of: fn(&Self) -> f64| Value::Numbers(springs.iter().map(of).collect::<Vec<f64>>().into());
        let ends = springs.iter().flat_map(|spring| spring.ends).collect();
        let values = [
            ("pairs", Value::Indices(Array { shape: vec![springs.len(), 2], entries: ends })),
            ("stiffness", column(|spring| spring.stiffness)),
            ("damping", column(|spring| spring.damping)),
            ("rest_length", column(|spring| spring.rest_length)),
        ];
        Item::new(KIND, values)
    }
}

/// Whether a spring exerts a force, which excludes rods and broken springs.
pub fn is_elastic(spring: &Spring) -> bool {
    spring.stiffness.is_finite() && (spring.stiffness > 0.0 || spring.damping > 0.0)
}

/// Number of springs in a scene.
///
/// # Errors
/// If a network lacks the pairs of particles.
pub fn count(scene: &Scene) -> Result<usize> {
    let networks = scene.bodies.iter().filter(|body| body.item.kind == KIND);
    networks.map(|body| body.item.tuples::<2>("pairs").map(<[_]>::len)).sum()
}

/// Springs of all bodies, with indices into the whole scene.
///
/// # Errors
/// If a network lacks a parameter of its springs, or a spring connects a particle that does not exist.
pub fn declared(scene: &Scene) -> Result<Vec<Spring>> {
    let mut springs = Vec::with_capacity(count(scene)?);
    let mut first = 0;
    for body in &scene.bodies {
        let count = body.positions.len();
        if body.item.kind == KIND {
            add_network(&body.item, first..first + count as u32, &mut springs)?;
        }
        first += count as u32;
    }
    Ok(springs)
}

/// Values of a strain parameter for every spring, in the order of [`declared`]; infinite if a network lacks the parameter.
///
/// # Errors
/// If a network does not give a number ≥ 0 for each of its springs.
pub fn strains(scene: &Scene, name: &str) -> Result<Vec<f64>> {
    let mut all = Vec::with_capacity(count(scene)?);
    for Body { item, .. } in scene.bodies.iter().filter(|body| body.item.kind == KIND) {
        let count = item.tuples::<2>("pairs")?.len();
        if !item.values.contains_key(name) {
            all.resize(all.len() + count, f64::INFINITY);
            continue;
        }
        let strains = item.numbers(name, count)?;
        if let Some(index) = strains.iter().position(|strain| strain.is_nan() || *strain < 0.0) {
            let path = format!("{}.{name}[{index}]", item.path);
            return Err(Error::parameter(path, "a number ≥ 0", format!("{:?}", Value::Number(strains[index]))));
        }
        all.extend(strains);
    }
    Ok(all)
}

/// Appends the springs of a network between these particles.
fn add_network(item: &Item, particles: Range<u32>, springs: &mut Vec<Spring>) -> Result<()> {
    let pairs = item.tuples::<2>("pairs")?;
    let numbers = |name: &str| item.numbers(name, pairs.len());
    let (stiffness, damping, rest_length) = (numbers("stiffness")?, numbers("damping")?, numbers("rest_length")?);
    if let Some(index) = pairs.iter().position(|ends| ends.iter().any(|&end| end as usize >= particles.len())) {
        let path = format!("{}.pairs[{index}]", item.path);
        return Err(Error::parameter(path, format!("two of {} particles", particles.len()), format!("{:?}", pairs[index])));
    }
    springs.extend(pairs.iter().enumerate().map(|(index, ends)| Spring {
        ends: ends.map(|end| end + particles.start),
        stiffness: stiffness[index],
        damping: damping[index],
        rest_length: rest_length[index],
    }));
    Ok(())
}
