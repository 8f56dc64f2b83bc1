//! Energy budget of damping and of sources.

use glam::DVec3;

use super::scene::*;
use physcore_engine::ledger::Class;
use physcore_engine::parallel::SERIAL;
use physcore_engine::scene::{Item, Value};

const CELLS: [usize; 2] = [24, 18];

/// Pond with damping in one half, a point source, and a source in some cells.
fn pond() -> Item {
    let point = Value::Vector(DVec3::new(1.13, 0.61, 0.0));
    let strip = with(source(mask(&CELLS, |[i, j, _]| i == 4 && j > 3), 3.0, 0.7), "stop", Value::Number(1.3));
    let ricker = Item::new("Ricker", [("frequency", Value::Number(1.5))]);
    let pulse = with(source(field(&CELLS, |[i, ..]| i as f64 / 24.0), 2.0, 0.0), "signal", Value::Record(Box::new(ricker)));
    let item = with(wave(&CELLS, 0.1, &["fixed", "free", "free", "free"]), "damping", field(&CELLS, |[i, ..]| (i / 12) as f64));
    let item = with(item, "sources", Value::Records(vec![source(point, 0.2, 0.9), strip, pulse]));
    with(
        with(item, "density", Value::Number(0.7)),
        "displacement",
        field(&CELLS, |[i, j, _]| 0.01 * libm::sin(0.3 * i as f64 + 0.2 * j as f64)),
    )
}

/// Work and dissipation are integrals of the order of the method, and so is their balance with the energy.
#[test]
fn energy_is_what_sources_gave_less_what_damping_took() {
    for (integrator, order, steps) in [("VelocityVerlet", 2.0, 200), ("RungeKutta4", 4.0, 100)] {
        let error = |steps: u64| {
            let simulation = after(&pond(), integrator, steps, 1.2 / steps as f64);
            let start = energy(&after(&pond(), integrator, 0, 0.01)).balance();
            let ledger = energy(&simulation);
            assert!(ledger.sum(Class::Dissipated) > 1e-3 && ledger.sum(Class::Work) > 1e-2, "{ledger:?}");
            (ledger.balance() - start).abs()
        };
        let found = (error(steps) / error(2 * steps)).log2();
        assert!(found > order - 0.5, "{integrator}: {found}");
    }
}

#[test]
fn damping_alone_takes_energy_at_its_rate() {
    // Undamped modes exchange kinetic and potential energy, with equal means: E falls as exp(−γt), within γ/ω.
    let item = with(with(wave(&CELLS, 0.1, &FIXED), "damping", Value::Number(0.05)), "rate", field(&CELLS, random));
    let [start, end] = [0, 2000].map(|steps| energy(&after(&item, "VelocityVerlet", steps, 0.005)));
    let left = end.total() / start.total();
    assert!((left / libm::exp(-0.5) - 1.0).abs() < 0.02, "{left}");
    // Verlet's energy error is (ωh)²/4 at most, with ω² ≤ 8c²/h².
    assert!((end.balance() / start.balance() - 1.0).abs() < 0.005);
}

/// ∫ s dV is the amplitude, for any position of the point and any grid: the momentum per second at the start.
#[test]
fn a_point_source_gives_the_same_momentum_on_any_grid() {
    for (count, point) in [(10, 0.5), (20, 0.52), (40, 0.03), (40, 0.987)] {
        let spacing = 1.0 / count as f64;
        let mut source = source(Value::Vector(DVec3::new(point, 0.4, 0.0)), 2.0, 0.0);
        source.values.insert("phase".to_owned(), Value::Number(std::f64::consts::FRAC_PI_2));
        let item = with(wave(&[count, count], spacing, &["free"; 4]), "sources", Value::Records(vec![source]));
        let rate: f64 = fields(&after(&item, "VelocityVerlet", 10, 0.001))[1].iter().sum();
        assert!((rate * spacing * spacing - 2.0 * 0.01).abs() < 1e-14, "{rate}");
    }
}

/// A change of fields is work; the work is 0 when the old fields are restored.
#[test]
fn what_is_written_counts_as_work() {
    let mut simulation = after(&pond(), "VelocityVerlet", 40, 0.01);
    let (before, [u, v]) = (energy(&simulation), fields(&simulation));
    simulation.write(&[("systems[0].displacement", &vec![0.3; u.len()])], &SERIAL).unwrap();
    let there = energy(&simulation);
    assert!((there.balance() - before.balance()).abs() < 1e-14);
    assert!(there.sum(Class::Work) > before.sum(Class::Work));
    simulation.write(&[("systems[0].displacement", &u), ("systems[0].rate", &v)], &SERIAL).unwrap();
    assert!((energy(&simulation).sum(Class::Work) - before.sum(Class::Work)).abs() < 1e-14);
    let refused = simulation.write(&[("systems[0].rate", &vec![f64::NAN; v.len()])], &SERIAL).unwrap_err().to_string();
    assert!(refused.starts_with("set.rate at cell (0, 0): expected a finite number"), "{refused}");
    assert_eq!(fields(&simulation), [u, v]);
}
