//! Contacts side by side.

use glam::{DMat3, DVec2, DVec3};

use crate::rows::{BodyVelocities, BodyVelocity, Bundles, ContactRow, InPlane, InSpace, RowSpace};
use crate::surface::Friction;

/// Numbers from −1 to 1 that look random.
fn numbers() -> impl FnMut() -> f64 {
    let mut state = 1_u64;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// Bodies of which every seventh is fixed, and the last does not move, with a contact of each with some of the next ones. The lever
/// arms of rolling and torsional friction are up to `lever` [m].
fn group<S: RowSpace>(count: usize, lever: f64) -> (BodyVelocities<S>, Vec<ContactRow<S>>) {
    let mut random = numbers();
    let mut vector = || DVec3::new(random(), random(), random());
    let mut v = BodyVelocities::<S>::default();
    for body in 0..count {
        let inverse_mass = if body % 7 == 3 || body + 1 == count { 0.0 } else { 1.0 + (body % 3) as f64 };
        let inertia = DMat3::from_diagonal(DVec3::new(3.0, 2.0, 1.0) * inverse_mass);
        let [linear, angular] = [vector(), vector()].map(|motion| if inverse_mass > 0.0 { motion } else { DVec3::ZERO });
        let (linear, angular) = (S::vector(linear), S::turn(angular));
        v.bodies.push(BodyVelocity { linear, angular, inverse_mass, inverse_inertia: S::inverse(&inertia) });
    }
    let mut rows = Vec::new();
    for one in 0..count - 1 {
        for other in [one + 1, one + 2, one + 5].into_iter().filter(|other| *other < count - 1) {
            let normal = S::widen(S::vector(vector())).normalize();
            let friction =
                Friction { sliding: 0.3 * (one % 2) as f64, rolling: 0.5 * lever * (one % 3) as f64, torsional: lever };
            let arms = [vector(), vector()];
            rows.extend(ContactRow::new([one, other], arms, normal, friction, &v));
        }
    }
    (v, rows)
}

/// Velocities after iterations in alternating order, side by side and row by row.
fn both<S: RowSpace>(lever: f64) -> [BodyVelocities<S>; 2] {
    let (mut v, mut rows) = group::<S>(60, lever);
    let mut single = v.clone();
    let mut bundles = Bundles::default();
    bundles.clear(v.bodies.len());
    for row in &rows {
        bundles.add(row, &v);
    }
    bundles.equip(&v);
    for iteration in 0..6 {
        let is_reversed = iteration % 2 == 1;
        bundles.relax(&mut v, is_reversed);
        for place in 0..rows.len() {
            let index = if is_reversed { rows.len() - 1 - place } else { place };
            rows[index].relax(&mut single);
        }
    }
    [v, single]
}

/// In the plane the operations are the same, but for moments.
#[test]
fn rows_side_by_side_have_the_bits_of_single_ones_in_the_plane() {
    let [v, single] = both::<InPlane>(0.0);
    let (start, _) = group::<InPlane>(60, 0.0);
    let motions =
        |v: &BodyVelocities<InPlane>| -> Vec<(DVec2, f64)> { v.bodies.iter().map(|body| (body.linear, body.angular)).collect() };
    assert_eq!(motions(&v), motions(&single));
    assert_ne!(motions(&v), motions(&start));
}

/// In space bounds on friction round differently, by an ulp or two in each of 6 · 165 solutions of velocities of order 1.
#[test]
fn rows_side_by_side_agree_with_single_ones_in_space() {
    let [v, single] = both::<InSpace>(0.02);
    for (body, other) in v.bodies.iter().zip(&single.bodies) {
        assert!(body.linear.abs_diff_eq(other.linear, 1e-12) && body.angular.abs_diff_eq(other.angular, 1e-12));
    }
}
