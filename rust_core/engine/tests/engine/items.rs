//! Required values of the items of a scene, and the errors if they are missing.

use std::collections::BTreeMap;

use glam::DVec3;
use physcore_engine::error::{Error, Result};
use physcore_engine::forces::springs::{self, Spring};
use physcore_engine::parallel::SERIAL;
use physcore_engine::scene::{Array, Body, Item, Scene, Value, corners};
use physcore_engine::simulation::{Numerics, Simulation, Vigilance};

use crate::CATALOG;

fn numbers(shape: &[usize], entries: &[f64]) -> Value {
    Value::Numbers(Array { shape: shape.to_vec(), entries: entries.to_vec() })
}

/// Two particles in 2D, one of them fixed.
fn pair() -> Item {
    let values = [
        ("positions", numbers(&[2, 2], &[1.0, 2.0, 3.0, 4.0])),
        ("velocities", numbers(&[2, 2], &[0.0, 0.0, 5.0, 6.0])),
        ("mass", numbers(&[2], &[1.0, 2.0])),
        ("charge", numbers(&[2], &[0.0, 0.5])),
        ("radius", numbers(&[2], &[0.1, 0.2])),
        ("fixed", Value::Flags(vec![true, false].into())),
        ("color", Value::Text("red".to_owned())),
    ];
    Item { path: "bodies[3]".to_owned(), ..Item::new("Particles", values) }
}

fn simulation(scene: &Scene) -> Result<Simulation> {
    let numerics = Numerics {
        integrator: "VelocityVerlet".into(),
        integrators: BTreeMap::new(),
        precision: "f64".to_owned(),
        threads: Some(1),
        max_energy_growth: 1e6,
        vigilance: Vigilance::Active,
    };
    Simulation::new(scene, &numerics, CATALOG, &SERIAL)
}

fn message<T>(outcome: Result<T>) -> String {
    match outcome {
        Err(error @ Error::Parameter { .. }) => error.to_string(),
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("accepted"),
    }
}

#[test]
fn a_body_has_columns_and_keeps_what_else_its_item_says() {
    let body = Body::new(pair(), 2).unwrap();
    assert_eq!(body.positions, [DVec3::new(1.0, 2.0, 0.0), DVec3::new(3.0, 4.0, 0.0)]);
    assert_eq!(body.velocities[1], DVec3::new(5.0, 6.0, 0.0));
    assert_eq!((body.mass, body.charge, body.radius), (vec![1.0, 2.0], vec![0.0, 0.5], vec![0.1, 0.2]));
    assert_eq!(body.fixed, [true, false]);
    assert_eq!(body.item.values.keys().collect::<Vec<_>>(), ["color"]);
    let values = ["positions", "velocities"].map(|name| (name, numbers(&[1, 3], &[7.0, 8.0, 9.0])));
    let columns = ["mass", "charge", "radius"].map(|name| (name, numbers(&[1], &[1.0])));
    let fixed = [("fixed", Value::Flags(vec![false].into()))];
    let solid = Body::new(Item::new("Particles", values.into_iter().chain(columns).chain(fixed)), 3).unwrap();
    assert_eq!(solid.positions, [DVec3::new(7.0, 8.0, 9.0)]);
}

#[test]
fn a_column_that_does_not_fit_is_named() {
    let wrong = [
        ("positions", numbers(&[2, 3], &[0.0; 6])),
        ("velocities", numbers(&[1, 2], &[0.0; 2])),
        ("mass", numbers(&[3], &[1.0; 3])),
        ("charge", numbers(&[2, 1], &[0.0; 2])),
        ("radius", Value::Number(1.0)),
        ("fixed", Value::Flags(vec![true].into())),
    ];
    for (name, value) in wrong {
        let mut item = pair();
        item.values.insert(name.to_owned(), value);
        assert!(message(Body::new(item, 2)).starts_with(&format!("bodies[3].{name}: expected")), "{name}");
        let mut item = pair();
        item.values.remove(name);
        assert!(message(Body::new(item, 2)).ends_with("got nothing"), "{name}");
    }
}

#[test]
fn a_network_says_what_each_spring_is() {
    let spring = |end: u32| Spring { ends: [end, end + 1], stiffness: 3.0, damping: 0.5, rest_length: f64::from(end) };
    let network = |count: u32| Body {
        positions: vec![DVec3::ZERO; count as usize + 1],
        item: Item { path: "bodies[1]".to_owned(), ..Spring::network(&(0..count).map(spring).collect::<Vec<_>>()) },
        ..Body::default()
    };
    let dust = Body { positions: vec![DVec3::ZERO; 5], ..Body::default() };
    let mut scene = Scene { dimension: 2, bodies: vec![dust, network(2), network(1)], ..Scene::default() };
    assert_eq!(springs::count(&scene).unwrap(), 3);
    let found: Vec<_> = springs::declared(&scene).unwrap().iter().map(|spring| (spring.ends, spring.rest_length)).collect();
    assert_eq!(found, [([5, 6], 0.0), ([6, 7], 1.0), ([8, 9], 0.0)]);
    scene.bodies[1].positions.pop();
    assert_eq!(message(springs::declared(&scene)), "bodies[1].pairs[1]: expected two of 2 particles, got [1, 2]");
    scene.bodies[1] = network(2);
    scene.bodies[1].item.values.insert("damping".to_owned(), numbers(&[1], &[0.0]));
    let refused = message(springs::declared(&scene));
    assert_eq!(refused, "bodies[1].damping: expected 2 numbers, got an array of shape [1] of numbers");
    scene.bodies[1].item.values.insert("pairs".to_owned(), Value::Indices(vec![0, 1].into()));
    assert!(message(springs::count(&scene)).starts_with("bodies[1].pairs: expected rows of 2 indices"));
}

#[test]
fn an_unknown_kind_is_refused_with_its_path() {
    let item = |path: &str| Item { path: path.to_owned(), ..Item::new("Pond", []) };
    let body = Body::new(pair(), 2).unwrap();
    let scene = Scene { dimension: 2, bodies: vec![body.clone()], ..Scene::default() };
    assert!(simulation(&scene).is_ok());
    let cases = [
        Scene { bodies: vec![Body { item: item("bodies[0]"), ..body }], ..scene.clone() },
        Scene { forces: vec![item("forces[0]")], ..scene.clone() },
        Scene { boundaries: vec![item("boundaries[0]")], ..scene.clone() },
        Scene { systems: vec![item("systems[0]")], ..scene },
    ];
    for (scene, path) in cases.iter().zip(["bodies[0]", "forces[0]", "boundaries[0]", "systems[0]"]) {
        let refused = message(simulation(scene));
        assert!(refused.starts_with(&format!("{path}: expected a")) && refused.ends_with("got Pond"), "{refused}");
    }
}

#[test]
fn a_domain_has_no_ends_along_an_axis_that_is_not_there() {
    let corner = |name: &'static str, x: f64| (name, Value::Vector(DVec3::new(x, f64::INFINITY.copysign(x), 0.0)));
    let domain = Item { path: "periodic".to_owned(), ..Item::new("Periodic", [corner("lower", -1.0), corner("upper", 1.0)]) };
    let [lower, upper] = corners(&domain, 2).unwrap();
    assert_eq!((lower, upper), (-upper, DVec3::new(1.0, f64::INFINITY, f64::INFINITY)));
    assert_eq!(corners(&domain, 3).unwrap()[0].z, 0.0);
    assert_eq!(
        message(corners(&Item { path: "periodic".to_owned(), ..Item::from("Periodic") }, 2)),
        "periodic.lower: expected a corner, got nothing"
    );
}

#[test]
fn items_are_equal_if_they_say_the_same() {
    let said = |value: Value| Item::new("Fluid", [("kernel", value)]);
    let kernel = |path: &str, h: f64| {
        Value::Record(Box::new(Item { path: path.to_owned(), ..Item::new("WendlandC2", [("smoothing", Value::Number(h))]) }))
    };
    assert_eq!(said(kernel("bodies[0].kernel", 1.5)), said(kernel("bodies[1].kernel", 1.5)));
    assert_ne!(said(kernel("bodies[0].kernel", 1.5)), said(kernel("bodies[0].kernel", 1.6)));
    assert_ne!(said(Value::Flag(true)), said(Value::Number(1.0)));
}
