//! Motion of bodies on springs: frequencies, stability, budgets, and springs beside contacts.

use glam::DVec3;

use super::laboratory::{Laboratory, cuboid, rectangle, round, turned};
use crate::joints::{DampedSpring, JointKind};
use crate::rotation::Orientation;
use crate::world::WORLD;

const G: f64 = 9.81;
const H: f64 = 1.0 / 240.0;
const REST: (DVec3, DVec3) = (DVec3::ZERO, DVec3::ZERO);
const STIFFNESS: f64 = 50.0;

/// A bar of mass 2 and length 1 along x, with a vertical spring of length 1 at its right end. Returns ω² = k (1/m + r²/I) too.
fn bar_on_spring(dimension: usize, damping: f64) -> (Laboratory, f64) {
    let mut lab = Laboratory::new(dimension, DVec3::ZERO);
    let (shape, orientation) = if dimension == 2 {
        (rectangle(1.0, 0.1), Orientation::planar(0.0))
    } else {
        (cuboid(1.0, 0.1, 0.2), turned(1.0, 0.0, 0.0, 0.0))
    };
    lab.add(&shape, (2.0, 0.0, 0.0), (DVec3::ZERO, orientation), REST);
    let spring = JointKind::Spring(DampedSpring { stiffness: STIFFNESS, damping, rest_length: 1.0 });
    lab.join(spring, [WORLD, 0], [DVec3::new(0.5, 1.0, 0.0), DVec3::new(0.5, 0.0, 0.0)], DVec3::Z);
    (lab, STIFFNESS * (0.5 + 0.25 / (2.0 * 1.01 / 12.0)))
}

/// Sets the bar in the motion in which its free end swings by `amplitude`, and no other.
fn swing(lab: &mut Laboratory, amplitude: f64, squared: f64) {
    let rate = amplitude * squared.sqrt() / squared * STIFFNESS;
    lab.motions[0].velocity = DVec3::new(0.0, 0.5 * rate, 0.0);
    let orientation = lab.world.state.turns[0].orientation;
    lab.world.turn(0, orientation, DVec3::new(0.0, 0.0, 0.5 * rate / (2.0 * 1.01 / 12.0)));
}

fn end(lab: &Laboratory) -> f64 {
    lab.mover(0).pose().point(DVec3::new(0.5, 0.0, 0.0)).y
}

/// After a quarter of the period the end of the bar is at its amplitude; the error is of order h², and of the amplitude.
#[test]
fn a_bar_swings_with_its_effective_mass() {
    for dimension in [2, 3] {
        let error = |steps: usize| {
            let (mut lab, squared) = bar_on_spring(dimension, 0.0);
            swing(&mut lab, 1e-6, squared);
            // At 1/8 of the period, where the phase counts.
            lab.step(std::f64::consts::FRAC_PI_4 / squared.sqrt() / steps as f64, steps);
            end(&lab) / 1e-6 - std::f64::consts::FRAC_1_SQRT_2
        };
        let (coarse, fine) = (error(10), error(20));
        assert!(fine.abs() < 1e-3, "{fine}");
        assert!((coarse / fine - 4.0).abs() < 0.1, "{coarse} {fine}");
    }
}

/// The bound on ω² is sharp: steps of 0.99 · 2/ω keep the amplitude, and steps of 1.01 · 2/ω let it grow.
#[test]
fn the_bound_of_a_spring_is_sharp() {
    let (lab, squared) = bar_on_spring(2, 0.0);
    let rates = lab.world.spring_rates(|end| lab.mover(end), false);
    assert_eq!(rates.len(), 1);
    assert!((rates[0].1[0] / squared - 1.0).abs() < 1e-12, "{rates:?}");
    for (part, stable) in [(0.99, true), (1.01, false)] {
        let (mut lab, _) = bar_on_spring(2, 0.0);
        swing(&mut lab, 1e-9, squared);
        let h = part * 2.0 / rates[0].1[0].sqrt();
        let most = (0..100).fold(0.0, |most: f64, _| {
            lab.step(h, 1);
            most.max(end(&lab).abs())
        });
        assert_eq!(most < 1e-7, stable, "{part} {most:e}");
    }
}

/// Bounds hold: no state of a body between several springs of different lengths has a stiffer mode, by power iteration over
/// central differences of the forces.
#[test]
fn bounds_of_springs_hold() {
    let mut lab = Laboratory::new(2, DVec3::ZERO);
    lab.add(&rectangle(1.0, 0.3), (2.0, 0.0, 0.0), (DVec3::ZERO, Orientation::planar(0.3)), REST);
    lab.add(&rectangle(0.4, 0.3), (0.3, 0.0, 0.0), (DVec3::new(2.0, 0.5, 0.0), Orientation::planar(-0.8)), REST);
    for (ends, points, stiffness, rest_length) in [
        ([WORLD, 0], [(-1.0, 1.0), (-0.4, 0.1)], 30.0, 0.1),
        ([0, 1], [(0.4, -0.1), (1.9, 0.6)], 80.0, 0.5),
        ([0, 1], [(0.4, 0.1), (2.1, 0.4)], 20.0, 4.0),
        ([1, WORLD], [(2.1, 0.6), (4.0, 3.0)], 60.0, 2.0),
    ] {
        let points = points.map(|(x, y)| DVec3::new(x, y, 0.0));
        lab.join(JointKind::Spring(DampedSpring { stiffness, damping: 0.0, rest_length }), ends, points, DVec3::Z);
    }
    // Energies of displaced states: their second differences are the stiffness.
    let inertias: Vec<[f64; 3]> = (0..2)
        .map(|body| {
            let solid = &lab.world.bodies[body];
            [solid.inverse_mass, solid.inverse_mass, solid.inertia.largest_inverse()]
        })
        .collect();
    let energy = |lab: &Laboratory, x: &[f64; 6]| {
        lab.world.spring_energy(|end| {
            let mut mover = lab.mover(end);
            if end != WORLD {
                mover.position += DVec3::new(x[3 * end], x[3 * end + 1], 0.0);
                mover.orientation = mover.orientation.turned(DVec3::new(0.0, 0.0, x[3 * end + 2]));
            }
            mover
        })
    };
    let step = 1e-4;
    let mut matrix = [[0.0; 6]; 6];
    for i in 0..6 {
        for j in 0..6 {
            let corner = |a: f64, b: f64| {
                let mut x = [0.0; 6];
                x[i] += a * step;
                x[j] += b * step;
                energy(&lab, &x)
            };
            let second = (corner(1.0, 1.0) - corner(1.0, -1.0) - corner(-1.0, 1.0) + corner(-1.0, -1.0)) / (4.0 * step * step);
            matrix[i][j] = second * (inertias[i / 3][i % 3] * inertias[j / 3][j % 3]).sqrt();
        }
    }
    let mut vector = [1.0, 0.3, -0.7, 0.2, 0.9, -0.4];
    let mut largest = 0.0;
    for _ in 0..200 {
        let next: [f64; 6] = std::array::from_fn(|i| (0..6).map(|j| matrix[i][j] * vector[j]).sum());
        largest = next.iter().map(|entry| entry * entry).sum::<f64>().sqrt();
        vector = next.map(|entry| entry / largest);
    }
    for ahead in [false, true] {
        let bound = lab.world.spring_rates(|end| lab.mover(end), ahead).iter().map(|(_, rates)| rates[0]).fold(0.0, f64::max);
        assert!(bound >= largest && bound < 6.0 * largest, "{bound} {largest} {ahead}");
    }
}

/// Without damping the energy errs by the square of the step, in a motion with large turns.
#[test]
fn the_energy_on_springs_errs_by_the_square_of_the_step() {
    for dimension in [2, 3] {
        let error = |steps: usize| {
            let (mut lab, _) = bar_on_spring(dimension, 0.0);
            lab.motions[0].velocity = DVec3::new(1.0, -2.0, if dimension == 3 { 0.5 } else { 0.0 });
            let before = lab.balance();
            (0..steps).fold(0.0, |most: f64, _| {
                lab.step(2.0 / steps as f64, 1);
                most.max((lab.balance() - before).abs())
            })
        };
        let (coarse, fine) = (error(400), error(800));
        assert!((coarse / fine - 4.0).abs() < 0.2, "{coarse} {fine}");
    }
}

#[test]
fn motion_on_springs_is_reversible() {
    let (mut lab, _) = bar_on_spring(3, 0.0);
    lab.motions[0].velocity = DVec3::new(1.0, -2.0, 0.5);
    lab.step(H, 240);
    lab.reverse();
    lab.step(H, 240);
    // Rounding of 480 steps, which grows with the motion.
    assert!(lab.motions[0].position.length() < 1e-11, "{}", lab.motions[0].position);
}

/// A damped bar swings as exp(−γ t/2) sin(ω t)/ω; the energy that it loses is metered. Both errors are of order h².
#[test]
fn damping_dissipates_what_is_metered() {
    let damping = 0.8;
    let error = |steps: usize| {
        let (mut lab, squared) = bar_on_spring(2, damping);
        let decay = 0.5 * damping * squared / STIFFNESS;
        swing(&mut lab, 1e-6, squared);
        let rate = 1e-6 * squared.sqrt();
        let before = lab.balance();
        let time = 1.0;
        lab.step(time / steps as f64, steps);
        let turning = (squared - decay * decay).sqrt();
        let expected = rate * f64::exp(-decay * time) * f64::sin(turning * time) / turning;
        ((end(&lab) - expected) / 1e-6, (lab.balance() - before) / before, lab.meters.damped / before)
    };
    let (coarse, fine) = (error(200), error(400));
    assert!((coarse.0 / fine.0 - 4.0).abs() < 0.2, "{coarse:?} {fine:?}");
    assert!((coarse.1 / fine.1 - 4.0).abs() < 0.4, "{coarse:?} {fine:?}");
    assert!(fine.2 > 0.5 && fine.0.abs() < 1e-2 && fine.1.abs() < 1e-2, "{fine:?}");
}

/// A body in the group of a contact that stays open moves as a body alone, to rounding.
#[test]
fn springs_act_alike_in_groups_and_alone() {
    let run = |ground: f64| {
        let (mut lab, _) = bar_on_spring(2, 0.3);
        lab.gravity = DVec3::new(0.0, -1.0, 0.0);
        lab.add_wall(DVec3::Y, DVec3::new(0.0, ground, 0.0), 0.5, 0.0);
        lab.motions[0].velocity = DVec3::new(1.0, 0.5, 0.0);
        lab.step(H, 240);
        (lab.motions[0], lab.world.state.turns[0])
    };
    // The box of the ground reaches everywhere below it: the far one too is in a group, so that one is left out.
    let alone = {
        let (mut lab, _) = bar_on_spring(2, 0.3);
        lab.gravity = DVec3::new(0.0, -1.0, 0.0);
        lab.motions[0].velocity = DVec3::new(1.0, 0.5, 0.0);
        lab.step(H, 240);
        (lab.motions[0], lab.world.state.turns[0])
    };
    let near = run(-1.3);
    assert!((near.0.position - alone.0.position).length() < 1e-11, "{near:?} {alone:?}");
    assert!((near.0.velocity - alone.0.velocity).length() < 1e-10, "{near:?} {alone:?}");
    assert!((near.1.spin - alone.1.spin).length() < 1e-10, "{near:?} {alone:?}");
}

/// A block that a spring pulls up with half its weight rests on the ground.
#[test]
fn a_block_rests_under_a_spring() {
    let mut lab = Laboratory::new(2, DVec3::new(0.0, -G, 0.0));
    lab.add_plane(DVec3::Y, 0.5, 0.0);
    lab.add(&rectangle(0.4, 0.2), (2.0, 0.5, 0.0), (DVec3::new(0.0, 0.1, 0.0), Orientation::planar(0.0)), REST);
    let spring = DampedSpring { stiffness: 10.0 * G, damping: 0.0, rest_length: 0.9 };
    lab.join(JointKind::Spring(spring), [WORLD, 0], [DVec3::new(0.1, 1.2, 0.0), DVec3::new(0.1, 0.2, 0.0)], DVec3::Z);
    lab.step(H, 480);
    assert!((lab.motions[0].position - DVec3::new(0.0, 0.1, 0.0)).length() < 1e-9, "{}", lab.motions[0].position);
    assert!((lab.world.state.joints[0].reaction[0] - DVec3::new(0.0, G, 0.0)).length() < 1e-6);
}

/// A spring that breaks leaves its energy to the budget, and a disc in free fall.
#[test]
fn a_broken_spring_loses_its_energy() {
    let mut lab = Laboratory::new(2, DVec3::new(0.0, -G, 0.0));
    lab.add(&round("Disc", 0.1), (1.0, 0.0, 0.0), (DVec3::ZERO, Orientation::planar(0.0)), REST);
    let spring = DampedSpring { stiffness: STIFFNESS, damping: 0.0, rest_length: 1.0 };
    let joint = lab.join(JointKind::Spring(spring), [WORLD, 0], [DVec3::Y, DVec3::ZERO], DVec3::Z);
    joint.breaking_force = 1.5 * G;
    let before = lab.balance();
    lab.step(H, 240);
    let joint = &lab.world.state.joints[0];
    assert!(joint.broken && joint.reaction == [DVec3::ZERO; 2]);
    let torn = lab.world.state.torn;
    assert!((torn / (0.5 * (1.5 * G).powi(2) / STIFFNESS) - 1.0).abs() < 0.1, "{torn}");
    assert!((lab.balance() + torn - before).abs() < 1e-2 * torn, "{}", lab.balance() + torn - before);
}
