//! Benchmark of waves on a plane by velocity Verlet: million cells per second of CPU time. Energy budget and divergence monitor
//! are included. Run `cargo bench --bench waves`, optionally with the number of threads; wall-clock time is then measured.

use std::time::Instant;

use glam::DVec3;
use physcore_benches::CATALOG;
use physcore_engine::parallel::SERIAL;
use physcore_engine::scene::{Array, Item, Scene, Value};
use physcore_engine::simd::Level;
use physcore_engine::simulation::{Numerics, Simulation, Vigilance};

/// Number of repetitions of each measurement; the best counts.
const TURNS: usize = 5;

/// Plane with fixed edges; the initial mode has a kink.
fn plane(cells: usize, varying: bool) -> Item {
    let all = |number: f64| Value::Vector(DVec3::new(number, number, 0.0));
    let grid = Item::new(
        "Grid",
        [("cells", all(cells as f64)), ("spacing", Value::Number(1.0)), ("origin", all(0.0)), ("periodic", all(0.0))],
    );
    let numbers = [("damping", 0.0), ("rate", 0.0), ("density", 1.0), ("order", 2.0)];
    let field = |of: &dyn Fn(usize) -> f64| {
        Value::Numbers(Array { shape: vec![cells; 2], entries: (0..cells * cells).map(of).collect() })
    };
    let item = Item::new("Wave", numbers.map(|(name, number)| (name, Value::Number(number))));
    let mut item = Item { path: "systems[0]".to_owned(), ..item };
    let speed = if varying { field(&|index| 1.0 - 0.1 * ((index * 7919) % 101) as f64 / 101.0) } else { Value::Number(1.0) };
    item.values.insert("grid".to_owned(), Value::Record(Box::new(grid)));
    item.values.insert("speed".to_owned(), speed);
    item.values.insert("displacement".to_owned(), field(&|index| ((index % cells) as f64 / cells as f64 - 0.5).abs()));
    item.values.insert("edges".to_owned(), Value::Texts(vec!["fixed".to_owned(); 4]));
    item
}

/// CPU time of all threads of this process [s].
fn cpu_time() -> f64 {
    let tasks = std::fs::read_dir("/proc/self/task").expect("this benchmark runs on Linux");
    let time = |task: std::fs::DirEntry| {
        std::fs::read_to_string(task.path().join("schedstat")).ok()?.split(' ').next()?.parse::<f64>().ok()
    };
    1e-9 * tasks.flatten().filter_map(time).sum::<f64>()
}

/// Measures steps of a plane, and prints the results.
fn measure(cells: usize, precision: &str, varying: bool, threads: usize, steps: u64) {
    let numerics = Numerics {
        integrator: "VelocityVerlet".into(),
        integrators: std::collections::BTreeMap::new(),
        precision: precision.to_owned(),
        threads: Some(threads),
        max_energy_growth: 1e6,
        vigilance: Vigilance::Active,
    };
    let scene = Scene { dimension: 2, systems: vec![plane(cells, varying)], ..Scene::default() };
    let mut simulation = Simulation::new(&scene, &numerics, CATALOG, &SERIAL).expect("the scene is sound");
    simulation.step(steps, 0.6, &|| false).expect("nothing diverges");
    let best = (0..TURNS).map(|_| {
        let (start, busy) = (Instant::now(), cpu_time());
        simulation.step(steps, 0.6, &|| false).expect("nothing diverges");
        if threads == 1 { cpu_time() - busy } else { start.elapsed().as_secs_f64() }
    });
    let best = best.fold(f64::INFINITY, f64::min);
    let rate = 1e-6 * (cells * cells) as f64 * steps as f64 / best;
    let speed = if varying { "varying" } else { "uniform" };
    println!("{cells:>5}² {precision} {speed:<8} {threads} threads {rate:>8.0} M cells/s {:>10.0} steps/s", steps as f64 / best);
}

fn main() {
    println!("waves, {:?}", Level::current());
    let threads = std::env::args().find_map(|argument| argument.parse().ok()).unwrap_or(1);
    for precision in ["f32", "f64"] {
        for (cells, steps) in [(64, 40_000), (256, 4_000), (1024, 400), (4096, 32), (8192, 16)] {
            measure(cells, precision, false, threads, steps);
        }
        measure(1024, precision, true, threads, 400);
        measure(4096, precision, true, threads, 32);
    }
}
