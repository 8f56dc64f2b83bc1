//! Derivatives of the exact sum over all pairs. With A = κ cᵢcⱼ and d = xᵢ − xⱼ, the stiffness of a pair is K = A (1/s³ − 3
//! ddᵀ/s⁵).

use glam::DVec3;

use super::{AllPairs, PairGroup};
use crate::derivatives::{Derivatives, Directed, MatrixBlock, Motion, Push};
use crate::math::Vector;

/// Maximum number of pairs with derivatives, counted in both directions. A matrix takes 76 bytes for each.
const MOST: usize = 1 << 21;

impl<V: Vector> AllPairs<V> {
    /// Whether the force is an exact sum over few enough pairs for a matrix.
    pub(super) fn has_derivatives(&self) -> bool {
        self.angle == 0.0 && self.pairs <= MOST
    }

    /// Calls `each` for every interacting pair. Its arguments are target and source, the vector d [m], the stiffness of the
    /// target along and across d [N/m], and whether the pair is mutual. The force on the target is −d times the stiffness across.
    fn respond(&self, at: &Motion<'_>, mut each: impl FnMut([usize; 2], DVec3, Directed, bool)) {
        for PairGroup { targets, sources, mutual } in &self.groups {
            for (place, &target) in targets.iter().enumerate() {
                for &source in &sources[if *mutual { place + 1 } else { 0 }..] {
                    let offset = at.position[target] - at.position[source];
                    let square = offset.length_squared() + self.softening * self.softening;
                    let across = self.constant * self.charge[target] * self.charge[source] / (square * square.sqrt());
                    let along = across * (1.0 - 3.0 * offset.length_squared() / square);
                    each([target, source], offset, Directed { along, across }, *mutual);
                }
            }
        }
    }
}

impl<V: Vector> Derivatives for AllPairs<V> {
    fn forces(&self, at: &Motion<'_>, push: &mut dyn FnMut(Push)) {
        self.respond(at, |[target, source], offset, stiffness, mutual| {
            let (force, stiffness) = (-stiffness.across * offset, stiffness.largest());
            push(Push { particle: target, force, stiffness });
            if mutual {
                push(Push { particle: source, force: -force, stiffness });
            }
        });
    }

    /// A one-sided pair has the block of the target alone. The block for the motion of the source is omitted, so that the matrix
    /// is symmetric.
    fn blocks(&self, at: &Motion<'_>, [position, _]: [f64; 2], add: &mut dyn FnMut(MatrixBlock)) {
        self.respond(at, |[target, source], offset, stiffness, mutual| {
            let direction = offset.normalize_or_zero();
            let [exact, definite] = [stiffness, stiffness.definite()].map(|stiffness| position * stiffness.matrix(direction));
            if mutual {
                add(MatrixBlock { ends: [target as u32, source as u32], exact, definite });
            } else {
                add(MatrixBlock::of(target, exact, definite));
            }
        });
    }
}
