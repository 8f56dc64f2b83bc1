//! Bits of the result: independent of threads, batches, checkpoints, reflection and rotation; user-defined functions.

use super::scene::*;
use physcore_engine::integrators::first_order::NAMES;
use physcore_engine::scene::Item;

/// An interrupt may come after a batch's last poll and before its steps count: none of them then counts. Here each poll in
/// turn takes longer than the batch and interrupts.
#[test]
fn an_interrupt_at_the_end_of_a_batch_takes_it_back() {
    let item = noisy(&[128, 256], &["free"; 4], gray_scott());
    let start = std::time::Instant::now();
    after(&item, "RungeKutta4", 40, 0.5);
    let taken = start.elapsed();
    for number in [1, 2, 4] {
        let mut simulation = simulation(&item, "RungeKutta4", "f64", 2).unwrap();
        let looks = std::cell::Cell::new(0);
        let late = || {
            looks.set(looks.get() + 1);
            std::thread::sleep(if looks.get() == number { taken } else { std::time::Duration::ZERO });
            looks.get() == number
        };
        assert_eq!(simulation.step(40, 0.5, &late).is_err(), looks.get() >= number);
        let steps = simulation.steps();
        assert_eq!(simulation.state_hash(), after(&item, "RungeKutta4", steps, 0.5).state_hash(), "{number}: {steps}");
    }
}

#[test]
fn threads_and_batches_change_no_bit_and_checkpoints_go_on() {
    let item = noisy(&[320, 500], &["free", "fixed", "free", "free"], gray_scott());
    for (method, precision) in [("ExplicitEuler", "f32"), ("RungeKuttaChebyshev", "f64")] {
        let run = |threads: usize, batches: &[u64]| {
            let mut simulation = simulation(&item, method, precision, threads).unwrap();
            batches.iter().for_each(|&steps| simulation.step(steps, 0.8, &|| false).unwrap());
            simulation
        };
        let whole = run(1, &[12]);
        let expected = (whole.state_hash(), budgets(&whole));
        let parts = run(2, &[1, 4, 7]);
        assert_eq!((parts.state_hash(), budgets(&parts)), expected, "{method}");
        let checkpoint = run(1, &[5]).capture();
        let mut again = simulation(&item, method, precision, 1).unwrap();
        again.restore(&checkpoint).unwrap();
        again.step(7, 0.8, &|| false).unwrap();
        assert_eq!((again.state_hash(), budgets(&again)), expected, "{method}");
    }
}

/// The run of a field that is reflected, or transposed about its diagonal, is the image of the original run, bit for bit.
#[test]
fn mirror_images_and_the_diagonal_keep_their_bits() {
    let side = 33;
    let of = |i: usize, j: usize| random(i + 100 * j);
    let item = |at: &dyn Fn(usize, usize) -> f64| {
        let all = |shift: f64| field(&[side, side], move |index| at(index / side, index % side) * shift);
        dish(&[side, side], &["free"; 4], gray_scott(), [("u", 0.2, all(1.0)), ("v", 0.1, all(0.5))])
    };
    for method in NAMES {
        let run = |at: &dyn Fn(usize, usize) -> f64| values(&after(&item(at), method, 30, 0.7), "v");
        let plain = run(&of);
        for (image, place) in [
            (run(&|i, j| of(side - 1 - i, j)), (|i, j, n| (n - 1 - i) * n + j) as fn(usize, usize, usize) -> usize),
            (run(&|i, j| of(i, side - 1 - j)), |i, j, n| i * n + n - 1 - j),
            (run(&|i, j| of(j, i)), |i, j, n| j * n + i),
        ] {
            assert!((0..side * side).all(|index| image[index] == plain[place(index / side, index % side, side)]), "{method}");
        }
    }
}

fn rates(u: f64, v: f64) -> [f64; 2] {
    [0.035 * (1.0 - u) - u * v * v, u * v * v - 0.0975 * v]
}

/// A user-defined function agrees with the same built-in reaction within roundings, and with the species exchanged bit by
/// bit.
#[test]
fn a_function_of_the_users_is_the_same_reaction() {
    let (cells, edges) = ([21, 18], ["free", "fixed", "periodic", "periodic"]);
    for method in NAMES {
        let own = noisy(&cells, &edges, reaction(["u", "v"], rates));
        let exchanged = dish(
            &cells,
            &edges,
            reaction(["v", "u"], |v, u| {
                let [one, other] = rates(u, v);
                [other, one]
            }),
            [("v", 0.1, field(&cells, |index| 0.5 * random(index + 1_000_000))), ("u", 0.2, field(&cells, random))],
        );
        let run = |item: &Item| {
            let simulation = after(item, method, 40, 0.7);
            ["u", "v"].map(|species| values(&simulation, species))
        };
        let (built_in, own, exchanged) = (run(&noisy(&cells, &edges, gray_scott())), run(&own), run(&exchanged));
        assert!((0..2).all(|species| distance(&built_in[species], &own[species]) < 1e-13), "{method}");
        assert_eq!(own, exchanged, "{method}");
    }
}
