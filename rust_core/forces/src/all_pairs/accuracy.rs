//! Opening angle of the tree, and its error in the initial state.

use glam::DVec3;

use super::evaluation::field;
use super::{AllPairs, PairGroup};
use crate::error::Result;
use crate::math::{Real, Vector};
use crate::matter::{Columns, View};
use crate::scene::Value;
use crate::{Declared, StateView};

/// Largest opening angle that is chosen. Beyond it, the bounding sphere of small cells determines their acceptance.
const LARGEST: f64 = 2.0;

/// Smallest opening angle that is chosen; below it, the exact sum is used.
const SMALLEST: f64 = 0.1;

/// Approximate exponent of the opening angle in the error.
const ORDER: f64 = 3.5;

/// Maximum number of bodies for which the error is measured.
const SAMPLE: usize = 1000;

/// Ratio of the error to the requested error from which on an angle is not widened further.
const CLOSE: f64 = 0.8;

/// Number of trials after which the widest angle so far is taken.
const TRIALS: usize = 10;

/// An evaluation by the tree.
#[derive(Debug, Clone, Copy)]
struct TreeEvaluation {
    angle: f64,
    error: f64,
    pairs: usize,
    bytes: usize,
}

impl<V: Vector> AllPairs<V> {
    /// Sets the opening angle, and measures its error and number of interactions in the initial state. For "auto" the angle is
    /// one whose error is at most the requested error, and close to it. The exact sum is kept if the tree would need as many
    /// interactions.
    pub(super) fn choose_angle(&mut self, declared: &Declared<'_, V>) -> Result<()> {
        let Declared { scene, item, properties, executor, .. } = declared;
        let wished = match item.values.get("opening_angle") {
            Some(Value::Text(text)) if text == "auto" => Some(item.number("force_error")?),
            _ => None,
        };
        self.pairs = self.groups.iter().map(|group| group.targets.len() * group.sources.len()).sum();
        let angle = if wished.is_some() { LARGEST } else { item.non_negative("opening_angle")? };
        if angle == 0.0 {
            return Ok(());
        }
        let (start, count) = (scene.positions(), properties.count());
        let position = Columns::from_fn(count, |index| V::narrow(start[properties.caller[index] as usize] - properties.origin));
        let velocity = Columns::zeros(count);
        let (position, velocity) = (position.view(), velocity.view());
        let at = StateView { position, velocity, residual: View::default(), properties, solids: &[], time: 0.0, executor };
        let sample = self.sample(&at);
        let exact = self.accelerations::<f64>(&sample, &self.of_sample(&sample), &at).0;
        let all_pairs = self.pairs;
        let mut trial = |angle: f64| {
            self.angle = angle;
            let (found, pairs, bytes) = self.accelerations::<V::Scalar>(&sample, &self.groups, &at);
            TreeEvaluation { angle, error: relative_error(&found, &exact), pairs, bytes }
        };
        let first = trial(angle);
        let chosen = match wished {
            Some(wished) => widest(wished, all_pairs, first, &mut trial),
            None => Some(first),
        };
        executor.check()?;
        self.angle = 0.0;
        if let Some(TreeEvaluation { angle, error, pairs, bytes }) = chosen {
            (self.angle, self.force_error, self.pairs, self.evaluation) = (angle, error, pairs, bytes);
        }
        Ok(())
    }

    /// A sample of the movable particles that the force acts on.
    fn sample(&self, at: &StateView<'_, V>) -> Vec<usize> {
        let mut mobile: Vec<usize> = self.groups.iter().flat_map(|group| &group.targets).copied().collect();
        mobile.retain(|&index| !at.properties.is_fixed(index));
        mobile.sort_unstable();
        mobile.dedup();
        let stride = mobile.len().div_ceil(SAMPLE).max(1);
        mobile.into_iter().step_by(stride).collect()
    }

    /// The groups with their targets reduced to a sample.
    fn of_sample(&self, sample: &[usize]) -> Vec<PairGroup> {
        let reduced = |group: &PairGroup| PairGroup {
            targets: group.targets.iter().copied().filter(|index| sample.binary_search(index).is_ok()).collect(),
            sources: group.sources.clone(),
            mutual: group.mutual,
        };
        self.groups.iter().map(reduced).collect()
    }

    /// Accelerations of a sample by groups, in units of this force; the number of interactions of all targets; and the memory of
    /// the evaluation [bytes].
    fn accelerations<T: Real>(
        &self,
        sample: &[usize],
        groups: &[PairGroup],
        at: &StateView<'_, V>,
    ) -> (Vec<DVec3>, usize, usize) {
        let (mut accelerations, mut pairs, mut bytes) = (vec![DVec3::ZERO; sample.len()], 0, 0);
        for group in groups {
            let sums = self.attraction::<T>(group, at, at.executor);
            (pairs, bytes) = (pairs + sums.interactions, bytes + sums.bytes);
            for (sum, index) in accelerations.iter_mut().zip(sample) {
                if let Ok(target) = group.targets.binary_search(index) {
                    let per_mass = self.charge[*index] / self.units[0] / at.properties.mass[*index];
                    *sum += per_mass * field(&sums[target]);
                }
            }
        }
        (accelerations, pairs, bytes)
    }
}

/// The widest angle whose error is at most the requested error. None if such trees need more interactions than all pairs. The
/// error is interpolated as a power of the angle, between the nearest angles on both sides.
fn widest(
    wished: f64,
    all_pairs: usize,
    first: TreeEvaluation,
    trial: &mut impl FnMut(f64) -> TreeEvaluation,
) -> Option<TreeEvaluation> {
    let (mut last, mut wide, mut fine) = (first, None::<TreeEvaluation>, None::<TreeEvaluation>);
    for trials in 1.. {
        if last.pairs >= all_pairs || last.angle < SMALLEST {
            return None;
        }
        if last.error > wished {
            wide = Some(last);
        } else {
            fine = Some(last);
        }
        let angle = match (wide, fine) {
            // Steps are limited, because the order of the error is approximate.
            (Some(wide), None) => wide.angle * libm::pow(wished / wide.error, 1.0 / ORDER).clamp(0.5, 0.95),
            (Some(wide), Some(fine)) if trials < TRIALS && fine.error > 0.0 && fine.error < CLOSE * wished => {
                let log = |one: f64, other: f64| libm::log(one / other);
                let share = log(CLOSE.sqrt() * wished, fine.error) / log(wide.error, fine.error);
                fine.angle * libm::pow(wide.angle / fine.angle, share)
            }
            _ => break,
        };
        last = trial(angle);
    }
    fine
}

/// Rms of the differences relative to the rms of the exact vectors; 0 if the exact vectors are 0.
fn relative_error(found: &[DVec3], exact: &[DVec3]) -> f64 {
    let squares = |vectors: &mut dyn Iterator<Item = DVec3>| vectors.map(DVec3::length_squared).sum::<f64>();
    let difference = squares(&mut found.iter().zip(exact).map(|(found, exact)| *found - *exact));
    let size = squares(&mut exact.iter().copied());
    if size > 0.0 { (difference / size).sqrt() } else { 0.0 }
}
