//! Motion of joined bodies: closed forms, conservation, loops and limits.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;

use super::laboratory::{Laboratory, cuboid, rectangle, round, turned};
use crate::joints::{JointKind, Motor};
use crate::rotation::{Orientation, rotation_by};
use crate::world::WORLD;

const G: f64 = 9.81;
const DOWN: DVec3 = DVec3::new(0.0, -G, 0.0);
const H: f64 = 1.0 / 240.0;
const REST: (DVec3, DVec3) = (DVec3::ZERO, DVec3::ZERO);
/// Error of a joint in a small group, over the size of its bodies: the tolerance of the linearizations is 1e-11.
const CLOSED: f64 = 1e-9;

/// Adds bars of length 1 between points, each 0.8 long, so that they do not touch; returns the index of the first.
fn add_bars(lab: &mut Laboratory, points: &[DVec3], mass: impl Fn(usize) -> f64) -> usize {
    let first = lab.motions.len();
    for (index, ends) in points.windows(2).enumerate() {
        let way = ends[1] - ends[0];
        let angle = libm::atan2(way.y, way.x);
        let shape = rectangle(0.8 * way.length(), 0.02 * way.length());
        lab.add(&shape, (mass(index), 0.3, 0.0), (ends[0].midpoint(ends[1]), Orientation::planar(angle)), REST);
    }
    first
}

/// Joins bars to each other, and the first to the world.
fn hinge_bars(lab: &mut Laboratory, points: &[DVec3], first: usize) {
    for (index, &point) in points[..points.len() - 1].iter().enumerate() {
        let before = if index == 0 { WORLD } else { first + index - 1 };
        lab.join(JointKind::Hinge, [before, first + index], [point; 2], DVec3::Z);
    }
}

/// Bars of length 1 that hang on the world, at these angles from the horizontal.
fn hanging(angles: &[f64], mass: impl Fn(usize) -> f64) -> Laboratory {
    let mut lab = Laboratory::new(2, DOWN);
    let mut points = vec![DVec3::ZERO];
    points.extend(angles.iter().scan(DVec3::ZERO, |point, angle| {
        *point += DVec3::new(angle.cos(), angle.sin(), 0.0);
        Some(*point)
    }));
    let first = add_bars(&mut lab, &points, mass);
    hinge_bars(&mut lab, &points, first);
    lab
}

fn angle(lab: &Laboratory, body: usize) -> f64 {
    lab.world.state.turns[body].orientation.angle
}

/// Largest error of the balance of energy, over a number of steps [J].
fn drift(lab: &mut Laboratory, h: f64, steps: usize) -> f64 {
    let before = lab.balance();
    (0..steps).fold(0.0, |most: f64, _| {
        lab.step(h, 1);
        most.max((lab.balance() - before).abs())
    })
}

/// A quarter of the period of a bar that falls from the horizontal is K(sin 45°)/ω, with ω² = m g d/(I + m d²). The angle then is
/// −90°, up to an error of order h².
#[test]
fn a_pendulum_has_its_period() {
    const K: f64 = 1.854_074_677_301_371_8;
    let error = |steps: usize| {
        let mut lab = hanging(&[0.0], |_| 2.0);
        let inertia = (0.64 + 4e-4) / 12.0 + 0.25;
        let quarter = K / (0.5 * G / inertia).sqrt();
        lab.step(quarter / steps as f64, steps);
        angle(&lab, 0) + FRAC_PI_2
    };
    let (coarse, fine) = (error(100), error(200));
    assert!(fine.abs() < 1e-4, "{fine}");
    assert!((coarse / fine - 4.0).abs() < 0.05, "{coarse} {fine}");
}

#[test]
fn the_energy_of_a_double_pendulum_errs_by_the_square_of_the_step() {
    let error = |steps: usize| drift(&mut hanging(&[0.3, -0.4], |_| 1.0), 2.0 / steps as f64, steps);
    let (coarse, fine) = (error(500), error(1000));
    assert!((coarse / fine - 4.0).abs() < 0.2, "{coarse} {fine}");
}

/// Reversed velocities lead back to the start. Rounding and the tolerance of the joints, 1e-11, grow with the motion.
#[test]
fn motion_with_joints_is_reversible() {
    let mut lab = hanging(&[0.3, -0.4, -0.9], |index| 1.0 + index as f64);
    let start: Vec<DVec3> = lab.motions.iter().map(|motion| motion.position).collect();
    lab.step(H, 240);
    assert!((lab.motions[2].position - start[2]).length() > 0.5);
    lab.reverse();
    lab.step(H, 240);
    for (motion, start) in lab.motions.iter().zip(start) {
        assert!((motion.position - start).length() < 1e-8, "{}", motion.position - start);
    }
}

/// A free chain in space, with each kind of joint, keeps momentum and angular momentum to the rounding of its impulses.
#[test]
fn free_chains_keep_their_momenta() {
    let kinds = [JointKind::Ball, JointKind::Hinge, JointKind::Weld, JointKind::Prismatic, JointKind::Rod(1.0)];
    let mut lab = Laboratory::new(3, DVec3::ZERO);
    let turning = DVec3::new(0.3, -0.2, 0.5);
    for k in 0..=kinds.len() {
        let place = DVec3::new(k as f64, 0.0, 0.0);
        lab.add(
            &cuboid(0.6, 0.1, 0.2),
            (1.0 + k as f64, 0.0, 0.0),
            (place, turned(1.0, 0.0, 0.0, 0.0)),
            (turning.cross(place), turning),
        );
    }
    // Another spin of the last body moves every joint.
    lab.world.turn(kinds.len(), turned(1.0, 0.0, 0.0, 0.0), DVec3::new(3.0, 2.0, -1.0));
    for (k, kind) in kinds.into_iter().enumerate() {
        let middle = DVec3::new(k as f64 + 0.5, 0.0, 0.0);
        let points =
            if let JointKind::Rod(length) = kind { [-0.5, 0.5].map(|x| middle + x * length * DVec3::X) } else { [middle; 2] };
        lab.join(kind, [k, k + 1], points, DVec3::new(0.0, 0.6, 0.8));
    }
    let before = lab.momenta();
    let scale = 30.0;
    let energy = lab.energy();
    for _ in 0..480 {
        lab.step(H, 1);
        let (momentum, angular) = lab.momenta();
        assert!((momentum - before.0).length() < 1e-12 * scale, "{}", momentum - before.0);
        assert!((angular - before.1).length() < 1e-12 * scale, "{}", angular - before.1);
        assert!(lab.opening() < CLOSED, "{:e}", lab.opening());
    }
    assert!((lab.energy() / energy - 1.0).abs() < 1e-3, "{}", lab.energy() / energy);
}

/// Planks of length 1 in a half circle between two points.
fn bridge(count: usize, mass: impl Fn(usize) -> f64) -> Laboratory {
    let mut lab = Laboratory::new(2, DOWN);
    let radius = count as f64 / PI;
    let angles = (0..=count).map(|k| -PI * k as f64 / count as f64);
    let points: Vec<DVec3> = angles.map(|angle| radius * DVec3::new(-angle.cos(), angle.sin(), 0.0)).collect();
    let first = add_bars(&mut lab, &points, mass);
    hinge_bars(&mut lab, &points, first);
    lab.join(JointKind::Hinge, [count - 1, WORLD], [points[count]; 2], DVec3::Z);
    lab
}

/// Twenty planks with a heavy one in the middle stay closed while they sag. The energy errs by the square of the step.
#[test]
fn a_chain_of_twenty_planks_bears_a_load() {
    let error = |steps: usize| {
        let mut lab = bridge(20, |index| if index == 10 { 100.0 } else { 1.0 });
        let (before, mut worst) = (lab.balance(), 0.0_f64);
        for _ in 0..steps {
            lab.step(1.0 / steps as f64, 1);
            assert!(lab.opening() < CLOSED, "{:e}", lab.opening());
            worst = worst.max((lab.balance() - before).abs());
        }
        assert!(lab.motions[10].velocity.length() > 0.5, "{}", lab.motions[10].velocity);
        worst
    };
    let (coarse, fine) = (error(240), error(480));
    assert!(fine < 1e-4 * 120.0 * G * 6.0, "{fine}");
    assert!((coarse / fine - 4.0).abs() < 0.4, "{coarse} {fine}");
}

/// A bridge of a large group: its joints are solved together in each piece, which corrects what the last one left.
#[test]
fn a_bridge_of_sixty_planks_holds() {
    let mut lab = bridge(60, |_| 1.0);
    let (before, mut worst) = (lab.balance(), 0.0_f64);
    for _ in 0..480 {
        lab.step(H, 1);
        worst = worst.max(lab.opening());
    }
    // Errors of a piece are of the order of the square of the turn in it, (1e-3 rad)², and no larger in the sum.
    assert!(worst < 1e-5, "{worst:e}");
    assert!((lab.balance() - before).abs() < 1e-6 * 60.0 * G * 20.0, "{}", lab.balance() - before);
}

/// A crank turns at the speed of its motor. The rocker's angle follows from the lengths of the four bars: its end is where two
/// circles meet.
#[test]
fn a_four_bar_linkage_moves_as_its_geometry_says() {
    let [ground, crank, coupler, rocker] = [4.0, 1.0, 3.5, 2.5];
    let end = |turn: f64| {
        let from = crank * DVec3::new(turn.cos(), turn.sin(), 0.0);
        let way = DVec3::new(ground, 0.0, 0.0) - from;
        let distance = way.length();
        let along = (distance * distance + coupler * coupler - rocker * rocker) / (2.0 * distance);
        let across = (coupler * coupler - along * along).sqrt();
        from + (along * way + across * DVec3::new(-way.y, way.x, 0.0)) / distance
    };
    let start = 0.7;
    let points =
        [DVec3::ZERO, crank * DVec3::new(f64::cos(start), f64::sin(start), 0.0), end(start), DVec3::new(ground, 0.0, 0.0)];
    let mut lab = Laboratory::new(2, DOWN);
    let first = add_bars(&mut lab, &points, |_| 1.0);
    hinge_bars(&mut lab, &points, first);
    lab.join(JointKind::Hinge, [2, WORLD], [points[3]; 2], DVec3::Z);
    lab.world.state.joints[0].joint.motor = Some(Motor { speed: 3.0, most: 1e3 });
    // The start takes a tenth of a second.
    lab.step(H, 24);
    let from = (lab.world.angular_velocity(0).z, angle(&lab, 0));
    assert!((from.0 - 3.0).abs() < 1e-6, "{}", from.0);
    for _ in 0..480 {
        lab.step(H, 1);
        let held = lab.mover(2).pose().point(DVec3::new(-0.5 * rocker, 0.0, 0.0));
        let expected = end(angle(&lab, 0));
        assert!((held - expected).length() < 10.0 * CLOSED, "{held} {expected}");
    }
    assert!((angle(&lab, 0) - from.1 - 6.0).abs() < 1e-3, "{}", angle(&lab, 0) - from.1);
}

/// A door on two hinges has five equations too many. It swings about a sloping axis as a door on one hinge does, and both
/// together bear what that one bears.
#[test]
fn redundant_hinges_share_the_load_of_one() {
    let slope = rotation_by(DVec3::new(0.5, 0.0, 0.0));
    let axis = slope * DVec3::Z;
    let door = |hinges: &[f64]| {
        let mut lab = Laboratory::new(3, DVec3::new(0.0, 0.0, -G));
        lab.add(
            &cuboid(0.8, 0.04, 2.0),
            (20.0, 0.0, 0.0),
            (slope * DVec3::new(0.4, 0.0, 0.0), Orientation::spatial(slope)),
            REST,
        );
        for &height in hinges {
            lab.join(JointKind::Hinge, [WORLD, 0], [height * axis; 2], axis);
        }
        lab
    };
    let (mut one, mut two) = (door(&[0.0]), door(&[-0.8, 0.8]));
    for _ in 0..240 {
        one.step(H, 1);
        two.step(H, 1);
        assert!(
            (one.motions[0].position - two.motions[0].position).length() < 1e-7,
            "{} {}",
            one.motions[0].position,
            two.motions[0].position
        );
        let force = |lab: &Laboratory| lab.world.state.joints.iter().map(|joint| joint.reaction[0]).sum::<DVec3>();
        assert!((force(&one) - force(&two)).length() < 1e-3, "{} {}", force(&one), force(&two));
        assert!(two.opening() < CLOSED, "{:e}", two.opening());
    }
    assert!((one.motions[0].position - slope * DVec3::new(0.4, 0.0, 0.0)).length() > 0.1);
}

/// A bar falls on the limit of its hinge and rests there. All that it loses is metered, up to the error of the fall, and it never
/// gains.
#[test]
fn limits_dissipate_and_never_add_energy() {
    for (dimension, limit) in [(2, -0.5), (3, -0.5), (2, -2.5)] {
        let mut lab = Laboratory::new(dimension, DOWN);
        let (shape, orientation) = if dimension == 2 {
            (rectangle(0.8, 0.1), Orientation::planar(0.0))
        } else {
            (cuboid(0.8, 0.1, 0.1), turned(1.0, 0.0, 0.0, 0.0))
        };
        lab.add(&shape, (3.0, 0.0, 0.0), (DVec3::new(0.5, 0.0, 0.0), orientation), REST);
        lab.join(JointKind::Hinge, [WORLD, 0], [DVec3::ZERO; 2], DVec3::Z).limits = [limit, 3.0];
        let scale = 3.0 * G * 0.5;
        let (before, mut energy) = (lab.balance(), lab.energy());
        for _ in 0..720 {
            lab.step(H, 1);
            assert!((lab.balance() - before).abs() < 1e-4 * scale, "{}", (lab.balance() - before) / scale);
            assert!(lab.energy() < energy + 1e-4 * scale);
            energy = energy.min(lab.energy());
        }
        if limit > -FRAC_PI_2 {
            let height = 0.5 * f64::sin(limit);
            assert!((lab.motions[0].position.y - height).abs() < 1e-8, "{}", lab.motions[0].position.y - height);
            assert!((lab.meters.dissipated + 3.0 * G * height).abs() < 1e-4 * scale, "{}", lab.meters.dissipated);
        }
    }
}

/// A ball strikes a bar that lies at its limit, which bears the impact at once: it bounces as from a wall.
#[test]
fn a_limit_bears_impacts() {
    let mut lab = Laboratory::new(2, DVec3::ZERO);
    lab.add(&rectangle(1.0, 0.1), (1.0, 0.0, 1.0), (DVec3::new(0.5, 0.0, 0.0), Orientation::planar(0.0)), REST);
    lab.add(
        &round("Disc", 0.1),
        (1.0, 0.0, 1.0),
        (DVec3::new(0.6, 0.4, 0.0), Orientation::planar(0.0)),
        (-2.0 * DVec3::Y, DVec3::ZERO),
    );
    lab.join(JointKind::Hinge, [WORLD, 0], [DVec3::ZERO; 2], DVec3::Z).limits = [0.0, 1.0];
    lab.step(H, 60);
    assert!((lab.motions[1].velocity.y - 2.0).abs() < 1e-6, "{}", lab.motions[1].velocity);
    assert!(angle(&lab, 0).abs() < 1e-9, "{}", angle(&lab, 0));
}

/// Limits count all turns, in space as in the plane.
#[test]
fn a_wheel_stops_after_several_turns() {
    for dimension in [2, 3] {
        let mut lab = Laboratory::new(dimension, DVec3::ZERO);
        let (shape, orientation) = if dimension == 2 {
            (round("Disc", 0.2), Orientation::planar(0.0))
        } else {
            (round("Ball", 0.2), turned(1.0, 0.0, 0.0, 0.0))
        };
        lab.add(&shape, (1.0, 0.0, 0.0), (DVec3::ZERO, orientation), (DVec3::ZERO, 20.0 * DVec3::Z));
        lab.join(JointKind::Hinge, [WORLD, 0], [DVec3::ZERO; 2], DVec3::Z).limits = [-1.0, 10.0];
        lab.step(H, 240);
        let joint = lab.world.state.joints[0].joint;
        let (_, place) = joint.freedom([&lab.mover(WORLD), &lab.mover(0)]).unwrap();
        // It is reached 1e-9 of the lever before.
        assert!((place / joint.unit() - 10.0).abs() < 1e-8, "{place}");
        assert!(lab.world.angular_velocity(0).length() < 1e-9);
    }
}

/// A motor moves the second body at its speed, between limits that it does not reach, and its work is the kinetic energy.
#[test]
fn motors_reach_their_speed_between_limits() {
    let mut lab = Laboratory::new(2, DOWN);
    lab.add(&rectangle(0.2, 0.1), (2.0, 0.0, 0.0), (DVec3::ZERO, Orientation::planar(0.0)), REST);
    let joint = lab.join(JointKind::Prismatic, [WORLD, 0], [DVec3::ZERO; 2], DVec3::X);
    (joint.limits, joint.motor) = ([-0.1, 5.0], Some(Motor { speed: 0.5, most: 20.0 }));
    lab.step(H, 240);
    assert!((lab.motions[0].velocity.x - 0.5).abs() < 1e-9, "{}", lab.motions[0].velocity.x);
    assert!((lab.meters.work - 0.25).abs() < 1e-9, "{}", lab.meters.work);
    // It takes v/a = 0.05 s at the largest force.
    assert!((lab.motions[0].position.x - (0.5 - 0.0125)).abs() < 2e-3 * 0.5, "{}", lab.motions[0].position.x);
}

/// A welded cantilever bears its weight, and the moment of the weight about the anchor; on the other body, the opposite ones.
#[test]
fn a_cantilever_has_its_bending_moment() {
    for (ends, sign) in [([WORLD, 0], 1.0), ([0, WORLD], -1.0)] {
        let mut lab = Laboratory::new(2, DOWN);
        lab.add(&rectangle(1.0, 0.1), (3.0, 0.0, 0.0), (DVec3::new(0.5, 0.0, 0.0), Orientation::planar(0.0)), REST);
        lab.join(JointKind::Weld, ends, [DVec3::ZERO; 2], DVec3::Z);
        lab.step(H, 240);
        let [force, torque] = lab.world.state.joints[0].reaction;
        assert!((force - sign * DVec3::new(0.0, 3.0 * G, 0.0)).length() < 1e-6, "{force}");
        assert!((torque - sign * DVec3::new(0.0, 0.0, 1.5 * G)).length() < 1e-6, "{torque}");
    }
}

/// A rod breaks where its tension passes 2 m g, 3 m g sin a = 2 m g, and bears nothing from then on.
#[test]
fn a_broken_joint_bears_nothing() {
    let mut lab = Laboratory::new(2, DOWN);
    lab.add(&round("Disc", 0.1), (1.0, 0.0, 0.0), (DVec3::X, Orientation::planar(0.0)), REST);
    lab.join(JointKind::Rod(1.0), [WORLD, 0], [DVec3::ZERO, DVec3::X], DVec3::Z).breaking_force = 2.0 * G;
    while !lab.world.state.joints[0].broken {
        lab.step(H, 1);
    }
    let fallen = libm::asin(-lab.motions[0].position.y);
    // One step turns it by h √(2 g sin a).
    assert!((fallen - libm::asin(2.0 / 3.0)).abs() < 2.0 * H * (2.0 * G * 2.0 / 3.0_f64).sqrt(), "{fallen}");
    let velocity = lab.motions[0].velocity;
    for _ in 0..10 {
        assert_eq!(lab.world.state.joints[0].reaction, [DVec3::ZERO; 2]);
        lab.step(H, 1);
    }
    assert!((lab.motions[0].velocity - velocity - 10.0 * H * DOWN).length() < 1e-12);
}

/// Bodies overlap where their joint is. An overlap that is left slowly adds no energy for which the step would be taken again.
#[test]
fn bodies_whose_joint_breaks_do_not_fly_apart() {
    for overlap in [0.01, 0.1] {
        let mut lab = Laboratory::new(2, DOWN);
        for x in [0.0, 0.5 - overlap] {
            lab.add(&rectangle(0.5, 0.1), (12.0, 0.8, 0.0), (x * DVec3::X, Orientation::planar(0.0)), REST);
        }
        lab.join(JointKind::Hinge, [0, 1], [(0.25 - 0.5 * overlap) * DVec3::X; 2], DVec3::Z);
        lab.step(H, 10);
        let before = lab.balance();
        lab.world.state.joints[0].broken = true;
        lab.step(H, 400);
        assert!(lab.overlap() < 1e-6, "{}", lab.overlap());
        assert_eq!(lab.world.state.retaken, 0);
        let gain = lab.balance() - before;
        assert!(gain.abs() < 1e-9 * 24.0 * G * overlap, "{gain}");
    }
}
