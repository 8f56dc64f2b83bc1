//! The broad phase against all pairs.

use glam::DVec3;
use physcore_rigid::broad::pairs;
use physcore_rigid::shapes::BoundingBox;
use proptest::prelude::*;

use crate::samples::point;

/// Boxes of sizes over four orders of magnitude, some flat, some infinite, some that touch others.
fn boxes(dimension: usize) -> impl Strategy<Value = Vec<BoundingBox>> {
    let one = (point(dimension), point(dimension), -4.0..0.0_f64, 0..20_u8).prop_map(move |(center, size, scale, kind)| {
        let half = size.abs() * 10_f64.powf(scale);
        let grid = (center * 4.0).round() / 4.0;
        match kind {
            0 => BoundingBox::EVERYWHERE,
            1 => BoundingBox { lower: DVec3::NEG_INFINITY, upper: DVec3::INFINITY.with_y(center.y) },
            2..6 => BoundingBox { lower: grid, upper: grid + 0.25 },
            _ => BoundingBox { lower: center - half, upper: center + half },
        }
    });
    prop::collection::vec(one, 0..60)
}

proptest! {
    #[test]
    fn all_pairs_are_found_once(
        bounds in (2..=3_usize).prop_flat_map(boxes),
        moves in prop::collection::vec(any::<bool>(), 60),
    ) {
        let moves = &moves[..bounds.len()];
        let mut expected = Vec::new();
        for j in 0..bounds.len() {
            expected.extend((0..j).filter(|&i| (moves[i] || moves[j]) && bounds[i].overlaps(&bounds[j])).map(|i| [i as u32, j as u32]));
        }
        expected.sort_unstable();
        let mut found = vec![[7, 8]];
        pairs(&bounds, moves, &mut found);
        prop_assert_eq!(found, expected);
    }
}
