//! Inside and outside of spheres: impacts, slides along the curve, and leaving the surface.

use glam::{DVec2, DVec3};
use proptest::prelude::*;

use super::laboratory::{Ball, Laboratory, floor, plane, sphere};

const G: DVec3 = DVec3::new(0.0, -9.81, 0.0);

/// A particle that slides from the top of a smooth sphere leaves it where cos θ = 2/3 (start from rest). It lands on the
/// floor with the energy of its fall.
#[test]
fn leaving_a_sphere() {
    for h in [2e-3, 1e-3] {
        let push = 1e-3;
        let ball = Ball::new(DVec3::new(0.0, 1.5, 0.0), DVec3::new(push, 0.0, 0.0), 0.5);
        let mut laboratory = Laboratory::<DVec2>::new(&[ball], vec![sphere(DVec3::ZERO, 1.0, false, 0.3, 0.0)], G);
        while laboratory.position(0).length() < 1.5 + 1e-9 {
            laboratory.step(h);
            assert!(laboratory.position(0).length() > 1.5 - 1e-12);
        }
        // v² = v₀² + 2 g R (1 − cos θ) = g R cos θ. The distance passes 1e-9 at most three steps later; at about 3 m/s a step
        // is 3 h of 1.5 m. Verlet's own error is of order h².
        let cosine = laboratory.position(0).y / laboratory.position(0).length();
        let exact = 2.0 / 3.0 + push * push / (3.0 * 9.81 * 1.5);
        let angle = (exact.acos() - cosine.acos()).abs();
        assert!(angle < 3.0 * 3.0 * h / 1.5, "θ is off by {angle}");
    }
}

/// A bead that slides in a bowl is a pendulum: its period is T = 4 √(R/g) K(sin θ₀/2), to O(h²).
#[test]
fn a_bowl_is_a_pendulum() {
    // θ₀ = 1: T = 4 √(1/9.81) · 1.6856503...; K from the arithmetic-geometric mean of 1 and cos(θ₀/2).
    let (mut a, mut b) = (1.0_f64, 0.5_f64.cos());
    for _ in 0..6 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    let period = 4.0 * (1.0 / 9.81_f64).sqrt() * std::f64::consts::FRAC_PI_2 / a;
    let error = |steps: u32| {
        let start = DVec3::new(1.0_f64.sin(), -1.0_f64.cos(), 0.0);
        let bowl = vec![sphere(DVec3::ZERO, 1.0, true, 0.0, 0.0)];
        let mut laboratory = Laboratory::<DVec2>::new(&[Ball::new(start, DVec3::ZERO, 0.0)], bowl, G);
        let energy = laboratory.energy();
        // A quarter period, where the bead is fastest: the error in time shows as an angle.
        for _ in 0..steps {
            laboratory.step(0.25 * period / f64::from(steps));
            assert!((laboratory.position(0).length() - 1.0).abs() < 1e-12, "left the bowl");
            // Verlet's energy error: of order (ω h)² g R, ω² = g/R; with a factor of 1.
            let scale = 9.81 * (0.25 * period / f64::from(steps)).powi(2) * 9.81;
            assert!((laboratory.energy() + laboratory.dissipated() - energy).abs() < scale);
        }
        laboratory.position(0).x.abs()
    };
    let (coarse, fine) = (error(200), error(400));
    let order = (coarse / fine).log2();
    assert!(order > 1.8 && coarse < 1e-4, "errors {coarse:e} and {fine:e}, order {order}");
}

/// A smooth bowl dissipates no energy: over 10⁴ swings the error stays that of Verlet, without drift.
#[test]
fn a_bowl_does_not_drift() {
    let start = DVec3::new(0.9 * 0.8_f64.sin(), -0.9 * 0.8_f64.cos(), 0.0);
    let bowl = vec![sphere(DVec3::ZERO, 1.0, true, 1.0, 0.0)];
    let mut laboratory = Laboratory::<DVec3>::new(&[Ball::new(start, DVec3::new(0.0, 0.0, 1.0), 0.1)], bowl, G);
    let energy = laboratory.energy();
    let mut worst = [0.0_f64; 2];
    for half in &mut worst {
        for _ in 0..100_000 {
            laboratory.step(0.01);
            *half = half.max((laboratory.energy() + laboratory.dissipated() - energy).abs());
        }
    }
    assert!(worst[0] < 9.81 * 9.81 * 1e-4 && worst[1] < 1.1 * worst[0], "{worst:?}");
}

/// With friction a ball in a bowl comes to rest within the cone of friction.
#[test]
fn a_rough_bowl_stops() {
    let bowl = vec![sphere(DVec3::ZERO, 1.0, true, 0.5, 0.2)];
    let ball = Ball::new(DVec3::new(0.6, 0.0, 0.2), DVec3::new(0.0, 0.0, 1.5), 0.05);
    let mut laboratory = Laboratory::<DVec3>::new(&[ball], bowl, G);
    let energy = laboratory.energy();
    laboratory.steps(20_000, 1e-3);
    assert_eq!(laboratory.velocity(0), DVec3::ZERO);
    let slope = laboratory.position(0).x.hypot(laboratory.position(0).z) / -laboratory.position(0).y;
    assert!(slope <= 0.2 + 1e-12, "rests at a slope of {slope}");
    assert!((laboratory.energy() + laboratory.dissipated() - energy).abs() < 1e-3);
}

/// Around the inside of a rough hoop, without gravity: the normal acceleration is v²/R, so v' = −μ v²/R and v = v₀/(1 + μ v₀
/// t/R). A second-order method with μ v h/R = 6e-4 has an error of some (6e-4)² times the time constants passed, 0.6.
#[test]
fn around_a_rough_hoop() {
    for mu in [0.0, 0.3] {
        let hoop = vec![sphere(DVec3::ZERO, 1.0, true, 0.0, mu)];
        let ball = Ball::new(DVec3::X * 0.9, DVec3::new(0.0, 1.8, 0.0), 0.1);
        let mut laboratory = Laboratory::<DVec2>::new(&[ball], hoop, DVec3::ZERO);
        laboratory.steps(1000, 1e-3);
        let exact = 1.8 / (1.0 + mu * 1.8 / 0.9);
        let speed = laboratory.velocity(0).length();
        assert!((speed / exact - 1.0).abs() < 4e-7, "{speed} instead of {exact}");
        assert!((laboratory.position(0).length() - 0.9).abs() < 1e-15);
        assert!((laboratory.dissipated() - 0.5 * (1.8 * 1.8 - speed * speed)).abs() < 4e-7);
    }
}

/// A floor in a bowl: the ball rolls down the bowl, meets the floor and stays on it.
#[test]
fn a_floor_in_a_bowl() {
    let walls = vec![sphere(DVec3::Y, 1.0, true, 0.2, 0.1), {
        let mut low = floor(0.2, 0.1);
        low.values.insert("point".to_owned(), physcore_engine::scene::Value::Vector(DVec3::new(0.0, 0.3, 0.0)));
        low
    }];
    let ball = Ball::new(DVec3::new(0.8, 1.2, 0.0), DVec3::new(0.0, 0.0, 0.3), 0.05);
    let mut laboratory = Laboratory::<DVec3>::new(&[ball], walls, G);
    laboratory.steps(20_000, 1e-3);
    assert_eq!(laboratory.velocity(0), DVec3::ZERO);
    assert!((laboratory.position(0).y - 0.35).abs() < 1e-15);
}

/// Around the circle in which a floor cuts a bowl, without friction. Gravity presses the particle onto the floor, and its
/// motion onto the bowl. The particle stays on both of them at the same speed. Each of the steps turns it by v h/R = 1.4e-3.
#[test]
fn around_the_rim_of_a_floor() {
    let (radius, speed, h) = (0.51_f64.sqrt(), 1.0, 1e-3);
    let walls = vec![sphere(DVec3::Y, 1.0, true, 0.0, 0.0), plane(DVec3::Y * 0.3, DVec3::Y, 0.0, 0.0)];
    let ball = Ball::new(DVec3::new(radius, 0.3, 0.0), DVec3::Z * speed, 0.0);
    let mut laboratory = Laboratory::<DVec3>::new(&[ball], walls, G);
    for _ in 0..1000 {
        laboratory.step(h);
        let position = laboratory.position(0);
        assert!((position.y - 0.3).abs() < 1e-12 && (position.x.hypot(position.z) - radius).abs() < 1e-12, "{position}");
    }
    // A Verlet step on a circle has the energy error of a swing: (ω h)²/2 of the energy, and no drift.
    assert!((laboratory.velocity(0).length() - speed).abs() < (speed * h / radius).powi(2));
}

proptest! {

    /// A heap presses a grain against the overhang of a rough ball that stands in a floor. The grain may slide back and forth
    /// within a step or not at all. It moves no farther than s = v h + a h²/2, and friction adds no energy. The remaining
    /// error of a Verlet step is κ a s²/2, as the push grows along the curve by κ a s. The numbers are rounded.
    #[test]
    fn pressed_along_an_overhang(press in 1e2..1e5_f64, slope in -1.0..1.0_f64, speed in -0.1..0.1_f64, h in 1e-6..1e-4) {
        let (normal, along) = (DVec3::new(0.8, -0.6, 0.0), DVec3::new(0.6, 0.8, 0.0));
        let walls = vec![sphere(DVec3::ZERO, 1.0, false, 0.0, 0.3), plane(DVec3::Y * -0.85, DVec3::Y, 0.0, 0.5)];
        let load = (along * slope - normal) * press;
        let mut laboratory = Laboratory::<DVec2>::new(&[Ball::new(normal * 1.01, along * speed, 0.01)], walls, load);
        let balance = |laboratory: &Laboratory<DVec2>| laboratory.energy() + laboratory.dissipated();
        for _ in 0..10 {
            let (position, velocity, energy) = (laboratory.position(0), laboratory.velocity(0), balance(&laboratory));
            laboratory.step(h);
            let moved = laboratory.position(0).distance(position);
            let farthest = (velocity.length() + 0.5 * load.length() * h) * h;
            prop_assert!(moved <= farthest + 1e-14, "moved {moved:e} m instead of at most {farthest:e} m");
            let gained = balance(&laboratory) - energy;
            let scale = load.length() * (0.5 * farthest * farthest + 8.0 * f64::EPSILON);
            prop_assert!(gained <= scale, "gained {gained:e} J/kg of at most {scale:e}");
        }
    }

    /// Fast particles in a ball with losses stay inside for ever, and energy + dissipated is as accurate as on a curve.
    /// Impacts are exact. Slides have Verlet's error, (ω h)² of the energies involved, with ω the larger of √(g/R) and v/R.
    #[test]
    fn inside_a_ball(angle in 0.0..std::f64::consts::TAU, v in prop::array::uniform2(-3.0..3.0_f64), e in 0.0..=1.0, h in 1e-4..3e-3) {
        let start = DVec3::new(angle.cos(), angle.sin(), 0.0) * 0.6;
        let ball = Ball::new(start, DVec3::new(v[0], v[1], 0.0), 0.1);
        let mut laboratory = Laboratory::<DVec2>::new(&[ball], vec![sphere(DVec3::ZERO, 1.0, true, e, 0.0)], G);
        let energy = laboratory.energy();
        let (mut scale, mut dissipated) = (0.0_f64, 0.0);
        for _ in 0..1000 {
            laboratory.step(h);
            prop_assert!(laboratory.position(0).length() <= 0.9 + 1e-14);
            prop_assert!(laboratory.dissipated() >= dissipated);
            dissipated = laboratory.dissipated();
            let square = laboratory.velocity(0).length_squared();
            scale = scale.max((square / 0.81 + 9.81 / 0.9) * h * h * (square + 9.81));
            let balance = laboratory.energy() + dissipated - energy;
            prop_assert!(balance.abs() < scale + 1e-11, "off by {balance:e} of {scale:e}");
        }
    }
}
