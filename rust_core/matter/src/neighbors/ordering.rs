//! Ordering of particles for locality: neighbors in space are near each other in memory.

use glam::DVec3;

/// Mean number of particles per cell.
const CROWD: f64 = 8.0;

/// Particle of each memory index: row by row through cells of a few particles each, x fastest. The sort is stable.
pub fn ordering(positions: &[DVec3], dimension: usize) -> Vec<u32> {
    let low = positions.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = positions.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    let extent = (high - low).to_array();
    // A flat distribution has no cells across.
    let wide = extent[..dimension].iter().filter(|&&length| length > 0.0);
    let (space, axes) = wide.fold((1.0, 0), |(space, axes), length| (space * length, axes + 1));
    let cell = libm::pow(space * CROWD / positions.len() as f64, 1.0 / f64::from(axes.max(1)));
    let key = |index: u32| {
        let [x, y, z] = ((positions[index as usize] - low) / cell).to_array().map(|cell| cell as u64);
        [z, y, x]
    };
    let mut order: Vec<u32> = (0..positions.len() as u32).collect();
    order.sort_by_cached_key(|&index| key(index));
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbors_in_space_are_neighbors_in_memory() {
        // A shuffled lattice of 32³. In rows of cells of two, neighbors along x are about 8 slots apart.
        let count = 32 * 32 * 32;
        let point = |index: usize| DVec3::new((index % 32) as f64, (index / 32 % 32) as f64, (index / 1024) as f64);
        let positions: Vec<DVec3> = (0..count).map(|index| point(index * 12_345 % count)).collect();
        let order = ordering(&positions, 3);
        let far =
            order.windows(2).filter(|pair| (positions[pair[0] as usize] - positions[pair[1] as usize]).abs().max_element() > 3.0);
        assert!(far.count() < count / 50);
        let mut sorted = order;
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq(0..count as u32));
    }

    #[test]
    fn coincident_and_few_particles_keep_their_order() {
        assert_eq!(ordering(&[DVec3::ONE; 3], 3), [0, 1, 2]);
        assert!(ordering(&[], 2).is_empty());
    }
}
