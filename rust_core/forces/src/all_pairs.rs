//! Inverse-square force between all pairs, the common law of gravitation and of Coulomb: Fᵢ = −κ cᵢ Σⱼ cⱼ d/s³ with d = xᵢ − xⱼ
//! and s² = |d|² + ε². The potential energy of a pair is −κ cᵢcⱼ/s.
//!
//! For gravitation the charge c is the mass, and κ = G. For Coulomb's law c is the electric charge, and κ = −k.
//!
//! Lengths and charges are computed in units of powers of two, taken from the largest initial values. In SI units, distances and
//! their cubes may be out of the range of f32.
//!
//! Source for the softening: H. C. Plummer, Mon. Not. R. Astron. Soc. 71 (1911) 460.

mod accuracy;
mod derivatives;
mod encounters;
mod evaluation;
mod expansion;
mod hilbert;
mod laws;
mod sums;
mod tree;

use std::f64::consts::TAU;
use std::ops::Range;

use glam::DVec3;

use super::derivatives::Derivatives;
use super::{About, Declared, Force, ForceKind, Forces, Rates, Reach, StateView, Validity};
use crate::error::{Error, Result};
use crate::history::History;
use crate::ledger::{Class, Ledger};
use crate::math::{Real, Vector};
use crate::matter::EnergySink;
use crate::parallel::{BlockedSlice, Executor};
use crate::scene::{Item, Scene, Value};
use crate::simd::LANES;
use crate::stability::{Horizon, SpectralBound};
use evaluation::field;
use laws::{COINCIDENT, POTENTIAL, WORK};

/// Steps per period of the fastest orbit at an automatic time step.
const STEPS_PER_TURN: f64 = 100.0;

/// Particles per block of work.
const BLOCK: usize = 4096;

/// Pairs of targets and sources.
struct PairGroup {
    /// Particles that feel the force.
    targets: Vec<usize>,
    /// Particles that exert the force.
    sources: Vec<usize>,
    /// Whether the targets and sources are the same particles, each of which acts on all others. Otherwise the sources do not
    /// feel the targets.
    mutual: bool,
}

/// Inverse-square force between all pairs.
struct AllPairs<V: Vector> {
    name: &'static str,
    /// Path of the item.
    path: String,
    /// Constant κ.
    constant: f64,
    /// Softening length ε [m].
    softening: f64,
    /// Charge c of each particle.
    charge: Vec<f64>,
    groups: Vec<PairGroup>,
    /// Opening angle θ of the tree; 0 for the exact sum.
    angle: f64,
    /// Relative rms error of the acceleration in the initial state.
    force_error: f64,
    /// Number of interactions of targets with cells and bodies in the initial state.
    pairs: usize,
    /// Memory of an evaluation by the tree in the initial state [bytes].
    evaluation: usize,
    /// Whether there are charges of both signs.
    polar: bool,
    /// Unit of length, a power of two [m].
    length: f64,
    /// Units of charge and of charge per mass, powers of two.
    units: [f64; 2],
    /// Forces of the last evaluation [N].
    force: Vec<V>,
    /// Power [W] that keeps one-sided sources on their paths, of the last evaluation.
    work: Vec<f64>,
}

/// Entry of gravitation in the registry of forces.
pub fn gravitation<V: Vector>() -> ForceKind<V> {
    let build = |declared: &Declared<'_, V>| -> Result<Forces<V>> {
        let mass: Vec<f64> = declared.scene.bodies.iter().flat_map(|body| &body.mass).copied().collect();
        let mass = declared.properties.caller.iter().map(|&caller| mass[caller as usize]).collect();
        let constant = declared.item.non_negative("constant")?;
        Ok(vec![Box::new(AllPairs::<V>::new(declared, "gravitation", constant, mass)?)])
    };
    ForceKind { name: "Gravitation", reach: Reach::Far, charges: false, build }
}

/// Entry of Coulomb's law in the registry of forces.
pub fn coulomb<V: Vector>() -> ForceKind<V> {
    let build = |declared: &Declared<'_, V>| -> Result<Forces<V>> {
        let constant = declared.item.non_negative("constant")?;
        Ok(vec![Box::new(AllPairs::<V>::new(declared, "coulomb", -constant, declared.properties.charge.clone())?)])
    };
    ForceKind { name: "Coulomb", reach: Reach::Far, charges: true, build }
}

/// Whether an item names each particle, or its body, as a source, in the engine's order.
fn sources<V: Vector>(declared: &Declared<'_, V>) -> Result<Vec<bool>> {
    let Declared { scene, item, properties, .. } = declared;
    let named = match item.values.get("sources") {
        None => Item::default(),
        Some(Value::Indices(array)) => {
            Item { on: Some(array.entries.iter().map(|&body| body as usize).collect()), ..Item::default() }
        }
        Some(Value::Flags(array)) if array.entries.len() == scene.count() => {
            Item { members: Some(array.entries.clone()), ..Item::default() }
        }
        other => return Err(item.wrong("sources", "indices of bodies", other)),
    };
    let in_scene = scene.members(&named);
    Ok(properties.caller.iter().map(|&caller| in_scene[caller as usize]).collect())
}

/// The power of two at or below the largest |number|; 1 if all numbers are 0.
fn unit(numbers: impl Iterator<Item = f64>) -> f64 {
    const EXPONENT: u64 = 0x7ff0_0000_0000_0000;
    let largest = numbers.map(f64::abs).filter(|number| number.is_finite()).fold(0.0, f64::max);
    if largest < f64::MIN_POSITIVE { 1.0 } else { f64::from_bits(largest.to_bits() & EXPONENT) }
}

/// The interacting groups: the particles that are both targets and sources, and those of one-sided sources.
fn groups(targets: &[bool], sources: &[bool]) -> Vec<PairGroup> {
    let of = |fits: &dyn Fn(bool, bool) -> bool| -> Vec<usize> {
        (0..targets.len()).filter(|&index| fits(targets[index], sources[index])).collect()
    };
    let [both, only_targets, only_sources] = [of(&|t, s| t && s), of(&|t, s| t && !s), of(&|t, s| !t && s)];
    let group = |targets: &[usize], sources: Vec<usize>, mutual| PairGroup { targets: targets.to_vec(), sources, mutual };
    let all = [group(&both, both.clone(), true), group(&both, only_sources, false), group(&only_targets, of(&|_, s| s), false)];
    all.into_iter().filter(|group| !group.targets.is_empty() && !group.sources.is_empty()).collect()
}

impl<V: Vector> AllPairs<V> {
    /// Force of an item with the constant κ, for particles of these charges.
    fn new(declared: &Declared<'_, V>, name: &'static str, constant: f64, charge: Vec<f64>) -> Result<Self> {
        let Declared { scene, item, properties, chosen, .. } = declared;
        refuse_periodic(scene, item)?;
        let softening = item.non_negative("softening")?;
        let offsets = scene.positions().into_iter().map(|position| (position - properties.origin).abs().max_element());
        let per_mass = charge.iter().zip(&properties.mass).map(|(charge, mass)| charge / mass);
        let mut force = Self {
            name,
            path: item.path.clone(),
            constant,
            softening,
            groups: groups(chosen, &sources(declared)?),
            length: unit(offsets.chain([softening])),
            units: [unit(charge.iter().copied()), unit(per_mass)],
            polar: charge.iter().any(|&charge| charge > 0.0) && charge.iter().any(|&charge| charge < 0.0),
            charge,
            angle: 0.0,
            force_error: 0.0,
            pairs: 0,
            evaluation: 0,
            force: vec![V::default(); properties.count()],
            work: vec![0.0; properties.count()],
        };
        force.choose_angle(declared)?;
        Ok(force)
    }

    /// Unit of energy, κ c²/length [J].
    fn energy_unit(&self) -> f64 {
        self.constant * self.units[0] * self.units[0] / self.length
    }

    /// Calls `each` with every target of a group and its energy in units of [`AllPairs::energy_unit`]. The energy is the sum of
    /// cᵢcⱼ/s over all sources except the target itself.
    fn energies(&self, group: &PairGroup, at: &StateView<'_, V>, mut each: impl FnMut(usize, f64)) {
        let sums = self.attraction::<f64>(group, at, at.executor);
        for (target, &index) in group.targets.iter().enumerate() {
            let charge = self.charge[index] / self.units[0];
            // With softening, the sums of a mutual group include each particle's own term.
            let itself = if group.mutual && self.softening > 0.0 { charge * (self.length / self.softening) } else { 0.0 };
            each(index, charge * (sums[target][POTENTIAL] - itself));
        }
    }

    /// The error of a target that coincides with a source.
    fn coincidence(&self, group: &PairGroup, target: usize, at: &StateView<'_, V>) -> Error {
        let one = group.targets[target];
        let same = |index: usize| index != one && at.position.get(index) == at.position.get(one);
        let other = group.sources.iter().copied().find(|&index| same(index));
        let mut pair = [one, other.unwrap_or(one)].map(|index| at.properties.caller[index]);
        pair.sort_unstable();
        let place = (at.properties.origin + at.position.get(one).widen()).to_array();
        let found = format!("particles {} and {} both at {:?} m", pair[0], pair[1], &place[..V::DIMENSION]);
        let error = Error::parameter(&self.path, "particles in different places, as there is no softening", found);
        error.with_hint(if V::Scalar::NAME == "f32" {
            "give it a softening [m], or take precision=\"f64\", which tells closer particles apart"
        } else {
            "give it a softening [m]"
        })
    }
}

/// Rejects a periodic domain.
fn refuse_periodic(scene: &Scene, item: &Item) -> Result<()> {
    if scene.periodic.is_none() {
        return Ok(());
    }
    Err(Error::parameter(&item.path, "a scene without a Periodic domain", "one with it")
        .with_hint("the force of all periodic images is an infinite sum, which is not computed; use walls, or no domain"))
}

impl<V: Vector> History for AllPairs<V> {}

impl<V: Vector> Force<V> for AllPairs<V> {
    fn about(&self) -> About {
        let indices: usize = self.groups.iter().map(|group| group.targets.len() + group.sources.len()).sum();
        let layout = if self.angle == 0.0 {
            "the exact sum over all pairs, in both directions".to_owned()
        } else {
            format!("a tree with the opening angle {:.3}, cells by their quadrupoles", self.angle)
        };
        About {
            pairs: self.pairs,
            force_error: self.force_error,
            bytes: size_of_val(self.force.as_slice()) + 8 * (self.charge.len() + self.work.len() + indices) + self.evaluation,
            layout,
            ..About::new(self.name, Reach::Far)
        }
    }

    fn prepare(&mut self, at: &StateView<'_, V>, executor: &Executor) -> Result<()> {
        let mut found = Vec::with_capacity(self.groups.len());
        for group in &self.groups {
            let sums = self.attraction::<V::Scalar>(group, at, executor);
            executor.check()?;
            // A particle of a mutual group coincides with itself.
            let expected = if group.mutual { 1.0 } else { 0.0 };
            let coincides = |&target: &usize| sums[target][COINCIDENT] > expected;
            if let Some(target) = (0..group.targets.len()).find(|target| self.softening == 0.0 && coincides(target)) {
                return Err(self.coincidence(group, target, at));
            }
            found.push((group, sums));
        }
        let scale = |index: usize| self.constant * self.charge[index] * self.units[0] / (self.length * self.length);
        let slots = (BlockedSlice::new(&mut self.force, BLOCK), BlockedSlice::new(&mut self.work, BLOCK));
        executor.for_each_block(slots, &|(force, work)| {
            let (start, end) = (force.start, force.start + force.items.len());
            let mut sum = vec![DVec3::ZERO; force.items.len()];
            work.items.fill(0.0);
            for (group, sums) in &found {
                let [first, last] = [start, end].map(|index| group.targets.partition_point(|&target| target < index));
                for target in first..last {
                    let (index, sums) = (group.targets[target], &sums[target]);
                    sum[index - start] += scale(index) * field(sums);
                    work.items[index - start] += scale(index) * sums[WORK];
                }
            }
            force.items.iter_mut().zip(sum).for_each(|(force, sum)| *force = V::narrow(sum));
        });
        Ok(())
    }

    fn accumulate(&self, block: Range<usize>, _at: &StateView<'_, V>, rates: &mut Rates<'_, V>) {
        let power = &mut rates.power[EnergySink::Work as usize];
        for (lane, index) in (block.start..block.end.min(self.force.len())).enumerate() {
            rates.force.set(lane, rates.force.get(lane) + self.force[index]);
            power[index % LANES] += self.work[index];
        }
    }

    /// Computed in double precision, in every precision of the run.
    fn potentials(&self, at: &StateView<'_, V>, sums: &mut [f64]) {
        self.groups.iter().for_each(|group| self.energies(group, at, |index, energy| sums[index] -= self.energy_unit() * energy));
    }

    /// Computed in double precision, in every precision of the run.
    fn energy(&self, at: &StateView<'_, V>, ledger: &mut Ledger) -> Result<()> {
        let mut energy = 0.0;
        for group in &self.groups {
            // Each mutual pair is summed from both ends.
            let share = if group.mutual { 0.5 } else { 1.0 };
            self.energies(group, at, |_, of_target| energy -= share * of_target);
            at.executor.check()?;
        }
        ledger.add(Class::Potential, self.name, self.energy_unit() * energy);
        Ok(())
    }

    /// The largest stiffness of such a force is unknown. The frequency of the fastest orbit limits the accuracy: in the present
    /// state, and among few particles also at the next periapsis.
    fn bound(&self, at: &StateView<'_, V>, bound: &mut SpectralBound) -> Result<()> {
        let ahead = if bound.horizon() == Horizon::Present || !self.is_few() { 0.0 } else { self.frequency_squared_ahead(at) };
        let frequency_squared = self.frequency_squared(at).max(ahead);
        if frequency_squared > 0.0 && frequency_squared.is_finite() {
            bound.accuracy(self.name, TAU / frequency_squared.sqrt() / STEPS_PER_TURN);
        }
        Ok(())
    }

    fn validity(&self, _at: &StateView<'_, V>, horizon: Horizon) -> Validity {
        if horizon == Horizon::Present || self.is_few() { Validity::Now } else { Validity::Always }
    }

    fn derivatives(&mut self) -> Option<&mut dyn Derivatives> {
        if self.has_derivatives() { Some(self) } else { None }
    }
}
