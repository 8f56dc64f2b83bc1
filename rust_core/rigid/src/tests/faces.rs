//! Faces of networks that bodies meet between their particles.

use glam::DVec3;
use physcore_base::parallel::SERIAL;
use physcore_base::scene::Item;

use super::laboratory::{Laboratory, cuboid, round, turned};
use crate::face::NetFace;
use crate::shapes::SolidShape;
use crate::surface::Surface;
use crate::world::{CenterMotion, FreeFace, FreeParticles, FreePoint};

/// Body in its laboratory with particles, without forces, and faces between them.
struct Net {
    lab: Laboratory,
    points: Vec<FreePoint>,
    motions: Vec<CenterMotion>,
    faces: Vec<FreeFace>,
}

impl Net {
    /// Particles of a mass [kg] and the triangles between them, of which the first has the side that two share.
    fn new(lab: Laboratory, places: &[DVec3], mass: f64, triangles: &[[usize; 3]], radius: f64) -> Self {
        let mut net = Self { lab, points: Vec::new(), motions: Vec::new(), faces: Vec::new() };
        net.lab.world.shapes.push(SolidShape::round(radius));
        let surface = Surface { shape: net.lab.world.shapes.len() - 1, friction: None, restitution: 0.0 };
        for (index, &place) in places.iter().enumerate() {
            net.points.push(FreePoint { index: index + 1, surface, inverse_mass: 1.0 / mass });
            net.motions.push(CenterMotion::free(place, DVec3::ZERO));
        }
        let has = |corners: &[usize; 3], ends: [usize; 2]| ends.iter().all(|end| corners.contains(end));
        for (index, &corners) in triangles.iter().enumerate() {
            let mut face = NetFace { corners, beyond: [None; 3], owns: [true; 3], radius };
            for side in 0..3 {
                let ends = [corners[side], corners[(side + 1) % 3]];
                let mut others = triangles.iter().enumerate().filter(|(other, corners)| *other != index && has(corners, ends));
                if let Some((other, corners)) = others.next() {
                    face.owns[side] = index < other;
                    face.beyond[side] = corners.iter().copied().find(|corner| !ends.contains(corner));
                }
            }
            net.faces.push(FreeFace { index, face });
        }
        net
    }

    /// Takes steps of `h` seconds.
    fn step(&mut self, h: f64, steps: usize) {
        for _ in 0..steps {
            self.motions.iter_mut().for_each(|motion| motion.drift = motion.velocity);
            let kick = 0.5 * h * self.lab.gravity;
            self.lab.motions.iter_mut().for_each(|motion| motion.drift = motion.velocity + kick);
            let particles = FreeParticles { points: &self.points, faces: &self.faces };
            let moved = self.lab.world.drift((h, false), &mut self.lab.motions, particles, &mut self.motions, &SERIAL);
            for (motion, moved) in self.lab.motions.iter_mut().chain(&mut self.motions).zip(moved) {
                motion.position += if moved { DVec3::ZERO } else { h * motion.drift };
                motion.velocity = motion.drift;
            }
            self.lab.motions.iter_mut().for_each(|motion| motion.velocity += kick);
            let meters = self.lab.world.finish(h, &mut self.lab.motions, &mut self.motions, &SERIAL);
            self.lab.meters.dissipated += meters.dissipated;
        }
    }

    /// Momentum, and angular momentum about the origin.
    fn momenta(&self) -> (DVec3, DVec3) {
        let (mut momentum, mut angular) = self.lab.momenta();
        for (point, motion) in self.points.iter().zip(&self.motions) {
            momentum += motion.velocity / point.inverse_mass;
            angular += motion.position.cross(motion.velocity / point.inverse_mass);
        }
        (momentum, angular)
    }

    /// Kinetic energy and what was dissipated [J].
    fn balance(&self) -> f64 {
        let points = self.points.iter().zip(&self.motions);
        let kinetic = points.map(|(point, motion)| 0.5 * motion.velocity.length_squared() / point.inverse_mass);
        self.lab.balance() + kinetic.sum::<f64>()
    }
}

/// Corners of a square with edges of 2 m, and its two triangles.
const SQUARE: [DVec3; 4] =
    [DVec3::new(-1.0, -1.0, 0.0), DVec3::new(1.0, -1.0, 0.0), DVec3::new(1.0, 1.0, 0.0), DVec3::new(-1.0, 1.0, 0.0)];
const HALVES: [[usize; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

/// Ball of 0.1 m above a square at a place, falling at 1 m/s, with a restitution.
fn ball_above(place: [f64; 2], (friction, restitution): (f64, f64), velocity: DVec3) -> Net {
    let mut lab = Laboratory::new(3, DVec3::ZERO);
    let pose = (DVec3::new(place[0], place[1], 0.35), turned(1.0, 0.0, 0.0, 0.0));
    lab.add(&round("Ball", 0.1), (0.5, friction, restitution), pose, (velocity, DVec3::ZERO));
    Net::new(lab, &SQUARE, 0.3, &HALVES, 0.0)
}

/// A ball that falls on a face between its particles bounces once. The point that it hits has the mass 1/m = Σ w²/m. Velocity and
/// loss are those of an impact of two masses, to the rounding of a few operations.
#[test]
fn a_ball_bounces_off_a_face() {
    for (place, weights) in [([0.5, -0.25], [0.25, 0.375, 0.375]), ([0.0, 0.0], [0.5, 0.0, 0.5])] {
        let mut net = ball_above(place, (0.0, 0.5), -DVec3::Z);
        let start = net.balance();
        net.step(0.01, 50);
        let inverse = weights.iter().map(|weight| weight * weight).sum::<f64>() / 0.3;
        let impulse = 1.5 / (2.0 + inverse);
        assert!((net.lab.motions[0].velocity.z - (2.0 * impulse - 1.0)).abs() < 1e-13);
        for (motion, weight) in net.motions.iter().zip(weights) {
            assert!((motion.velocity + DVec3::Z * impulse * weight / 0.3).length() < 1e-13);
        }
        assert!((net.lab.meters.dissipated - 0.375 / (2.0 + inverse)).abs() < 1e-13);
        assert!((net.balance() - start).abs() < 1e-13);
    }
}

/// Momentum and angular momentum are kept to the rounding of 200 steps with impulses of about 1 N·s, by boxes that hit faces
/// anywhere, with friction. Arms of large groups are those at the start of a step, so that momentum alone is kept there. The energy
/// balance errs by free rotation, by splitting: up to (hω)²/12 of an energy of rotation below 0.01 J at ω = 4 rad/s. Large groups err
/// too by where a body is when it strikes: by up to a quarter of 0.01 m. This changes the loss by a small part of 0.3 J.
#[test]
fn impacts_on_faces_keep_momenta() {
    for sequential in [32, 0] {
        for place in [[0.3, -0.2], [0.02, 0.0], [-0.8, 0.85], [0.9, 0.1]] {
            let mut lab = Laboratory::new(3, DVec3::ZERO);
            lab.world.solver.sequential = sequential;
            let pose = (DVec3::new(place[0], place[1], 0.35), turned(0.9, 0.3, 0.2, 0.1));
            lab.add(&cuboid(0.2, 0.15, 0.1), (0.5, 0.4, 0.3), pose, (DVec3::new(0.5, 0.2, -1.0), DVec3::new(1.0, 2.0, 3.0)));
            let mut net = Net::new(lab, &SQUARE, 0.3, &HALVES, 0.01);
            let (momentum, angular) = net.momenta();
            let start = net.balance();
            net.step(0.01, 200);
            let (after, turning) = net.momenta();
            assert!((after - momentum).length() < 1e-13, "{sequential} {place:?} {after}");
            let is_exact = (turning - angular).length() < 1e-13;
            assert!(is_exact || sequential == 0, "{place:?} {}", turning - angular);
            assert!(net.lab.meters.dissipated > 0.0, "{sequential} {place:?}");
            let most = if sequential == 0 { 1e-4 } else { 1e-6 };
            assert!((net.balance() - start).abs() < most, "{sequential} {place:?} {} {start}", net.balance() - start);
        }
    }
}

/// No ball passes through a face, however fast it is: one that does in a single step stays above the plane of its particles.
#[test]
fn no_ball_passes_through_a_face() {
    for sequential in [32, 0] {
        for speed in [1.0, 10.0, 100.0] {
            let mut net = ball_above([0.4, -0.3], (0.0, 0.0), -speed * DVec3::Z);
            net.lab.world.solver.sequential = sequential;
            net.step(0.01, 100);
            let [a, b, c] = [0, 1, 2].map(|corner| net.motions[corner].position);
            let normal = (b - a).cross(c - a).normalize();
            assert!(normal.dot(net.lab.motions[0].position - a) > 0.1 - 1e-3, "{sequential} {speed}");
        }
    }
}

/// Gravity along a slope, and across it [m/s²].
const ALONG: f64 = 3.3;
const ACROSS: f64 = 9.2;

/// Body at a height above a net of fixed particles, which is a slope.
fn slope(item: &Item, height: f64, friction: f64) -> Net {
    let mut lab = Laboratory::new(3, DVec3::new(ALONG, 0.0, -ACROSS));
    let pose = (DVec3::new(0.2, 0.01, height), turned(1.0, 0.0, 0.0, 0.0));
    lab.add(item, (0.5, friction, 0.0), pose, (DVec3::ZERO, DVec3::ZERO));
    let mut places = Vec::new();
    for row in 0..5 {
        places.extend((0..12).map(|column| DVec3::new(0.13 * f64::from(column), 0.13 * f64::from(row) - 0.25, 0.0)));
    }
    let mut triangles = Vec::new();
    for row in 0..4 {
        for column in 0..11 {
            let a = 12 * row + column;
            triangles.extend([[a, a + 1, a + 12], [a + 1, a + 13, a + 12]]);
        }
    }
    let mut net = Net::new(lab, &places, f64::INFINITY, &triangles, 0.0);
    net.points.iter_mut().for_each(|point| point.inverse_mass = 0.0);
    net
}

/// A box slides, or sticks, and a ball rolls down a slope of faces as down a plane: no side or corner that they cross is felt. To rounding
/// in small groups. In large ones overlaps of up to 1e-6 of the size are pushed apart. A ball there meets sides and corners ahead, as
/// far as it moves in a step: they lift it by up to 1e-3 m.
#[test]
fn a_slope_of_faces_is_a_slope() {
    let h = 1e-3;
    let (brick, ball) = (cuboid(0.1, 0.08, 0.04), round("Ball", 0.03));
    for (item, height, friction, part, sequential, error) in [
        (&brick, 0.02, 0.2, 1.0, 32, 1e-12),
        (&brick, 0.02, 0.8, 1.0, 32, 1e-12),
        (&ball, 0.03, 0.8, 5.0 / 7.0, 32, 1e-12),
        (&brick, 0.02, 0.2, 1.0, 0, 1e-5),
        (&brick, 0.02, 0.8, 1.0, 0, 1e-5),
        (&ball, 0.03, 0.8, 5.0 / 7.0, 0, 2e-3),
    ] {
        let mut net = slope(item, height, friction);
        net.lab.world.solver.sequential = sequential;
        let along = if part < 1.0 { part * ALONG } else { (ALONG - friction * ACROSS).max(0.0) };
        for step in 1..=600 {
            net.step(h, 1);
            let (time, place) = (h * f64::from(step), net.lab.motions[0].position);
            let off = (place - DVec3::new(0.2 + 0.5 * along * time * time, 0.01, height)).length();
            assert!(off < error, "{sequential} {friction} {time} {off}");
        }
    }
}

/// Masses that are a power of two as large change no bit.
#[test]
fn masses_have_no_scale() {
    let of = |scale: f64, friction: f64, place: [f64; 2]| {
        let mut lab = Laboratory::new(3, DVec3::ZERO);
        let pose = (DVec3::new(place[0], place[1], 0.35), turned(1.0, 0.0, 0.0, 0.0));
        lab.add(&round("Ball", 0.1), (0.6 * scale, friction, 0.0), pose, (DVec3::new(-0.5, 0.2, -1.0), DVec3::ZERO));
        let mut net = Net::new(lab, &SQUARE, 0.3 * scale, &HALVES, 0.0);
        let mut states = Vec::new();
        for _ in 0..60 {
            net.step(0.01, 1);
            let motions = net.lab.motions.iter().chain(&net.motions);
            states.push(motions.map(|motion| (motion.position, motion.velocity)).collect::<Vec<_>>());
        }
        states
    };
    for friction in [0.0, 0.4] {
        for place in [[0.3, -0.2], [0.0, 0.0], [-0.8, 0.85]] {
            let [one, other] = [of(1.0, friction, place), of(0.25, friction, place)];
            assert!(one == other, "{friction} {place:?}");
        }
    }
}
