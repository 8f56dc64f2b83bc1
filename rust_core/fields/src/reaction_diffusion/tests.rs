//! Tests of reaction–diffusion systems: passes of several stages. Other tests are in `engine/tests/`.

use crate::history::{Archive, History};
use crate::integrators::first_order::{FirstOrder, NAMES};
use crate::parallel::{Executor, ThreadPool};
use crate::reaction_diffusion::ReactionDiffusion;
use crate::scene::Item;
use crate::scenes::reaction_diffusion::*;
use crate::systems::{Interval, RecordedSteps, System};

/// Steps of a run: more than one pass of the most stages.
const STEPS: u64 = 9;

/// Runs a method in passes of `depth` stages; returns the state with the tallies, and the activity.
fn passes(item: &Item, method: &str, depth: Option<usize>, threads: usize) -> (Archive, Vec<f64>) {
    let mut system = ReactionDiffusion::<f64>::new(item, FirstOrder::named(method).unwrap()).unwrap();
    if let Some(depth) = depth {
        (system.depth, system.workspace.activity) = (depth, vec![0.0; depth * system.law.grid.rows()]);
    }
    let interval = Interval { start: 0.0, first: 0, h: 0.9, steps: STEPS };
    let advance = |executor: &Executor| system.advance(interval, RecordedSteps::EveryStep, executor).unwrap();
    ThreadPool::new(threads).run(&|| false, advance).unwrap();
    let mut archive = Archive::default();
    system.capture(&mut archive);
    (archive, system.activity().to_vec())
}

/// Each method takes every second pair of depth and threads.
#[test]
fn passes_of_several_stages_change_no_bit() {
    let pairs = [(None, 1), (None, 2), (Some(7), 1), (Some(7), 3), (Some(2), 8), (Some(1), 2)];
    let flat = noisy(&[150, 13], &["fixed", "free", "periodic", "periodic"], gray_scott());
    let solid = noisy(&[130, 4, 5], &["free", "fixed", "periodic", "periodic", "free", "fixed"], gray_scott());
    for item in [flat, solid] {
        for (number, method) in NAMES.into_iter().enumerate() {
            let expected = passes(&item, method, Some(1), 1);
            assert_eq!(expected.1.len() as u64, STEPS);
            for (depth, threads) in pairs.into_iter().skip(number % 2).step_by(2) {
                assert_eq!(passes(&item, method, depth, threads), expected, "{method} {depth:?} {threads}");
            }
        }
    }
}
