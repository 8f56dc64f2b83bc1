//! Limits of the time step, divergence, and refusals.

use std::sync::Arc;

use super::scene::*;
use physcore_engine::error::{Divergence, Error};
use physcore_engine::integrators::{Integrator, with_integrator};
use physcore_engine::parallel::SERIAL;
use physcore_engine::scene::{Argument, Array, Callback, Failure, Item, Value};
use physcore_engine::simulation::Simulation;
use physcore_engine::stability::Horizon;

fn limit(simulation: &Simulation) -> f64 {
    simulation.limit(Horizon::Sharp, &SERIAL).unwrap().stability
}

/// Takes steps of a fraction of the limit.
fn run(item: &Item, integrator: &str, precision: &str, fraction: f64, steps: u64) -> Result<(), Error> {
    let mut simulation = simulation(item, integrator, precision, 1).unwrap();
    let dt = fraction * limit(&simulation);
    simulation.step(steps, dt, &|| false)
}

/// Every random field contains a checkerboard: just above the limit it grows by e^(√(2ε)·2) or more per step.
#[test]
fn the_limit_is_sharp_where_the_speed_is_uniform() {
    for edges in [["fixed"; 4], ["free"; 4], ["fixed", "free", "fixed", "fixed"], ["periodic"; 4]] {
        for (cells, order) in [([8, 9], 2.0), ([8, 9], 4.0), ([1, 6], 2.0)] {
            let item = with(wave(&cells, 0.3, &edges), "displacement", field(&cells, random));
            let item = with(item, "order", Value::Number(order));
            run(&item, "VelocityVerlet", "f64", 0.9999, 5_000).unwrap();
            let outcome = run(&item, "VelocityVerlet", "f64", 1.001, 20_000);
            assert!(matches!(outcome, Err(Error::Diverged(_))), "{edges:?} {cells:?} {order}: {outcome:?}");
        }
    }
}

#[test]
fn every_integrator_is_stable_up_to_its_limit() {
    let cells = [8, 9];
    let item = with(wave(&cells, 0.3, &FIXED), "displacement", field(&cells, random));
    with_integrator!(each I => {
        if I::limit(0.0) > 0.0 && !I::GYRATES {
            run(&item, I::NAME, "f64", 0.999, 2_000).unwrap();
            // Between a resonance and the last stable step there may be stable steps.
            let outcome = run(&item, I::NAME, "f64", 1.5 * I::last(0.0) / I::limit(0.0), 20_000);
            assert!(matches!(outcome, Err(Error::Diverged(_))), "{}: {outcome:?}", I::NAME);
        }
    });
}

/// Row sums bound the frequency from above.
#[test]
fn steps_within_the_bound_are_stable_where_speeds_and_dampings_vary() {
    let cells = [12, 13];
    for order in [2.0, 4.0] {
        let item = with(wave(&cells, 0.3, &FIXED), "displacement", field(&cells, random));
        let item = with(item, "speed", field(&cells, |at| 2.0 + random(at)));
        let item = with(with(item, "walls", mask(&cells, |[i, j, _]| i == 4 && j > 2)), "order", Value::Number(order));
        let damped = with(item.clone(), "damping", field(&cells, |[i, ..]| 5.0 * i as f64));
        for item in [item, damped] {
            for integrator in ["VelocityVerlet", "PEFRL", "RungeKutta4"] {
                run(&item, integrator, "f64", 0.999, 3_000).unwrap();
            }
        }
    }
}

/// c = 1, h = 0.5: the limit of a line is h/c, in the same unit as the other limits.
#[test]
fn a_line_reaches_the_courant_number_one() {
    let item = wave(&[400], 0.5, &["fixed", "fixed"]);
    assert!((limit(&simulation(&item, "VelocityVerlet", "f64", 1).unwrap()) - 0.5).abs() < 1e-15);
    assert_eq!(limit(&simulation(&item, "ExplicitEuler", "f64", 1).unwrap()), 0.0);
    let still = with(item, "speed", Value::Number(0.0));
    assert_eq!(limit(&simulation(&still, "VelocityVerlet", "f64", 1).unwrap()), f64::INFINITY);
}

#[test]
fn a_divergence_names_its_step_and_a_cell() {
    for precision in ["f32", "f64"] {
        let cells = [20, 30];
        let item = with(wave(&cells, 0.1, &FIXED), "displacement", field(&cells, random));
        let Err(Error::Diverged(divergence)) = run(&item, "VelocityVerlet", precision, 1.05, 100_000) else { panic!() };
        let Divergence { step, element, hint, .. } = *divergence;
        assert!(step > 10 && step < 1_000, "{step}");
        assert!(element.starts_with("cell (") && element.ends_with(") of systems[0]"), "{element}");
        assert!(hint.contains("set by wave"), "{hint}");
    }
}

fn refusal(item: &Item) -> String {
    simulation(item, "VelocityVerlet", "f64", 1).map(|_| ()).unwrap_err().to_string()
}

#[test]
fn what_does_not_fit_is_refused_with_its_path() {
    let item = || wave(&[4, 5], 0.1, &FIXED);
    let with_source = |source: Item| with(item(), "sources", Value::Records(vec![source]));
    let point = || source(Value::Vector(glam::DVec3::ZERO), 1.0, 1.0);
    let cases = [
        (with(item(), "speed", Value::Number(-1.0)), "systems[0].speed: expected numbers ≥ 0, got -1"),
        (with(item(), "rate", field(&[5, 4], random)), "systems[0].rate: expected an array of shape [4, 5]"),
        (with(item(), "rate", field(&[4, 5], |[i, ..]| 1.0 / i as f64)), "systems[0].rate at cell (0, 0): expected a finite"),
        (with(item(), "walls", mask(&[20], |_| true)), "systems[0].walls: expected an array of shape [4, 5]"),
        (with(item(), "order", Value::Number(3.0)), "systems[0].order: expected 2 or 4, got 3"),
        (with(item(), "density", Value::Number(0.0)), "systems[0].density: expected a number > 0, got 0"),
        (with(item(), "edges", Value::Texts(vec!["free".to_owned()])), "systems[0].edges: expected 4 times fixed or free"),
        (with(item(), "edges", Value::Texts(vec!["periodic".to_owned(); 4])), "systems[0].edges: expected periodic along"),
        (with_source(with(point(), "where", Value::Number(1.0))), "systems[0].sources[0].where: expected a point"),
        (with_source(with(point(), "stop", Value::Number(f64::NAN))), "systems[0].sources[0].stop: expected a number, got NaN"),
        (with_source(with(point(), "signal", Value::Number(1.0))), "systems[0].sources[0].signal: expected a Ricker"),
    ];
    for (item, expected) in cases {
        let found = refusal(&item);
        assert!(found.starts_with(expected), "{found}");
    }
    let outcome = simulation(&item(), "Leapfrog", "f64", 1).map(|_| ());
    assert_eq!(outcome.unwrap_err().to_string(), "integrator: expected the name of an integrator, got Leapfrog");
}

/// Callback that returns 1 up to a time, and then no number.
struct Until(f64);

impl Callback for Until {
    fn call(&self, arguments: &[Argument<'_>], what: &str, shape: &[usize]) -> Result<Vec<f64>, Failure> {
        let [Argument::Number(time)] = arguments else { panic!("{arguments:?}") };
        assert_eq!((what, shape), ("a number", &[][..]));
        if *time < self.0 {
            return Ok(vec![1.0]);
        }
        Err(Failure::Refused { expected: what.to_owned(), found: "None".to_owned(), hint: String::new() })
    }
}

#[test]
fn a_signal_of_the_users_drives_a_source_until_it_fails() {
    let place = Value::Flags(Array { shape: vec![4], entries: vec![true; 4] });
    let driven = with(source(place, 2.0, 0.0), "signal", Value::Callback(Arc::new(Until(0.55))));
    let item = with(wave(&[4], 0.5, &["free", "free"]), "sources", Value::Records(vec![driven]));
    let mut simulation = simulation(&item, "VelocityVerlet", "f64", 1).unwrap();
    let refused = simulation.step(10, 0.1, &|| false).unwrap_err().to_string();
    assert_eq!(refused, "systems[0].sources[0].signal: expected a number, got None");
    assert_eq!(simulation.steps(), 5);
    // Uniform field under s = 2.
    assert!(distance(&fields(&simulation)[0], &[0.25; 4]) < 1e-15);
}
