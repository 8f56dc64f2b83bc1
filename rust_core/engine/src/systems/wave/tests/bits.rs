//! The same bits for any number of threads, any batches, and from checkpoints.

use glam::DVec3;

use super::scene::*;
use crate::history::{Archive, History};
use crate::integrators::{Integrator, Pefrl, RungeKutta4, VelocityVerlet, with_integrator};
use crate::parallel::{Executor, SERIAL, ThreadPool};
use crate::scene::{Item, Value};
use crate::systems::wave::Wave;
use crate::systems::{Interval, Record, System};

/// A plane that is wide enough for several blocks, with all that a wave can have.
fn plane(order: f64) -> Item {
    let cells = [320, 1100];
    let item =
        with(wave(&cells, 0.1, &["fixed", "free", "periodic", "periodic"]), "speed", field(&cells, |at| 1.0 + 0.3 * random(at)));
    let item = with(item, "walls", mask(&cells, |[i, j, _]| i == 40 && j % 100 > 20));
    let item = with(item, "damping", field(&cells, |[i, ..]| f64::from(u8::from(i > 60))));
    let item = with(item, "displacement", field(&cells, random));
    let source = source(Value::Vector(DVec3::new(3.0, 50.0, 0.0)), 5.0, 2.0);
    with(with(item, "sources", Value::Records(vec![source])), "order", Value::Number(order))
}

#[test]
fn threads_and_batches_change_no_bit() {
    for (precision, order) in [("f32", 2.0), ("f64", 4.0)] {
        let item = plane(order);
        let run = |threads: usize, batches: &[u64]| {
            let mut simulation = simulation(&item, "VelocityVerlet", precision, threads).unwrap();
            batches.iter().for_each(|&steps| simulation.step(steps, 0.03, &|| false).unwrap());
            (simulation.state_hash(), energy(&simulation))
        };
        let expected = run(1, &[12]);
        assert_eq!(run(2, &[1, 4, 7]), expected, "{precision}");
    }
}

/// What an integrator makes of a wave in 21 steps, in passes of that many stages, on these threads: the state and the activity.
fn passes<I: Integrator>(item: &Item, depth: Option<usize>, threads: usize) -> (Vec<f64>, Vec<f64>) {
    let mut wave = Wave::<f64, I>::new(item).unwrap();
    if let Some(depth) = depth {
        let rows = wave.dynamics.medium.laplacian.grid.rows();
        (wave.depth, wave.workspace.kinetic) = (depth, vec![0.0; depth * rows]);
    }
    wave.begin(0.0, &SERIAL).unwrap();
    let interval = Interval { start: 0.0, first: 0, h: 0.02, steps: 21 };
    let advance = |executor: &Executor| wave.advance(interval, Record::EveryStep, executor).unwrap();
    ThreadPool::new(threads).run(&|| false, advance).unwrap();
    let mut archive = Archive::default();
    wave.capture(&mut archive);
    archive.write(wave.tallies());
    (archive.into_numbers(), wave.activity().to_vec())
}

/// Passes of several stages over slabs, on one thread, and on several with seams between their bands.
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

#[test]
fn every_integrator_goes_on_from_a_checkpoint() {
    let cells = [7, 19];
    let item = with(wave(&cells, 0.1, &FIXED), "damping", field(&cells, |[i, ..]| f64::from(u8::from(i > 3))));
    let item = with(item, "displacement", field(&cells, random));
    let source = source(Value::Vector(DVec3::new(0.3, 1.0, 0.0)), 0.1, 2.0);
    let item = with(item, "sources", Value::Records(vec![source]));
    with_integrator!(each I => {
        let mut whole = simulation(&item, I::NAME, "f32", 1).unwrap();
        whole.step(5, 0.01, &|| false).unwrap();
        let checkpoint = whole.capture();
        whole.step(6, 0.01, &|| false).unwrap();
        let mut again = simulation(&item, I::NAME, "f32", 1).unwrap();
        again.restore(&checkpoint).unwrap();
        for _ in 0..6 {
            again.step(1, 0.01, &|| false).unwrap();
        }
        assert_eq!(again.state_hash(), whole.state_hash(), "{}", I::NAME);
        assert_eq!(energy(&again), energy(&whole), "{}", I::NAME);
    });
}
