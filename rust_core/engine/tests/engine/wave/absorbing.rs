//! Absorbing edges: reflections, metered energy, and the integrators that support them.

use glam::DVec3;

use super::scene::*;
use physcore_engine::integrators::{Integrator, with_integrator};
use physcore_engine::ledger::Class;
use physcore_engine::parallel::SERIAL;
use physcore_engine::scene::{Item, Value};
use physcore_engine::stability::Horizon;

const OPEN: [&str; 6] = ["absorbing"; 6];

/// Wave with absorbing edges on all sides.
fn open(cells: &[usize], spacing: f64) -> Item {
    absorbing(wave(cells, spacing, &OPEN[..2 * cells.len()]))
}

/// Adds absorbing layers with their defaults to an item.
fn absorbing(item: Item) -> Item {
    let layer = [("cells", Value::Text("auto".to_owned())), ("reflection", Value::Number(1e-6))];
    with(item, "absorbing", Value::Record(Box::new(Item::new("Absorbing", layer))))
}

/// Whether an integrator supports absorbing edges: it has no negative substeps.
fn can(name: &str) -> bool {
    !["PEFRL", "BlanesMoan4", "BlanesMoan6", "ExplicitEuler"].contains(&name)
}

/// Ripple that is at rest at the edges at first. The lower corner of the grid is `shift` cells lower along each axis.
fn ripple(count: usize, dimension: usize, shift: usize, absorbs: bool) -> Item {
    let cells = &[count; 3][..dimension];
    let center = [0.45, 0.55, 0.5];
    let square = |at: [usize; 3]| -> f64 {
        (0..dimension).map(|axis| ((at[axis] as f64 + 0.5 - shift as f64) / 40.0 - center[axis]).powi(2)).sum::<f64>() / 0.01
    };
    let item = if absorbs { open(cells, 0.025) } else { wave(cells, 0.025, &["free"; 6][..2 * dimension]) };
    with(item, "displacement", field(cells, |at| (1.0 - square(at)) * libm::exp(-square(at))))
}

/// Compares with the same ripple on a much wider grid, from which no echo arrives in time.
#[test]
fn nothing_comes_back_at_any_angle() {
    with_integrator!(each I => {
        if can(I::NAME) && !I::GYRATES {
            let dimensions = if I::NAME == "VelocityVerlet" { 1..=3 } else { 2..=2 };
            for dimension in dimensions {
                // In as many steps waves cross half as many cells: an echo of the wider grid comes later.
                let (h, steps, wide) = (0.0125, if dimension == 3 { 72 } else { 120 }, if dimension == 3 { 76 } else { 100 });
                let shift = (wide - 40) / 2;
                let mut calm = after(&ripple(40, dimension, 0, true), I::NAME, 0, h);
                let mut sea = after(&ripple(wide, dimension, shift, false), I::NAME, 0, h);
                let (mut echo, mut highest) = (0.0_f64, 0.0_f64);
                for _ in 0..steps / 8 {
                    for simulation in [&mut calm, &mut sea] {
                        simulation.step(8, h, &|| false).unwrap();
                    }
                    let ([small, _], [large, _]) = (fields(&calm), fields(&sea));
                    let cells = &[40; 3][..dimension];
                    let part = entries(cells, |at| large[(0..dimension).fold(0, |index, axis| index * wide + at[axis] + shift)]);
                    echo = echo.max(distance(&small, &part));
                    highest = part[..40].iter().fold(highest, |highest, u| highest.max(u.abs()));
                }
                assert!(echo < 1e-3 * highest, "{} in {dimension}D: {echo:.1e} of {highest:.1e}", I::NAME);
            }
        }
    });
}

/// The energy that the faces meter is the energy that is lost, to the order of the method; all energy is gone in the end.
#[test]
fn what_leaves_is_metered() {
    let drift = |steps: u64, time: f64| {
        let simulation = after(&ripple(40, 2, 0, true), "VelocityVerlet", steps, time / steps as f64);
        let [start, now] = [&after(&ripple(40, 2, 0, true), "VelocityVerlet", 0, 0.01), &simulation].map(energy);
        (now.balance() / start.total() - 1.0, now.sum(Class::Dissipated) / start.total(), now.total() / start.total())
    };
    let ((coarse, dissipated, _), (fine, ..)) = (drift(80, 0.6), drift(160, 0.6));
    assert!(dissipated > 0.2 && dissipated < 0.9, "{dissipated}");
    // Verlet's energy error is up to (ωh)²/4 within a period, and the ripple's energy has a mean ω² = c²k² of 800 s⁻²:
    // 2.8e-3.
    assert!((3.5..4.5).contains(&(coarse / fine)) && fine.abs() < 2.9e-3, "{coarse:e} {fine:e}");
    let (_, dissipated, left) = drift(1600, 4.0);
    assert!((dissipated - 1.0).abs() < 2e-3 && left < 1e-3, "{dissipated} {left}");
}

/// Random fields contain all modes of the grid and its layers.
#[test]
fn every_integrator_that_can_is_stable_up_to_its_limit() {
    let cells = [9, 8];
    let item = with(open(&cells, 0.1), "displacement", field(&cells, random));
    let mixed = absorbing(wave(&cells, 0.1, &["absorbing", "fixed", "periodic", "periodic"]));
    let mixed = with(with(mixed, "speed", field(&cells, |at| 2.0 + random(at))), "displacement", field(&cells, random));
    for item in [item, mixed] {
        with_integrator!(each I => if !I::GYRATES {
            let outcome = simulation(&item, I::NAME, "f64", 1);
            if can(I::NAME) {
                let mut simulation = outcome.unwrap();
                let start = energy(&simulation).total();
                let dt = 0.99 * simulation.limit(Horizon::Sharp, &SERIAL).unwrap().stability;
                simulation.step(2_000, dt, &|| false).unwrap();
                let left = energy(&simulation).total();
                assert!(left < start, "{}: {left} of {start}", I::NAME);
            } else if I::NAME != "ExplicitEuler" {
                let refused = outcome.map(|_| ()).unwrap_err().to_string();
                let expected = "integrator: expected one without negative substeps beside absorbing edges: ExplicitEuler, \
                                SemiImplicitEuler, VelocityVerlet, McLachlan2, RungeKutta4, BogackiShampine3, DormandPrince5, got ";
                assert_eq!(refused, format!("{expected}{}", I::NAME));
            }
        });
    }
}

/// Fields and names are those of the user's cells, without the layers.
#[test]
fn layers_are_outside() {
    let cells = [6, 5];
    let source = source(Value::Vector(DVec3::new(0.05, 0.25, 0.0)), 1.0, 1.0);
    let item = with(open(&cells, 0.1), "sources", Value::Records(vec![source]));
    let mut simulation = after(&item, "VelocityVerlet", 0, 0.01);
    let infos = simulation.fields();
    assert!(infos.iter().all(|info| info.shape == cells));
    simulation.step(2, 0.01, &|| false).unwrap();
    let [u, _] = fields(&simulation);
    let most = (0..30).max_by(|&one, &other| u[one].total_cmp(&u[other])).unwrap();
    assert_eq!(most, 2);
    let written = entries(&cells, random);
    simulation.write(&[("systems[0].displacement", &written)], &SERIAL).unwrap();
    assert_eq!(fields(&simulation)[0], written);
    let wide = with(open(&cells, 0.1), "order", Value::Number(4.0));
    let refused = super::scene::simulation(&wide, "VelocityVerlet", "f64", 1).map(|_| ()).unwrap_err().to_string();
    assert_eq!(refused, "systems[0].order: expected 2 beside absorbing edges, got 4");
}

#[test]
fn threads_batches_and_checkpoints_change_no_bit() {
    let cells = [700, 500];
    let item = with(open(&cells, 0.1), "displacement", field(&cells, random));
    let item = with(item, "damping", Value::Number(0.3));
    for integrator in ["VelocityVerlet", "RungeKutta4"] {
        let run = |threads: usize, batches: &[u64]| {
            let mut simulation = simulation(&item, integrator, "f32", threads).unwrap();
            for &steps in batches {
                simulation.step(steps, 0.02, &|| false).unwrap();
                let checkpoint = simulation.capture();
                simulation = super::scene::simulation(&item, integrator, "f32", threads).unwrap();
                simulation.restore(&checkpoint).unwrap();
            }
            (simulation.state_hash(), energy(&simulation))
        };
        let expected = run(1, &[7]);
        assert_eq!(run(2, &[1, 2, 4]), expected, "{integrator}");
    }
}
