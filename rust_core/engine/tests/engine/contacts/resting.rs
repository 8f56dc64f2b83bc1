//! Rest and sliding: on a floor, on a slope, in corners and along edges.

use glam::{DVec2, DVec3, Vec3};
use physcore_engine::math::Vector;

use super::laboratory::{Ball, Laboratory, cuboid, floor, plane};

const G: DVec3 = DVec3::new(0.0, -9.81, 0.0);

fn stays_put<V: Vector>(e: f64, mu: f64) {
    let ball = Ball::new(DVec3::new(0.37, 0.1, 0.0), DVec3::ZERO, 0.1);
    let mut laboratory = Laboratory::<V>::new(&[ball], vec![floor(e, mu)], G);
    let start = laboratory.position(0);
    laboratory.steps(100_000, 1e-3);
    assert_eq!(laboratory.position(0), start);
    assert_eq!(laboratory.velocity(0), DVec3::ZERO);
}

/// A particle at rest stays in place, to the bit, for any material.
#[test]
fn rest_on_a_floor() {
    for (e, mu) in [(0.0, 0.0), (0.8, 0.3), (1.0, 0.0)] {
        stays_put::<DVec2>(e, mu);
        stays_put::<DVec3>(e, mu);
        stays_put::<Vec3>(e, mu);
    }
}

/// A block with speed v slides v²/(2 μ g). Uniform deceleration is integrated exactly, and so is its end.
#[test]
fn sliding_block_stops() {
    let (mu, v, h) = (0.3, 2.0, 1e-3);
    let ball = Ball { mass: 3.0, ..Ball::new(DVec3::ZERO, DVec3::new(v, 0.0, 0.0), 0.0) };
    let mut laboratory = Laboratory::<DVec2>::new(&[ball], vec![floor(0.4, mu)], G);
    laboratory.steps(1000, h);
    let exact = v * v / (2.0 * mu * 9.81);
    assert!((laboratory.position(0).x - exact).abs() < 1e-12, "{} instead of {exact}", laboratory.position(0).x);
    assert_eq!(laboratory.velocity(0), DVec3::ZERO);
    assert!((laboratory.dissipated() - 0.5 * 3.0 * v * v).abs() < 1e-12);
}

/// On a slope of angle α a block stays if tan α < μ. Otherwise it slides with the acceleration g (sin α − μ cos α), up or
/// down.
#[test]
fn block_on_a_slope() {
    let angle: f64 = 0.4;
    let normal = DVec3::new(-angle.sin(), angle.cos(), 0.0);
    let uphill = DVec3::new(angle.cos(), angle.sin(), 0.0);
    for (mu, expected) in [(0.5, 0.0), (0.3, 9.81 * (angle.sin() - 0.3 * angle.cos())), (0.0, 9.81 * angle.sin())] {
        let mut laboratory =
            Laboratory::<DVec2>::new(&[Ball::new(DVec3::ZERO, DVec3::ZERO, 0.0)], vec![plane(DVec3::ZERO, normal, 0.5, mu)], G);
        laboratory.steps(1000, 1e-3);
        // After 1 s: a/2 downhill. 1000 steps, each with several rounding errors of a few meters.
        let way = -laboratory.position(0).dot(uphill);
        assert!((way - 0.5 * expected).abs() < 1e-11, "μ = {mu}: {way} instead of {}", 0.5 * expected);
        assert!(laboratory.position(0).dot(normal).abs() < 1e-14);
    }
    // Thrown uphill at 2 m/s, the block stops after v²/(2 g (sin α + μ cos α)) and returns with less speed.
    let mu = 0.3;
    let mut laboratory =
        Laboratory::<DVec2>::new(&[Ball::new(DVec3::ZERO, uphill * 2.0, 0.0)], vec![plane(DVec3::ZERO, normal, 0.5, mu)], G);
    let highest = 4.0 / (2.0 * 9.81 * (angle.sin() + mu * angle.cos()));
    let start = laboratory.energy();
    let mut reached = 0.0_f64;
    for _ in 0..1000 {
        laboratory.step(1e-3);
        reached = reached.max(laboratory.position(0).dot(uphill));
        assert!((laboratory.energy() + laboratory.dissipated() - start).abs() < 1e-12);
    }
    // Measured at step ends only: the summit is flat to a h²/2.
    assert!(reached <= highest + 1e-13 && highest - reached < 9.81 * 0.5e-6, "{reached} instead of {highest}");
}

/// Along the edge of a tilted wedge only the component along the edge acts, here without friction. A ball that touches both
/// walls slides as a point on the edge does.
#[test]
fn sliding_along_an_edge() {
    let normals = [DVec3::new(1.0, 1.3, 0.2), DVec3::new(-1.1, 1.0, 0.4)].map(DVec3::normalize);
    let edge = normals[0].cross(normals[1]).normalize();
    let exact = edge * (0.5 * G.dot(edge));
    for radius in [0.0, 0.25] {
        // n·c = r for both normals.
        let center = (normals[0] + normals[1]) * (radius / (1.0 + normals[0].dot(normals[1])));
        let walls = normals.map(|normal| plane(DVec3::ZERO, normal, 0.3, 0.0)).to_vec();
        let mut laboratory = Laboratory::<DVec3>::new(&[Ball::new(center, DVec3::ZERO, radius)], walls, G);
        laboratory.steps(1000, 1e-3);
        let way = laboratory.position(0) - center;
        assert!((way - exact).length() < 1e-11, "radius {radius}: {way} instead of {exact}");
    }
}

/// A ball pressed into all three walls of a corner at once stays there, however steeply it is pressed along two of them.
#[test]
fn rest_in_a_corner() {
    for gravity in [DVec3::new(-1.0, -2.0, -3.0), DVec3::new(-3.0, -1.0, -2.0), DVec3::new(-2.0, -3.0, -1.0)] {
        let ball = Ball::new(DVec3::splat(-0.75), DVec3::ZERO, 0.25);
        let mut laboratory = Laboratory::<DVec3>::new(&[ball], vec![cuboid(DVec3::splat(-1.0), DVec3::ONE, 0.5, 0.0)], gravity);
        laboratory.steps(100, 1e-2);
        assert_eq!(laboratory.velocity(0), DVec3::ZERO);
        assert_eq!(laboratory.position(0), DVec3::splat(-0.75));
        // The position of the corner is rounded, and so is the energy there.
        assert!(laboratory.dissipated() <= f64::EPSILON);
    }
}

/// A ball thrown into a box with losses comes to rest in a corner or on the floor, with all its energy tallied.
#[test]
fn everything_comes_to_rest() {
    let balls: Vec<Ball> = (0..50)
        .map(|index| {
            let t = f64::from(index);
            Ball::new(
                DVec3::new((1.7 * t).sin(), (2.3 * t).sin(), (3.1 * t).sin()) * 0.8,
                DVec3::new((5.0 * t).cos(), t.sin(), (7.0 * t).sin()) * 9.0,
                0.1,
            )
        })
        .collect();
    let mut laboratory = Laboratory::<DVec3>::new(&balls, vec![cuboid(DVec3::splat(-1.0), DVec3::ONE, 0.5, 0.4)], G);
    let start = laboratory.energy();
    laboratory.steps(10_000, 1e-3);
    for index in 0..balls.len() {
        assert_eq!(laboratory.velocity(index), DVec3::ZERO, "ball {index}");
        // −0.9 is not a number of the format: the result is the next number inside, or one further.
        assert!((laboratory.position(index).y + 0.9).abs() <= f64::EPSILON, "ball {index}");
    }
    assert!((laboratory.energy() + laboratory.dissipated() - start).abs() < 1e-10);
}
