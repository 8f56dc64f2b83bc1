//! Single impacts and series of impacts: Newton's restitution, Coulomb's friction, and the energy that they dissipate.

use glam::{DVec2, DVec3};
use physcore_engine::math::Vector;
use proptest::prelude::*;

use super::laboratory::{Ball, Laboratory, cuboid, floor, plane};

const G: DVec3 = DVec3::new(0.0, -9.81, 0.0);

/// Heights follow e^(2n). Between bounces the flight conserves v²/2 + g y to rounding. Each apex is measured as the energy
/// over g at any moment of the flight, and is exact to rounding. The error is some 10 operations per step, 600 steps, of
/// 1e-16 each. The issue asks for 1e-6.
#[test]
fn bounce_heights() {
    let e: f64 = 0.8;
    let mut laboratory = Laboratory::<DVec2>::new(&[Ball::new(DVec3::Y, DVec3::ZERO, 0.0)], vec![floor(e, 0.0)], G);
    let mut heights = Vec::new();
    let mut rising = false;
    while heights.len() < 10 {
        laboratory.step(1e-3);
        let now = laboratory.velocity(0).y > 0.0;
        if rising && !now {
            heights.push(laboratory.energy() / 9.81);
        }
        rising = now;
    }
    for (bounce, height) in (1..).zip(heights) {
        let exact = e.powi(2 * bounce);
        assert!((height / exact - 1.0).abs() < 1e-11, "apex {bounce}: {height} instead of {exact}");
    }
}

/// Case L04: the series of bounces ends at T = √(2h/g) (1 + e)/(1 − e). It is collapsed only within the step that contains
/// its end. The ball therefore rests from the end of the first step after T on. Heights are as above.
#[test]
fn a_series_of_bounces_ends_when_it_should() {
    let h = 1.0 / 240.0;
    let mut laboratory = Laboratory::<DVec2>::new(&[Ball::new(DVec3::Y, DVec3::ZERO, 0.0)], vec![floor(0.8, 0.0)], G);
    let mut steps = 0;
    while laboratory.velocity(0) != DVec3::ZERO || steps == 0 {
        laboratory.step(h);
        steps += 1;
        assert!(steps < 2000, "never rests");
    }
    let rested = f64::from(steps) * h;
    assert!((rested - 4.063_712_768_871_578).abs() <= h, "rests at {rested}");
    assert_eq!(laboratory.position(0).y, 0.0);
    // 9.81 J at the start, none at the end; 1000 steps of a few rounding errors each.
    assert!((laboratory.dissipated() - 9.81).abs() < 1e-11);
}

/// Without losses, 10⁵ bounces of a ball neither gain nor lose energy beyond rounding. An impact rounds the returned speed by
/// ε/2 at most and the energy by ε. The sign is always the same because every impact has the same speed: 10⁵ ε. A flight adds
/// rounding errors of either sign, independent because the lengths of steps change. Some 5 of them in each of 1.2·10⁶ steps
/// add up to √(6·10⁶) ε ≈ 2500 ε.
#[test]
fn restitution_one_gains_nothing() {
    for normal in [DVec3::Y, DVec3::new(0.3, 1.0, 0.0), DVec3::new(-0.77, 0.13, 0.0)] {
        let gravity = -normal.normalize() * 9.81;
        let ball = Ball::new(normal.normalize() * 0.5, DVec3::ZERO, 0.1);
        let mut laboratory = Laboratory::<DVec2>::new(&[ball], vec![plane(DVec3::ZERO, normal, 1.0, 0.0)], gravity);
        let start = laboratory.energy();
        // From 0.4 m the ball returns after 2 √(0.8/9.81) = 0.571 s.
        for step in 0..1_200_000 {
            laboratory.step(0.0376 + 0.02 * (f64::from(step) * 0.618_033_988_749_895).fract());
        }
        let gain = laboratory.energy() / start - 1.0;
        assert!(gain.abs() < (1e5 + 2500.0) * f64::EPSILON, "normal {normal}: {gain:e}");
        assert_eq!(laboratory.dissipated(), 0.0);
    }
}

/// Oblique impact, by hand: vₙ = −3, vₜ = 4, e = 0.5, μ = 0.2 gives 1.5 and 4 − 0.2·1.5·3 = 3.1.
#[test]
fn oblique_impact_with_friction() {
    let ball = Ball { mass: 2.0, ..Ball::new(DVec3::new(0.0, 0.3, 0.0), DVec3::new(4.0, -3.0, 0.0), 0.0) };
    let mut laboratory = Laboratory::<DVec2>::new(&[ball], vec![floor(0.5, 0.2)], DVec3::ZERO);
    laboratory.step(0.2);
    let (x, v) = (laboratory.position(0), laboratory.velocity(0));
    assert!((v - DVec3::new(3.1, 1.5, 0.0)).length() < 1e-14, "{v}");
    assert!((x - DVec3::new(0.4 + 0.31, 0.15, 0.0)).length() < 1e-14, "{x}");
    assert!((laboratory.dissipated() - (25.0 - 9.61 - 2.25)).abs() < 1e-13);
}

/// Strong friction stops the slip and never reverses it.
#[test]
fn friction_stops_at_most_the_slip() {
    let ball = Ball::new(DVec3::new(0.0, 0.1, 0.0), DVec3::new(1.0, -3.0, 0.5), 0.0);
    let mut laboratory = Laboratory::<DVec3>::new(&[ball], vec![floor(1.0, 5.0)], DVec3::ZERO);
    laboratory.step(0.1);
    assert_eq!(laboratory.velocity(0), DVec3::new(0.0, 3.0, 0.0));
}

/// In the corner of a box every velocity component is reflected on its own.
#[test]
fn corner_of_a_box() {
    let ball = Ball::new(DVec3::new(0.2, 0.2, 0.2), DVec3::new(-1.0, -1.0, -1.0), 0.1);
    let walls = vec![cuboid(DVec3::ZERO, DVec3::ONE, 1.0, 0.0)];
    let mut laboratory = Laboratory::<DVec3>::new(&[ball], walls, DVec3::ZERO);
    laboratory.step(0.3);
    assert!((laboratory.position(0) - DVec3::splat(0.3)).length() < 1e-15);
    assert_eq!(laboratory.velocity(0), DVec3::ONE);
}

/// Hundreds of reflections between two close walls in one step stop early, but the particle neither leaves nor loses energy.
#[test]
fn more_impacts_than_a_step_resolves() {
    let ball = Ball::new(DVec3::splat(0.5), DVec3::new(1e6, 3e5, 7e4), 0.25);
    let walls = vec![cuboid(DVec3::ZERO, DVec3::ONE, 1.0, 0.0)];
    let mut laboratory = Laboratory::<DVec3>::new(&[ball], walls, G);
    let start = laboratory.energy();
    for _ in 0..100 {
        laboratory.step(1.0);
        assert!((laboratory.position(0) - DVec3::splat(0.5)).abs().max_element() <= 0.25 + 1e-15);
    }
    // 100 steps of 64 impacts, each with a rounding error or two.
    assert!((laboratory.energy() / start - 1.0).abs() < 100.0 * 64.0 * 2.0 * f64::EPSILON);
}

fn vector(range: f64) -> impl Strategy<Value = DVec3> {
    [-range..range, -range..range, -range..range].prop_map(DVec3::from_array)
}

fn total_is_constant<V: Vector>(
    balls: &[Ball],
    walls: Vec<physcore_engine::scene::Item>,
    h: f64,
    tolerance: f64,
) -> Result<(), TestCaseError> {
    let mut laboratory = Laboratory::<V>::new(balls, walls, G);
    let start = laboratory.energy();
    let mut before = 0.0;
    for _ in 0..200 {
        laboratory.step(h);
        let dissipated = laboratory.dissipated();
        prop_assert!(dissipated >= before - tolerance, "friction gave energy");
        before = dissipated;
        let balance = laboratory.energy() + dissipated - start;
        prop_assert!(balance.abs() < tolerance, "off by {balance:e}");
    }
    Ok(())
}

proptest! {

    /// Energy + dissipated is constant through impacts, slides, corners and rest on flat walls. A step changes energies of up
    /// to 100 J by at most some 20 roundings. There are 200 steps with a few events each: 100·200·20·2·1e-16 = 1e-10 at
    /// worst.
    #[test]
    fn total_and_dissipated(x in vector(0.8), v in vector(10.0), radius in 0.0..0.1, e in 0.0..=1.0, mu in 0.0..2.0, h in 1e-4..0.5) {
        let walls = || vec![cuboid(DVec3::splat(-1.0), DVec3::ONE, e, mu), plane(DVec3::new(0.0, -1.6, 0.0), DVec3::new(1.0, 1.0, 0.3), e, mu)];
        let inside = DVec3::new(1.0, 1.0, 0.3).normalize().dot(x - DVec3::new(0.0, -1.6, 0.0)) > 0.1;
        prop_assume!(inside);
        total_is_constant::<DVec3>(&[Ball::new(x, v, radius)], walls(), h, 1e-10)?;
    }

    /// Without losses motion is reversible: it retraces its bounces. Both ways take 40 steps. In a box errors grow only
    /// linearly in time, at each bounce by the error of its time, about ε: 80 steps · 10 m/s · some ε.
    #[test]
    fn reversal(x in vector(0.8), v in vector(10.0)) {
        let walls = vec![cuboid(DVec3::splat(-1.0), DVec3::ONE, 1.0, 0.0)];
        let mut laboratory = Laboratory::<DVec3>::new(&[Ball::new(x, v, 0.1)], walls, G);
        laboratory.steps(40, 0.01);
        laboratory.reverse();
        laboratory.steps(40, 0.01);
        prop_assert!((laboratory.position(0) - x).length() < 1e-11);
        prop_assert!((laboratory.velocity(0) + v).length() < 1e-10);
    }

    /// The mirror image of a motion is the motion of the mirror image, bit for bit: rounding does not depend on signs.
    #[test]
    fn mirror(x in vector(0.8), v in vector(10.0), e in 0.0..=1.0, mu in 0.0..2.0) {
        let mirrored = |vector: DVec3| vector * DVec3::new(-1.0, 1.0, 1.0);
        let run = |x, v| {
            let walls = vec![cuboid(DVec3::splat(-1.0), DVec3::ONE, e, mu)];
            let mut laboratory = Laboratory::<DVec3>::new(&[Ball::new(x, v, 0.1)], walls, G);
            laboratory.steps(100, 0.01);
            (laboratory.position(0), laboratory.velocity(0), laboratory.dissipated())
        };
        let (one, other) = (run(x, v), run(mirrored(x), mirrored(v)));
        prop_assert_eq!(one, (mirrored(other.0), mirrored(other.1), other.2));
    }
}
