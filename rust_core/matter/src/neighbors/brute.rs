//! Reference implementation of the neighbor search: all pairs.

use super::Domain;
use crate::math::AXES;

/// Finds all neighbors of each of `count` particles within `support` [m], as sorted particle indices.
pub fn brute(count: usize, dimension: usize, domain: &Domain, support: f64, positions: [&[f64]; AXES]) -> Vec<Vec<u32>> {
    let lengths = domain.lengths();
    let is_near = &move |one: usize, other: usize| {
        let mut square = 0.0;
        for axis in 0..dimension {
            let mut separation = positions[axis][one] - positions[axis][other];
            if let Some(length) = lengths[axis] {
                separation -= length * (separation * (1.0 / length)).round_ties_even();
            }
            square += separation * separation;
        }
        square <= support * support
    };
    let list = |one: usize| (0..count).filter(move |&other| other != one && is_near(one, other)).map(|other| other as u32);
    (0..count).map(|one| list(one).collect()).collect()
}
