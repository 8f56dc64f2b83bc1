//! Benchmark of tracers in Lorenz's flow: million point-steps per second of CPU time on one thread, including the divergence
//! monitor. Run `cargo bench --bench tracers`.

use std::time::Instant;

use physcore_benches::CATALOG;
use physcore_engine::parallel::SERIAL;
use physcore_engine::scene::{Array, Item, Scene, Value};
use physcore_engine::simd::Level;
use physcore_engine::simulation::{Numerics, Simulation, Vigilance};

/// Number of repetitions of each measurement; the best counts.
const TURNS: usize = 5;

/// Cloud of tracers around the attractor.
fn cloud(count: usize) -> Item {
    let place = |index: usize| ((index * 7919 % 10_007) as f64 / 10_007.0 - 0.5) + if index % 3 == 2 { 25.0 } else { 0.0 };
    let positions = Array { shape: vec![count, 3], entries: (0..3 * count).map(place).collect() };
    let parameters = [("sigma", 10.0), ("rho", 28.0), ("beta", 8.0 / 3.0)].map(|(name, number)| (name, Value::Number(number)));
    let flow = Value::Record(Box::new(Item::new("Lorenz", parameters)));
    Item { path: "systems[0]".to_owned(), ..Item::new("Tracers", [("positions", Value::Numbers(positions)), ("flow", flow)]) }
}

/// Measures steps, and prints the rate.
fn measure(count: usize, integrator: &str, precision: &str, steps: u64) {
    let numerics = Numerics {
        integrator: integrator.into(),
        integrators: std::collections::BTreeMap::new(),
        precision: precision.to_owned(),
        threads: Some(1),
        max_energy_growth: 1e6,
        vigilance: Vigilance::Active,
    };
    let scene = Scene { dimension: 3, systems: vec![cloud(count)], ..Scene::default() };
    let mut simulation = Simulation::new(&scene, &numerics, CATALOG, &SERIAL).expect("the scene is sound");
    simulation.step(steps, 0.002, &|| false).expect("nothing diverges");
    let best = (0..TURNS).map(|_| {
        let start = Instant::now();
        simulation.step(steps, 0.002, &|| false).expect("nothing diverges");
        start.elapsed().as_secs_f64()
    });
    let rate = 1e-6 * count as f64 * steps as f64 / best.fold(f64::INFINITY, f64::min);
    println!("{count:>8} {precision} {integrator:<19} {rate:>8.0} M point-steps/s");
}

fn main() {
    println!("Tracers in Lorenz' flow, {:?}", Level::current());
    for precision in ["f32", "f64"] {
        for integrator in ["RungeKutta4", "DormandPrince5", "ExplicitEuler"] {
            measure(1_000_000, integrator, precision, 200);
        }
        measure(10_000, "RungeKutta4", precision, 20_000);
        measure(100, "RungeKutta4", precision, 1_000_000);
    }
}
