//! Heaps of cuboids that fall on each other.

use glam::DVec3;

use super::laboratory::{Laboratory, cuboid, turned};

const HALF: f64 = 0.3;
const THIN: f64 = 0.1;
const MASS: f64 = 0.48;
const GRAVITY: f64 = 9.81;

/// Numbers from -1/2 to 1/2.
fn numbers(mut state: u64) -> impl FnMut() -> f64 {
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    }
}

/// Cuboids above each other in any orientation.
fn heap(side: usize) -> Laboratory {
    let mut laboratory = Laboratory::new(3, DVec3::new(0.0, 0.0, -GRAVITY));
    laboratory.add_plane(DVec3::Z, 0.5, 0.0);
    let mut random = numbers(1);
    for index in 0..side.pow(3) {
        let [i, j, k] = [index / side / side, index / side % side, index % side].map(|place| 1.5 * place as f64);
        let orientation = turned(random(), random(), random(), random());
        let position = DVec3::new(i, j, k + 1.0);
        laboratory.add(&cuboid(1.0, 0.8, 2.0 * HALF), (MASS, 0.5, 0.0), (position, orientation), (DVec3::ZERO, DVec3::ZERO));
    }
    laboratory
}

/// 27 cuboids that fall in a box.
fn boxed(seed: u64) -> Laboratory {
    let mut laboratory = Laboratory::new(3, DVec3::new(0.0, 0.0, -GRAVITY));
    laboratory.add_plane(DVec3::Z, 0.5, 0.0);
    for axis in [DVec3::X, DVec3::Y] {
        laboratory.add_wall(axis, DVec3::ZERO, 0.5, 0.0);
        laboratory.add_wall(-axis, 1.8 * axis, 0.5, 0.0);
    }
    let mut random = numbers(seed);
    for index in 0..27 {
        let [i, j, k] = [index / 9, index / 3 % 3, index % 3].map(|place| 0.3 + 0.6 * f64::from(place));
        let orientation = turned(random(), random(), random(), random());
        let velocity = DVec3::new(random(), random(), random());
        let place = (DVec3::new(i, j, k), orientation);
        laboratory.add(&cuboid(0.4, 0.3, 2.0 * THIN), (MASS, 0.5, 0.0), place, (velocity, DVec3::ZERO));
    }
    laboratory
}

/// Steps in which no body may touch anything have the bits of all others. Cuboids fall, and spread from where they land.
#[test]
fn steps_apart_have_the_same_bits() {
    let states = [true, false].map(|is_split| {
        let mut laboratory = heap(3);
        laboratory.is_split = is_split;
        laboratory.motions.iter_mut().for_each(|motion| motion.position *= 2.0);
        let mut states = Vec::new();
        for _ in 0..60 {
            laboratory.step(1.0 / 60.0, 1);
            let turns = laboratory.world.state.turns.iter().map(|turn| (turn.orientation.components(), turn.spin));
            states
                .push(laboratory.motions.iter().map(|motion| (motion.position, motion.velocity)).zip(turns).collect::<Vec<_>>());
        }
        assert_eq!((10..50).contains(&laboratory.apart), is_split, "{}", laboratory.apart);
        states
    });
    assert!(states[0] == states[1]);
}

/// A body moves by a tenth of its half thickness in a sweep at most: overlaps are not deeper than that. The drift is at most the
/// work that lifts all bodies out of such an overlap. A small group and a large one; neither waits for its impacts.
#[test]
fn a_heap_falls_without_drift() {
    for side in [3, 4] {
        let mut laboratory = heap(side);
        let start = laboratory.balance();
        let deepest = 0.1 * HALF;
        for _ in 0..120 {
            laboratory.step(1.0 / 60.0, 1);
            assert!(laboratory.overlap() <= deepest, "{side}: {}", laboratory.overlap());
        }
        let weight = MASS * GRAVITY * side.pow(3) as f64;
        let drift = laboratory.balance() - start;
        assert!(drift.abs() <= weight * deepest, "{side}: {drift} J of {start} J");
        assert_eq!(laboratory.world.state.waits, 0);
    }
}

/// Cuboids have come to rest in a box, as a large group. In a second, what sinks and what the balance gains is at most the work
/// that moves all by a thousandth of half their thickness.
#[test]
fn heaps_at_rest_neither_creep_nor_gain_energy() {
    let (mut gained, mut sunk, mut most) = (0.0, 0.0, 0.0);
    for seed in 1..=8 {
        let mut laboratory = boxed(seed);
        laboratory.world.solver.sequential = 8;
        laboratory.step(1.0 / 120.0, 360);
        let (balance, energy) = (laboratory.balance(), laboratory.energy());
        laboratory.step(1.0 / 120.0, 120);
        gained += laboratory.balance() - balance;
        sunk += energy - laboratory.energy();
        most += 1e-3 * THIN * MASS * GRAVITY * laboratory.motions.len() as f64;
    }
    assert!(gained.abs() < most && sunk.abs() < most, "{gained} J gained, {sunk} J sunk, at most {most} J");
}
