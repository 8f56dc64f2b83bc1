//! Symmetries to the last bit, and the force as the gradient of the energy.

use super::scene::*;
use crate::grid::Window;
use crate::math::Real;
use crate::parallel::SERIAL;
use crate::scene::{Item, Value};
use crate::systems::wave::Wave;

const N: usize = 21;
const PLANE: [usize; 2] = [N, N];

/// A function that mirroring and exchanging the axes leaves as it is.
fn symmetric([i, j, _]: [usize; 3]) -> f64 {
    let [x, y] = [i, j].map(|index| index.min(N - 1 - index));
    random([x.min(y), x.max(y), 0])
}

fn speed([i, j, k]: [usize; 3]) -> f64 {
    1.0 + 0.5 * symmetric([i, j, k])
}

/// Waves with uniform and variable speed, with walls, of both orders.
fn variants(cells: [usize; 2], edges: &[&str], displacement: impl Fn([usize; 3]) -> f64 + Copy) -> Vec<Item> {
    let plain = with(wave(&cells, 0.1, edges), "displacement", field(&cells, displacement));
    let varying = with(plain.clone(), "speed", field(&cells, speed));
    let walled = with(varying.clone(), "walls", mask(&cells, |at| symmetric(at) > 0.8));
    let fourth = |item: &Item| with(item.clone(), "order", Value::Number(4.0));
    vec![fourth(&plain), fourth(&walled), plain, varying, walled]
}

#[test]
fn mirror_images_and_the_diagonal_keep_their_bits() {
    for edges in [["fixed"; 4], ["free"; 4], ["periodic"; 4]] {
        for item in variants(PLANE, &edges, symmetric) {
            let u = &fields(&after(&item, "VelocityVerlet", 100, 0.02))[0];
            for index in 0..N * N {
                let (i, j) = (index / N, index % N);
                let images = [(N - 1 - i) * N + j, i * N + (N - 1 - j), j * N + i];
                assert!(images.iter().all(|&image| u[image] == u[index]), "{edges:?} at ({i}, {j})");
            }
        }
    }
}

#[test]
fn a_periodic_field_that_is_shifted_stays_so_bit_by_bit() {
    let cells = [N, N - 5];
    let shifted = |[i, j, k]: [usize; 3]| random([(i + 8) % N, (j + 3) % (N - 5), k]);
    let run = |of: &dyn Fn([usize; 3]) -> f64| {
        let item = with(wave(&cells, 0.1, &["periodic"; 4]), "displacement", field(&cells, of));
        fields(&after(&item, "PEFRL", 50, 0.02))[0].clone()
    };
    let (plain, moved) = (run(&random), run(&shifted));
    let at = |i: usize, j: usize| (i % N) * cells[1] + j % cells[1];
    assert!((0..N * cells[1]).all(|index| moved[index] == plain[at(index / cells[1] + 8, index % cells[1] + 3)]));
}

/// The energy is quadratic, so that E(u + d) − E(u − d) = 2 d·∇E exactly, and −∇E = ρ h^D L u.
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
    for item in &cases {
        let mut wave = Wave::<f64, crate::integrators::VelocityVerlet>::new(item).unwrap();
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
            work += out.iter().zip(&direction[row * length..]).map(|(a, d)| a * d).sum::<f64>();
        }
        assert!((risen + 2.0 * work).abs() < 1e-12 * risen.abs().max(1.0), "{risen} {work}");
    }
    assert_eq!(f32::NAME, "f32");
}

/// A wall is an edge: the mirror image of u beyond its face, with the other sign. The sums are taken in another order.
#[test]
fn a_wall_is_a_fixed_edge() {
    let (whole, part) = ([12, 9], [8, 9]);
    let run = |item: &Item| fields(&after(item, "VelocityVerlet", 60, 0.05))[0].clone();
    for order in [2.0, 4.0] {
        let order = |item| with(item, "order", Value::Number(order));
        let walled = order(with(wave(&whole, 0.1, &FIXED), "walls", mask(&whole, |[i, ..]| i >= 8)));
        let walled = run(&with(walled, "displacement", field(&whole, random)));
        let edged = run(&with(order(wave(&part, 0.1, &FIXED)), "displacement", field(&part, random)));
        assert!(distance(&walled[..72], &edged) < 1e-12);
        assert!(walled[72..].iter().all(|&u| u == 0.0));
    }
}

#[test]
fn verlet_runs_back_to_where_it_came_from() {
    let item = with(variants(PLANE, &FIXED, random).remove(4), "rate", field(&PLANE, |[i, j, _]| random([j, i, 3])));
    let mut simulation = after(&item, "VelocityVerlet", 0, 0.02);
    let start = fields(&simulation)[0].clone();
    simulation.step(300, 0.02, &|| false).unwrap();
    let reversed: Vec<f64> = fields(&simulation)[1].iter().map(|v| -v).collect();
    simulation.write(&[("systems[0].rate", &reversed)], &SERIAL).unwrap();
    simulation.step(300, 0.02, &|| false).unwrap();
    assert!(distance(&fields(&simulation)[0], &start) < 1e-11);
}
