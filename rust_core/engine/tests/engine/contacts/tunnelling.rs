//! No particle passes a wall, at any speed and in either precision.

use glam::{DVec2, DVec3, Vec2, Vec3};
use physcore_engine::boundaries::{self, Boundary};
use physcore_engine::math::{Real, Vector};
use physcore_engine::scene::{Item, Value};
use proptest::prelude::*;

use super::laboratory::{Ball, Laboratory, cuboid, plane, sphere};

fn direction() -> impl Strategy<Value = DVec3> {
    prop::array::uniform3(-1.0..1.0_f64)
        .prop_map(DVec3::from_array)
        .prop_filter("short", |v| v.length() > 0.1)
        .prop_map(DVec3::normalize)
}

/// Speed from a millimeter to 10⁶ m per second.
fn speed() -> impl Strategy<Value = f64> {
    (-3.0..6.0_f64).prop_map(|exponent| 10.0_f64.powf(exponent))
}

/// Time step from 10⁻⁴ to 1 s.
fn step() -> impl Strategy<Value = f64> {
    (-4.0..=0.0_f64).prop_map(|exponent| 10.0_f64.powf(exponent))
}

fn flat<V: Vector>(vector: DVec3) -> DVec3 {
    V::narrow(vector).widen()
}

/// Runs a ball and checks it after every step. The ball may be outside by the rounding of its own coordinates.
fn stays<V: Vector>(ball: Ball, walls: Vec<Item>, gravity: DVec3, h: f64) -> Result<(), TestCaseError> {
    let shapes: Vec<Box<dyn Boundary>> =
        walls.iter().map(|item| boundaries::build(item, V::DIMENSION, DVec3::ZERO).expect("fine")).collect();
    let mut laboratory = Laboratory::<V>::new(&[ball], walls, flat::<V>(gravity));
    for number in 0..20 {
        laboratory.step(h);
        let x = laboratory.position(0);
        prop_assert!(x.is_finite() && laboratory.velocity(0).is_finite());
        for shape in &shapes {
            let (distance, _) = shape.distance(x);
            let rounding = 4.0 * V::Scalar::EPSILON * (x.length() + 4.0);
            prop_assert!(distance >= ball.radius - rounding, "step {number}: {distance} from a {} at {x}", shape.name());
        }
    }
    Ok(())
}

fn stays_everywhere(ball: Ball, walls: &[Item], gravity: DVec3, h: f64) -> Result<(), TestCaseError> {
    stays::<DVec3>(ball, walls.to_vec(), gravity, h)?;
    stays::<Vec3>(ball, walls.to_vec(), gravity, h)?;
    let ball = Ball { position: flat::<DVec2>(ball.position), velocity: flat::<DVec2>(ball.velocity), ..ball };
    let mut walls = walls.to_vec();
    for value in walls.iter_mut().flat_map(|wall| wall.values.values_mut()) {
        if let Value::Vector(vector) = value {
            *vector = flat::<DVec2>(*vector);
        }
    }
    stays::<DVec2>(ball, walls.clone(), gravity, h)?;
    stays::<Vec2>(ball, walls, gravity, h)
}

proptest! {

    #[test]
    fn a_box(x in prop::array::uniform3(-0.85..0.85_f64), way in direction(), speed in speed(), radius in prop::sample::select(vec![0.0, 1e-6, 0.1]),
             e in 0.0..=1.0, mu in 0.0..1.0, h in step()) {
        let ball = Ball::new(DVec3::from_array(x), way * speed, radius);
        stays_everywhere(ball, &[cuboid(DVec3::splat(-1.0), DVec3::ONE, e, mu)], DVec3::new(0.0, -9.81, 0.0), h)?;
    }

    #[test]
    fn a_ball(x in prop::array::uniform3(-0.45..0.45_f64), way in direction(), speed in speed(), radius in prop::sample::select(vec![0.0, 1e-6, 0.1]),
              e in 0.0..=1.0, mu in 0.0..1.0, h in step()) {
        let ball = Ball::new(DVec3::from_array(x), way * speed, radius);
        stays_everywhere(ball, &[sphere(DVec3::ZERO, 1.0, true, e, mu)], DVec3::new(0.0, -9.81, 0.0), h)?;
    }

    /// Wedge of two oblique walls under strong gravity.
    #[test]
    fn a_wedge(way in direction(), speed in speed(), tilt in 0.1..2.0, radius in prop::sample::select(vec![0.0, 0.05]), e in 0.0..=1.0, mu in 0.0..1.0, h in step()) {
        let walls = [plane(DVec3::ZERO, DVec3::new(1.0, tilt, 0.0), e, mu), plane(DVec3::ZERO, DVec3::new(-1.0, tilt, 0.3), e, mu)];
        stays_everywhere(Ball::new(DVec3::new(0.0, 2.0, 0.0), way * speed, radius), &walls, DVec3::new(0.0, -1000.0, 0.0), h)?;
    }

    /// A fast particle that aims at a small sphere from afar is deflected: its path would have passed through.
    #[test]
    fn a_small_obstacle(way in direction(), speed in 1.0..6.0_f64, size in -3.0..0.0_f64, miss in 0.0..0.95_f64, side in direction(), when in 0.01..0.99_f64) {
        let (speed, size) = (10.0_f64.powf(speed), 10.0_f64.powf(size));
        // Across the path; the closest approach is `miss` radii from the center, at the fraction `when` of a step of 1 s.
        let across = way.cross(side);
        prop_assume!(across.length() > 0.1 && speed * when > 4.0 * size);
        let start = across.normalize() * (miss * size) - way * (speed * when);
        let mut laboratory = Laboratory::<DVec3>::new(&[Ball::new(start, way * speed, 0.0)], vec![sphere(DVec3::ZERO, size, false, 1.0, 0.0)], DVec3::ZERO);
        laboratory.step(1.0);
        // At the moment of impact the normal makes the angle arcsin(miss) with the path. The velocity turns by twice the
        // complement. The start is rounded by ε·10⁶ m, which may be 10⁻⁷ of the sphere, amplified near grazing.
        let turned = laboratory.velocity(0).normalize().dot(way);
        let exact = -(1.0 - 2.0 * miss * miss);
        let rounding = 8.0 * f64::EPSILON * speed / size / (1.0 - miss * miss).sqrt() + 1e-13;
        prop_assert!((turned - exact).abs() < 4.0 * rounding, "turned to {turned} instead of {exact}");
        prop_assert!((laboratory.velocity(0).length() / speed - 1.0).abs() < 1e-14);
    }
}
