//! Symmetries to the last bit, walls as edges, and time reversal.

use super::scene::*;
use physcore_engine::parallel::SERIAL;
use physcore_engine::scene::{Item, Value};

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

/// A wall is an edge: the mirror image of u beyond its face, with the opposite sign. The sums are taken in another order.
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
