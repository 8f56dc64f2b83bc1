//! Gaps of two cuboids along the cross products of their edges (Gottschalk, Lin and Manocha, "`OBBTree`", SIGGRAPH 1996).

use glam::DVec3;

use super::edges::PARALLEL;
use crate::shapes::side_of;

/// Difference of gaps that may be rounding, over the size of the cuboids.
const ROUNDING: f64 = 1e-12;

/// Edges of two cuboids, each by the indices of its vertices, along whose normal they are farthest apart. None if the gap is
/// surely at most `least` [m]. The cuboids are given by the way between their centers and by their half edges.
pub(super) fn widest(apart: DVec3, halves: [[DVec3; 3]; 2], least: f64) -> Option<[[usize; 2]; 2]> {
    let lengths = halves.map(|half| half.map(DVec3::length));
    let [one, other] = [0, 1].map(|body| [0, 1, 2].map(|axis| halves[body][axis] / lengths[body][axis]));
    let along = one.map(|axis| axis.dot(apart));
    let cosines = one.map(|axis| other.map(|across| axis.dot(across)));
    let mut widest = least - ROUNDING * lengths.iter().flatten().sum::<f64>();
    let mut found = None;
    for i in 0..3 {
        let [i1, i2] = [(i + 1) % 3, (i + 2) % 3];
        for j in 0..3 {
            let [j1, j2] = [(j + 1) % 3, (j + 2) % 3];
            // Components of the cross product along the other two axes of the first cuboid.
            let [a, b] = [-cosines[i2][j], cosines[i1][j]];
            let first = lengths[0][i1] * a.abs() + lengths[0][i2] * b.abs();
            let second = lengths[1][j1] * cosines[i][j2].abs() + lengths[1][j2] * cosines[i][j1].abs();
            let (way, square) = (a * along[i1] + b * along[i2], a * a + b * b);
            let gap = (way.abs() - first - second) / square.sqrt();
            if gap > widest && square > PARALLEL * PARALLEL {
                widest = gap;
                found = Some(([i, j], (one[i1] * a + one[i2] * b) * way));
            }
        }
    }
    let (axes, outward) = found?;
    Some([0, 1].map(|body| {
        let (bit, toward) = (1 << axes[body], if body == 0 { outward } else { -outward });
        let start = side_of(halves[body].map(|edge| edge.dot(toward))) & !bit;
        [start, start | bit]
    }))
}
