//! Contacts and distances of convex shapes beside parry: nanoseconds for each pair on one thread, the largest difference of the
//! distances, and whether both have the same bits in another order of the pairs. Run
//! `cargo run --release --manifest-path benches/rivals/parry/Cargo.toml`.
//!
//! Pairs are almost in touch, as those of a heap. "moving" pairs turn a little between two visits, as from step to step, and parry keeps
//! their manifolds. A word selects the shapes that have it in their names.

use std::f64::consts::TAU;
use std::hint::black_box;
use std::time::Instant;

use glam::{DMat3, DQuat, DVec3};
use physcore_base::scene::{Array, Item, Value};
use physcore_rigid::collision;
use physcore_rigid::pose::Pose;
use physcore_rigid::shapes::SolidShape;

/// Number of pairs.
const PAIRS: usize = 2000;
/// Number of visits to all pairs; the fastest counts.
const VISITS: usize = 20;
/// Largest gap of a contact [m].
const REACH: f64 = 0.02;
/// Largest angle by which a body turns between two visits [rad].
const TURN: f64 = 1e-3;

/// Random numbers between −1 and 1, by a linear congruence.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    fn rotation(&mut self, dimension: usize) -> DQuat {
        if dimension == 2 {
            return DQuat::from_rotation_z(0.5 * TAU * self.next());
        }
        loop {
            let four = [self.next(), self.next(), self.next(), self.next()];
            let quaternion = DQuat::from_array(four);
            if (0.1..1.0).contains(&quaternion.length()) {
                return quaternion.normalize();
            }
        }
    }
}

/// Position and rotation of the second body of a pair relative to the first one.
type Placement = (DVec3, DQuat);

/// Convex shape as declared.
fn shape(kind: &str, values: Vec<(&'static str, Value)>, dimension: usize) -> SolidShape {
    let item = Item { path: "shape".to_owned(), ..Item::new(kind, values) };
    SolidShape::declared(&item, dimension).expect("the shape is sound").0
}

fn points(name: &'static str, points: &[DVec3], dimension: usize) -> Vec<(&'static str, Value)> {
    let entries = points.iter().flat_map(|point| point.to_array()[..dimension].to_vec()).collect();
    vec![(name, Value::Numbers(Array { shape: vec![points.len(), dimension], entries }))]
}

fn lengths<const N: usize>(values: [(&'static str, f64); N]) -> Vec<(&'static str, Value)> {
    values.map(|(name, value)| (name, Value::Number(value))).to_vec()
}

fn pose((position, rotation): Placement) -> Pose {
    Pose { position, rotation: DMat3::from_quat(rotation) }
}

/// Placements of the second body with gaps between −0.01 and 0.02 m.
fn placements(shape: &SolidShape, dimension: usize) -> Vec<Placement> {
    let mut random = Random(1);
    let place = |_| {
        let rotation = random.rotation(dimension);
        let way = random.rotation(dimension) * DVec3::X;
        let target = 0.005 + 0.015 * random.next();
        let mut far = 3.0 * shape.reach();
        for _ in 0..100 {
            let pose = pose((far * way, rotation));
            let (gap, normal) = collision::separation((shape, &Pose::WORLD), (shape, &pose), dimension);
            far -= (gap - target) / normal.dot(way).max(0.3);
        }
        (far * way, rotation)
    };
    (0..PAIRS).map(place).collect()
}

/// Placements before each visit.
fn moving(placements: &[Placement], visit: usize) -> Vec<Placement> {
    let turn = DQuat::from_rotation_z(TURN * visit as f64);
    placements.iter().map(|&(position, rotation)| (position, turn * rotation)).collect()
}

/// Nanoseconds for each pair of the fastest visit.
fn time(placements: &[Placement], moves: bool, mut visit: impl FnMut(&[Placement]) -> usize) -> f64 {
    let once = |number: usize| {
        let places = moving(placements, if moves { number } else { 0 });
        let start = Instant::now();
        black_box(visit(&places));
        start.elapsed().as_secs_f64()
    };
    1e9 * (0..VISITS).map(once).fold(f64::INFINITY, f64::min) / placements.len() as f64
}

/// Parry in one dimension: its crate, and how it takes placements.
macro_rules! rival {
    ($module:ident, $parry:ident, $place:expr) => {
        mod $module {
            use $parry::math::Pose;
            use $parry::query::{self, ContactManifold, DefaultQueryDispatcher, PersistentQueryDispatcher};
            use $parry::shape::Shape;

            use super::{Placement, REACH};

            type Kept = (Vec<ContactManifold<(), ()>>, Option<query::ContactManifoldsWorkspace>);

            fn placed(placement: Placement) -> Pose {
                let place: fn(Placement) -> Pose = $place;
                place(placement)
            }

            pub fn distances(shape: &dyn Shape, placements: &[Placement]) -> Vec<f64> {
                let of = |&placement: &Placement| {
                    let distance = query::distance(&Pose::IDENTITY, shape, &placed(placement), shape).expect("shapes are known");
                    distance.distance
                };
                placements.iter().map(of).collect()
            }

            /// Number of contacts of all pairs, whose manifolds are kept or begin anew.
            pub fn contacts(shape: &dyn Shape, placements: &[Placement], kept: &mut Vec<Kept>, anew: bool) -> usize {
                kept.resize_with(placements.len(), Kept::default);
                let of = |(&placement, (manifolds, workspace)): (&Placement, &mut Kept)| {
                    if anew {
                        manifolds.clear();
                        *workspace = None;
                    }
                    let dispatcher = DefaultQueryDispatcher;
                    let found = dispatcher.contact_manifolds(&placed(placement), shape, shape, REACH, manifolds, workspace);
                    found.expect("shapes are known");
                    manifolds.iter().map(|manifold| manifold.points.len()).sum::<usize>()
                };
                placements.iter().zip(kept).map(of).sum()
            }
        }
    };
}

rival!(plane, parry2d_f64, |(position, rotation)| {
    Pose::new(parry2d_f64::math::Vector::new(position.x, position.y), 2.0 * rotation.z.atan2(rotation.w))
});
rival!(space, parry3d_f64, |(position, rotation)| {
    let rotation = parry3d_f64::math::Rotation::from_array(rotation.to_array());
    Pose::from_parts(parry3d_f64::math::Vector::from_array(position.to_array()), rotation)
});

/// Number of contacts of all pairs, as the package finds them.
fn contacts(shape: &SolidShape, placements: &[Placement], dimension: usize) -> usize {
    let mut found = Vec::new();
    let of = |&placement: &Placement| {
        found.clear();
        collision::contacts((shape, &Pose::WORLD), (shape, &pose(placement)), REACH, dimension, &mut found);
        found.len()
    };
    placements.iter().map(of).sum()
}

fn distances(shape: &SolidShape, placements: &[Placement], dimension: usize) -> Vec<f64> {
    let of = |&placement: &Placement| collision::separation((shape, &Pose::WORLD), (shape, &pose(placement)), dimension).0;
    placements.iter().map(of).collect()
}

/// Whether results have the same bits in reverse order.
fn repeats(placements: &[Placement], distances: impl Fn(&[Placement]) -> Vec<f64>) -> bool {
    let backwards: Vec<Placement> = placements.iter().rev().copied().collect();
    distances(placements).iter().eq(distances(&backwards).iter().rev())
}

/// Prints the row of a shape: nanoseconds for each pair, and how far the distances agree.
macro_rules! row {
    ($module:ident, $name:literal, $dimension:literal, $ours:expr, $theirs:expr) => {
        if std::env::args().skip(1).all(|word| $name.contains(&word)) {
            let (ours, theirs) = ($ours, $theirs);
            let placements = placements(&ours, $dimension);
            let (mut kept, mut anew) = (Vec::new(), Vec::new());
            let times = [
                time(&placements, false, |places| contacts(&ours, places, $dimension)),
                time(&placements, false, |places| $module::contacts(&theirs, places, &mut anew, true)),
                time(&placements, true, |places| contacts(&ours, places, $dimension)),
                time(&placements, true, |places| $module::contacts(&theirs, places, &mut kept, false)),
                time(&placements, false, |places| distances(&ours, places, $dimension).len()),
                time(&placements, false, |places| $module::distances(&theirs, places).len()),
            ];
            let apart = distances(&ours, &placements, $dimension).into_iter().zip($module::distances(&theirs, &placements));
            let error = apart.filter(|(gap, _)| *gap > 0.0).map(|(gap, other)| (gap - other).abs()).fold(0.0, f64::max);
            let same = repeats(&placements, |places| distances(&ours, places, $dimension));
            let others = repeats(&placements, |places| $module::distances(&theirs, places));
            let [one, two, three, four, five, six] = times.map(|time| format!("{time:.0}"));
            println!("| {} | {one} | {two} | {three} | {four} | {five} | {six} | {error:.0e} | {same} | {others} |", $name);
        }
    };
}

fn main() {
    println!(
        "| shape | contacts [ns] | parry | moving [ns] | parry | distance [ns] | parry | difference [m] | same bits | parry |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    let ring = |sides: usize| (0..sides).map(move |side| TAU * side as f64 / sides as f64);
    let octagon: Vec<DVec3> = ring(8).map(|angle| 0.2 * DVec3::new(angle.cos(), angle.sin(), 0.0)).collect();
    let flat = octagon.iter().map(|point| parry2d_f64::math::Vector::new(point.x, point.y)).collect();
    let mut random = Random(2);
    let ball: Vec<DVec3> = (0..20).map(|_| 0.2 * (random.rotation(3) * DVec3::X)).collect();
    let hull = shape("Hull", points("points", &ball, 3), 3);
    // Both place the hull about its center of mass.
    let center = SolidShape::declared(&Item::new("Hull", points("points", &ball, 3)), 3).expect("the shape is sound").1.center;
    let round: Vec<_> = ball.iter().map(|&point| parry3d_f64::math::Vector::from_array((point - center).to_array())).collect();
    row!(
        plane,
        "rectangle",
        2,
        shape("Rectangle", lengths([("width", 0.4), ("height", 0.2)]), 2),
        parry2d_f64::shape::Cuboid::new(parry2d_f64::math::Vector::new(0.2, 0.1))
    );
    row!(
        plane,
        "octagon",
        2,
        shape("Polygon", points("vertices", &octagon, 2), 2),
        parry2d_f64::shape::ConvexPolygon::from_convex_polyline(flat).expect("an octagon is convex")
    );
    row!(
        plane,
        "capsule in 2D",
        2,
        shape("Capsule", lengths([("length", 0.4), ("radius", 0.1)]), 2),
        parry2d_f64::shape::Capsule::new_x(0.2, 0.1)
    );
    row!(
        space,
        "cuboid",
        3,
        shape("Cuboid", lengths([("a", 0.4), ("b", 0.3), ("c", 0.2)]), 3),
        parry3d_f64::shape::Cuboid::new(parry3d_f64::math::Vector::new(0.2, 0.15, 0.1))
    );
    row!(
        space,
        "capsule in 3D",
        3,
        shape("Capsule", lengths([("length", 0.4), ("radius", 0.1)]), 3),
        parry3d_f64::shape::Capsule::new_z(0.2, 0.1)
    );
    row!(
        space,
        "hull of 20 points",
        3,
        hull,
        parry3d_f64::shape::ConvexPolyhedron::from_convex_hull(&round).expect("the points have a hull")
    );
}
