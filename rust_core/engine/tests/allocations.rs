//! A step allocates nothing: all memory belongs to the plan.

use std::collections::BTreeMap;

use glam::DVec3;
use physcore_engine::parallel::SERIAL;
use physcore_engine::scene::{Body, Fluid, Scene, Spring, Term, Value};
use physcore_engine::simulation::{Numerics, Simulation, Vigilance};

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
                max_energy_growth: 1e6,
                vigilance: Vigilance::OutOfRange,
            };
            let mut world = Simulation::new(&scene, &numerics, &SERIAL).unwrap();
            world.step(10, 1e-3, &|| false).unwrap();
            let allocated = allocation_counter::measure(|| (0..10).for_each(|_| world.step(1, 1e-3, &|| false).unwrap()));
            // A step may end with an audit, which lists the names of the forces.
            assert!(allocated.count_total <= 10, "{integrator}, springs: {springs}: {allocated:?}");
        }
    }
}

/// Water that falls over in a box, and is shifted: its lists are made anew now and then, in memory that is there.
#[test]
fn steps_of_a_shifted_fluid_allocate_nothing() {
    let spacing = 0.05;
    let at = |index: i32| spacing * (f64::from(index) + 0.5);
    let positions: Vec<DVec3> = (0..10).flat_map(|x| (0..20).map(move |y| DVec3::new(at(x), at(y), 0.0))).collect();
    let count = positions.len();
    let fluid = Fluid {
        spacing,
        density: 1000.0,
        viscosity: 1e-3,
        sound_speed: Some(40.0),
        artificial_viscosity: 0.02,
        density_diffusion: 0.1,
        surface_tension: 0.0,
        shifting: 6.0,
        summation: false,
        kernel: "WendlandC2".to_owned(),
        smoothing: 1.5,
        obstacles: true,
    };
    let body = Body {
        velocities: vec![DVec3::ZERO; count],
        mass: vec![1000.0 * spacing * spacing; count],
        charge: vec![0.0; count],
        radius: vec![0.0; count],
        fixed: vec![false; count],
        fluid: Some(fluid),
        positions,
        ..Body::default()
    };
    let material = [("restitution", Value::Number(0.0)), ("friction", Value::Number(0.0))];
    let corners = [("lower", Value::Vector(DVec3::ZERO)), ("upper", Value::Vector(DVec3::new(1.5, 1.5, 0.0)))];
    let scene = Scene {
        dimension: 2,
        bodies: vec![body],
        forces: vec![term("forces[0]", "Gravity", &[("acceleration", Value::Vector(DVec3::new(0.0, -9.81, 0.0)))])],
        boundaries: vec![term("boundaries[0]", "Box", &[&material[..], &corners[..]].concat())],
        ..Scene::default()
    };
    let numerics = Numerics {
        integrator: "VelocityVerlet".to_owned(),
        precision: "f32".to_owned(),
        threads: Some(1),
        max_energy_growth: 1e6,
        vigilance: Vigilance::OutOfRange,
    };
    let mut world = Simulation::new(&scene, &numerics, &SERIAL).unwrap();
    world.step(200, 5e-4, &|| false).unwrap();
    let allocated = allocation_counter::measure(|| (0..10).for_each(|_| world.step(1, 5e-4, &|| false).unwrap()));
    // As above.
    assert!(allocated.count_total <= 10, "{allocated:?}");
}
