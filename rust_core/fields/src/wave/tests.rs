//! Tests of waves: passes of several stages, and the force as the gradient of the energy. Other tests are in `engine/tests/`.

use glam::DVec3;

use crate::grid::Window;
use crate::history::{Archive, History};
use crate::integrators::{Integrator, Pefrl, RungeKutta4, VelocityVerlet};
use crate::parallel::{Executor, SERIAL, ThreadPool};
use crate::scene::{Item, Value};
use crate::scenes::wave::*;
use crate::systems::{Interval, RecordedSteps, System};
use crate::wave::Wave;

/// Runs 21 steps of an integrator in passes of `depth` stages on `threads` threads; returns the state with the tallies, and the activity.
fn passes<I: Integrator>(item: &Item, depth: Option<usize>, threads: usize) -> (Archive, Vec<f64>) {
    let mut wave = Wave::<f64>::new::<I>(item).unwrap();
    if let Some(depth) = depth {
        let rows = wave.dynamics.medium.laplacian.grid.rows();
        (wave.depth, wave.workspace.kinetic) = (depth, vec![0.0; depth * rows]);
    }
    wave.begin(0.0, &SERIAL).unwrap();
    let interval = Interval { start: 0.0, first: 0, h: 0.02, steps: 21 };
    let advance = |executor: &Executor| wave.advance(interval, RecordedSteps::EveryStep, executor).unwrap();
    ThreadPool::new(threads).run(&|| false, advance).unwrap();
    let mut archive = Archive::default();
    wave.capture(&mut archive);
    (archive, wave.activity().to_vec())
}

/// Covers passes of several stages over slabs, on one thread and on several with seams between their bands.
#[test]
fn passes_of_several_stages_change_no_bit() {
    let (flat, solid) = ([150, 9], [130, 4, 5]);
    let plane =
        with(wave(&flat, 0.1, &["fixed", "free", "periodic", "periodic"]), "damping", field(&flat, |at| random(at).abs()));
    let place = Value::Vector(DVec3::new(3.0, 0.4, 0.0));
    let plane = with(plane, "sources", Value::Records(vec![source(place, 5.0, 2.0)]));
    let solid = (wave(&solid, 0.1, &["free", "fixed", "periodic", "periodic", "free", "fixed"]), field(&solid, random));
    for item in [with(plane, "displacement", field(&flat, random)), with(solid.0, "displacement", solid.1)] {
        let expected = passes::<VelocityVerlet>(&item, Some(1), 1);
        for (depth, threads) in [(None, 1), (None, 2), (Some(7), 1), (Some(7), 3), (Some(2), 8)] {
            assert_eq!(passes::<VelocityVerlet>(&item, depth, threads), expected, "{depth:?} {threads}");
        }
        assert_eq!(passes::<RungeKutta4>(&item, None, 2), passes::<RungeKutta4>(&item, Some(1), 1));
        assert_eq!(passes::<Pefrl>(&item, Some(5), 3), passes::<Pefrl>(&item, Some(1), 1));
    }
}

/// Energy gradient: E is quadratic, so E(u + d) − E(u − d) = 2 d·∇E exactly, and −∇E = ρ h^D L u, the mass of a cell times
/// its acceleration.
#[test]
fn the_force_is_minus_the_gradient_of_the_energy() {
    let mut cases = Vec::new();
    for edges in [["fixed", "free", "free", "fixed"], ["periodic", "periodic", "fixed", "fixed"], ["free"; 4]] {
        cases.extend(variants(PLANE, &edges, random));
    }
    for order in [2.0, 4.0] {
        let line = with(wave(&[9], 0.1, &["fixed", "free"]), "displacement", field(&[9], random));
        let solid = wave(&[5, 6, 7], 0.1, &["fixed", "free", "periodic", "periodic", "fixed", "fixed"]);
        let solid = with(with(solid, "displacement", field(&[5, 6, 7], random)), "speed", field(&[5, 6, 7], speed));
        cases.extend([line, solid].map(|item| with(item, "order", Value::Number(order))));
        cases.push(with(wave(&[1, 1], 0.1, &FIXED), "displacement", Value::Number(0.3)));
    }
    let dense = |item: &Item| with(item.clone(), "density", field(&PLANE, |at| 1.0 + random(at).abs()));
    cases.extend(variants(PLANE, &FIXED, random).iter().map(dense));
    for item in &cases {
        let mut wave = Wave::<f64>::new::<VelocityVerlet>(item).unwrap();
        let (length, rows) = (wave.dynamics.medium.laplacian.grid.row_length(), wave.dynamics.medium.laplacian.grid.rows());
        let base = wave.state.displacement.clone();
        let is_wall = |index: usize| wave.walls.as_ref().is_some_and(|walls| walls[index]);
        let direction: Vec<f64> = (0..base.len()).map(|index| if is_wall(index) { 0.0 } else { random([index, 7, 7]) }).collect();
        let mut energy = |sign: f64| {
            let moved = base.iter().zip(&direction).map(|(u, d)| u + sign * d);
            wave.state.displacement = moved.collect();
            wave.dynamics.energies(&wave.state, &SERIAL).iter().map(|row| row.potential).sum::<f64>()
        };
        let risen = energy(1.0) - energy(-1.0);
        let (mut out, mut scratch) = (vec![0.0; length], vec![0.0; 4 * length]);
        let mut work = 0.0;
        let window = Window::new(&base, length);
        for row in 0..rows {
            wave.dynamics.accelerate(window, row, 0..length, &mut out, &mut scratch);
            let density = |column: usize| wave.dynamics.medium.relative_density(row, column);
            let work_of = |(column, (a, d)): (usize, (&f64, &f64))| density(column) * a * d;
            work += out.iter().zip(&direction[row * length..]).enumerate().map(work_of).sum::<f64>();
        }
        assert!((risen + 2.0 * work).abs() < 1e-12 * risen.abs().max(1.0), "{risen} {work}");
    }
}
