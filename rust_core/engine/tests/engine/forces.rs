//! Forces: the use of their parameters and of the space that they act in.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};
use physcore_engine::catalog::Space;
use physcore_engine::error::Error;
use physcore_engine::forces::{StateView, Validity};
use physcore_engine::matter::{Columns, Properties, View};
use physcore_engine::parallel::SERIAL;
use physcore_engine::scene::{Body, Item, Scene, Value};
use physcore_engine::simulation::{Numerics, Simulation, Vigilance};
use physcore_engine::stability::Horizon;

use crate::CATALOG;

fn item(kind: &str, values: &[(&'static str, Value)]) -> Item {
    Item { path: "forces[0]".into(), ..Item::new(kind, values.to_vec()) }
}

/// Scene of unit masses of radius 0.06 m in two dimensions.
fn scene(positions: &[DVec3], force: Item) -> Scene {
    let count = positions.len();
    let body = Body {
        positions: positions.to_vec(),
        velocities: vec![DVec3::ZERO; count],
        mass: vec![1.0; count],
        charge: vec![0.0; count],
        radius: vec![0.06; count],
        fixed: vec![false; count],
        ..Body::default()
    };
    Scene { dimension: 2, bodies: vec![body], forces: vec![force], ..Scene::default() }
}

fn simulation(scene: &Scene) -> Result<Simulation, Error> {
    let numerics = Numerics {
        integrator: "VelocityVerlet".into(),
        integrators: BTreeMap::new(),
        precision: "f64".into(),
        threads: Some(1),
        max_energy_growth: 1e6,
        vigilance: Vigilance::EveryStep,
    };
    Simulation::new(scene, &numerics, CATALOG, &SERIAL)
}

/// In a well ω² = k/m at every position of the particle; in any other central field the limit changes with the distance.
#[test]
fn the_limit_of_a_well_alone_is_the_same_everywhere() {
    let (columns, properties) = (Columns::<DVec2>::from_fn(1, |_| DVec2::X), Properties::new(vec![1.0]));
    let at = StateView {
        position: columns.view(),
        velocity: columns.view(),
        residual: View::default(),
        properties: &properties,
        solids: &[],
        time: 0.0,
        executor: &SERIAL,
    };
    for exponent in [-2.0, 0.0, 0.99, 1.0, 1.01, 3.0] {
        let values =
            [("center", Value::Vector(DVec3::ZERO)), ("strength", Value::Number(2.0)), ("softening", Value::Number(0.1))];
        let field = item("CentralForce", &[&values[..], &[("exponent", Value::Number(exponent))]].concat());
        let built = DVec2::forces(CATALOG).build(&scene(&[DVec3::X], field.clone()), &field, &properties, &SERIAL).unwrap();
        let expected = if exponent == 1.0 { Validity::Always } else { Validity::Now };
        assert_eq!(built[0].validity(&at, Horizon::Present), expected, "exponent {exponent}");
    }
}

/// Atoms whose size, well or cutoff is not above 0 are refused.
#[test]
fn the_parameters_of_atoms_are_above_zero() {
    let atoms = |epsilon: f64, sigma: f64, cutoff: f64| {
        let values = [("epsilon", epsilon), ("sigma", sigma), ("cutoff", cutoff)];
        scene(&[DVec3::ZERO, DVec3::X], item("LennardJones", &values.map(|(name, value)| (name, Value::Number(value)))))
    };
    assert!(simulation(&atoms(1.0, 1.0, 2.5)).is_ok());
    for wrong in [0.0, -1.0] {
        let scenes = [atoms(wrong, 1.0, 2.5), atoms(1.0, wrong, 2.5), atoms(1.0, 1.0, wrong)];
        for (name, scene) in ["epsilon", "sigma", "cutoff"].into_iter().zip(&scenes) {
            let error = simulation(scene).err().expect(name).to_string();
            assert!(error.starts_with(&format!("forces[0].{name}: expected a number > 0")), "{error}");
        }
    }
}

/// Two balls that touch across the ends of a square have the energy k δ²/2. The third components of the corners, 0 or
/// infinite, change neither the energy nor the range of the neighbor lists.
#[test]
fn the_third_axis_of_a_plane_is_not_periodic() {
    let numbers = [("stiffness", 100.0), ("damping", 0.0), ("friction", 0.0), ("tangential_damping", 0.0), ("exponent", 1.0)];
    let repulsion = item("SoftSpheres", &numbers.map(|(name, value)| (name, Value::Number(value))));
    let positions = [DVec3::new(0.05, 0.5, 0.0), DVec3::new(0.95, 0.5, 0.0)];
    let square = |depth: f64| {
        let periodic = Some([DVec3::new(0.0, 0.0, -depth), DVec3::new(1.0, 1.0, depth)]);
        simulation(&Scene { periodic, ..scene(&positions, repulsion.clone()) }).unwrap()
    };
    let [flat, open] = [0.0, f64::INFINITY].map(square);
    // The overlap of 0.02 is a difference of numbers of size 1, each rounded.
    assert!((flat.energy(&SERIAL).unwrap().total() - 0.02).abs() < 100.0 * f64::EPSILON);
    assert_eq!(flat.plan().stages[0].notes, open.plan().stages[0].notes);
}
