//! Conservative advancement: the time at which two elements come near each other, never too late.
//!
//! Along straight paths the distance of two elements falls by at most the length l of their largest relative displacement.
//! Steps of 0.9 (d − ξ)/l therefore never pass a distance ξ. Source: M. Li, D. M. Kaufman, C. Jiang, ACM Trans. Graph. 40,
//! 170 (2021), "Additive CCD".

use glam::DVec3;

use super::distance::Closest;

/// Part of the remaining distance that a step takes, and part of the initial distance at which elements meet.
const PART: f64 = 0.9;
const NEAR: f64 = 0.1;
/// Maximum number of steps. Elements that would take more meet at their last positions.
const MOST: u32 = 200;

/// Length l [m] of the largest relative displacement of two elements, and all displacements without their mean. The first
/// element has `split` of the vertices.
#[inline(always)]
pub fn relative(displacements: &[DVec3; 4], split: usize) -> (f64, [DVec3; 4]) {
    let mean = 0.25 * (displacements[0] + displacements[1] + displacements[2] + displacements[3]);
    let own = displacements.map(|displacement| displacement - mean);
    let squares = own.map(DVec3::length_squared);
    let largest = |squares: &[f64]| squares.iter().copied().fold(0.0, f64::max).sqrt();
    (largest(&squares[..split]) + largest(&squares[split..]), own)
}

/// Closest points when two elements come within `least` [m] of each other; None if they do not. The paths start at the
/// positions `x` and have these displacements. The distance at the start is above `least`.
pub fn meeting(
    measure: impl Fn(&[DVec3; 4]) -> Closest,
    mut x: [DVec3; 4],
    (length, displacements): (f64, [DVec3; 4]),
    least: f64,
) -> Option<Closest> {
    let mut now = measure(&x);
    let mut gap = now.separation.length() - least;
    let end = NEAR * gap;
    let mut time = 0.0;
    for _ in 0..MOST {
        let step = PART * gap / length;
        time += step;
        if time >= 1.0 {
            return None;
        }
        x.iter_mut().zip(&displacements).for_each(|(x, &displacement)| *x += step * displacement);
        now = measure(&x);
        gap = now.separation.length() - least;
        if gap <= end {
            break;
        }
    }
    Some(now)
}
