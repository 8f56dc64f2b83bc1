//! The sums over all pairs in a state: exact, or by a tree.

use glam::DVec3;

use super::expansion::{CellAttraction, CellLaw, MovingCellAttraction};
use super::laws::{Attraction, SUMS, Tide};
use super::sums::{self, SourceLaw};
use super::tree::{Targets, Tree};
use super::{AllPairs, Group};
use crate::forces::StateView;
use crate::math::{AXES, Real, Vector};
use crate::parallel::{BlockedSlice, Executor};
use crate::simd::{Record, WORDS};

/// Particles per block of work.
const BLOCK: usize = 4096;

/// The sums for each target of a group, and the number of interactions that they consist of.
type Sums<const SUMS: usize> = (Vec<[f64; SUMS]>, usize);

impl<V: Vector> AllPairs<V> {
    /// The sums of [`Attraction`] for the targets of a group.
    pub(super) fn attraction<T: Real>(&self, group: &Group, at: &StateView<'_, V>, executor: &Executor) -> Sums<SUMS> {
        let words = |index: usize| {
            let [x, y, z] = at.velocity.get(index).widen().to_array();
            [self.charge[index] / self.units[0], x, y, z]
        };
        let square = T::from_f64(self.softening_squared());
        let (still, moving) = (CellAttraction(square), MovingCellAttraction(square));
        match (square > T::ZERO, group.mutual) {
            (true, true) => self.sums(Attraction::<T, true, false>(square), still, group, words, at, executor),
            (false, true) => self.sums(Attraction::<T, false, false>(square), still, group, words, at, executor),
            (true, false) => self.sums(Attraction::<T, true, true>(square), moving, group, words, at, executor),
            (false, false) => self.sums(Attraction::<T, false, true>(square), moving, group, words, at, executor),
        }
    }

    /// The largest squared frequency of the relative motion of a target and its sources [1/s²]: Σⱼ κ|cᵢcⱼ|(1/mᵢ + 1/mⱼ)/s³,
    /// for a pair that is alone the ω² of its circular orbit; one-sided sources count as infinitely heavy.
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
            let (sums, _) = self.sums(law, law, group, words, at, at.executor);
            let mobile = group.targets.iter().zip(sums).filter(|&(&index, _)| !at.properties.is_fixed(index));
            largest = mobile.fold(largest, |largest, (&index, [by_charge, by_ratio])| {
                let charge = self.charge[index].abs();
                largest.max(charge / mass[index] * charges * by_charge + charge * ratios * by_ratio)
            });
        }
        self.constant.abs() / self.length.powi(3) * largest
    }

    /// The square of the softening in units of length.
    fn softening_squared(&self) -> f64 {
        (self.softening / self.length) * (self.softening / self.length)
    }

    /// The sums of a law for bodies, and of one for cells where there is a tree, over the sources of a group. `words` are those
    /// of a source after its position.
    fn sums<T: Real, const WITH: usize, const CELL: usize, const SUMS: usize>(
        &self,
        near: impl SourceLaw<T, WORDS, SUMS>,
        far: impl CellLaw<T, CELL, SUMS>,
        group: &Group,
        words: impl Fn(usize) -> [f64; WITH] + Sync,
        at: &StateView<'_, V>,
        executor: &Executor,
    ) -> Sums<SUMS> {
        let place = |index: usize| (at.position.get(index).widen() / self.length).to_array().map(T::from_f64);
        let sources: Vec<Record<T>> = each(&group.sources, executor, |index| {
            let mut record = [T::ZERO; WORDS];
            record[..AXES].copy_from_slice(&place(index));
            record[AXES..AXES + WITH].copy_from_slice(&words(index).map(T::from_f64));
            record
        });
        let targets = || each(&group.targets, executor, place);
        if self.angle == 0.0 {
            let sums = sums::sum(V::DIMENSION, near, &targets(), &sources, executor);
            return (sums, group.targets.len() * group.sources.len());
        }
        let tree = Tree::new(far, &sources, V::DIMENSION, self.angle, executor);
        let targets = if group.mutual { tree.targets() } else { Targets::new(&targets(), V::DIMENSION, executor) };
        tree.sums(near, far, &targets, V::DIMENSION, executor)
    }
}

/// A value for each of some particles.
fn each<R: Copy + Default + Send>(particles: &[usize], executor: &Executor, of: impl Fn(usize) -> R + Sync) -> Vec<R> {
    let mut values = vec![R::default(); particles.len()];
    executor.for_each_block(BlockedSlice::new(&mut values, BLOCK), &|mine| {
        mine.items.iter_mut().zip(&particles[mine.start..]).for_each(|(value, &index)| *value = of(index));
    });
    values
}

/// The field of a target among the sums of [`Attraction`].
pub(super) fn field(sums: &[f64; SUMS]) -> DVec3 {
    DVec3::new(sums[0], sums[1], sums[2])
}
