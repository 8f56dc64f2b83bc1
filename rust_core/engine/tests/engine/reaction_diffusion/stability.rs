//! Limit of the step, and divergence.

use super::scene::*;
use physcore_engine::error::Error;
use physcore_engine::integrators::first_order::NAMES;
use physcore_engine::parallel::SERIAL;
use physcore_engine::scene::{Item, Value};
use physcore_engine::stability::Horizon;

/// Checkerboard without reactions, the fastest mode of two fixed edges.
fn checkerboard() -> Item {
    let cells = [10, 14];
    let sign = |index: usize| if (index / 14 + index % 14).is_multiple_of(2) { 1.0 } else { -1.0 };
    dish(&cells, &["fixed"; 4], inert(), [("u", 0.3, field(&cells, sign)), ("v", 0.1, Value::Number(0.0))])
}

fn limit(item: &Item, method: &str) -> physcore_engine::stability::Limit {
    simulation(item, method, "f64", 1).unwrap().limit(Horizon::Sharp, &SERIAL).unwrap()
}

/// λ = 8 D/h². Without feed and with v = 0 the Gray–Scott reaction has no rates, and the limit is exact.
#[test]
fn the_limit_is_that_of_the_fastest_mode() {
    for (name, interval) in [
        ("ExplicitEuler", 2.0),
        ("BogackiShampine3", 2.512_745_326_618_329),
        ("RungeKutta4", 2.785_293_563_405_282),
        ("DormandPrince5", 3.306_567_892_634_947),
    ] {
        let found = limit(&checkerboard(), name);
        assert!((found.stability * 8.0 * 0.3 / interval - 1.0).abs() < 1e-12, "{name}: {found:?}");
        assert_eq!(found.term, "diffusion of u");
    }
}

#[test]
fn steps_are_stable_just_below_the_limit_and_grow_just_above() {
    for name in NAMES {
        let limit = limit(&checkerboard(), name).stability;
        let largest = |fraction: f64| {
            let mut simulation = simulation(&checkerboard(), name, "f64", 1).unwrap();
            let diverged =
                simulation.step(if name == "RungeKuttaChebyshev" { 40 } else { 200 }, fraction * limit, &|| false).is_err();
            let values = values(&simulation, "u").into_iter().map(f64::abs);
            if diverged { f64::INFINITY } else { values.fold(0.0, f64::max) }
        };
        assert!(largest(0.999) <= 1.0, "{name}");
        assert!(largest(1.004) > 1.5, "{name}");
    }
}

/// Long steps of the stabilized method are stable with a reaction too, at a step a hundred times Euler's limit.
#[test]
fn stages_are_chosen_by_the_step() {
    let cells = [64];
    let species = [("u", 40.0, field(&cells, random)), ("v", 20.0, field(&cells, |index| 0.3 * random(index + 99)))];
    let item = dish(&cells, &["free"; 2], gray_scott(), species);
    let euler = limit(&item, "ExplicitEuler").stability;
    let stabilized = limit(&item, "RungeKuttaChebyshev").stability;
    assert!(stabilized > 100.0 * euler, "{stabilized} {euler}");
    let exact = values(&after(&item, "RungeKutta4", 40_000, 0.0125), "u");
    let found = values(&after(&item, "RungeKuttaChebyshev", 250, 2.0), "u");
    assert!(distance(&found, &exact) < 1e-3, "{}", distance(&found, &exact));
}

/// A step above the limit is detected long before the state overflows, at the same step for any batches.
#[test]
fn a_divergence_is_noticed_in_time() {
    let item = noisy(&[40, 40], &["free"; 4], gray_scott());
    let run = |batches: &[u64], threads: usize| {
        let mut simulation = simulation(&item, "RungeKutta4", "f64", threads).unwrap();
        let error = batches.iter().find_map(|&steps| simulation.step(steps, 1.9, &|| false).err());
        let Some(Error::Diverged(divergence)) = error else { panic!("{error:?}") };
        let largest = values(&simulation, "u").into_iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        assert!(largest.is_finite() && largest < 1e7, "{largest:e}");
        (divergence.step, simulation.state_hash())
    };
    let expected = run(&[4000], 1);
    assert_eq!(run(&vec![1; 4000], 1), expected);
    assert_eq!(run(&[7, 31, 4000], 2), expected);
}

/// Growth that steps resolve is no divergence, from any small value: here by 1e9.
#[test]
fn resolved_growth_is_none() {
    let item = dish(
        &[16],
        &["free"; 2],
        reaction(["u", "v"], |u, v| [u * (1.0 - u), -v]),
        [("u", 0.1, Value::Number(1e-9)), ("v", 0.1, Value::Number(1e-9))],
    );
    let end = after(&item, "RungeKutta4", 3000, 0.01);
    assert!(values(&end, "u").iter().all(|u| (u - 1.0).abs() < 1e-3));
}

/// A reaction limits the step where diffusion is slow.
#[test]
fn fast_reactions_limit_the_step() {
    let species = [("u", 0.0, Value::Number(2.0)), ("v", 0.0, Value::Number(2.0))];
    let item = dish(&[8], &["free"; 2], numbers("Brusselator", &[("a", 2.0), ("b", 4.0)]), species);
    let found = limit(&item, "ExplicitEuler");
    // J = [[3, 4], [−4, −4]]: the norms are 8 and 8, the eigenvalues −½ ± 1.9 i.
    assert_eq!((found.stability, found.term), (0.25, "reaction"));
    let own = reaction(["u", "v"], |u, v| [2.0 - 5.0 * u + u * u * v, 4.0 * u - u * u * v]);
    let species = [("u", 0.0, Value::Number(2.0)), ("v", 0.0, Value::Number(2.0))];
    let by_differences = limit(&dish(&[8], &["free"; 2], own, species), "ExplicitEuler").stability;
    assert!((by_differences / 0.25 - 1.0).abs() < 1e-5, "{by_differences}");
}
