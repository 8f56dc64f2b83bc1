//! Selection of contacts, and their requirements. Some pairs would close to less than the thickness, along the normal at the
//! start of the step. Others meet on their paths.

use std::collections::HashSet;

use glam::DVec3;

use super::distance::{Closest, combined};
use super::mesh::ElementPair;
use super::nearby::Near;
use super::resolution::ContactStep;
use super::{MeshContact, Origin};
use super::{SelfContacts, advancement};
use crate::parallel::{BlockedSlice, Executor};
use crate::solvers::impulses::Handle;

/// Distance that is always kept: in units of the thickness, or of the present distance where that is less.
const KEPT: f64 = 0.5;
const KEPT_OF_PRESENT: f64 = 0.5;
/// Distance beyond the thickness up to which contacts of the last step are taken into the next one, in thicknesses.
const LASTING: f64 = 1.0;
/// Number of items that one thread processes at a time.
const BLOCK: usize = 1024;

impl SelfContacts {
    /// Contacts of the last step that are not far apart now, with their impulses, the nearest first.
    pub(super) fn lasting(&self, free: &[DVec3], ContactStep { h, .. }: ContactStep<'_>) -> Vec<MeshContact> {
        let contact = |&(key, load): &(u64, f64)| {
            let pair = self.mesh.pair(key)?;
            let closest = pair.measure(&pair.gather(&self.start));
            let near = Near::new(pair, &closest);
            let mut contact = self.along_normal((&near, &closest), (LASTING, free, free), h)?;
            contact.impulse = h * load;
            Some((near, contact))
        };
        in_order(self.loads.pairs.iter().filter_map(contact).collect()).into_iter().map(|(_, contact)| contact).collect()
    }

    /// Indices of the nearby pairs that may come nearer than (1 + `margin`) thicknesses with these velocities.
    pub(super) fn reached(
        &self,
        velocities: &[DVec3],
        margin: f64,
        ContactStep { h, executor, .. }: ContactStep<'_>,
    ) -> Vec<u32> {
        let reached = |index: usize| {
            let near = &self.nearby.pairs[index];
            let reach = (1.0 + margin) * self.rules[near.pair.rule as usize].thickness;
            (near.distance <= 0.0 || near.least(velocities, h) < reach).then_some(index as u32)
        };
        by_blocks(self.nearby.pairs.len(), executor, &reached)
    }

    /// Contacts of the pairs in `reached` that close along their normals and are not `known`, the nearest first.
    pub(super) fn closing(
        &self,
        reached: &[u32],
        known: &HashSet<u64>,
        motion: (f64, &[DVec3], &[DVec3]),
        ContactStep { h, executor, .. }: ContactStep<'_>,
    ) -> Vec<MeshContact> {
        let contact = |index: usize| {
            let near = &self.nearby.pairs[reached[index] as usize];
            if known.contains(&near.pair.key) {
                return None;
            }
            let closest = near.pair.measure(&near.pair.gather(&self.start));
            self.along_normal((near, &closest), motion, h).map(|contact| (*near, contact))
        };
        in_order(by_blocks(reached.len(), executor, &contact)).into_iter().map(|(_, contact)| contact).collect()
    }

    /// Pairs in `reached` that come too near each other on their paths, with their closest points there, the nearest first.
    pub(super) fn meetings(
        &self,
        reached: &[u32],
        velocities: &[DVec3],
        ContactStep { h, executor, .. }: ContactStep<'_>,
    ) -> Vec<(Near, Closest)> {
        let meeting = |index: usize| {
            let near = &self.nearby.pairs[reached[index] as usize];
            let (pair, distance) = (&near.pair, near.distance);
            let least = (KEPT * self.rules[pair.rule as usize].thickness).min(KEPT_OF_PRESENT * distance);
            if distance > 0.0 && near.least(velocities, h) >= least {
                return None;
            }
            let (x, ways) = (pair.gather(&self.start), pair.gather(velocities).map(|velocity| h * velocity));
            if distance > 0.0 && near.least_of_vertices(&x, &ways) >= least {
                return None;
            }
            let motion = advancement::relative(&ways, pair.split());
            let met = (distance - motion.0 <= least).then(|| advancement::meeting(|x| pair.measure(x), x, motion, least));
            met.flatten().map(|closest| (*near, closest))
        };
        in_order(by_blocks(reached.len(), executor, &meeting))
    }

    /// Contact of a pair with its normal at the start; None unless it closes to less than (1 + `margin`) thicknesses with
    /// these velocities. Closest points on a boundary belong to several pairs; only a locally closest pair counts.
    fn along_normal(
        &self,
        (near, closest): (&Near, &Closest),
        (margin, free, velocities): (f64, &[DVec3], &[DVec3]),
        h: f64,
    ) -> Option<MeshContact> {
        let (pair, distance, normal) = (&near.pair, near.distance, near.normal);
        let rule = &self.rules[pair.rule as usize];
        let along = |velocities: &[DVec3]| normal.dot(combined(&closest.weights, &pair.gather(velocities)));
        let reached = distance + h * along(velocities) < (1.0 + margin) * rule.thickness;
        if !reached || distance <= 0.0 || !(closest.interior || self.is_local(pair, closest)) {
            return None;
        }
        let (approach, least) = (along(free), ((rule.thickness - distance) / h).min(0.0));
        // Pairs that touched in the last step rest; arriving pairs bounce.
        let bounces = rule.restitution > 0.0 && approach < least && self.loads.of(pair.key).is_none();
        let least = if bounces { least.max(-rule.restitution * approach) } else { least };
        let origin = Origin::Pair(pair.key);
        MeshContact::new(
            (pair.nodes.map(Handle::Particle), origin),
            closest.weights,
            normal,
            (least, rule.friction),
            &self.inverse_mass,
        )
    }

    /// Contact of a pair that meets on its path.
    pub(super) fn on_the_way(&self, &Near { ref pair, distance, .. }: &Near, closest: &Closest, h: f64) -> Option<MeshContact> {
        let rule = &self.rules[pair.rule as usize];
        let normal = closest.separation.normalize_or_zero();
        let gap = normal.dot(combined(&closest.weights, &pair.gather(&self.start)));
        let least = ((distance.min(rule.thickness) - gap) / h).min(0.0);
        MeshContact::new(
            (pair.nodes.map(Handle::Particle), Origin::Way),
            closest.weights,
            normal,
            (least, rule.friction),
            &self.inverse_mass,
        )
    }

    /// Whether no points near the closest points of a pair are closer.
    fn is_local(&self, pair: &ElementPair, closest: &Closest) -> bool {
        let x = &self.start;
        let (p, weights) = (closest.separation, &closest.weights);
        let alone = |vertex: u32, toward: DVec3| {
            let neighbors = self.mesh.neighbors(vertex);
            neighbors.iter().all(|&neighbor| toward.dot(x[neighbor as usize] - x[vertex as usize]) <= 0.0)
        };
        if pair.has_face() {
            return closest.interior && alone(pair.nodes[0], -p);
        }
        let edges = [(pair.key >> 32) as u32, pair.key as u32];
        let mut ends = 0;
        (0..2).all(|side| {
            let [a, b] = [pair.nodes[2 * side], pair.nodes[2 * side + 1]];
            let along = weights[2 * side + 1].abs();
            let toward = if side == 0 { -p } else { p };
            if along > 0.0 && along < 1.0 {
                let point = (1.0 - along) * x[a as usize] + along * x[b as usize];
                let opposite = self.mesh.opposite[edges[side] as usize];
                opposite.iter().all(|&vertex| vertex == a || vertex == b || toward.dot(x[vertex as usize] - point) <= 0.0)
            } else {
                // All edges at a vertex have it as their closest point. The edge to its first neighbor stands for them.
                ends += 1;
                let [vertex, other] = if along <= 0.0 { [a, b] } else { [b, a] };
                ends == 1 && self.mesh.neighbors(vertex).first() == Some(&other) && alone(vertex, toward)
            }
        })
    }
}

/// Sorts the results of pairs, the nearest first.
fn in_order<T>(mut found: Vec<(Near, T)>) -> Vec<(Near, T)> {
    found.sort_unstable_by(|(one, _), (other, _)| one.order(other));
    found
}

/// Results of `each` for the indices below `count`, in their order.
fn by_blocks<R: Send + Clone>(count: usize, executor: &Executor, each: &(impl Fn(usize) -> Option<R> + Sync)) -> Vec<R> {
    let mut found: Vec<Vec<R>> = vec![Vec::new(); count.div_ceil(BLOCK)];
    executor.for_each_block(BlockedSlice::new(&mut found, 1), &|work: BlockedSlice<'_, Vec<R>>| {
        let first = work.start * BLOCK;
        work.items[0].extend((first..count.min(first + BLOCK)).filter_map(each));
    });
    found.concat()
}
