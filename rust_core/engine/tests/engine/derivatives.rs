//! Derivatives of forces for implicit methods, compared with differences of the forces themselves.

use glam::{DVec2, DVec3};
use physcore_engine::catalog::Space;
use physcore_engine::forces::derivatives::{MatrixBlock, Motion, Push};
use physcore_engine::forces::{self, Rates, StateView};
use physcore_engine::matter::{Columns, Power, Properties, SINKS, View};
use physcore_engine::parallel::SERIAL;
use physcore_engine::scene::{Array, Body, Item, Scene, Value};
use physcore_engine::simd::{LANES, padded};

use crate::CATALOG;

/// Step of differences: with forces of about 1 their errors are δ² and ε/δ, 1e-11 and 4e-11.
const STEP: f64 = 5e-6;

fn numbers(values: &[(&'static str, f64)]) -> Vec<(&'static str, Value)> {
    values.iter().map(|&(name, value)| (name, Value::Number(value))).collect()
}

/// Pseudorandom number in (−1, 1), the same in every run.
fn random(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 11) as f64 / 2f64.powi(52) - 1.0
}

fn vectors(seed: &mut u64, count: usize, dimension: usize, size: f64) -> Vec<DVec3> {
    let mut component = |axis: usize| if axis < dimension { size * random(seed) } else { 0.0 };
    (0..count).map(|_| DVec3::from_array([0, 1, 2].map(&mut component))).collect()
}

/// Dented sheet of 4 × 3 particles of radius 0.6 m, a meter apart, with six faces.
fn scene(dimension: usize, force: Item) -> Scene {
    let shifts = vectors(&mut 7, 12, dimension, 0.15);
    let positions: Vec<DVec3> = shifts
        .iter()
        .enumerate()
        .map(|(index, &shift)| DVec3::new((index % 4) as f64, (index / 4) as f64, 0.0) + shift)
        .collect();
    let faces =
        (0..2).flat_map(|row: u32| (0..3).flat_map(move |column| [4 * row + column, 4 * row + column + 1, 4 * row + column + 4]));
    let faces = Value::Indices(Array { shape: vec![6, 3], entries: faces.collect() });
    let body = Body {
        velocities: vec![DVec3::ZERO; 12],
        mass: vec![1.0; 12],
        charge: vec![0.0; 12],
        radius: vec![0.6; 12],
        fixed: vec![false; 12],
        positions,
        item: Item::new("Particles", [("faces", faces)]),
    };
    Scene { dimension, bodies: vec![body], forces: vec![force], ..Scene::default() }
}

/// Force of a scene in one dimension, with a state.
struct Laboratory<V: Space> {
    force: Box<dyn forces::Force<V>>,
    properties: Properties<V>,
    position: Vec<DVec3>,
    velocity: Vec<DVec3>,
}

impl<V: Space<Scalar = f64>> Laboratory<V> {
    fn new(force: Item, speed: f64) -> Self {
        let scene = scene(V::DIMENSION, force);
        let mut properties = Properties::<V>::new(vec![1.0; 12]);
        properties.radius = vec![0.6; 12];
        properties.origin = DVec3::new(0.5, -0.3, 0.0);
        let built = V::forces(CATALOG).build(&scene, &scene.forces[0], &properties, &SERIAL).unwrap();
        let force = built.into_iter().next_back().unwrap();
        let position = scene.bodies[0].positions.iter().map(|&x| x - properties.origin).collect();
        Self { force, properties, position, velocity: vectors(&mut 11, 12, V::DIMENSION, speed) }
    }

    fn at(&mut self, displacement: &[DVec3], change: &[DVec3]) -> [Vec<DVec3>; 2] {
        let add = |one: &[DVec3], other: &[DVec3]| one.iter().zip(other).map(|(&one, &other)| one + other).collect();
        [add(&self.position, displacement), add(&self.velocity, change)]
    }

    /// Forces at the state changed by these displacements and velocities.
    fn forces(&mut self, displacement: &[DVec3], change: &[DVec3]) -> Vec<DVec3> {
        let [position, velocity] = self.at(displacement, change);
        let at = Motion { position: &position, velocity: &velocity, origin: self.properties.origin, time: 0.0 };
        let derivatives = self.force.derivatives().expect("derivatives");
        derivatives.arrange(&at, &SERIAL).unwrap();
        let mut sum = vec![DVec3::ZERO; 12];
        derivatives.forces(&at, &mut |Push { particle, force, .. }| sum[particle] += force);
        sum
    }

    /// Product of s K + r C with displacements; checks that uᵀ B u of its definite part is not negative for random u.
    fn product(&mut self, weights: [f64; 2], u: &[DVec3]) -> Vec<DVec3> {
        let at = Motion { position: &self.position, velocity: &self.velocity, origin: self.properties.origin, time: 0.0 };
        let derivatives = self.force.derivatives().expect("derivatives");
        derivatives.arrange(&at, &SERIAL).unwrap();
        let (mut exact, mut definite) = (vec![DVec3::ZERO; 12], vec![DVec3::ZERO; 12]);
        derivatives.blocks(&at, weights, &mut |block: MatrixBlock| {
            let [one, other] = block.ends.map(|end| end as usize);
            for (sum, matrix) in [(&mut exact, block.exact), (&mut definite, block.definite)] {
                if one == other {
                    sum[one] += matrix * u[one];
                } else {
                    sum[one] += matrix * (u[one] - u[other]);
                    sum[other] += matrix.transpose() * (u[other] - u[one]);
                }
            }
        });
        let form: f64 = definite.iter().zip(u).map(|(product, u)| product.dot(*u)).sum();
        assert!(form > -1e-9, "not definite: {form}");
        exact
    }

    /// Forces of explicit methods.
    fn accumulated(&mut self) -> Vec<DVec3> {
        let columns = |values: &[DVec3]| Columns::<V>::from_fn(12, |index| V::narrow(values[index]));
        let (position, velocity) = (columns(&self.position), columns(&self.velocity));
        let at = StateView {
            position: position.view(),
            velocity: velocity.view(),
            residual: View::default(),
            properties: &self.properties,
            solids: &[],
            time: 0.0,
            executor: &SERIAL,
        };
        self.force.prepare(&at, &SERIAL).unwrap();
        let (mut force, mut power): (_, Power) = (Columns::<V>::zeros(12), [[0.0; LANES]; SINKS]);
        self.force.accumulate(0..padded(12), &at, &mut Rates::new(force.span(), &mut power));
        (0..12).map(|index| force.get(index).widen()).collect()
    }
}

/// Compares a force with that of explicit methods. Compares K with differences by positions, at rest unless `in_motion`, and
/// C with differences by velocities in motion.
fn check<V: Space<Scalar = f64>>(force: &Item, in_motion: bool) {
    let still = vec![DVec3::ZERO; 12];
    for seed in 0..5 {
        for (speed, weights) in [(0.0, [1.0, 0.0]), (0.7, [0.0, 1.0])] {
            let mut laboratory = Laboratory::<V>::new(force.clone(), if in_motion { 0.7 } else { speed });
            let explicit = laboratory.accumulated();
            for (one, other) in laboratory.forces(&still, &still).iter().zip(&explicit) {
                assert!((*one - *other).length() < 1e-12 * (1.0 + other.length()), "{force:?}: {one} instead of {other}");
            }
            let u = vectors(&mut (seed + 3), 12, V::DIMENSION, 1.0);
            let [forward, backward] = [STEP, -STEP].map(|step| {
                let way: Vec<DVec3> = u.iter().map(|&u| step * u).collect();
                if weights[0] > 0.0 { laboratory.forces(&way, &still) } else { laboratory.forces(&still, &way) }
            });
            let product = laboratory.product(weights, &u);
            let size = product.iter().map(|product| product.length()).fold(1.0, f64::max);
            for index in 0..12 {
                let difference = (backward[index] - forward[index]) / (2.0 * STEP);
                let error = (product[index] - difference).length();
                // Truncation error: the square of the step over the slowest slip, a few hundredths [m/s].
                assert!(error < 2e-7 * size, "{force:?} {weights:?}: {} instead of {difference}", product[index]);
            }
        }
    }
}

fn repulsion(damping: f64, friction: f64, tangential: f64, exponent: f64) -> Item {
    let values = [
        ("stiffness", 3.0),
        ("damping", damping),
        ("friction", friction),
        ("tangential_damping", tangential),
        ("exponent", exponent),
    ];
    Item::new("SoftSpheres", numbers(&values))
}

/// Atoms near the inflection of their potential, where it is stiff along the bond, and pulls across.
#[test]
fn of_atoms() {
    for cutoff in [1.4, 2.5] {
        let force = Item::new("LennardJones", numbers(&[("epsilon", 1.0), ("sigma", 0.9), ("cutoff", cutoff)]));
        check::<DVec2>(&force, false);
        check::<DVec3>(&force, false);
    }
}

/// Friction that sticks, and friction that slides, on contacts without damping of their normal motion.
#[test]
fn of_soft_spheres() {
    for exponent in [1.0, 1.5] {
        let mut bouncing = repulsion(0.0, 1e3, 0.3, exponent);
        bouncing.values.insert("restitution".to_owned(), Value::Number(0.4));
        for force in [repulsion(0.2, 1e3, 0.3, exponent), repulsion(0.0, 0.1, 50.0, exponent), bouncing] {
            check::<DVec2>(&force, false);
            check::<DVec3>(&force, false);
        }
    }
}

#[test]
fn of_central_forces() {
    for (exponent, softening, strength) in
        [(-2.0, 0.0, 1.0), (-2.0, 0.3, 1.0), (-1.7, 0.1, -2.0), (0.0, 0.1, 1.0), (3.0, 0.0, 0.5)]
    {
        let mut values = numbers(&[("strength", strength), ("exponent", exponent), ("softening", softening)]);
        values.push(("center", Value::Vector(DVec3::new(1.4, 0.6, 0.0))));
        let force = Item::new("CentralForce", values);
        check::<DVec2>(&force, false);
        check::<DVec3>(&force, false);
    }
}

/// Gravitation with its pole, and softened.
#[test]
fn of_gravitation() {
    for softening in [0.0, 0.3] {
        let values = numbers(&[("constant", 0.7), ("softening", softening), ("opening_angle", 0.0)]);
        let force = Item::new("Gravitation", values);
        check::<DVec2>(&force, false);
        check::<DVec3>(&force, false);
    }
}

#[test]
fn of_drag() {
    let mut values = numbers(&[("linear", 0.0), ("quadratic", 0.4)]);
    values.push(("wind", Value::Vector(DVec3::new(0.3, -0.2, 0.0))));
    let force = Item::new("Drag", values);
    check::<DVec2>(&force, true);
    check::<DVec3>(&force, true);
}

/// Hinges bent far from rest, so that all second derivatives of the angles count.
#[test]
fn of_hinges() {
    let rows = |entries: Vec<u32>| Value::Indices(Array { shape: vec![entries.len() / 4, 4], entries });
    let values = [
        ("hinges", rows(vec![1, 4, 0, 5, 5, 2, 1, 6, 6, 3, 2, 7, 5, 8, 4, 9])),
        ("rest_angle", Value::Numbers(vec![0.4, -1.0, 2.5, 0.0].into())),
        ("weight", Value::Numbers(vec![1.0, 0.7, 0.5, 1.2].into())),
        ("stiffness", Value::Number(0.8)),
        ("damping", Value::Number(0.3)),
    ];
    check::<DVec3>(&Item::new("Dihedral", values), false);
}

/// Wind: derivatives by velocities alone; those by positions are left out.
#[test]
fn of_wind_by_velocity() {
    let mut values = numbers(&[("density", 1.2), ("normal", 1.1), ("tangential", 0.3)]);
    values.push(("velocity", Value::Vector(DVec3::new(2.0, -1.0, 1.5))));
    let mut laboratory = Laboratory::<DVec3>::new(Item::new("Wind", values), 0.7);
    let (u, still) = (vectors(&mut 5, 12, 3, 1.0), vec![DVec3::ZERO; 12]);
    let [forward, backward] = [STEP, -STEP].map(|step| {
        let way: Vec<DVec3> = u.iter().map(|&u| step * u).collect();
        laboratory.forces(&still, &way)
    });
    for (index, product) in laboratory.product([0.0, 1.0], &u).into_iter().enumerate() {
        let difference = (backward[index] - forward[index]) / (2.0 * STEP);
        assert!((product - difference).length() < 2e-8, "{product} instead of {difference}");
    }
}
