//! Scenes of any size and shape: no panic, and either an error or a finite state. `PROPTEST_CASES` is their number.

use std::collections::BTreeMap;

use glam::DVec3;
use physcore_engine::error::Error;
use physcore_engine::forces::springs::Spring;
use physcore_engine::parallel::SERIAL;
use physcore_engine::scene::{Body, Item, Scene, Value};
use physcore_engine::simulation::{Numerics, Simulation, Vigilance};
use physcore_engine::stability::Horizon;
use proptest::prelude::*;
use proptest::sample::select;

use crate::CATALOG;

const INTEGRATORS: [&str; 10] = [
    "ExplicitEuler",
    "SemiImplicitEuler",
    "VelocityVerlet",
    "McLachlan2",
    "RungeKutta4",
    "PEFRL",
    "BlanesMoan4",
    "BlanesMoan6",
    "BogackiShampine3",
    "DormandPrince5",
];

const FORCES: [&str; 5] = ["Gravity", "Drag", "CentralForce", "LennardJones", "SoftSpheres"];

/// Number ≥ 0, mostly within six decades of 1.
fn amount() -> impl Strategy<Value = f64> {
    let within =
        |decades: i32| (1.0..10.0_f64, -decades..decades).prop_map(|(mantissa, exponent)| mantissa * 10.0_f64.powi(exponent));
    prop_oneof![20 => within(6), 2 => within(300), 2 => Just(0.0), 1 => select(vec![5e-324, 1e-308, f64::MAX])]
}

/// Number > 0.
fn positive() -> impl Strategy<Value = f64> {
    amount().prop_map(|number| if number > 0.0 { number } else { 1.0 })
}

/// Number of either sign.
fn number() -> impl Strategy<Value = f64> {
    (amount(), any::<bool>()).prop_map(|(number, negative)| if negative { -number } else { number })
}

fn vector() -> impl Strategy<Value = DVec3> {
    (number(), number(), number()).prop_map(|(x, y, z)| DVec3::new(x, y, z))
}

/// Up to six particles that start on a lattice, with springs from each to the next.
fn body() -> impl Strategy<Value = Body> {
    let particles = (1_usize..7, positive(), vector(), positive(), prop_oneof![Just(0.0), amount()]);
    let springs = (prop::option::of((amount(), amount(), amount())), any::<bool>());
    (particles, springs, prop::option::weighted(0.2, fluid())).prop_map(
        |((count, spacing, velocity, mass, radius), (spring, fixed), fluid)| {
            let lattice_point = |index: usize| DVec3::new((index % 2) as f64, (index / 2) as f64, 0.0) * spacing;
            let ends = |index: usize| [index as u32, index as u32 + 1];
            let link = |(stiffness, damping, rest_length): (f64, f64, f64)| {
                (1..count).map(|index| Spring { ends: ends(index - 1), stiffness, damping, rest_length }).collect::<Vec<_>>()
            };
            Body {
                positions: (0..count).map(lattice_point).collect(),
                velocities: vec![velocity; count],
                mass: vec![mass; count],
                charge: vec![0.0; count],
                radius: vec![if fluid.is_some() { 0.0 } else { radius }; count],
                fixed: (0..count).map(|index| fixed && fluid.is_none() && index == 0).collect(),
                item: match fluid {
                    Some(mut fluid) => {
                        fluid.values.insert("spacing".to_owned(), Value::Number(spacing));
                        fluid
                    }
                    None => Spring::network(&spring.map(link).unwrap_or_default()),
                },
            }
        },
    )
}

fn fluid() -> impl Strategy<Value = Item> {
    let numbers = (positive(), amount(), prop::option::of(positive()), amount(), amount());
    let kernel = select(vec!["WendlandC2", "WendlandC4", "CubicSpline"]);
    (numbers, kernel, any::<bool>()).prop_map(|((density, viscosity, sound_speed, alpha, tension), kernel, summation)| {
        let text = |text: &str| Value::Text(text.to_owned());
        let kernel = Item::new(kernel, [("smoothing", Value::Number(1.5))]);
        let method = [
            ("sound_speed", sound_speed.map_or_else(|| text("auto"), Value::Number)),
            ("artificial_viscosity", Value::Number(alpha)),
            ("density_diffusion", Value::Number(0.1)),
            ("shifting", Value::Number(0.0)),
            ("density_from", text(if summation { "summation" } else { "continuity" })),
            ("kernel", Value::Record(Box::new(kernel))),
        ];
        let values = [
            ("method", Value::Record(Box::new(Item::new("WeaklyCompressible", method)))),
            ("density", Value::Number(density)),
            ("viscosity", Value::Number(viscosity)),
            ("surface_tension", Value::Number(tension)),
            ("obstacles", Value::Flag(true)),
        ];
        Item::new("Fluid", values)
    })
}

/// Force with any parameters that Python accepts.
fn force() -> impl Strategy<Value = Item> {
    (select(&FORCES[..]), vector(), number(), amount(), amount(), positive()).prop_map(
        |(kind, vector, signed, first, second, positive)| {
            let values = match kind {
                "Gravity" => vec![("acceleration", Value::Vector(vector))],
                "Drag" => {
                    vec![("linear", Value::Number(first)), ("quadratic", Value::Number(second)), ("wind", Value::Vector(vector))]
                }
                "CentralForce" => vec![
                    ("center", Value::Vector(vector)),
                    ("strength", Value::Number(signed)),
                    ("exponent", Value::Number(-2.0)),
                    ("softening", Value::Number(first)),
                ],
                "LennardJones" => vec![
                    ("epsilon", Value::Number(first)),
                    ("sigma", Value::Number(positive)),
                    ("cutoff", Value::Number(2.5 * positive)),
                ],
                _ => vec![
                    ("stiffness", Value::Number(positive)),
                    ("damping", Value::Number(first)),
                    ("friction", Value::Number(0.0)),
                    ("tangential_damping", Value::Number(0.0)),
                    ("exponent", Value::Number(1.0)),
                ],
            };
            Item::new(kind, values)
        },
    )
}

/// Plane or sphere around everything.
fn boundary() -> impl Strategy<Value = Item> {
    (any::<bool>(), vector(), positive(), 0.0..=1.0_f64, amount()).prop_map(|(plane, vector, size, restitution, friction)| {
        let material =
            [("restitution", Value::Number(restitution)), ("friction", Value::Number(friction)), ("no_slip", Value::Flag(false))];
        let geometry = if plane {
            vec![("point", Value::Vector(DVec3::new(0.0, -size, 0.0))), ("normal", Value::Vector(vector))]
        } else {
            vec![("center", Value::Vector(DVec3::ZERO)), ("radius", Value::Number(size)), ("inside", Value::Flag(true))]
        };
        Item::new(if plane { "Plane" } else { "Sphere" }, material.into_iter().chain(geometry))
    })
}

fn scene() -> impl Strategy<Value = Scene> {
    let items =
        (prop::collection::vec(body(), 1..3), prop::collection::vec(force(), 0..3), prop::collection::vec(boundary(), 0..2));
    (2_usize..4, items, prop::option::weighted(0.2, positive())).prop_map(|(dimension, (bodies, forces, boundaries), period)| {
        let corner = |size: f64| DVec3::new(size, size, if dimension == 2 { 0.0 } else { size });
        let mut scene = Scene {
            dimension,
            bodies,
            forces,
            boundaries,
            periodic: period.map(|size| [corner(-size), corner(size)]),
            ..Scene::default()
        };
        if dimension == 2 {
            flatten(&mut scene);
        }
        scene
    })
}

/// Projects everything onto the plane z = 0.
fn flatten(scene: &mut Scene) {
    for vector in scene.bodies.iter_mut().flat_map(|body| &mut body.velocities) {
        vector.z = 0.0;
    }
    for value in scene.forces.iter_mut().chain(&mut scene.boundaries).flat_map(|item| item.values.values_mut()) {
        if let Value::Vector(vector) = value {
            vector.z = 0.0;
        }
    }
}

fn numerics() -> impl Strategy<Value = Numerics> {
    let vigilance = vec![Vigilance::OutOfRange, Vigilance::Active, Vigilance::EveryStep];
    (select(&INTEGRATORS[..]), select(vec!["f32", "f64"]), select(vigilance)).prop_map(|(integrator, precision, vigilance)| {
        Numerics {
            integrator: integrator.into(),
            integrators: BTreeMap::new(),
            precision: precision.to_owned(),
            threads: Some(1),
            max_energy_growth: 1e6,
            vigilance,
        }
    })
}

fn is_finite(world: &Simulation) -> bool {
    let values = |name: &str| world.read(name).map_or(Vec::new(), |(_, values)| values);
    values("positions").iter().chain(&values("velocities")).all(|value| value.is_finite())
}

proptest! {
    #[test]
    fn a_scene_is_refused_or_stays_finite(scene in scene(), numerics in numerics(), dt in amount(), steps in 1_u64..20) {
        let Ok(mut world) = Simulation::new(&scene, &numerics, CATALOG, &SERIAL) else { return Ok(()) };
        prop_assert!(is_finite(&world), "not finite at the start");
        for horizon in [Horizon::Sharp, Horizon::Certified, Horizon::Present] {
            prop_assert!(!world.limit(horizon, &SERIAL).unwrap().dt().is_nan(), "the limit is not a number");
        }
        let outcome = world.step(steps, dt, &|| false);
        prop_assert!(!matches!(outcome, Err(Error::State(_))), "{:?}", outcome);
        prop_assert!(is_finite(&world), "not finite after {:?}", outcome);
        let capture = world.capture();
        let mut other = Simulation::new(&scene, &numerics, CATALOG, &SERIAL).unwrap();
        other.restore(&capture).unwrap();
        prop_assert_eq!(world.state_hash(), other.state_hash());
        if world.energy(&SERIAL).is_ok() {
            let (_, positions) = world.read("positions").unwrap();
            let refused = world.write(&[("velocities", &positions)], &SERIAL).is_err();
            prop_assert!(refused || is_finite(&world), "not finite after new velocities");
        }
    }
}
