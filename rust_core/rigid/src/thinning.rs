//! Fewer contacts where a body lies on many parts of another.

use glam::DVec3;

use crate::contact::ContactPoint;
use crate::pose::Pose;
use crate::spatial;

/// Cosine of the angle of normals that count as one.
const ALIKE: f64 = 0.999;
/// Distance of places that count as one, relative to their distances from the centers of the bodies.
const SAME: f64 = 1e-9;

/// Keeps, of the contacts from `start` on whose normals are alike, those that are well spread: two in 2D, four in 3D.
pub(crate) fn thin(points: &mut Vec<ContactPoint>, start: usize, poses: [&Pose; 2], dimension: usize) {
    if points.len() - start < 2 {
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
        let group = distinct(group, &points[start..]);
        let place = |index: usize| (touches[group[index]].point, touches[group[index]].gap);
        for place in spatial::spread(group.len(), place, normal, dimension) {
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

/// Contacts of a group without those at the place of an earlier one, such as a vertex of several parts.
fn distinct(group: Vec<usize>, points: &[ContactPoint]) -> Vec<usize> {
    let is_same = |one: &ContactPoint, other: &ContactPoint| {
        let [a, b] = one.points;
        a.distance(other.points[0]) + b.distance(other.points[1]) <= SAME * (a.length() + b.length())
    };
    let mut kept: Vec<usize> = Vec::new();
    for index in group {
        if !kept.iter().any(|&one| is_same(&points[one], &points[index])) {
            kept.push(index);
        }
    }
    kept
}
