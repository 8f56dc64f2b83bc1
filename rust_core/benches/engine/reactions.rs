//! Benchmark of Gray–Scott kinetics on a plane by Euler's method: million cells per second of CPU time. Budgets and divergence
//! monitor are included. Run `cargo bench --bench reactions`, optionally with the number of threads; wall-clock time is then
//! measured.

use std::time::Instant;

use glam::DVec3;
use physcore_benches::CATALOG;
use physcore_engine::parallel::SERIAL;
use physcore_engine::scene::{Array, Item, Scene, Value};
use physcore_engine::simd::Level;
use physcore_engine::simulation::{Numerics, Simulation, Vigilance};

/// Number of repetitions of each measurement; the best counts.
const TURNS: usize = 5;

/// Reaction–diffusion system with a feature in each row.
fn dish(cells: usize) -> Item {
    let all = |number: f64| Value::Vector(DVec3::new(number, number, 0.0));
    let record = |item: Item| Value::Record(Box::new(item));
    let numbers = |kind: &str, values: [(&'static str, f64); 2]| {
        record(Item::new(kind, values.map(|(name, number)| (name, Value::Number(number)))))
    };
    let field = |of: &dyn Fn(usize) -> f64| {
        Value::Numbers(Array { shape: vec![cells; 2], entries: (0..cells * cells).map(of).collect() })
    };
    let grid = [("cells", all(cells as f64)), ("spacing", Value::Number(1.0)), ("origin", all(0.0)), ("periodic", all(0.0))];
    let middle = |index: usize| ((index % cells) as f64 / cells as f64 - 0.5).abs() < 0.1;
    let initial = [("u", Value::Number(1.0)), ("v", field(&|index| if middle(index) { 0.3 } else { 0.0 }))];
    let values = [
        ("grid", record(Item::new("Grid", grid))),
        ("reaction", numbers("GrayScott", [("feed", 0.035), ("kill", 0.0625)])),
        ("diffusion", numbers("", [("u", 0.2), ("v", 0.1)])),
        ("initial", record(Item::new("", initial))),
        ("edges", Value::Texts(vec!["free".to_owned(); 4])),
    ];
    Item { path: "systems[0]".to_owned(), ..Item::new("ReactionDiffusion", values) }
}

/// CPU time of all threads of this process [s].
fn cpu_time() -> f64 {
    let tasks = std::fs::read_dir("/proc/self/task").expect("this benchmark runs on Linux");
    let time = |task: std::fs::DirEntry| {
        std::fs::read_to_string(task.path().join("schedstat")).ok()?.split(' ').next()?.parse::<f64>().ok()
    };
    1e-9 * tasks.flatten().filter_map(time).sum::<f64>()
}

/// Measures steps of a reaction–diffusion system, and prints the rate.
fn measure(cells: usize, integrator: &str, precision: &str, threads: usize, steps: u64) {
    let numerics = Numerics {
        integrator: integrator.into(),
        integrators: std::collections::BTreeMap::new(),
        precision: precision.to_owned(),
        threads: Some(threads),
        max_energy_growth: 1e6,
        vigilance: Vigilance::Active,
    };
    let scene = Scene { dimension: 2, systems: vec![dish(cells)], ..Scene::default() };
    let mut simulation = Simulation::new(&scene, &numerics, CATALOG, &SERIAL).expect("the scene is sound");
    simulation.step(steps, 0.6, &|| false).expect("nothing diverges");
    let best = (0..TURNS).map(|_| {
        let (start, busy) = (Instant::now(), cpu_time());
        simulation.step(steps, 0.6, &|| false).expect("nothing diverges");
        if threads == 1 { cpu_time() - busy } else { start.elapsed().as_secs_f64() }
    });
    let best = best.fold(f64::INFINITY, f64::min);
    let rate = 1e-6 * (cells * cells) as f64 * steps as f64 / best;
    println!(
        "{cells:>5}² {precision} {integrator:<19} {threads} threads {rate:>8.0} M cells/s {:>10.0} steps/s",
        steps as f64 / best
    );
}

fn main() {
    println!("Gray and Scott's reaction, {:?}", Level::current());
    let threads = std::env::args().find_map(|argument| argument.parse().ok()).unwrap_or(1);
    for precision in ["f32", "f64"] {
        for (cells, steps) in [(64, 20_000), (1024, 200), (4096, 32), (8192, 16)] {
            measure(cells, "ExplicitEuler", precision, threads, steps);
        }
        measure(1024, "RungeKutta4", precision, threads, 50);
        measure(1024, "RungeKuttaChebyshev", precision, threads, 50);
    }
}
