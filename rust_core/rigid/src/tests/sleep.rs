//! Groups of bodies that fall asleep and wake.

use glam::DVec3;

use super::laboratory::{Laboratory, cuboid, rectangle, round, turned};
use crate::joints::{DampedSpring, JointKind};
use crate::rotation::Orientation;
use crate::world::{SleepRule, WORLD};

const H: f64 = 1.0 / 240.0;
const G: DVec3 = DVec3::new(0.0, -9.81, 0.0);
const LIMIT: f64 = 0.05;
const REST: (DVec3, DVec3) = (DVec3::ZERO, DVec3::ZERO);

fn at(x: f64, y: f64) -> (DVec3, Orientation) {
    (DVec3::new(x, y, 0.0), Orientation::planar(0.0))
}

/// Two boxes that fall on each other and on a floor.
fn stack() -> Laboratory {
    let mut lab = Laboratory::new(2, G);
    lab.add_plane(DVec3::Y, 0.5, 0.0);
    for y in [0.11, 0.32] {
        lab.add(&rectangle(0.4, 0.2), (1.0, 0.5, 0.0), at(0.0, y), REST);
    }
    lab
}

fn with_sleep(mut lab: Laboratory) -> Laboratory {
    lab.world.let_sleep(vec![SleepRule { speed: LIMIT, after: 0.5 }; lab.motions.len()]);
    lab
}

fn sleeps(lab: &Laboratory) -> Vec<bool> {
    (0..lab.motions.len()).map(|body| lab.world.is_asleep(body)).collect()
}

/// Balance with what sleep has discarded [J].
fn balance(lab: &Laboratory) -> f64 {
    lab.balance() + lab.world.state.slept
}

/// A group falls asleep half a second after it came to rest; its energy is then that of the heights, and all else was booked. The
/// balance of a stack at rest changes by the rounding of 4 J in a step.
#[test]
fn a_stack_falls_asleep_with_its_energy_booked() {
    let mut lab = with_sleep(stack());
    let mut woken = 0;
    while !lab.world.is_asleep(0) {
        let before = balance(&lab);
        lab.step(H, 1);
        woken += 1;
        assert!(woken < 240, "it does not fall asleep");
        assert!(!lab.world.is_asleep(0) || (balance(&lab) - before).abs() < 1e-14, "{}", balance(&lab) - before);
    }
    assert!(woken >= 120, "{woken} steps");
    assert_eq!(sleeps(&lab), [true; 2]);
    let (places, before, loads) = (lab.motions.clone(), balance(&lab), lab.world.state.packed_loads());
    lab.step(H, 240);
    assert_eq!(lab.world.state.packed_loads(), loads);
    for (motion, place) in lab.motions.iter().zip(&places) {
        assert_eq!((motion.position, motion.velocity), (place.position, DVec3::ZERO));
    }
    assert_eq!(balance(&lab), before);
}

/// Without being asked for, nothing sleeps: the steps have the bits of a world that may, until it does.
#[test]
fn steps_before_sleep_are_those_without_it() {
    let (mut lab, mut other) = (with_sleep(stack()), stack());
    for _ in 0..100 {
        lab.step(H, 1);
        other.step(H, 1);
        let states =
            [&lab, &other].map(|lab| lab.motions.iter().map(|motion| (motion.position, motion.velocity)).collect::<Vec<_>>());
        assert_eq!(states[0], states[1]);
    }
    other.step(H, 1000);
    assert_eq!(sleeps(&other), [false; 2]);
}

/// Blocks at rest in free space sleep. A ball that hits one of them at 30 m/s, a length in a step, wakes both of this group and no
/// other. Nothing is lost: momenta change by the rounding of 3 kg m/s.
#[test]
fn a_struck_group_wakes_before_it_is_touched() {
    let mut lab = Laboratory::new(3, DVec3::ZERO);
    let upright = turned(1.0, 0.0, 0.0, 0.0);
    for x in [0.0, 0.21, 1.5] {
        lab.add(&cuboid(0.2, 0.2, 0.2), (1.0, 0.5, 0.3), (DVec3::new(x, 0.0, 0.0), upright), REST);
    }
    let ball = (DVec3::new(-30.0, 0.05, 0.0), upright);
    lab.add(&round("Ball", 0.05), (0.1, 0.5, 0.3), ball, (30.0 * DVec3::X, DVec3::ZERO));
    let mut lab = with_sleep(lab);
    lab.step(H, 180);
    assert_eq!(sleeps(&lab), [true, true, true, false]);
    let before = lab.momenta();
    lab.step(H, 80);
    assert_eq!(sleeps(&lab), [false, false, true, false]);
    assert!(lab.motions[0].velocity.x > 0.1, "{}", lab.motions[0].velocity);
    let after = lab.momenta();
    assert!((after.0 - before.0).length() < 1e-14 && (after.1 - before.1).length() < 1e-13, "{before:?} {after:?}");
}

/// A ball that nothing holds stays awake at the top of its flight, however slow it is there: it falls by g t²/2.
#[test]
fn a_body_in_the_air_stays_awake() {
    let mut lab = Laboratory::new(2, 0.01 * DVec3::NEG_Y);
    lab.add_plane(DVec3::Y, 0.5, 0.0);
    lab.add(&round("Disc", 0.1), (1.0, 0.5, 0.0), at(0.0, 0.2), REST);
    let mut lab = with_sleep(lab);
    lab.step(H, 480);
    assert!((lab.motions[0].position.y - (0.2 - 0.5 * 0.01 * 4.0)).abs() < 1e-12);
}

/// Another force wakes a group if it would bring a body to the limit in half a second: gravity turns a little, and a bit more.
#[test]
fn a_change_of_the_forces_wakes() {
    for (change, sleeping) in [(0.9, true), (1.1, false)] {
        let mut lab = with_sleep(stack());
        lab.step(H, 240);
        assert_eq!(sleeps(&lab), [true; 2]);
        lab.gravity = G + change * LIMIT / 0.5 * DVec3::X;
        lab.step(H, 2);
        assert_eq!(sleeps(&lab), [sleeping; 2], "{change}");
    }
}

/// Bodies on joints and springs sleep with those that these connect: a stack that hangs on a weight awake stays so.
#[test]
fn joints_and_springs_connect_groups() {
    let spring = DampedSpring { stiffness: 50.0, damping: 5.0, rest_length: 1.0 };
    for kind in [JointKind::Rod(1.0), JointKind::Spring(spring)] {
        let mut lab = Laboratory::new(2, G);
        for y in [0.0, -1.0] {
            lab.add(&rectangle(0.2, 0.2), (1.0, 0.5, 0.0), at(0.0, y), REST);
        }
        lab.join(JointKind::Weld, [WORLD, 0], [DVec3::ZERO; 2], DVec3::Z);
        lab.join(kind, [0, 1], [DVec3::ZERO, DVec3::NEG_Y], DVec3::Z);
        lab.motions[1].velocity.x = 1.0;
        let mut lab = with_sleep(lab);
        lab.step(H, 480);
        assert_eq!(sleeps(&lab), [false; 2]);
        lab.motions[1].velocity = DVec3::ZERO;
        lab.motions[1].position = DVec3::new(0.0, -1.0 - if kind == JointKind::Rod(1.0) { 0.0 } else { 9.81 / 50.0 }, 0.0);
        lab.world.state.turns.iter_mut().for_each(|turn| turn.spin = DVec3::ZERO);
        lab.step(H, 200);
        assert_eq!(sleeps(&lab), [true; 2]);
        let place = lab.motions[1].position;
        lab.step(H, 240);
        assert_eq!(lab.motions[1].position, place);
    }
}

/// A box on a belt, a fixed body that moves, stays awake. A fixed body that comes to a box wakes it.
#[test]
fn fixed_bodies_that_move_keep_others_awake() {
    let mut lab = with_sleep(stack());
    lab.step(H, 240);
    assert_eq!(sleeps(&lab), [true; 2]);
    lab.world.walls[0].mover.velocity = 0.01 * DVec3::X;
    lab.step(H, 480);
    assert_eq!(sleeps(&lab), [false; 2]);
}
