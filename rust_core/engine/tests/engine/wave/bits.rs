//! Bits of the result: independent of the number of threads, of batches, and of checkpoints.

use glam::DVec3;

use super::scene::*;
use physcore_engine::integrators::{Integrator, with_integrator};
use physcore_engine::scene::{Item, Value};

/// Plane wide enough for several blocks, with all options of a wave.
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

#[test]
fn every_integrator_goes_on_from_a_checkpoint() {
    let cells = [7, 19];
    let item = with(wave(&cells, 0.1, &FIXED), "damping", field(&cells, |[i, ..]| f64::from(u8::from(i > 3))));
    let item = with(item, "displacement", field(&cells, random));
    let source = source(Value::Vector(DVec3::new(0.3, 1.0, 0.0)), 0.1, 2.0);
    let item = with(item, "sources", Value::Records(vec![source]));
    with_integrator!(each I => if !I::GYRATES {
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
