//! Two systems in one simulation equal two separate simulations, also in substeps; couplings are told of steps and of other new
//! states.

use std::sync::{Arc, Mutex};

use glam::DVec3;

use super::*;
use crate::catalog::Catalog;
use crate::forces::springs::Spring;
use crate::ledger::Class;
use crate::parallel::SERIAL;
use crate::scene::{Body, Scene};
use crate::systems::{Location, matter};

/// All forces and fluids.
const CATALOG: Catalog = Catalog { forces: physcore_forces::FORCES, fluids: physcore_fluids::FLUIDS };

/// Rope of `count` particles that swings about its first one.
fn rope(count: u32) -> Scene {
    stiff_rope(count, 50.0)
}

/// Rope with springs of a stiffness [N/m].
fn stiff_rope(count: u32, stiffness: f64) -> Scene {
    let at = |index: u32| DVec3::new(0.11 * f64::from(index), 0.0, 0.0);
    let spring = |index: u32| Spring { ends: [index, index + 1], stiffness, damping: 0.1, rest_length: 0.1 };
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
    begun(&rope(count))
}

fn begun(scene: &Scene) -> Box<dyn System> {
    let mut system = matter::build(scene, &"VelocityVerlet".into(), "f64", CATALOG, &SERIAL).unwrap();
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

/// A stiff rope beside a soft one. Its limit of stability is √(20000/50) = 20 times smaller.
fn stiff() -> Several {
    let part = |name: &str, scene: &Scene| SystemPart { name: name.to_owned(), system: begun(scene) };
    Several::new(vec![part("", &rope(4)), part("tail", &stiff_rope(4, 20_000.0))], Vec::new())
}

/// Limit of stability of the soft rope's steps [s].
fn soft_limit() -> f64 {
    system(4).limit(Horizon::Certified, 0.0, &SERIAL).unwrap().dt()
}

/// Divides steps of `h` seconds; returns the numbers of substeps.
fn divide(systems: &mut Several, h: f64) -> [u64; 2] {
    let division = systems.divided(h, 0, 0.0, &SERIAL).unwrap();
    systems.divide(division);
    [0, 1].map(|index| systems.division().substeps(index))
}

#[test]
fn the_stiffer_system_has_the_bits_of_shorter_steps() {
    let (mut both, h) = (stiff(), 0.5 * soft_limit());
    let (mut soft, mut tail) = (system(4), begun(&stiff_rope(4, 20_000.0)));
    let [one, substeps] = divide(&mut both, h);
    assert_eq!((one, substeps), (1, 10));
    let interval = Interval { start: 0.3, first: 7, h, steps: 6 };
    let shorter = Interval { first: 70, h: h / 10.0, steps: 60, ..interval };
    both.advance(interval, RecordedSteps::EveryStep, &SERIAL).unwrap();
    soft.advance(interval, RecordedSteps::EveryStep, &SERIAL).unwrap();
    tail.advance(shorter, RecordedSteps::EveryStep, &SERIAL).unwrap();
    let numbers = captured(&both).into_arrays().filter(|(name, _)| name != DIVISION).flat_map(|(_, numbers)| numbers);
    let apart = [&*soft, &*tail].into_iter().flat_map(|system| captured(system).into_arrays().flat_map(|(_, numbers)| numbers));
    assert_eq!(numbers.collect::<Vec<_>>(), apart.collect::<Vec<_>>());
    // One activity for each step of the whole, at its end.
    let ends = tail.activity().chunks_exact(10).map(|substeps| substeps[9]);
    let sums: Vec<f64> = soft.activity().iter().zip(ends).map(|(one, other)| 0.0 + one + other).collect();
    assert_eq!(both.activity(), sums);
    // A long step records its end alone.
    for system in [&mut both as &mut dyn System, &mut *soft] {
        system.advance(Interval { first: 13, steps: 1, ..interval }, RecordedSteps::EveryStep, &SERIAL).unwrap();
    }
    tail.advance(Interval { first: 130, steps: 10, ..shorter }, RecordedSteps::EveryStep, &SERIAL).unwrap();
    assert_eq!(both.activity(), [0.0 + soft.activity()[0] + tail.activity()[9]]);
    assert_eq!(both.cost(), soft.cost() + 10.0 * tail.cost());
}

#[test]
fn limits_are_those_of_divided_steps() {
    let (mut both, h) = (stiff(), 0.5 * soft_limit());
    let limit = |systems: &Several| systems.limit(Horizon::Certified, 0.0, &SERIAL).unwrap().dt();
    let whole = limit(&both);
    assert_eq!(divide(&mut both, whole), [1, 1]);
    divide(&mut both, h);
    assert_eq!(limit(&both), (10.0 * whole).min(soft_limit()));
    assert!(both.stages()[0].notes.iter().all(|note| !note.contains("substeps")));
    let expected = format!("tail takes 10 equal substeps per step of {h:.3e} s: its own limit is {whole:.3e} s");
    assert_eq!(both.stages()[1].notes[0], expected);
    assert_eq!([both.stages()[0].evaluations, both.stages()[1].evaluations], [1, 10]);
    // A system takes undivided steps up to its limit for the present directions of the springs.
    let sharp = begun(&stiff_rope(4, 20_000.0)).limit(Horizon::Sharp, 0.0, &SERIAL).unwrap().dt();
    assert!(sharp > 1.05 * whole);
    assert_eq!([divide(&mut both, sharp), divide(&mut both, 1.001 * sharp)], [[1, 1], [1, 2]]);
}

#[test]
fn a_division_is_rolled_back_captured_and_found_anew_after_a_write() {
    let (mut first, mut second, h) = (stiff(), stiff(), 0.5 * soft_limit());
    divide(&mut first, h);
    let interval = Interval { start: 0.0, first: 0, h, steps: 4 };
    first.advance(interval, RecordedSteps::EveryStep, &SERIAL).unwrap();
    let after = captured(&first);
    first.rollback();
    first.advance(interval, RecordedSteps::LastStep, &SERIAL).unwrap();
    assert_eq!(captured(&first), after);
    second.restore(&mut after.clone()).unwrap();
    assert_eq!(second.division(), first.division());
    for systems in [&mut first, &mut second] {
        systems.advance(Interval { first: 4, ..interval }, RecordedSteps::LastStep, &SERIAL).unwrap();
    }
    assert_eq!(captured(&first), captured(&second));
    // Springs of a third of their rest length are stiffer across their direction than along it.
    let short: Vec<f64> = (0..4).flat_map(|index| [0.033 * f64::from(index), 0.0]).collect();
    first.write(&[("tail.positions", &short)], 0.0, &SERIAL).unwrap();
    assert!(first.division().limits[1] < 0.9 * second.division().limits[1]);
    assert_eq!(first.division().limits[0], f64::INFINITY);
    second.restore(&mut captured(&stiff())).unwrap();
    assert_eq!(second.division().substeps(1), 1);
}

#[test]
fn a_limit_that_has_fallen_is_followed_at_once_and_one_that_has_risen_from_its_double_on() {
    let (mut both, h) = (stiff(), 0.5 * soft_limit());
    divide(&mut both, h);
    let found = both.division().limits[1];
    for (earlier, expected) in [(1.1 * found, found), (0.6 * found, 0.6 * found), (0.5 * found, found)] {
        both.divide(Division { limits: vec![f64::INFINITY, earlier], ..both.division().clone() });
        let further = both.divided_further(5, 0.0, &SERIAL).unwrap();
        assert_eq!((further.limits, further.until), (vec![f64::INFINITY, expected], 6));
    }
    // The limits of springs vary; they are found again the later, the larger they are.
    for (steps, until) in [(1.0, 2), (2.5, 5), (100.0, 8)] {
        divide(&mut both, found / steps);
        assert_eq!(both.division().until, until);
    }
}

/// Coupling that notes its calls: the system that has advanced, or None for another new state.
struct Noted(Arc<Mutex<Vec<Option<usize>>>>);

impl Coupling for Noted {
    fn systems(&self) -> [usize; 2] {
        [0, 1]
    }

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

#[test]
fn coupled_systems_take_the_same_steps() {
    let mut both = Several { couplings: vec![Box::new(Noted(Arc::default()))], ..stiff() };
    assert_eq!(divide(&mut both, 0.5 * soft_limit()), [1, 1]);
    assert_eq!(both.division().until, u64::MAX);
}
