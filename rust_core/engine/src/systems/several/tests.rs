//! Two systems in one simulation equal two separate simulations; couplings are told of steps and of other new states.

use std::sync::{Arc, Mutex};

use glam::DVec3;

use super::*;
use crate::forces::springs::Spring;
use crate::ledger::Class;
use crate::parallel::SERIAL;
use crate::scene::{Body, Scene};
use crate::systems::{Location, matter};

/// Rope of `count` particles that swings about its first one.
fn rope(count: u32) -> Scene {
    let at = |index: u32| DVec3::new(0.11 * f64::from(index), 0.0, 0.0);
    let spring = |index: u32| Spring { ends: [index, index + 1], stiffness: 50.0, damping: 0.1, rest_length: 0.1 };
    let body = Body {
        positions: (0..count).map(at).collect(),
        velocities: (0..count).map(|index| DVec3::new(0.0, f64::from(index), 0.0)).collect(),
        mass: vec![0.1; count as usize],
        charge: vec![0.0; count as usize],
        radius: vec![0.0; count as usize],
        fixed: (0..count).map(|index| index == 0).collect(),
        item: Spring::network(&(0..count - 1).map(spring).collect::<Vec<_>>()),
    };
    Scene { dimension: 2, bodies: vec![body], ..Scene::default() }
}

fn system(count: u32) -> Box<dyn System> {
    let mut system = matter::build(&rope(count), &"VelocityVerlet".into(), "f64", &SERIAL).unwrap();
    system.begin(0.0, &SERIAL).unwrap();
    system
}

fn both() -> Several {
    let part = |name: &str, count: u32| SystemPart { name: name.to_owned(), system: system(count) };
    Several::new(vec![part("", 4), part("tail", 7)], Vec::new())
}

const INTERVAL: Interval = Interval { start: 0.0, first: 0, h: 1e-3, steps: 100 };

fn captured(system: &dyn System) -> Archive {
    let mut archive = Archive::default();
    system.capture(&mut archive);
    archive
}

fn state(system: &dyn System) -> Vec<f64> {
    captured(system).state().copied().collect()
}

#[test]
fn each_system_has_the_bits_that_it_has_alone() {
    let (mut one, mut other, mut both) = (system(4), system(7), both());
    for system in [&mut *one, &mut *other, &mut both as &mut dyn System] {
        system.advance(INTERVAL, RecordedSteps::EveryStep, &SERIAL).unwrap();
    }
    assert_eq!(state(&both), [state(&*one), state(&*other)].concat());
    let sums: Vec<f64> = one.activity().iter().zip(other.activity()).map(|(one, other)| 0.0 + one + other).collect();
    assert_eq!((both.activity(), both.activity().len()), (sums.as_slice(), 100));
    // One addition more per class than in each budget.
    let [one, other, both] = [&*one, &*other, &both as &dyn System].map(|system| system.audit(0.1, &SERIAL).unwrap());
    for class in [Class::Kinetic, Class::Potential, Class::Dissipated] {
        assert_eq!(both.sum(class), one.sum(class) + other.sum(class));
    }
}

#[test]
fn fields_have_the_names_of_their_items() {
    let both = both();
    let fields = both.fields();
    let points = fields.iter().filter(|field| field.location == Location::Points);
    let names: Vec<_> = points.map(|field| (field.name.as_str(), field.shape[0])).collect();
    assert_eq!(names, [("positions", 4), ("velocities", 4), ("tail.positions", 7), ("tail.velocities", 7)]);
    let index = |name: &str| fields.iter().position(|field| field.name == name).unwrap();
    assert_eq!(fields[index("tail.positions")].rate.as_deref(), Some("tail.velocities"));
    assert_eq!(both.read(index("tail.velocities"), 0.0), system(7).read(1, 0.0));
    let stages = both.stages();
    assert_eq!(stages.iter().map(|stages| stages.item.as_str()).collect::<Vec<_>>(), ["", "tail"]);
    assert!(both.read(fields.len(), 0.0).is_empty());
}

#[test]
fn a_write_that_fails_changes_no_system() {
    let mut both = both();
    both.advance(INTERVAL, RecordedSteps::LastStep, &SERIAL).unwrap();
    let before = captured(&both);
    let (still, wrong) = ([0.0; 8], [f64::NAN; 14]);
    let fields = [("velocities", &still[..]), ("tail.velocities", &wrong[..])];
    assert!(both.write(&fields, 0.1, &SERIAL).unwrap_err().to_string().contains("set.velocities[0]"));
    assert_eq!(captured(&both), before);
    assert!(both.write(&[("heights", &still)], 0.1, &SERIAL).unwrap_err().to_string().starts_with("set.heights"));
    both.write(&[("velocities", &still), ("tail.velocities", &[0.0; 14])], 0.1, &SERIAL).unwrap();
    assert_eq!(both.audit(0.1, &SERIAL).unwrap().sum(Class::Kinetic), 0.0);
}

#[test]
fn a_checkpoint_holds_all_systems() {
    let (mut first, mut second) = (both(), both());
    first.advance(INTERVAL, RecordedSteps::LastStep, &SERIAL).unwrap();
    second.restore(&mut captured(&first)).unwrap();
    let next = Interval { first: 100, ..INTERVAL };
    for system in [&mut first, &mut second] {
        system.advance(next, RecordedSteps::LastStep, &SERIAL).unwrap();
    }
    assert_eq!(captured(&first), captured(&second));
    first.rollback();
    assert_ne!(state(&first), state(&second));
    let refused = second.restore(&mut captured(&*system(4))).unwrap_err().to_string();
    assert!(refused.starts_with("state: systems/tail/matter/positions is missing; "), "{refused}");
}

#[test]
fn the_limit_is_that_of_the_stiffest_system() {
    let (one, other) = (system(4), system(7));
    let [one, other, both] =
        [&*one, &*other, &both() as &dyn System].map(|system| system.limit(Horizon::Sharp, 0.0, &SERIAL).unwrap());
    assert_eq!((both.stability, both.term), (one.stability.min(other.stability), "springs"));
}

/// Coupling that notes its calls: the system that has advanced, or None for another new state.
struct Noted(Arc<Mutex<Vec<Option<usize>>>>);

impl Coupling for Noted {
    fn update(&self, _systems: &mut [SystemPart]) {
        self.0.lock().unwrap().push(None);
    }

    fn follow(&self, _systems: &mut [SystemPart], advanced: usize) {
        self.0.lock().unwrap().push(Some(advanced));
    }
}

#[test]
fn a_coupling_follows_each_system_and_learns_of_every_other_new_state() {
    let calls = Arc::default();
    let mut both = Several { couplings: vec![Box::new(Noted(Arc::clone(&calls)))], ..both() };
    let noted = || std::mem::take(&mut *calls.lock().unwrap());
    both.begin(0.0, &SERIAL).unwrap();
    assert_eq!(noted(), [None]);
    both.advance(INTERVAL, RecordedSteps::LastStep, &SERIAL).unwrap();
    assert_eq!(noted(), [Some(0), Some(1)]);
    let mut archive = captured(&both);
    both.rollback();
    both.restore(&mut archive).unwrap();
    both.write(&[("velocities", &[0.0; 8])], 0.1, &SERIAL).unwrap();
    assert_eq!(noted(), [None; 3]);
}
