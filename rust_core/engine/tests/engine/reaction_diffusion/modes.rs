//! Diffusion mode by mode, and orders in time.

use std::f64::consts::PI;

use super::scene::*;
use physcore_engine::integrators::first_order::NAMES;
use physcore_engine::scene::Value;

/// A mode decays by the factor R(−λh) in each step, with λ of the discrete operator. Euler's method has 1 − λh. The classical
/// Runge–Kutta method has 1 − z + z²/2 − z³/6 + z⁴/24. The tolerance is some hundred roundings of numbers up to 1.
#[test]
fn modes_decay_at_their_discrete_rates() {
    let (count, wave, rate) = (24, 5.0, 0.3);
    for (edges, cells, angle, phase) in [
        (["free"; 2], vec![count], PI * wave / count as f64, 0.5),
        (["fixed"; 2], vec![count], PI * wave / count as f64, 0.5),
        (["periodic"; 2], vec![count], 2.0 * PI * wave / count as f64, 0.0),
    ] {
        let of = |index: usize| {
            let argument = angle * (index as f64 + phase);
            if edges[0] == "fixed" { libm::sin(argument) } else { libm::cos(argument) }
        };
        let item = dish(&cells, &edges, inert(), [("u", rate, field(&cells, of)), ("v", 0.1, Value::Number(0.0))]);
        let eigenvalue = 4.0 * rate * libm::sin(0.5 * angle).powi(2);
        for (name, factor) in [
            ("ExplicitEuler", |z: f64| 1.0 - z),
            ("RungeKutta4", |z: f64| 1.0 - z + z * z / 2.0 - z * z * z / 6.0 + z * z * z * z / 24.0),
        ] as [(&str, fn(f64) -> f64); 2]
        {
            let (steps, h) = (40, 0.9);
            let left = factor(eigenvalue * h).powi(steps);
            let expected: Vec<f64> = (0..count).map(|index| left * of(index)).collect();
            let found = values(&after(&item, name, steps as u64, h), "u");
            assert!(distance(&found, &expected) < 1e-14, "{name} {edges:?}: {}", distance(&found, &expected));
        }
    }
}

#[test]
fn every_method_has_its_order() {
    let cells = [12, 10];
    let smooth = |index: usize| 0.6 + 0.3 * libm::sin(0.5 * (index / 10) as f64) * libm::cos(0.4 * (index % 10) as f64);
    for reaction in [gray_scott(), numbers("Brusselator", &[("a", 0.7), ("b", 0.9)])] {
        let species = [("u", 0.2, field(&cells, smooth)), ("v", 0.1, field(&cells, |index| 0.5 * smooth(119 - index)))];
        let item = dish(&cells, &["free", "fixed", "periodic", "periodic"], reaction, species);
        let exact = values(&after(&item, "DormandPrince5", 200, 0.01), "v");
        for name in NAMES {
            let (order, dt) = match name {
                "ExplicitEuler" => (1.0, 0.1),
                "RungeKuttaChebyshev" => (2.0, 0.5),
                "BogackiShampine3" => (3.0, 0.5),
                "RungeKutta4" => (4.0, 0.125),
                _ => (5.0, 0.0625),
            };
            let error = |dt: f64| distance(&values(&after(&item, name, (2.0 / dt) as u64, dt), "v"), &exact);
            let found = (error(dt) / error(0.5 * dt)).log2();
            assert!((found - order).abs() < 0.35, "{name}: {found}");
        }
    }
}

/// Near an even state of the Brusselator a mode grows as exp(Jt − λDt): eigenvalues of a 2 × 2 matrix, here real.
#[test]
fn a_turing_mode_grows_at_its_rate() {
    let (a, b, count, wave) = (2.0, 4.0, 40, 13.0);
    let [slow, fast] = [0.5, 4.0];
    let mode = |index: usize| libm::cos(PI * wave * (index as f64 + 0.5) / count as f64);
    let eigenvalue = 4.0 * libm::sin(0.5 * PI * wave / count as f64).powi(2);
    let [[p, q], [r, s]] = [[b - 1.0 - slow * eigenvalue, a * a], [-b, -a * a - fast * eigenvalue]];
    let (half, product) = (0.5 * (p + s), p * s - q * r);
    let growth = half + libm::sqrt(half * half - product);
    assert!(growth > 0.05, "{growth}");
    // Eigenvector (q, growth − p): its amplitude grows as exp(growth t) alone. Terms of second order are 1e-8 of it.
    let size = 1e-8;
    let kinetics = numbers("Brusselator", &[("a", a), ("b", b)]);
    let species = [
        ("u", slow, field(&[count], |index| a + size * q * mode(index))),
        ("v", fast, field(&[count], |index| b / a + size * (growth - p) * mode(index))),
    ];
    let item = dish(&[count], &["free"; 2], kinetics, species);
    let end = values(&after(&item, "RungeKutta4", 800, 0.01), "u");
    let amplitude = 2.0 / count as f64 * end.iter().enumerate().map(|(index, u)| (u - a) * mode(index)).sum::<f64>();
    let ratio = amplitude / (size * q * libm::exp(growth * 8.0));
    assert!((ratio - 1.0).abs() < 1e-5, "{ratio}");
}
