//! Discrete modes: values lie at the centers and edges on faces. Modes are therefore sines and cosines of the exact length,
//! and −L has the eigenvalue (4c²/h²) Σ sin²(k h/2).

use std::f64::consts::PI;

use super::scene::*;
use physcore_engine::integrators::{Integrator, with_integrator};
use physcore_engine::scene::{Item, Value};

const CELLS: [usize; 2] = [25, 15];
const SPACING: f64 = 0.1;

/// sin(1.5πx) cos(4πy/3) on [0, 2] × [0, 1.5], fixed along x by an edge and by a wall, and free along y; with its frequency.
fn membrane() -> (Item, Vec<f64>, f64) {
    let [x, y] = [1.5 * PI, 4.0 * PI / 3.0];
    let center = |index: usize| (index as f64 + 0.5) * SPACING;
    let mode = |[i, j, _]: [usize; 3]| if i < 20 { libm::sin(x * center(i)) * libm::cos(y * center(j)) } else { 0.0 };
    let item = with(wave(&CELLS, SPACING, &["fixed", "fixed", "free", "free"]), "speed", Value::Number(2.0));
    let item = with(item, "walls", mask(&CELLS, |[i, ..]| i >= 20));
    let frequency = 2.0 * 2.0 / SPACING * libm::hypot(libm::sin(0.5 * x * SPACING), libm::sin(0.5 * y * SPACING));
    (with(item, "displacement", field(&CELLS, mode)), entries(&CELLS, mode), frequency)
}

/// Verlet's own frequency is (2/h) asin(ωh/2). Each step rounds by an ulp of the terms of L u, 8 c²h²/h² u. Over 500 steps
/// this is 500 · 8 · 0.16 · 1e-16 at random.
#[test]
fn a_mode_swings_at_verlets_own_frequency() {
    let (item, mode, frequency) = membrane();
    let simulation = after(&item, "VelocityVerlet", 500, 0.02);
    let turned = libm::cos(500.0 * 2.0 * libm::asin(0.5 * frequency * 0.02));
    let exact: Vec<f64> = mode.iter().map(|u| turned * u).collect();
    assert!(distance(&fields(&simulation)[0], &exact) < 1e-12);
    let square: f64 = mode.iter().map(|u| u * u).sum();
    let energy = energy(&after(&item, "VelocityVerlet", 0, 0.02));
    assert!((energy.total() / (0.5 * frequency * frequency * square * SPACING * SPACING) - 1.0).abs() < 1e-13);
}

#[test]
fn every_integrator_keeps_its_order() {
    let (item, mode, frequency) = membrane();
    with_integrator!(each I => if !I::GYRATES {
        let steps = (16 / u64::from(I::ORDER)).max(6) * 25 / I::NODES.len().min(5) as u64;
        let error = |steps: u64| {
            let [u, v] = fields(&after(&item, I::NAME, steps, 0.5 / steps as f64));
            let [cos, sin] = [libm::cos(0.5 * frequency), libm::sin(0.5 * frequency)];
            let errors = mode.iter().zip(u.iter().zip(&v)).map(|(mode, (u, v))| (u - cos * mode).hypot(v / frequency + sin * mode));
            errors.fold(0.0, f64::max)
        };
        let order = (error(steps) / error(2 * steps)).log2();
        assert!((order - f64::from(I::ORDER)).abs() < 0.2, "{}: {order}", I::NAME);
    });
}

/// Compares with the exact frequency, in one dimension to three, for waves along all axes with fixed, free and periodic
/// edges.
#[test]
fn differences_have_their_order() {
    let edges = ["fixed", "fixed", "free", "free", "periodic", "periodic"];
    for (order, dimension) in [(2.0, 1), (2.0, 2), (2.0, 3), (4.0, 1), (4.0, 2), (4.0, 3)] {
        let error = |count: usize| {
            let cells = [count; 3];
            let at = |index: usize| (index as f64 + 0.5) / count as f64;
            let mode = |[i, j, k]: [usize; 3]| {
                let functions = [libm::sin(2.0 * PI * at(i)), libm::cos(PI * at(j)), libm::cos(2.0 * PI * at(k))];
                functions[..dimension].iter().product()
            };
            let cells = &cells[..dimension];
            let item = with(wave(cells, 1.0 / count as f64, &edges[..2 * dimension]), "order", Value::Number(order));
            let item = with(item, "displacement", field(cells, mode));
            let frequency = PI * [4.0, 5.0, 9.0_f64][dimension - 1].sqrt();
            let exact = entries(cells, |at| libm::cos(0.2 * frequency) * mode(at));
            distance(&fields(&after(&item, "BlanesMoan6", 8, 0.025))[0], &exact)
        };
        let found = (error(10) / error(20)).log2();
        assert!((found - order).abs() < 0.25, "order {order} in {dimension}D: {found}");
    }
}
