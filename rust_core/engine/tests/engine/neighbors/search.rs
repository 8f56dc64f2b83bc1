//! The search finds the neighbors that the comparison of all pairs finds, for any configuration.

use physcore_engine::math::AXES;
use physcore_engine::neighbors::{Domain, brute};
use proptest::prelude::*;

use super::laboratory::{Points, by_particle, cloud, search, view};

/// Coordinate in units of the support, in a domain with a spread of one.
fn coordinate() -> impl Strategy<Value = (f64, f64)> {
    let face = |number: i32, nudge: i32, size: f64| {
        let face = f64::from(number) * size;
        match nudge {
            ..0 => face.next_down(),
            0 => face,
            1.. => face.next_up(),
        }
    };
    prop_oneof![
        // (part of the spread, number of supports)
        8 => (-0.5..0.5).prop_map(|part| (part, 0.0)),
        2 => (-4..4_i32, -1..=1_i32).prop_map(move |(number, nudge)| (0.0, face(number, nudge, 1.0))),
        2 => (-16..16_i32, -1..=1_i32).prop_map(move |(number, nudge)| (0.0, face(number, nudge, 0.25 * (1.0 + 1e-6)))),
        // Slightly below a face. With cells smaller than the support by 1e-6, a particle one support further would be two
        // cells further.
        1 => (-4..4_i32, 0..4_i32).prop_map(|(number, nudge)| (0.0, f64::from(number) - (f64::from(nudge) + 0.5) * 1e-6)),
        1 => Just((0.0, 0.0)),
    ]
}

#[derive(Debug, Clone)]
struct Configuration {
    points: Points,
    dimension: usize,
    domain: Domain,
    cutoff: f64,
    skin: f64,
}

/// Combination of everything: any scale, any position, any periods, particles outside of them, and particles without a
/// position.
fn configuration() -> impl Strategy<Value = Configuration> {
    let particles =
        prop::collection::vec((prop::array::uniform3(coordinate()), prop::array::uniform3(-3..3_i32), 0..200_u32), 0..60);
    let spread = prop::array::uniform3(prop::sample::select(vec![0.0, 0.1, 1.0, 3.0, 8.0, 100.0, 1e4, 1e8]));
    let offset = prop::array::uniform3(prop::sample::select(vec![0.0, 0.0, -1.0, 1e3, -1e6, 2e8]));
    let period =
        prop::array::uniform3(prop::option::of(prop::sample::select(vec![2.0, 2.0 + 1e-9, 2.3, 2.5, 3.0, 5.0, 40.0, 1e5])));
    let lengths = (prop::sample::select(vec![1e-9, 0.3, 1.0, 1e12]), prop::sample::select(vec![0.0, 0.1, 1.0]));
    (particles, 2..=3_usize, spread, offset, period, lengths).prop_map(
        |(particles, dimension, spread, offset, period, (cutoff, relative_skin))| {
            let skin = cutoff * relative_skin;
            let support = cutoff + skin;
            let domain = Domain {
                period: std::array::from_fn(|axis| {
                    let lower: f64 = offset[axis] * cutoff;
                    period[axis].map(|length| (lower, f64::next_up(lower + length * support * (1.0 + 1e-7))))
                }),
            };
            let points = std::array::from_fn(|axis| {
                let slot = |(point, turns, fate): &([(f64, f64); AXES], [i32; AXES], u32)| {
                    let (part, supports) = point[axis];
                    let unwrapped = domain.lengths()[axis].map_or(0.0, |length| length * f64::from(turns[axis]));
                    match (fate, fate % 3 == axis as u32) {
                        (0..3, true) => f64::NAN,
                        (3..6, true) => f64::INFINITY,
                        (6..9, true) => f64::NEG_INFINITY,
                        _ => {
                            offset[axis] * cutoff
                                + (part * spread[axis] + supports) * support
                                + unwrapped.clamp(-1e8 * cutoff, 1e8 * cutoff)
                        }
                    }
                };
                particles.iter().map(slot).collect()
            });
            Configuration { points, dimension, domain, cutoff, skin }
        },
    )
}

proptest! {
    #[test]
    fn the_neighbors_are_those_of_all_pairs(Configuration { points, dimension, domain, cutoff, skin } in configuration()) {
        let neighbors = search(&points, dimension, &domain, cutoff, skin).unwrap();
        let expected = brute(points[0].len(), dimension, &domain, cutoff + skin, view(&points));
        prop_assert_eq!(by_particle(&neighbors), expected);
    }
}

#[test]
fn many_particles_have_the_neighbors_of_all_pairs() {
    // Dense, dilute, and so dilute that the table of buckets wraps around; two or three blocks of slots.
    for (count, side) in [(1500, 6.0), (2500, 25.0), (2500, 3000.0)] {
        for dimension in [2, 3] {
            for periodic in 0..8_u32 {
                let period = std::array::from_fn(|axis| (periodic & (1 << axis) != 0).then_some((0.0, side)));
                let points = cloud(count, [side; AXES], u64::from(periodic));
                let domain = Domain { period };
                let neighbors = search(&points, dimension, &domain, 1.0, 0.1).unwrap();
                let expected = brute(count, dimension, &domain, 1.1, view(&points));
                assert!(by_particle(&neighbors) == expected, "{count} particles, {side} supports, {dimension}D, {periodic:b}");
            }
        }
    }
}
