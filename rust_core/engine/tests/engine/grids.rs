//! Simulations of one system on a grid.

use physcore_engine::error::Result;
use physcore_engine::parallel::SERIAL;
use physcore_engine::scene::{Item, Scene, Value};
use physcore_engine::simulation::{Numerics, Simulation, Vigilance};

use crate::CATALOG;

/// Simulation of a system alone.
pub fn simulation(item: &Item, integrator: &str, precision: &str, threads: usize) -> Result<Simulation> {
    let dimension = match &item.values["edges"] {
        Value::Texts(edges) => edges.len() / 2,
        _ => 2,
    };
    let numerics = Numerics {
        integrator: integrator.into(),
        integrators: std::collections::BTreeMap::new(),
        precision: precision.to_owned(),
        threads: Some(threads),
        max_energy_growth: 1e6,
        vigilance: Vigilance::Active,
    };
    Simulation::new(&Scene { dimension, systems: vec![item.clone()], ..Scene::default() }, &numerics, CATALOG, &SERIAL)
}

/// Simulation in double precision on one thread, after `steps` of `dt` seconds.
pub fn after(item: &Item, integrator: &str, steps: u64, dt: f64) -> Simulation {
    let mut simulation = simulation(item, integrator, "f64", 1).unwrap();
    simulation.step(steps, dt, &|| false).unwrap();
    simulation
}

/// Largest |a − b|.
pub fn distance(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).map(|(one, other)| (one - other).abs()).fold(0.0, f64::max)
}
