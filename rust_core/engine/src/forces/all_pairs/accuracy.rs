//! The opening angle of the tree, and the error that it makes in the scene as it starts.

use glam::DVec3;

use super::evaluation::field;
use super::{AllPairs, Group};
use crate::error::Result;
use crate::forces::{Declared, StateView};
use crate::math::{Real, Vector};
use crate::matter::{Columns, View};
use crate::scene::Value;

/// The largest opening angle that is chosen: from there on it is the sphere about a cell's bodies that decides.
const LARGEST: f64 = 1.154_700_538_379_251_5;

/// The smallest opening angle that is chosen before the exact sum.
const SMALLEST: f64 = 0.1;

/// The exponent of the opening angle with which the error grows, about.
const ORDER: f64 = 3.5;

/// Maximum number of bodies on which the error is measured.
const SAMPLE: usize = 1000;

impl<V: Vector> AllPairs<V> {
    /// Takes the opening angle of the item, or for "auto" the largest whose error stays below the wished one if that needs fewer
    /// interactions than the exact sum; and measures both in the scene as it starts.
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
        let at = StateView { position, velocity, residual: View::default(), properties, time: 0.0, executor };
        let sample = self.sample(&at);
        let (exact, _) = self.accelerations::<f64>(&sample, &self.of_sample(&sample), &at);
        let all_pairs = self.pairs;
        self.angle = angle;
        loop {
            let (found, pairs) = self.accelerations::<V::Scalar>(&sample, &self.groups, &at);
            executor.check()?;
            (self.force_error, self.pairs) = (relative_error(&found, &exact), pairs);
            let Some(wished) = wished.filter(|&wished| pairs >= all_pairs || self.force_error > wished) else { break };
            // Not too far at once: the error's order is only about this.
            self.angle *= libm::pow(wished / self.force_error, 1.0 / ORDER).clamp(0.5, 0.95);
            if pairs >= all_pairs || self.angle < SMALLEST {
                (self.angle, self.force_error, self.pairs) = (0.0, 0.0, all_pairs);
                break;
            }
        }
        Ok(())
    }

    /// Some of the particles that the force accelerates.
    fn sample(&self, at: &StateView<'_, V>) -> Vec<usize> {
        let mut mobile: Vec<usize> = self.groups.iter().flat_map(|group| &group.targets).copied().collect();
        mobile.retain(|&index| !at.properties.is_fixed(index));
        mobile.sort_unstable();
        mobile.dedup();
        let stride = mobile.len().div_ceil(SAMPLE).max(1);
        mobile.into_iter().step_by(stride).collect()
    }

    /// The groups, whose targets are only those of a sample.
    fn of_sample(&self, sample: &[usize]) -> Vec<Group> {
        let reduced = |group: &Group| Group {
            targets: group.targets.iter().copied().filter(|index| sample.binary_search(index).is_ok()).collect(),
            sources: group.sources.clone(),
            mutual: group.mutual,
        };
        self.groups.iter().map(reduced).collect()
    }

    /// The accelerations of a sample by some groups, in units of this force, and the number of interactions of all.
    fn accelerations<T: Real>(&self, sample: &[usize], groups: &[Group], at: &StateView<'_, V>) -> (Vec<DVec3>, usize) {
        let (mut accelerations, mut pairs) = (vec![DVec3::ZERO; sample.len()], 0);
        for group in groups {
            let (sums, interactions) = self.attraction::<T>(group, at, at.executor);
            pairs += interactions;
            for (sum, index) in accelerations.iter_mut().zip(sample) {
                if let Ok(target) = group.targets.binary_search(index) {
                    let per_mass = self.charge[*index] / self.units[0] / at.properties.mass[*index];
                    *sum += per_mass * field(&sums[target]);
                }
            }
        }
        (accelerations, pairs)
    }
}

/// The rms difference over the rms of the exact vectors; 0 if these are 0.
fn relative_error(found: &[DVec3], exact: &[DVec3]) -> f64 {
    let squares = |vectors: &mut dyn Iterator<Item = DVec3>| vectors.map(DVec3::length_squared).sum::<f64>();
    let difference = squares(&mut found.iter().zip(exact).map(|(found, exact)| *found - *exact));
    let size = squares(&mut exact.iter().copied());
    if size > 0.0 { (difference / size).sqrt() } else { 0.0 }
}
