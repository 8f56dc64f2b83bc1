//! Energy of small groups: what impacts, friction and short bounces dissipate.

use glam::DVec3;
use physcore_base::scene::{Array, Item, Value};

use super::laboratory::{Laboratory, cuboid, rectangle, round, turned};
use crate::mover::Mover;
use crate::pose::Pose;
use crate::rotation::Orientation;
use crate::shapes::SolidShape;
use crate::surface::{Friction, Surface};
use crate::world::FixedSolid;

const G: f64 = 9.81;
const DOWN: DVec3 = DVec3::new(0.0, -G, 0.0);
const REST: (DVec3, DVec3) = (DVec3::ZERO, DVec3::ZERO);

fn at(x: f64, y: f64, angle: f64) -> (DVec3, Orientation) {
    (DVec3::new(x, y, 0.0), Orientation::planar(angle))
}

/// Largest error of the balance over the energy at the start, over a number of steps.
fn drift(lab: &mut Laboratory, h: f64, steps: usize) -> f64 {
    let before = lab.balance();
    (0..steps).fold(0.0, |most: f64, _| {
        lab.step(h, 1);
        most.max((lab.balance() - before).abs() / before.abs())
    })
}

/// Adds a fixed body.
fn add_fixed(lab: &mut Laboratory, item: &Item, position: DVec3) {
    let (shape, _) = SolidShape::declared(item, if lab.world.planar { 2 } else { 3 }).unwrap();
    lab.world.shapes.push(shape);
    let surface = Surface { shape: lab.world.shapes.len() - 1, friction: Some(Friction::default()), restitution: 0.0 };
    lab.world.walls.push(FixedSolid { surface, mover: Mover::wall(&Pose { position, ..Pose::WORLD }) });
    lab.world.wall_names.push("fixed".to_owned());
}

/// A free fall and its impacts are exact, bounces that end within a step too: what is left is the rounding of 1000 steps. A
/// ball without restitution slides over pegs, as a pendulum of ω² = g/R: steps of order 2 err by (ωH)²/24 of m g R, for
/// R = 0.031 m by 6e-6 of the energy.
#[test]
fn impacts_of_a_ball_are_booked_to_rounding() {
    for restitution in [0.0, 0.5, 1.0] {
        let mut lab = Laboratory::new(2, DOWN);
        lab.add_plane(DVec3::Y, 0.0, 0.0);
        for row in 0..5 {
            for column in 0..7 {
                let x = 0.1 * (f64::from(column) - 3.0 + 0.5 * f64::from(row % 2));
                add_fixed(&mut lab, &round("Disc", 0.015), DVec3::new(x, 0.3 + 0.09 * f64::from(row), 0.0));
            }
        }
        lab.add(&round("Disc", 0.016), (1.0, 0.0, restitution), at(0.004, 1.2, 0.0), REST);
        let drift = drift(&mut lab, 1.0 / 240.0, 1000);
        assert!(drift < if restitution > 0.0 { 1e-12 } else { 1e-5 }, "{restitution} {drift}");
    }
}

/// A plate that lands flat strikes with all its corners at once: it does not turn, and rises to e² of its height. So it does in
/// the plane and in space. The height is read at steps, up to g h²/8 below.
#[test]
fn a_plate_that_lands_flat_does_not_turn() {
    let (h, restitution) = (1.0 / 240.0, 0.5);
    for dimension in [2, 3] {
        let up = if dimension == 2 { DVec3::Y } else { DVec3::Z };
        let mut lab = Laboratory::new(dimension, -G * up);
        lab.add_plane(up, 0.5, 0.0);
        let place = 0.55 * up;
        if dimension == 2 {
            lab.add(&rectangle(0.6, 0.1), (1.0, 0.5, restitution), (place, Orientation::planar(0.0)), REST);
        } else {
            lab.add(&cuboid(0.6, 0.4, 0.1), (1.0, 0.5, restitution), (place, turned(1.0, 0.0, 0.0, 0.0)), REST);
        }
        let mut top = 0.0_f64;
        for step in 0..240 {
            lab.step(h, 1);
            assert!(lab.world.angular_velocity(0).length() < 1e-12, "{dimension} {step} {}", lab.world.angular_velocity(0));
            if lab.motions[0].velocity.dot(up) > 0.0 && step < 130 {
                top = top.max(lab.motions[0].position.dot(up) - 0.05);
            }
        }
        assert!((top - 0.125).abs() < G * h * h, "{dimension} {top}");
    }
}

/// Cube of an edge with a corner pushed in, as a mesh.
fn dented_cube(edge: f64) -> Item {
    let signs = (0..8).map(|corner| [4, 2, 1].map(|bit| if corner & bit == 0 { -0.5 } else { 0.5 }));
    let mut vertices: Vec<f64> = signs.flatten().map(|sign| sign * edge).collect();
    vertices[21..].fill(-0.1 * edge);
    let faces = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4]];
    let faces: Vec<u32> = faces.into_iter().chain([[1, 5, 7], [1, 7, 3]]).flatten().collect();
    let values = [
        ("vertices", Value::Numbers(Array { shape: vec![8, 3], entries: vertices })),
        ("faces", Value::Indices(Array { shape: vec![faces.len() / 3, 3], entries: faces })),
    ];
    Item::new("MeshShape", values)
}

/// A body whose parts are within reach of a wall stops there without turning, if it does not bounce, and its energy is lost.
#[test]
fn a_mesh_lands_flat_on_a_thin_wall_at_any_speed() {
    for speed in [1.0, 30.0, 60.0, 100.0, 1e3, 1e4] {
        let mut lab = Laboratory::new(3, -G * DVec3::Z);
        let wall = DVec3::new(0.5, 0.5, -5e-4);
        add_fixed(&mut lab, &cuboid(1.2, 1.2, 1e-3), wall);
        let place = (DVec3::new(0.25, 0.25, 0.25), turned(1.0, 0.0, 0.0, 0.0));
        lab.add(&dented_cube(0.15), (1.0, 0.0, 0.0), place, (-speed * DVec3::Z, DVec3::ZERO));
        for _ in 0..=(50.0 / speed).ceil() as usize {
            lab.step(1.0 / 240.0, 1);
        }
        // The center of mass is 0.35 edges above the lower face.
        let height = lab.motions[0].position.z - 0.35 * 0.15;
        assert!(height.abs() < 1e-9 && lab.world.angular_velocity(0).length() < 1e-9 * speed, "{speed}: {height}");
        assert!(lab.motions[0].velocity.length() < 1e-9 * speed && lab.overlap() < 1e-9, "{speed}");
    }
}

/// The errors of discs that fall in a heap are those of the motion between impacts, of order h².
#[test]
fn a_heap_of_discs_closes() {
    let of = |h: f64| {
        let mut lab = Laboratory::new(2, DOWN);
        lab.add_plane(DVec3::Y, 0.4, 0.3);
        lab.add_wall(DVec3::X, DVec3::new(-0.6, 0.0, 0.0), 0.4, 0.3);
        lab.add_wall(-DVec3::X, DVec3::new(0.6, 0.0, 0.0), 0.4, 0.3);
        for k in 0..10_u8 {
            let x = 0.4 * f64::from(k * 7 % 11) / 11.0 - 0.2;
            lab.add(&round("Disc", 0.1), (1.0, 0.4, 0.3), at(x, 0.3 + 0.3 * f64::from(k), 0.0), REST);
        }
        drift(&mut lab, h, (2.0 / h) as usize)
    };
    let (coarse, fine) = (of(1.0 / 120.0), of(1.0 / 480.0));
    assert!(coarse < 1e-4 && fine < 1e-5, "{coarse} {fine}");
}

/// A disc and a bar between walls that they cross forty times in a step, from many places.
#[test]
fn fast_bodies_stay_between_walls() {
    for start in 0..60 {
        let mut lab = Laboratory::new(2, DOWN);
        for (normal, place) in [(DVec3::X, 0.0), (-DVec3::X, 1.0), (DVec3::Y, 0.0), (-DVec3::Y, 1.0)] {
            lab.add_wall(normal, place * normal.abs(), 0.3, 0.9);
        }
        let (spin, x) = (DVec3::new(0.0, 0.0, 5e3), 0.3 + 1e-3 * f64::from(start));
        lab.add(&round("Disc", 0.05), (1.0, 0.3, 0.9), at(x, 0.3, 0.0), (DVec3::new(1e4, 3e3, 0.0), spin));
        lab.add(&rectangle(0.3, 0.02), (1.0, 0.3, 0.9), at(0.6, 0.6, 0.0), (DVec3::new(-1e4, 2e3, 0.0), -spin));
        let mut energy = lab.energy();
        for _ in 0..20 {
            lab.step(1.0 / 240.0, 1);
            assert!(lab.energy() <= energy + 1.0, "{} {energy}", lab.energy());
            energy = lab.energy();
            for motion in &lab.motions {
                let within = motion.position.cmpge(DVec3::ZERO).all() && motion.position.cmple(DVec3::ONE).all();
                assert!(within, "{start} {}", motion.position);
            }
            assert!(lab.overlap() < 1e-3, "{start} {}", lab.overlap());
        }
    }
}

/// The pairs of a step do not depend on those that were kept: blocks fall onto each other, tumble, and a fast ball hits them.
#[test]
fn pairs_that_are_kept_change_no_bits() {
    let of = |forgets: bool| {
        let mut lab = Laboratory::new(3, DOWN);
        lab.add_plane(DVec3::Y, 0.4, 0.2);
        for k in 0..12_u8 {
            let [x, y] = [f64::from(k % 4), f64::from(k / 4)];
            let place = DVec3::new(0.5 * x + 0.05 * y, 0.4 + 0.5 * y, 0.02 * x);
            let spin = DVec3::new(0.5 * x, -y, 3.0 * x);
            lab.add(&cuboid(0.4, 0.3, 0.1), (1.0, 0.4, 0.2), (place, turned(1.0, 0.1 * x, 0.2, 0.0)), (DVec3::ZERO, spin));
        }
        let fast = (DVec3::new(60.0, 0.0, 0.0), DVec3::ZERO);
        lab.add(&round("Ball", 0.1), (5.0, 0.4, 0.2), (DVec3::new(-3.0, 0.3, 0.0), turned(1.0, 0.0, 0.0, 0.0)), fast);
        for _ in 0..80 {
            if forgets {
                lab.world.forget_pairs();
            }
            lab.step(1.0 / 240.0, 1);
        }
        lab.motions.iter().map(|motion| (motion.position, motion.velocity)).collect::<Vec<_>>()
    };
    assert!(of(false) == of(true));
}

/// With μ = 1 at both walls of a corner, a disc can be jammed there by impulses of any size, which balance each other. Bodies that
/// press on it leave it free of them. In a step of 1/480 s a square spins by 0.04 rad: the error of the energy is about
/// half the square of that.
#[test]
fn a_disc_in_a_corner_is_not_jammed() {
    let mut lab = Laboratory::new(2, DVec3::new(0.0, -9.81, 0.0));
    let side = 0.08_f64.sqrt();
    for (item, mass, friction, position, velocity) in [
        (round("Disc", 0.2), 1.0, 0.0, [0.25, 0.25], [0.0, 0.0]),
        (rectangle(side, side), 1.0, 0.0, [0.25, 0.75], [2.0, 2.0]),
        (round("Disc", 0.19375), 1.0, 0.0, [0.75, 0.75], [0.0, -1.0]),
        (round("Disc", 0.1), 0.375, 1.0, [0.75, 0.25], [0.75, 0.0]),
    ] {
        let vector = |[x, y]: [f64; 2]| DVec3::new(x, y, 0.0);
        lab.add(&item, (mass, friction, 0.0), (vector(position), Orientation::planar(0.0)), (vector(velocity), DVec3::ZERO));
    }
    for (normal, place) in [(DVec3::X, DVec3::ZERO), (-DVec3::X, DVec3::X), (DVec3::Y, DVec3::ZERO), (-DVec3::Y, DVec3::Y)] {
        lab.add_wall(normal, place, 1.0, 1.0);
    }
    let start = lab.balance();
    lab.step(1.0 / 480.0, 240);
    let change = (lab.balance() - start).abs();
    assert!(change < 1e-3 * start, "{change} of {start}");
    assert!(lab.overlap() < 1e-5, "{}", lab.overlap());
}

/// A disc falls on a tower of others in a large group. The lower contacts overlap, and yield to the impact: they dissipate their
/// part of its energy. The balance errs by the work that lifts the discs out of their overlaps: g h² for each above, in pieces of
/// length h. It errs too by the way of a piece, by which the disc falls too far or not far enough.
#[test]
fn an_impact_on_a_tower_is_booked() {
    let (height, below, step) = (1.0, 4_u8, 1.0 / 120.0);
    let mut lab = Laboratory::new(2, DOWN);
    lab.world.solver.sequential = 0;
    lab.world.solver.iterations = 100;
    lab.add_plane(DVec3::Y, 0.5, 0.0);
    for k in 0..=below {
        let top = if k == below { height } else { 0.0 };
        lab.add(&round("Disc", 0.1), (1.0, 0.5, 0.0), at(0.0, 0.1 + 0.2 * f64::from(k) + top, 0.0), REST);
    }
    let start = lab.balance();
    lab.step(step, 120);
    let (discs, piece) = (f64::from(below + 1), step / lab.world.solver.substeps as f64);
    let most = G * (discs * discs * G * piece * piece + piece * (2.0 * G * height).sqrt());
    let error = lab.balance() - start;
    assert!(lab.meters.dissipated > 0.99 * G * height, "{}", lab.meters.dissipated);
    assert!(error.abs() < most, "{error} J, at most {most} J of {} J", G * height);
}
