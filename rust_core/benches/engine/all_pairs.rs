//! Benchmark of gravitation by direct summation: billion ordered pairs per second of wall-clock time. One step of velocity Verlet
//! is measured, including the energy budget. Run `cargo bench --bench all_pairs`, optionally with the number of threads.

use std::time::Instant;

use glam::DVec3;
use physcore_benches::CATALOG;
use physcore_engine::parallel::SERIAL;
use physcore_engine::scene::{Body, Item, Scene, Value};
use physcore_engine::simd::Level;
use physcore_engine::simulation::{Numerics, Simulation, Vigilance};

/// Number of repetitions of each measurement; the best counts.
const TURNS: usize = 5;

/// Stars at random positions in a cube, which attract each other.
fn cluster(count: usize) -> Scene {
    let mut state = 1_u64;
    let mut number = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / 9_007_199_254_740_992.0
    };
    let body = Body {
        positions: (0..count).map(|_| DVec3::new(number(), number(), number())).collect(),
        velocities: vec![DVec3::ZERO; count],
        mass: vec![1.0 / count as f64; count],
        charge: vec![0.0; count],
        radius: vec![0.0; count],
        fixed: vec![false; count],
        ..Body::default()
    };
    let law = Item::new("Gravitation", [("constant", Value::Number(1.0)), ("softening", Value::Number(0.01))]);
    let forces = vec![Item { path: "forces[0]".to_owned(), ..law }];
    Scene { dimension: 3, bodies: vec![body], forces, ..Scene::default() }
}

/// Measures steps of a cluster, and prints the rate.
fn measure(count: usize, precision: &str, threads: usize) {
    let numerics = Numerics {
        integrator: Item::new("VelocityVerlet", []),
        integrators: std::collections::BTreeMap::new(),
        precision: precision.to_owned(),
        threads: Some(threads),
        max_energy_growth: 1e6,
        vigilance: Vigilance::Active,
    };
    let mut simulation = Simulation::new(&cluster(count), &numerics, CATALOG, &SERIAL).expect("the scene is sound");
    simulation.step(1, 1e-4, &|| false).expect("nothing diverges");
    let pairs = (count * count) as f64;
    let steps = (1e9 / pairs).ceil();
    let best = (0..TURNS).map(|_| {
        let start = Instant::now();
        simulation.step(steps as u64, 1e-4, &|| false).expect("nothing diverges");
        start.elapsed().as_secs_f64() / steps
    });
    let best = best.fold(f64::INFINITY, f64::min);
    println!("{count:>6} {precision} {threads} threads {:>6.2} G pairs/s", 1e-9 * pairs / best);
}

fn main() {
    println!("all pairs, {:?}", Level::current());
    let threads = std::env::args().find_map(|argument| argument.parse().ok()).unwrap_or(1);
    for precision in ["f32", "f64"] {
        for count in [1024, 10_240, 30_720] {
            measure(count, precision, threads);
        }
    }
}
