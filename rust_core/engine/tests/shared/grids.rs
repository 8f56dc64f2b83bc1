//! Simulations of one system on a grid.

use glam::DVec3;
use physcore_engine::error::Result;
use physcore_engine::parallel::SERIAL;
use physcore_engine::scene::{Item, Scene, Value};
use physcore_engine::simulation::{Numerics, Simulation, Vigilance};

/// A grid of up to three axes with its lower corner in the origin, periodic along the axes whose edges say so.
pub fn grid(cells: &[usize], spacing: f64, edges: &[&str]) -> Item {
    let vector = |of: &dyn Fn(usize) -> f64| {
        let mut entries = [0.0; 3];
        (0..cells.len()).for_each(|axis| entries[axis] = of(axis));
        Value::Vector(DVec3::from_array(entries))
    };
    Item::new(
        "Grid",
        [
            ("cells", vector(&|axis| cells[axis] as f64)),
            ("spacing", Value::Number(spacing)),
            ("origin", vector(&|_| 0.0)),
            ("periodic", vector(&|axis| f64::from(u8::from(edges[2 * axis] == "periodic")))),
        ],
    )
}

/// The conditions on the edges of a system, two along each axis.
pub fn on_edges(words: &[&str]) -> Value {
    Value::Texts(words.iter().map(|&word| word.to_owned()).collect())
}

/// A simulation of a system alone.
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
    Simulation::new(&Scene { dimension, systems: vec![item.clone()], ..Scene::default() }, &numerics, &SERIAL)
}

/// That in double precision on one thread, after `steps` of `dt` seconds.
pub fn after(item: &Item, integrator: &str, steps: u64, dt: f64) -> Simulation {
    let mut simulation = simulation(item, integrator, "f64", 1).unwrap();
    simulation.step(steps, dt, &|| false).unwrap();
    simulation
}

/// The largest |a − b|.
pub fn distance(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).map(|(one, other)| (one - other).abs()).fold(0.0, f64::max)
}
