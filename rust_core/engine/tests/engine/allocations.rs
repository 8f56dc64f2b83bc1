//! A step allocates nothing: all memory belongs to the plan.

use std::collections::BTreeMap;

use glam::DVec3;
use physcore_engine::forces::springs::Spring;
use physcore_engine::parallel::SERIAL;
use physcore_engine::scene::{Array, Body, Item, PARTICLES, Scene, Value};
use physcore_engine::simulation::{Numerics, Simulation, Vigilance};

use crate::CATALOG;

fn rope(springs: bool) -> Body {
    let count = 40;
    let spring = |index: u32| Spring { ends: [index, index + 1], stiffness: 100.0, damping: 0.1, rest_length: 0.1 };
    Body {
        positions: (0..count).map(|index| DVec3::new(0.1 * f64::from(index), 0.0, 1.0)).collect(),
        velocities: vec![DVec3::ZERO; count as usize],
        mass: vec![0.1; count as usize],
        charge: vec![0.0; count as usize],
        radius: vec![0.01; count as usize],
        fixed: (0..count).map(|index| index == 0).collect(),
        item: if springs { Spring::network(&(0..count - 1).map(spring).collect::<Vec<_>>()) } else { Item::new(PARTICLES, []) },
    }
}

#[test]
fn steps_allocate_nothing() {
    let forces = vec![
        Item::new("Gravity", [("acceleration", Value::Vector(DVec3::new(0.0, 0.0, -9.81)))]),
        Item::new("Drag", [("linear", Value::Number(0.01)), ("quadratic", Value::Number(0.1))]),
    ];
    let material = [("restitution", Value::Number(0.5)), ("friction", Value::Number(0.2))];
    let geometry = [("point", Value::Vector(DVec3::ZERO)), ("normal", Value::Vector(DVec3::Z))];
    let floor = Item::new("Plane", material.into_iter().chain(geometry));
    for springs in [true, false] {
        for integrator in [
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
        ] {
            let scene = Scene {
                dimension: 3,
                bodies: vec![rope(springs)],
                forces: forces.clone(),
                boundaries: vec![floor.clone()],
                ..Scene::default()
            };
            let numerics = Numerics {
                integrator: integrator.into(),
                integrators: BTreeMap::new(),
                precision: "f64".to_owned(),
                threads: Some(1),
                max_energy_growth: 1e6,
                vigilance: Vigilance::OutOfRange,
            };
            let mut world = Simulation::new(&scene, &numerics, CATALOG, &SERIAL).unwrap();
            world.step(10, 1e-3, &|| false).unwrap();
            let allocated = allocation_counter::measure(|| (0..10).for_each(|_| world.step(1, 1e-3, &|| false).unwrap()));
            // A step may end with an audit, which lists the names of the forces.
            assert!(allocated.count_total <= 10, "{integrator}, springs: {springs}: {allocated:?}");
        }
    }
}

/// Water that falls over in a box, with shifted particles. Its lists are rebuilt now and then, in existing memory.
#[test]
fn steps_of_a_shifted_fluid_allocate_nothing() {
    let spacing = 0.05;
    let at = |index: i32| spacing * (f64::from(index) + 0.5);
    let positions: Vec<DVec3> = (0..10).flat_map(|x| (0..20).map(move |y| DVec3::new(at(x), at(y), 0.0))).collect();
    let count = positions.len();
    let kernel = Item::new("WendlandC2", [("smoothing", Value::Number(1.5))]);
    let method = [
        ("sound_speed", Value::Number(40.0)),
        ("artificial_viscosity", Value::Number(0.02)),
        ("density_diffusion", Value::Number(0.1)),
        ("shifting", Value::Number(6.0)),
        ("density_from", Value::Text("continuity".to_owned())),
        ("kernel", Value::Record(Box::new(kernel))),
    ];
    let fluid = [
        ("method", Value::Record(Box::new(Item::new("WeaklyCompressible", method)))),
        ("spacing", Value::Number(spacing)),
        ("density", Value::Number(1000.0)),
        ("viscosity", Value::Number(1e-3)),
        ("surface_tension", Value::Number(0.0)),
        ("obstacles", Value::Flag(true)),
    ];
    let body = Body {
        velocities: vec![DVec3::ZERO; count],
        mass: vec![1000.0 * spacing * spacing; count],
        charge: vec![0.0; count],
        radius: vec![0.0; count],
        fixed: vec![false; count],
        item: Item::new("Fluid", fluid),
        positions,
    };
    let material = [("restitution", Value::Number(0.0)), ("friction", Value::Number(0.0))];
    let corners = [("lower", Value::Vector(DVec3::ZERO)), ("upper", Value::Vector(DVec3::new(1.5, 1.5, 0.0)))];
    let scene = Scene {
        dimension: 2,
        bodies: vec![body],
        forces: vec![Item::new("Gravity", [("acceleration", Value::Vector(DVec3::new(0.0, -9.81, 0.0)))])],
        boundaries: vec![Item::new("Box", material.into_iter().chain(corners))],
        ..Scene::default()
    };
    let numerics = Numerics {
        integrator: "VelocityVerlet".into(),
        integrators: BTreeMap::new(),
        precision: "f32".to_owned(),
        threads: Some(1),
        max_energy_growth: 1e6,
        vigilance: Vigilance::OutOfRange,
    };
    let mut world = Simulation::new(&scene, &numerics, CATALOG, &SERIAL).unwrap();
    world.step(200, 5e-4, &|| false).unwrap();
    let allocated = allocation_counter::measure(|| (0..10).for_each(|_| world.step(1, 5e-4, &|| false).unwrap()));
    // As above, for the audit.
    assert!(allocated.count_total <= 10, "{allocated:?}");
}

/// A wave, one step at a time and many in one pass over memory.
#[test]
fn steps_on_grids_allocate_nothing() {
    const SIDE: usize = 64;
    let grid = || {
        let vector = |value: f64| Value::Vector(DVec3::new(value, value, 0.0));
        let cells = ("cells", vector(SIDE as f64));
        Item::new("Grid", [cells, ("spacing", Value::Number(1.0)), ("origin", vector(0.0)), ("periodic", vector(0.0))])
    };
    let ripple = |size: f64| {
        let entries = (0..SIDE * SIDE).map(|cell| size * (0.01 * cell as f64).sin().abs()).collect();
        Value::Numbers(Array { shape: vec![SIDE, SIDE], entries })
    };
    let edges = Value::Texts(vec!["fixed".to_owned(); 4]);
    let numbers = [("speed", 1.0), ("damping", 0.0), ("rate", 0.0), ("density", 1.0), ("order", 2.0)];
    let values = [("grid", Value::Record(Box::new(grid()))), ("edges", edges), ("displacement", ripple(1.0))];
    let wave = Item::new("Wave", numbers.map(|(name, number)| (name, Value::Number(number))).into_iter().chain(values));
    for integrator in ["VelocityVerlet", "RungeKutta4", "BlanesMoan4"] {
        let scene = Scene { dimension: 2, systems: vec![wave.clone()], ..Scene::default() };
        let numerics = Numerics {
            integrator: integrator.into(),
            integrators: BTreeMap::new(),
            precision: "f64".to_owned(),
            threads: Some(1),
            max_energy_growth: 1e6,
            vigilance: Vigilance::OutOfRange,
        };
        let mut world = Simulation::new(&scene, &numerics, CATALOG, &SERIAL).unwrap();
        world.step(40, 0.5, &|| false).unwrap();
        for steps in [1, 40] {
            let allocated = allocation_counter::measure(|| (0..10).for_each(|_| world.step(steps, 0.5, &|| false).unwrap()));
            assert!(allocated.count_total <= 10, "{integrator}, {steps} steps: {allocated:?}");
        }
    }
}
