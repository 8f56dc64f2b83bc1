//! The derivatives of the exact sum over all pairs: with A = κ cᵢcⱼ and d = xᵢ − xⱼ, K = A (1/s³ − 3 ddᵀ/s⁵) of a pair.

use glam::DVec3;

use super::{AllPairs, Group};
use crate::forces::derivatives::{Block, Derivatives, Directed, Motion, Push};
use crate::math::Vector;

/// The most pairs, counted in both directions, that have derivatives: a matrix takes 76 bytes for each.
const MOST: usize = 1 << 21;

impl<V: Vector> AllPairs<V> {
    /// Whether the force is an exact sum over pairs few enough for a matrix.
    pub(super) fn has_derivatives(&self) -> bool {
        self.angle == 0.0 && self.groups.iter().map(|group| group.targets.len() * group.sources.len()).sum::<usize>() <= MOST
    }

    /// Calls `each` with every pair that acts: target, source, the force on the target [N], its stiffness, and whether the source feels it
    /// too.
    fn respond(&self, at: &Motion<'_>, mut each: impl FnMut([usize; 2], DVec3, Directed, DVec3, bool)) {
        for group @ Group { targets, sources, mutual } in &self.groups {
            debug_assert!(!group.mutual || targets == sources);
            for (place, &target) in targets.iter().enumerate() {
                for &source in &sources[if *mutual { place + 1 } else { 0 }..] {
                    let offset = at.position[target] - at.position[source];
                    let square = offset.length_squared() + self.softening * self.softening;
                    let across = self.constant * self.charge[target] * self.charge[source] / (square * square.sqrt());
                    let along = across * (1.0 - 3.0 * offset.length_squared() / square);
                    each([target, source], -across * offset, Directed { along, across }, offset.normalize_or_zero(), *mutual);
                }
            }
        }
    }
}

impl<V: Vector> Derivatives for AllPairs<V> {
    fn forces(&self, at: &Motion<'_>, push: &mut dyn FnMut(Push)) {
        self.respond(at, |[target, source], force, stiffness, _, mutual| {
            let stiffness = stiffness.largest();
            push(Push { particle: target, force, stiffness });
            if mutual {
                push(Push { particle: source, force: -force, stiffness });
            }
        });
    }

    /// The source of a pair that is not mutual responds to nothing: its block is the target's alone, and its own motion is not in it, which
    /// makes the matrix symmetric and Newton's method slower.
    fn blocks(&self, at: &Motion<'_>, [position, _]: [f64; 2], add: &mut dyn FnMut(Block)) {
        self.respond(at, |[target, source], _, stiffness, direction, mutual| {
            let [exact, definite] = [stiffness, stiffness.definite()].map(|stiffness| position * stiffness.matrix(direction));
            if mutual {
                add(Block { ends: [target as u32, source as u32], exact, definite });
            } else {
                add(Block::of(target, exact, definite));
            }
        });
    }
}
