//! Motion on surfaces that are made of parts, which must be as that on whole ones.

use glam::{DQuat, DVec3};
use physcore_base::scene::{Array, Item, Value};

use super::laboratory::{Laboratory, cuboid, rectangle, round, turned};
use super::plane::random;
use crate::mover::Mover;
use crate::pose::Pose;
use crate::rotation::Orientation;
use crate::shapes::{SolidShape, walls};
use crate::surface::{Friction, Surface};
use crate::world::FixedSolid;

const G: f64 = 9.81;
const H: f64 = 1.0 / 240.0;

/// Adds a shape at rest.
fn fix(lab: &mut Laboratory, shape: SolidShape, pose: &Pose, friction: f64) {
    lab.world.shapes.push(shape);
    let friction = Some(Friction { sliding: friction, ..Friction::default() });
    let surface = Surface { shape: lab.world.shapes.len() - 1, friction, restitution: 0.0 };
    lab.world.walls.push(FixedSolid { surface, mover: Mover::wall(pose) });
    lab.world.wall_names.push("wall".to_owned());
}

/// Adds a slope down along x, a height field whose nodes are 0.1 m apart.
fn add_slope(lab: &mut Laboratory, dimension: usize, slope: f64, friction: f64) {
    let shape = if dimension == 2 { vec![91] } else { vec![91, 13] };
    let count: usize = shape.iter().product();
    let row = shape.get(1).copied().unwrap_or(1);
    let entries = (0..count).map(|node| -slope * 0.1 * (node / row) as f64).collect();
    let item = Item::new(
        "HeightField",
        [
            ("heights", Value::Numbers(Array { shape, entries })),
            ("spacing", Value::Number(0.1)),
            ("origin", Value::Vector(DVec3::new(-1.0, -0.6, 0.0).with_y(if dimension == 2 { 0.0 } else { -0.6 }))),
            ("friction", Value::Number(friction)),
            ("restitution", Value::Number(0.0)),
        ],
    );
    let wall = walls(&item, 0, dimension).unwrap().remove(0);
    fix(lab, wall.shape, &wall.pose, friction);
}

/// Bodies roll and slide down a slope of parts as down a plane, without a loss where parts meet. The heights are rounded, and so
/// are the normals of the parts, by 1e-16 of 9 m over 0.1 m; the way of 5 m is the integral of these.
#[test]
fn a_slope_of_parts_is_a_slope() {
    let angle = 25.0_f64.to_radians();
    for (dimension, kind, friction) in [(2, "Disc", 0.5), (2, "Rectangle", 0.1), (3, "Ball", 0.5), (3, "Cuboid", 0.1)] {
        let up = DVec3::AXES[dimension - 1];
        let normal = DVec3::X * angle.sin() + up * angle.cos();
        let down = DVec3::X * angle.cos() - up * angle.sin();
        let mut lab = Laboratory::new(dimension, up * -G);
        add_slope(&mut lab, dimension, angle.tan(), friction);
        let item = match kind {
            "Rectangle" => rectangle(0.37, 0.2),
            "Cuboid" => cuboid(0.37, 0.27, 0.2),
            _ => round(kind, 0.1),
        };
        let orientation =
            if dimension == 2 { Orientation::planar(-angle) } else { Orientation::spatial(DQuat::from_rotation_y(angle)) };
        let start = -up * (1.0 * angle.tan()) + 0.1 * normal;
        lab.add(&item, (2.0, friction, 0.0), (start, orientation), (DVec3::ZERO, DVec3::ZERO));
        let before = lab.balance();
        lab.step(H, 360);
        let along = match kind {
            "Disc" => G * angle.sin() / 1.5,
            "Ball" => G * angle.sin() / 1.4,
            _ => G * (angle.sin() - friction * angle.cos()),
        };
        let way = lab.motions[0].position - start;
        assert!((way - down * (0.5 * along * 2.25)).length() < 1e-9, "{kind}: {}", way - down * (1.125 * along));
        assert!((lab.balance() - before).abs() < 1e-9 * 2.0 * G * way.length(), "{kind}: {}", lab.balance() - before);
    }
}

/// Polygon in the shape of a U: 1 m wide and 0.6 m high outside, with walls of 0.1 m.
fn cup() -> Item {
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.6], [0.9, 0.6], [0.9, 0.1], [0.1, 0.1], [0.1, 0.6], [0.0, 0.6]];
    let entries: Vec<f64> = corners.into_iter().flatten().collect();
    Item::new("Polygon", [("vertices", Value::Numbers(Array { shape: vec![8, 2], entries }))])
}

/// A fast disc stays in a cup, whose walls it would pass within a step, and its energy is only dissipated.
#[test]
fn a_cup_holds_a_fast_disc() {
    for (speed, angle) in [(30.0, 0.3), (100.0, 2.0), (300.0, -0.4)] {
        let mut lab = Laboratory::new(2, DVec3::new(0.0, -G, 0.0));
        let (shape, mass) = SolidShape::declared(&cup(), 2).unwrap();
        fix(&mut lab, shape, &Pose { position: mass.center, ..Pose::WORLD }, 0.3);
        // A lid.
        lab.add_wall(DVec3::NEG_Y, DVec3::new(0.0, 0.6, 0.0), 0.3, 0.0);
        let velocity = DVec3::new(speed * f64::cos(angle), speed * f64::sin(angle), 0.0);
        let start = (DVec3::new(0.5, 0.3, 0.0), Orientation::planar(0.0));
        lab.add(&round("Disc", 0.05), (1.0, 0.3, 0.8), start, (velocity, DVec3::ZERO));
        let before = lab.balance();
        for _ in 0..100 {
            lab.step(H, 10);
            let at = lab.motions[0].position;
            let is_in = (0.15 - 1e-6..=0.85 + 1e-6).contains(&at.x) && (0.15 - 1e-6..=0.55 + 1e-6).contains(&at.y);
            assert!(is_in, "speed {speed}: {at}");
        }
        assert!((lab.balance() - before).abs() < 1e-4 * 0.5 * speed * speed, "{}", lab.balance() - before);
    }
}

/// A cup upside down falls onto its two rims, and stands on them.
#[test]
fn a_cup_stands_on_its_rims() {
    let mut lab = Laboratory::new(2, DVec3::new(0.0, -G, 0.0));
    lab.add_plane(DVec3::Y, 0.5, 0.0);
    let mass = SolidShape::declared(&cup(), 2).unwrap().1;
    let height = 0.6 - mass.center.y;
    let start = (DVec3::Y * (height + 0.05), Orientation::planar(std::f64::consts::PI));
    lab.add(&cup(), (1.0, 0.5, 0.0), start, (DVec3::ZERO, DVec3::ZERO));
    lab.step(H, 480);
    assert!((lab.motions[0].position - DVec3::Y * height).length() < 1e-8, "{}", lab.motions[0].position);
    assert!(lab.motions[0].velocity.length() < 1e-8);
}

/// An angle of two thin bars, a bar and a cube stay in a box of thin walls, whatever feature of theirs comes first. They do not
/// overlap deeper than half the thickness of a wall, 1 mm, and gain no energy.
#[test]
fn corners_and_edges_stay_between_thin_walls() {
    let records = vec![cuboid(0.137, 0.0137, 0.02), cuboid(0.0101, 0.101, 0.005)];
    let positions = vec![0.0, -0.05, 0.0, -0.0685, 0.0, 0.0];
    let orientations = vec![1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
    let values = [
        ("shapes", Value::Records(records)),
        ("positions", Value::Numbers(Array { shape: vec![2, 3], entries: positions })),
        ("orientations", Value::Numbers(Array { shape: vec![2, 4], entries: orientations })),
    ];
    let items = [Item::new("Compound", values), cuboid(0.137, 0.0137, 0.02), cuboid(0.1, 0.1, 0.1)];
    let mut seed = 1;
    for (trial, item) in items.iter().cycle().take(300).enumerate() {
        let mut lab = Laboratory::new(3, DVec3::NEG_Z * G);
        for (axis, side) in DVec3::AXES.into_iter().flat_map(|axis| [(axis, -0.0005), (axis, 1.0005)]) {
            let size = DVec3::splat(1.2) - axis * 1.199;
            let (shape, _) = SolidShape::declared(&cuboid(size.x, size.y, size.z), 3).unwrap();
            let position = 0.5 * (DVec3::ONE - axis) + side * axis;
            fix(&mut lab, shape, &Pose { position, ..Pose::WORLD }, 0.3);
        }
        let mut draw = || 2.0 * random(&mut seed) - 1.0;
        let mut vector = || DVec3::new(draw(), draw(), draw());
        let (velocity, turning, turn) = (20.0 * vector(), 3.0 * vector(), vector());
        let start = (DVec3::splat(0.5), turned(1.0, turn.x, turn.y, turn.z));
        lab.add(item, (1.0, 0.8, 0.0), start, (velocity, turning));
        let mut energy = lab.energy();
        for step in 0..40 {
            lab.step(H, 1);
            assert!(lab.overlap() < 5e-4, "trial {trial}, step {step}: {}", lab.overlap());
            assert!(lab.energy() <= 1.01 * energy, "trial {trial}, step {step}: {} {energy}", lab.energy());
            energy = lab.energy();
        }
    }
}
