//! A step allocates nothing: all memory belongs to the plan.

use std::collections::BTreeMap;

use glam::DVec3;
use physcore_engine::scene::{Body, Scene, Spring, Term, Value};
use physcore_engine::simulation::{Numerics, build};

fn term(path: &str, kind: &str, values: &[(&str, Value)]) -> Term {
    let values: BTreeMap<_, _> = values.iter().map(|(name, value)| ((*name).to_owned(), value.clone())).collect();
    Term { path: path.to_owned(), kind: kind.to_owned(), on: None, values }
}

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
        springs: if springs { (0..count - 1).map(spring).collect() } else { Vec::new() },
        ..Body::default()
    }
}

#[test]
fn steps_allocate_nothing() {
    let forces = vec![
        term("forces[0]", "Gravity", &[("acceleration", Value::Vector(DVec3::new(0.0, 0.0, -9.81)))]),
        term("forces[1]", "Drag", &[("linear", Value::Number(0.01)), ("quadratic", Value::Number(0.1))]),
    ];
    let material = [("restitution", Value::Number(0.5)), ("friction", Value::Number(0.2))];
    let geometry = [("point", Value::Vector(DVec3::ZERO)), ("normal", Value::Vector(DVec3::Z))];
    let floor = term("boundaries[0]", "Plane", &[&material[..], &geometry[..]].concat());
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
                integrator: integrator.to_owned(),
                precision: "f64".to_owned(),
                threads: Some(1),
                runaway: 1e6,
                ignore_runaway: true,
            };
            let mut world = build(&scene, &numerics).unwrap();
            world.step(10, 1e-3, &|| false).unwrap();
            let allocated = allocation_counter::measure(|| (0..10).for_each(|_| world.step(1, 1e-3, &|| false).unwrap()));
            // A step may end with an audit, which lists the names of the forces.
            assert!(allocated.count_total <= 10, "{integrator}, springs: {springs}: {allocated:?}");
        }
    }
}
