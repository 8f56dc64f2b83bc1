//! Budgets of species.

use super::scene::*;
use physcore_engine::integrators::first_order::NAMES;
use physcore_engine::parallel::SERIAL;
use physcore_engine::scene::Value;

/// stored + removed − supplied is constant, up to roundings of the sums in double precision, and of values in single
/// precision.
#[test]
fn amounts_change_by_what_reacts_and_what_passes_the_edges() {
    for (cells, edges) in [
        (vec![40], vec!["fixed", "free"]),
        (vec![33, 20], vec!["free", "fixed", "fixed", "free"]),
        (vec![6, 7, 19], vec!["periodic", "periodic", "fixed", "fixed", "free", "fixed"]),
    ] {
        let item = noisy(&cells, &edges, gray_scott());
        for name in NAMES {
            for (precision, bound) in [("f64", 1e-13), ("f32", 2e-5)] {
                let mut simulation = simulation(&item, name, precision, 1).unwrap();
                let before = budgets(&simulation);
                simulation.step(150, 0.4, &|| false).unwrap();
                for (before, after) in before.iter().zip(budgets(&simulation)) {
                    let sum = |parts: &[(&str, f64)]| parts.iter().map(|&(_, amount)| amount).sum::<f64>();
                    let drift = (after.stored + sum(&after.removed) - sum(&after.supplied)) / before.stored - 1.0;
                    assert!(drift.abs() < bound, "{name} {precision} {cells:?} {}: {drift:e}", after.name);
                    assert!(sum(&after.removed) > 0.1 * before.stored && after.removed.iter().all(|&(_, amount)| amount > 0.0));
                }
            }
        }
    }
}

/// The sum u + v loses (F + k) v and gains F (1 − u): u loses to v exactly the amount that v gains.
#[test]
fn what_one_species_loses_to_the_other_is_gained_there() {
    let item = noisy(&[20, 21], &["free"; 4], numbers("GrayScott", &[("feed", 0.0), ("kill", 0.0)]));
    let simulation = after(&item, "RungeKutta4", 100, 0.5);
    let [u, v] = <[_; 2]>::try_from(budgets(&simulation)).unwrap();
    assert_eq!(u.supplied, [("reaction", 0.0), ("set", 0.0)]);
    assert!(u.removed[0].1 > 1.0 && (u.removed[0].1 - v.supplied[0].1).abs() < 1e-12 * u.removed[0].1);
}

#[test]
fn what_is_set_counts_as_supplied() {
    let item = noisy(&[12, 9], &["free"; 4], gray_scott());
    let mut simulation = after(&item, "RungeKutta4", 10, 0.5);
    let (before, u) = (budgets(&simulation), values(&simulation, "u"));
    simulation.write(&[("systems[0].u", &vec![0.25; u.len()])], &SERIAL).unwrap();
    let there = budgets(&simulation);
    let set = there[0].supplied[1].1;
    assert!((there[0].stored - before[0].stored - set).abs() < 1e-13 && set != 0.0 && there[1] == before[1]);
    let hash = simulation.state_hash();
    let refused = simulation.write(&[("systems[0].u", &u), ("systems[0].v", &vec![f64::NAN; u.len()])], &SERIAL).unwrap_err();
    assert!(refused.to_string().starts_with("set.v at cell (0, 0): expected a finite number"), "{refused}");
    assert_eq!((simulation.state_hash(), budgets(&simulation)), (hash, there));
}

#[test]
fn what_does_not_fit_is_refused_with_its_path() {
    let item = noisy(&[8, 8], &["free"; 4], gray_scott());
    let refused = |change: &dyn Fn(&mut physcore_engine::scene::Item), integrator: &str| {
        let mut item = item.clone();
        change(&mut item);
        simulation(&item, integrator, "f32", 1).err().unwrap().to_string()
    };
    let in_record = |record: &'static str, name: &'static str, value: Value| {
        move |item: &mut physcore_engine::scene::Item| {
            let Some(Value::Record(inner)) = item.values.get_mut(record) else { panic!("{record}") };
            inner.path = format!("systems[0].{record}");
            inner.values.insert(name.to_owned(), value.clone());
        }
    };
    let negative = refused(&in_record("diffusion", "u", Value::Number(-1.0)), "RungeKutta4");
    assert!(negative.starts_with("systems[0].diffusion['u']: expected a number ≥ 0"), "{negative}");
    let large = refused(&in_record("initial", "v", Value::Number(1e300)), "RungeKutta4");
    assert!(large.starts_with("systems[0].initial['v'] at cell (0, 0): expected a number that f32 holds"), "{large}");
    let shape = refused(&in_record("initial", "v", field(&[8, 7], |_| 0.0)), "RungeKutta4");
    assert!(shape.starts_with("systems[0].initial['v']: expected an array of shape [8, 8]"), "{shape}");
    let method = refused(&|_| (), "VelocityVerlet");
    assert!(method.contains("ExplicitEuler") && method.contains("RungeKuttaChebyshev"), "{method}");
}
