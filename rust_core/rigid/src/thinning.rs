//! Fewer contacts where a body lies on many parts of another.

use glam::DVec3;

use crate::contact::ContactPoint;
use crate::pose::Pose;
use crate::spatial;

/// Number of contacts that are never too many.
const FEW: usize = 4;
/// Cosine of the angle of normals that count as one.
const ALIKE: f64 = 0.999;

/// Keeps, of the contacts from `start` on whose normals are alike, those that are well spread: two in 2D, four in 3D.
pub(crate) fn thin(points: &mut Vec<ContactPoint>, start: usize, poses: [&Pose; 2], dimension: usize) {
    if points.len() - start <= FEW {
        return;
    }
    let touches: Vec<_> = points[start..].iter().map(|point| point.at(poses, DVec3::ZERO)).collect();
    let mut is_kept = vec![false; touches.len()];
    let mut is_free = vec![true; touches.len()];
    for first in 0..touches.len() {
        if !is_free[first] {
            continue;
        }
        let normal = touches[first].normal;
        let is_alike = |index: &usize| is_free[*index] && (*index == first || touches[*index].normal.dot(normal) > ALIKE);
        let group: Vec<usize> = (first..touches.len()).filter(is_alike).collect();
        group.iter().for_each(|&index| is_free[index] = false);
        let places: Vec<(DVec3, f64)> = group.iter().map(|&index| (touches[index].point, touches[index].gap)).collect();
        for place in spatial::spread(&places, normal, dimension) {
            is_kept[group[place]] = true;
        }
    }
    let mut kept = is_kept.iter();
    let mut index = 0;
    points.retain(|_| {
        index += 1;
        index <= start || *kept.next().unwrap_or(&true)
    });
}
