//! Scratch measurements.
use glam::DVec3;

use super::laboratory::{Laboratory, cuboid, rectangle, round, turned};
use crate::rotation::Orientation;

const G: f64 = 9.81;
const DOWN: DVec3 = DVec3::new(0.0, -G, 0.0);
const REST: (DVec3, DVec3) = (DVec3::ZERO, DVec3::ZERO);

fn random(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 11) as f64 / (1_u64 << 53) as f64
}

fn run(name: &str, lab: &mut Laboratory, h: f64, seconds: f64) {
    let before = lab.balance();
    let start = std::time::Instant::now();
    let (mut last, mut jumps, mut slowest, mut sum) = (before, Vec::new(), 0.0_f64, 0.0);
    let steps = (seconds / h) as usize;
    for step in 0..steps {
        let at = std::time::Instant::now();
        lab.step(h, 1);
        slowest = slowest.max(at.elapsed().as_secs_f64());
        let now = lab.balance();
        jumps.push(((now - last).abs(), (now - last), step));
        sum += (now - last).abs();
        last = now;
    }
    jumps.sort_by(|a, b| b.0.total_cmp(&a.0));
    let top: Vec<String> = jumps.iter().take(4).map(|j| format!("{}:{:+.1e}", j.2, j.1 / before.abs())).collect();
    println!(
        "{name} 1/h {:.0} drift {:+.2e} sum|jump| {:.2e} lost {:.4} overlap {:.1e} top [{}] {:.2} ms/step slowest {:.1} retaken {} waits {}",
        1.0 / h,
        (last - before) / before.abs(),
        sum / before.abs(),
        lab.meters.dissipated / before.abs(),
        lab.overlap(),
        top.join(" "),
        start.elapsed().as_secs_f64() * 1e3 / steps as f64,
        slowest * 1e3,
        lab.world.state.retaken,
        lab.world.state.waits
    );
}

fn pile(n: usize, polygons: bool, e: f64, mu: f64) -> Laboratory {
    let mut lab = Laboratory::new(2, DOWN);
    lab.add_plane(DVec3::Y, mu, e);
    lab.add_wall(DVec3::X, DVec3::new(-0.6, 0.0, 0.0), mu, e);
    lab.add_wall(-DVec3::X, DVec3::new(0.6, 0.0, 0.0), mu, e);
    let mut seed = 1;
    for k in 0..n {
        let x = random(&mut seed) - 0.5;
        let place = (DVec3::new(0.8 * x, 0.3 + 0.35 * k as f64, 0.0), Orientation::planar(6.0 * random(&mut seed)));
        if polygons {
            lab.add(&rectangle(0.25, 0.15), (1.0, mu, e), place, REST);
        } else {
            lab.add(&round("Disc", 0.1), (1.0, mu, e), place, REST);
        }
    }
    lab
}

fn galton(n: usize, e: f64) -> Laboratory {
    let mut lab = Laboratory::new(2, DOWN);
    lab.add_plane(DVec3::Y, 0.0, 0.0);
    lab.add_wall(DVec3::X, DVec3::new(-0.4, 0.0, 0.0), 0.0, e);
    lab.add_wall(-DVec3::X, DVec3::new(0.4, 0.0, 0.0), 0.0, e);
    let mut seed = 1;
    for row in 0..8 {
        for k in 0..8 {
            let x = 0.1 * (k as f64 - 3.5 + 0.5 * (row % 2) as f64);
            let (shape, _) = crate::shapes::SolidShape::declared(&round("Disc", 0.015), 2).unwrap();
            lab.world.shapes.push(shape);
            let surface = crate::surface::Surface { shape: lab.world.shapes.len() - 1, friction: Some(Default::default()), restitution: 0.0 };
            let pose = crate::pose::Pose { position: DVec3::new(x, 0.3 + 0.09 * row as f64, 0.0), ..crate::pose::Pose::WORLD };
            lab.world.walls.push(crate::world::FixedSolid { surface, mover: crate::mover::Mover::wall(&pose) });
            lab.world.wall_names.push("peg".to_owned());
        }
    }
    for k in 0..n {
        let x = 0.02 * (random(&mut seed) - 0.5);
        lab.add(&round("Disc", 0.016), (1.0, 0.0, e), (DVec3::new(x, 1.2 + 0.1 * k as f64, 0.0), Orientation::planar(0.0)), REST);
    }
    lab
}

fn heap(n: usize, e: f64) -> Laboratory {
    let mut lab = Laboratory::new(3, DVec3::new(0.0, 0.0, -G));
    lab.add_plane(DVec3::Z, 0.5, e);
    let mut seed = 1;
    for k in 0..n {
        let place = DVec3::new(0.3 * random(&mut seed), 0.3 * random(&mut seed), 0.3 + 0.4 * k as f64);
        let turn = turned(random(&mut seed), random(&mut seed), random(&mut seed), random(&mut seed));
        lab.add(&cuboid(0.3, 0.2, 0.1), (6.0, 0.5, e), (place, turn), REST);
    }
    lab
}

#[test]
#[ignore = "a measurement"]
fn scratch_planar() {
    for inverse in [120.0, 240.0, 480.0] {
        run("discs 12", &mut pile(12, false, 0.3, 0.4), 1.0 / inverse, 4.0);
        run("rects 12", &mut pile(12, true, 0.3, 0.4), 1.0 / inverse, 4.0);
        run("rects 12 e0", &mut pile(12, true, 0.0, 0.4), 1.0 / inverse, 4.0);
        run("rects 12 e0 mu0", &mut pile(12, true, 0.0, 0.0), 1.0 / inverse, 4.0);
        run("rects 3", &mut pile(3, true, 0.3, 0.4), 1.0 / inverse, 4.0);
    }
}

#[test]
#[ignore = "a measurement"]
fn scratch_crowded() {
    run("galton 1", &mut galton(1, 0.5), 1.0 / 240.0, 3.0);
    run("galton 1", &mut galton(1, 0.5), 1.0 / 480.0, 3.0);
    run("galton 20", &mut galton(20, 0.5), 1.0 / 240.0, 4.0);
    run("galton 20", &mut galton(20, 0.5), 1.0 / 480.0, 4.0);
    run("discs 30", &mut pile(30, false, 0.3, 0.4), 1.0 / 240.0, 4.0);
    run("rects 24", &mut pile(24, true, 0.3, 0.4), 1.0 / 240.0, 4.0);
}

#[test]
#[ignore = "a measurement"]
fn scratch_heaps() {
    for n in [1, 4, 8, 12, 20, 27] {
        for inverse in [60.0, 240.0] {
            run(&format!("cuboids {n}"), &mut heap(n, 0.0), 1.0 / inverse, 4.0);
        }
    }
}
