//! Evaluation of the sums over all pairs in a state: exact, or by a tree.

use glam::DVec3;

use super::expansion::{CellAttraction, CellLaw, MovingCellAttraction};
use super::laws::{Attraction, SUMS, Tide};
use super::sums::{self, SourceLaw, TargetSums};
use super::tree::Tree;
use super::{AllPairs, PairGroup};
use crate::StateView;
use crate::math::{AXES, Real, Vector};
use crate::parallel::{BlockedSlice, Executor};
use crate::simd::WORDS;

/// Particles per block of work.
const BLOCK: usize = 4096;

impl<V: Vector> AllPairs<V> {
    /// Sums of [`Attraction`] for the targets of a group.
    pub(super) fn attraction<T: Real>(&self, group: &PairGroup, at: &StateView<'_, V>, executor: &Executor) -> TargetSums<SUMS> {
        let per_unit = 1.0 / self.units[0];
        let words = |index: usize| {
            let [x, y, z] = if group.mutual { [0.0; AXES] } else { at.velocity.get(index).widen().to_array() };
            [self.charge[index] * per_unit, x, y, z]
        };
        let square = T::from_f64(self.softening_squared());
        let (moving, polar) = (MovingCellAttraction(square), CellAttraction::<T, true>(square));
        let monopolar = CellAttraction::<T, false>(square);
        let (soft, hard) = (Attraction::<T, true, false>(square), Attraction::<T, false, false>(square));
        match (square > T::ZERO, group.mutual, self.polar) {
            (true, true, false) => self.sums(soft, monopolar, group, words, at, executor),
            (true, true, true) => self.sums(soft, polar, group, words, at, executor),
            (false, true, false) => self.sums(hard, monopolar, group, words, at, executor),
            (false, true, true) => self.sums(hard, polar, group, words, at, executor),
            (true, false, _) => self.sums(Attraction::<T, true, true>(square), moving, group, words, at, executor),
            (false, false, _) => self.sums(Attraction::<T, false, true>(square), moving, group, words, at, executor),
        }
    }

    /// Largest squared frequency of the relative motion of a target and its sources [1/s²]: Σⱼ κ|cᵢcⱼ|(1/mᵢ + 1/mⱼ)/s³. For an
    /// isolated pair this is the ω² of its circular orbit. One-sided sources count as infinitely heavy.
    pub(super) fn frequency_squared(&self, at: &StateView<'_, V>) -> f64 {
        let law = Tide(V::Scalar::from_f64(self.softening_squared()));
        let [charges, ratios] = self.units;
        let mass = &at.properties.mass;
        let mut largest = 0.0_f64;
        for group in &self.groups {
            let words = |index: usize| {
                let charge = self.charge[index].abs();
                [charge / charges, if group.mutual { charge / mass[index] / ratios } else { 0.0 }]
            };
            let sums = self.sums(law, law, group, words, at, at.executor);
            let mobile = group.targets.iter().enumerate().filter(|&(_, &index)| !at.properties.is_fixed(index));
            largest = mobile.fold(largest, |largest, (target, &index)| {
                let [by_charge, by_ratio] = sums[target];
                let charge = self.charge[index].abs();
                largest.max(charge / mass[index] * charges * by_charge + charge * ratios * by_ratio)
            });
        }
        self.constant.abs() / self.length.powi(3) * largest
    }

    /// Squared softening in units of length.
    fn softening_squared(&self) -> f64 {
        (self.softening / self.length) * (self.softening / self.length)
    }

    /// Sums over the sources of a group. The law `near` applies to bodies, and `far` to cells, if there is a tree. `words`
    /// returns the words of a source after its position.
    fn sums<T: Real, const WITH: usize, const CELL: usize, const SUMS: usize>(
        &self,
        near: impl SourceLaw<T, WORDS, SUMS>,
        far: impl CellLaw<T, CELL, SUMS>,
        group: &PairGroup,
        words: impl Fn(usize) -> [f64; WITH] + Sync,
        at: &StateView<'_, V>,
        executor: &Executor,
    ) -> TargetSums<SUMS> {
        // The inverse is exact, because the unit is a power of two.
        let per_length = 1.0 / self.length;
        let place = |index: usize| (at.position.get(index).widen() * per_length).to_array().map(T::from_f64);
        let source = |source: usize| {
            let (mut record, index) = ([T::ZERO; WORDS], group.sources[source]);
            record[..AXES].copy_from_slice(&place(index));
            record[AXES..AXES + WITH].copy_from_slice(&words(index).map(T::from_f64));
            record
        };
        let target = |target: usize| place(group.targets[target]);
        let (targets, sources) = (group.targets.len(), group.sources.len());
        if self.angle == 0.0 {
            return sums::sum(V::DIMENSION, near, &each(targets, executor, target), &each(sources, executor, source), executor);
        }
        let tree = Tree::new(far, sources, &source, V::DIMENSION, self.angle, executor);
        if group.mutual {
            tree.mutual_sums(near, far, V::DIMENSION, executor)
        } else {
            tree.sums_at(near, far, targets, &target, V::DIMENSION, executor)
        }
    }
}

/// Computes `count` values in parallel.
fn each<R: Copy + Default + Send>(count: usize, executor: &Executor, of: impl Fn(usize) -> R + Sync) -> Vec<R> {
    let mut values = vec![R::default(); count];
    executor.for_each_block(BlockedSlice::new(&mut values, BLOCK), &|mine| {
        mine.items.iter_mut().zip(mine.start..).for_each(|(value, index)| *value = of(index));
    });
    values
}

/// Field of a target from the sums of [`Attraction`].
pub(super) fn field(sums: &[f64; SUMS]) -> DVec3 {
    DVec3::new(sums[0], sums[1], sums[2])
}
