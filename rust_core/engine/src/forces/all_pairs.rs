//! The inverse-square force between all pairs, the common law of gravitation and of Coulomb: Fᵢ = −κ cᵢ Σⱼ cⱼ d/s³ with
//! d = xᵢ − xⱼ and s² = |d|² + ε², and the potential energy −κ cᵢcⱼ/s of a pair.
//!
//! The charge c is the mass and κ = G for gravitation; it is the electric charge and κ = −k for Coulomb's law. Source for
//! the softening: H. C. Plummer, Mon. Not. R. Astron. Soc. 71 (1911) 460.
//!
//! Lengths and charges are computed in units of powers of two, those of the largest at the start: distances and their
//! cubes in SI units may be out of the range of f32.

mod expansion;
mod sums;
mod tree;

use std::f64::consts::TAU;
use std::ops::Range;

use glam::DVec3;

use super::{About, Declared, Force, Forces, Kind, Rates, Reach, StateView, Validity};
use crate::error::{Error, Result};
use crate::history::History;
use crate::ledger::{Class, Ledger};
use crate::math::{AXES, Real, Vector};
use crate::matter::{Columns, EnergySink, View};
use crate::parallel::{BlockedSlice, Executor, SERIAL};
use crate::scene::{Item, Scene, Value};
use crate::simd::{LANES, Number, Record, WORDS};
use crate::stability::{Horizon, SpectralBound};
use expansion::Multipole;
use sums::SourceLaw;
use tree::{Body, Tree};

/// Steps per period of the fastest orbit at an automatic time step.
const STEPS_PER_TURN: f64 = 100.0;

/// The largest opening angle that is chosen.
const LARGEST_ANGLE: f64 = 1.0;

/// The smallest one for which a tree is worth more than the exact sum.
const SMALLEST_ANGLE: f64 = 0.1;

/// About the power of the opening angle with which the error grows.
const ERROR_ORDER: f64 = 3.8;

/// Maximum number of bodies on which the error is measured.
const SAMPLE: usize = 1000;

/// Pairs of targets and sources.
struct Group {
    /// The particles that feel the force.
    targets: Vec<usize>,
    /// The particles that exert it.
    sources: Vec<usize>,
    /// Whether each of these acts on each other, so that targets and sources are the same particles; else the sources do not
    /// feel the targets.
    mutual: bool,
}

/// An inverse-square force between all pairs.
struct AllPairs<V: Vector> {
    name: &'static str,
    /// Path of the item.
    path: String,
    /// The constant κ.
    constant: f64,
    /// Softening length ε [m].
    softening: f64,
    /// Charge c of each particle.
    charge: Vec<f64>,
    groups: Vec<Group>,
    /// Opening angle θ of the tree; 0 for the exact sum.
    angle: f64,
    /// Relative rms error of the acceleration at the start.
    force_error: f64,
    /// Interactions of targets with cells and bodies at the start.
    pairs: usize,
    /// Unit of length, a power of two [m].
    length: f64,
    /// Units of the charges and of charges per mass, powers of two.
    units: [f64; 2],
    /// Forces of the last evaluation [N].
    force: Columns<V>,
    /// Power of the last evaluation that holds one-sided sources on their paths [W].
    work: Vec<f64>,
}

/// The registry's entry for gravitation.
pub fn gravitation<V: Vector>() -> Kind<V> {
    let build = |declared: &Declared<'_, V>| -> Result<Forces<V>> {
        let mass: Vec<f64> = declared.scene.bodies.iter().flat_map(|body| &body.mass).copied().collect();
        let mass = declared.properties.caller.iter().map(|&caller| mass[caller as usize]).collect();
        let constant = declared.item.non_negative("constant")?;
        Ok(vec![Box::new(AllPairs::<V>::new(declared, "gravitation", constant, mass)?)])
    };
    Kind { name: "Gravitation", reach: Reach::Far, build }
}

/// The registry's entry for Coulomb's law.
pub fn coulomb<V: Vector>() -> Kind<V> {
    let build = |declared: &Declared<'_, V>| -> Result<Forces<V>> {
        let constant = declared.item.non_negative("constant")?;
        Ok(vec![Box::new(AllPairs::<V>::new(declared, "coulomb", -constant, declared.properties.charge.clone())?)])
    };
    Kind { name: "Coulomb", reach: Reach::Far, build }
}

/// Whether each particle, in the engine's order, is in a body that an item names as a source.
fn sources<V: Vector>(declared: &Declared<'_, V>) -> Result<Vec<bool>> {
    let Declared { scene, item, properties, .. } = declared;
    let on = match item.values.get("sources") {
        None => None,
        Some(Value::Indices(array)) => Some(array.entries.iter().map(|&body| body as usize).collect()),
        other => return Err(item.wrong("sources", "indices of bodies", other)),
    };
    let in_scene = scene.members(&Item { on, ..Item::default() });
    Ok(properties.caller.iter().map(|&caller| in_scene[caller as usize]).collect())
}

/// The largest power of two that is at most the largest |number|; 1 without any but 0.
fn unit(numbers: impl Iterator<Item = f64>) -> f64 {
    const EXPONENT: u64 = 0x7ff0_0000_0000_0000;
    let largest = numbers.map(f64::abs).filter(|number| number.is_finite()).fold(0.0, f64::max);
    if largest < f64::MIN_POSITIVE { 1.0 } else { f64::from_bits(largest.to_bits() & EXPONENT) }
}

/// The pairs that act: those among the particles that are targets and sources, and those of one-sided sources.
fn groups(targets: &[bool], sources: &[bool]) -> Vec<Group> {
    let of = |fits: &dyn Fn(bool, bool) -> bool| -> Vec<usize> {
        (0..targets.len()).filter(|&index| fits(targets[index], sources[index])).collect()
    };
    let [both, only_targets, only_sources] = [of(&|t, s| t && s), of(&|t, s| t && !s), of(&|t, s| !t && s)];
    let group = |targets: &[usize], sources: Vec<usize>, mutual| Group { targets: targets.to_vec(), sources, mutual };
    let all = [group(&both, both.clone(), true), group(&both, only_sources, false), group(&only_targets, of(&|_, s| s), false)];
    all.into_iter().filter(|group| !group.targets.is_empty() && !group.sources.is_empty()).collect()
}

impl<V: Vector> AllPairs<V> {
    /// The force of an item with the constant κ, for particles of these charges.
    fn new(declared: &Declared<'_, V>, name: &'static str, constant: f64, charge: Vec<f64>) -> Result<Self> {
        let Declared { scene, item, properties, chosen } = declared;
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
            charge,
            angle: 0.0,
            force_error: 0.0,
            pairs: 0,
            force: Columns::zeros(properties.count()),
            work: vec![0.0; properties.count()],
        };
        force.choose_angle(declared)?;
        Ok(force)
    }

    /// Takes the opening angle of the item, or for "auto" the largest whose error stays below the wished one, and measures the
    /// error in the scene as it starts.
    fn choose_angle(&mut self, declared: &Declared<'_, V>) -> Result<()> {
        let Declared { scene, item, properties, .. } = declared;
        let (start, origin) = (scene.positions(), properties.origin);
        let count = properties.count();
        let position = Columns::from_fn(count, |index| V::narrow(start[properties.caller[index] as usize] - origin));
        let velocity = Columns::zeros(count);
        let (position, velocity) = (position.view(), velocity.view());
        let at = StateView { position, velocity, residual: View::default(), properties, time: 0.0, executor: &SERIAL };
        let wished = match item.values.get("opening_angle") {
            Some(Value::Text(text)) if text == "auto" => Some(item.number("force_error")?),
            _ => None,
        };
        self.angle = if wished.is_some() { LARGEST_ANGLE } else { item.non_negative("opening_angle")? };
        (self.force_error, self.pairs) = self.measure(&at);
        while let Some(wished) = wished.filter(|&wished| self.force_error > wished) {
            // Not too far at once: the error's order is only about this.
            self.angle *= libm::pow(wished / self.force_error, 1.0 / ERROR_ORDER).clamp(0.5, 0.95);
            if !(self.angle > SMALLEST_ANGLE) {
                self.angle = 0.0;
            }
            (self.force_error, self.pairs) = self.measure(&at);
        }
        Ok(())
    }

    /// The rms error of the acceleration over its rms, on some of the targets, and the number of interactions.
    fn measure(&mut self, at: &StateView<'_, V>) -> (f64, usize) {
        let angle = self.angle;
        if angle == 0.0 {
            return (0.0, self.groups.iter().map(|group| group.targets.len() * group.sources.len()).sum());
        }
        let count = at.properties.count();
        let (mut exact, mut error, mut pairs) = (vec![DVec3::ZERO; count], vec![DVec3::ZERO; count], 0);
        let field = |sums: &[f64; SUMS]| DVec3::new(sums[0], sums[1], sums[2]);
        for group in &self.groups {
            let (sums, interactions) = self.attraction::<V::Scalar>(group, at, at.executor);
            pairs += interactions;
            for (&index, sums) in group.targets.iter().zip(&sums) {
                error[index] += field(sums);
            }
        }
        self.angle = 0.0;
        let stride = count.div_ceil(SAMPLE).max(1);
        for group in &self.groups {
            let targets = group.targets.iter().copied().filter(|index| index % stride == 0).collect();
            let sample = Group { targets, sources: group.sources.clone(), mutual: group.mutual };
            let (sums, _) = self.attraction::<f64>(&sample, at, at.executor);
            for (&index, sums) in sample.targets.iter().zip(&sums) {
                exact[index] += field(sums);
            }
        }
        self.angle = angle;
        let (mut difference, mut size) = (0.0, 0.0);
        for index in (0..count).step_by(stride) {
            let per_mass = self.charge[index] / self.units[0] / at.properties.mass[index];
            difference += ((error[index] - exact[index]) * per_mass).length_squared();
            size += (exact[index] * per_mass).length_squared();
        }
        (if size > 0.0 { (difference / size).sqrt() } else { 0.0 }, pairs)
    }

    /// The position of a particle in units of length.
    fn place(&self, index: usize, at: &StateView<'_, V>) -> DVec3 {
        at.position.get(index).widen() / self.length
    }

    /// Positions of some particles in units of length, in the precision of a sum.
    fn positions<T: Real>(&self, particles: &[usize], at: &StateView<'_, V>) -> Vec<[T; AXES]> {
        let scaled = |index: usize| (at.position.get(index).widen() / self.length).to_array().map(T::from_f64);
        particles.iter().map(|&index| scaled(index)).collect()
    }

    /// The records of some particles as sources: their positions, and the words that follow.
    fn records<T: Real, const N: usize>(
        &self,
        sources: &[usize],
        at: &StateView<'_, V>,
        words: impl Fn(usize) -> [f64; N],
    ) -> Vec<Record<T>> {
        let record = |(position, &index): ([T; AXES], &usize)| {
            let mut record = [T::ZERO; WORDS];
            record[..AXES].copy_from_slice(&position);
            record[AXES..AXES + N].copy_from_slice(&words(index).map(T::from_f64));
            record
        };
        self.positions(sources, at).into_iter().zip(sources).map(record).collect()
    }

    /// The sums of [`Attraction`] for the targets of a group, and the number of interactions.
    fn attraction<T: Real>(&self, group: &Group, at: &StateView<'_, V>, executor: &Executor) -> (Vec<[f64; SUMS]>, usize) {
        let square = T::from_f64((self.softening / self.length) * (self.softening / self.length));
        match (square > T::ZERO, group.mutual) {
            (true, true) => self.sums::<T, true, false>(square, group, at, executor),
            (false, true) => self.sums::<T, false, false>(square, group, at, executor),
            (true, false) => self.sums::<T, true, true>(square, group, at, executor),
            (false, false) => self.sums::<T, false, true>(square, group, at, executor),
        }
    }

    /// The same, exact or by the tree.
    fn sums<T: Real, const SOFTENED: bool, const ONE_SIDED: bool>(
        &self,
        square: T,
        group: &Group,
        at: &StateView<'_, V>,
        executor: &Executor,
    ) -> (Vec<[f64; SUMS]>, usize) {
        let law = Attraction::<T, SOFTENED, ONE_SIDED>(square);
        if self.angle > 0.0 {
            let body = |index: usize| Body {
                position: self.place(index, at),
                charge: self.charge[index] / self.units[0],
                velocity: at.velocity.get(index).widen(),
            };
            return self.tree_sums(law, Multipole::<T, ONE_SIDED>(square), group, body, at, executor);
        }
        let targets = self.positions::<T>(&group.targets, at);
        let sources = self.records::<T, 4>(&group.sources, at, |index| {
            let [x, y, z] = at.velocity.get(index).widen().to_array();
            [self.charge[index] / self.units[0], x, y, z]
        });
        (sums::sum(V::DIMENSION, law, &targets, &sources, executor), group.targets.len() * group.sources.len())
    }

    /// The same by the tree: one list of cells and bodies for each group of targets that follow each other in Morton order.
    fn tree_sums<T: Real, L: SourceLaw<T, WORDS, N>, M: SourceLaw<T, { expansion::WORDS }, N>, const N: usize>(
        &self,
        near: L,
        far: M,
        group: &Group,
        body: impl Fn(usize) -> Body,
        at: &StateView<'_, V>,
        executor: &Executor,
    ) -> (Vec<[f64; N]>, usize) {
        let place = |index: usize| self.place(index, at);
        let sources: Vec<Body> = group.sources.iter().map(|&index| body(index)).collect();
        let tree = Tree::new(&sources, V::DIMENSION, executor);
        let order: Vec<u32> = if group.mutual {
            tree.order.clone()
        } else {
            let positions: Vec<DVec3> = group.targets.iter().map(|&index| place(index)).collect();
            tree::morton_order(&positions, V::DIMENSION, executor).0.into_iter().map(|key| key.1).collect()
        };
        let sorted: Vec<usize> = order.iter().map(|&index| group.targets[index as usize]).collect();
        let record = |body: &Body| {
            let [[x, y, z], [u, v, w]] = [body.position, body.velocity].map(DVec3::to_array);
            [x, y, z, body.charge, u, v, w, 0.0].map(T::from_f64)
        };
        let records: Vec<Record<T>> = tree.bodies.iter().map(record).collect();
        let mut found = vec![([0.0; N], 0_usize); sorted.len()];
        executor.for_each_block(BlockedSlice::new(&mut found, sums::BLOCK), &|mine| {
            let members = mine.start..mine.start + mine.items.len();
            let places: Vec<DVec3> = sorted[members.clone()].iter().map(|&index| place(index)).collect();
            let low = places.iter().copied().fold(DVec3::INFINITY, DVec3::min);
            let high = places.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
            let own = if group.mutual { members } else { 0..0 };
            let (mut cells, mut bodies) = (Vec::new(), Vec::new());
            let whole = |cell: &tree::Cell| cells.push(cell.moments.words::<T>());
            tree.walk(low, high, self.angle, &own, whole, |range| bodies.extend_from_slice(&records[range]));
            let targets: Vec<[T; AXES]> = places.iter().map(|place| place.to_array().map(T::from_f64)).collect();
            let mut sums = vec![[0.0; N]; targets.len()];
            sums::add(V::DIMENSION, near, &targets, &bodies, &mut sums);
            sums::add(V::DIMENSION, far, &targets, &cells, &mut sums);
            for (slot, sums) in mine.items.iter_mut().zip(sums) {
                *slot = (sums, cells.len() + bodies.len());
            }
        });
        let mut sums = vec![[0.0; N]; sorted.len()];
        let mut pairs = 0;
        for (&index, (found, count)) in order.iter().zip(found) {
            sums[index as usize] = found;
            pairs += count;
        }
        (sums, pairs)
    }

    /// The error that a target coincides with a source.
    fn coincidence(&self, group: &Group, target: usize, at: &StateView<'_, V>) -> Error {
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

    /// The largest squared frequency of the relative motion of a target and its sources [1/s²]: Σⱼ κ|cᵢcⱼ|(1/mᵢ + 1/mⱼ)/s³,
    /// for a pair that is alone the ω² of its circular orbit; one-sided sources count as infinitely heavy.
    fn frequency_squared(&self, at: &StateView<'_, V>) -> f64 {
        let square = V::Scalar::from_f64((self.softening / self.length) * (self.softening / self.length));
        let [charges, ratios] = self.units;
        let mass = &at.properties.mass;
        let mut largest = 0.0_f64;
        for group in &self.groups {
            let ratio = |index: usize| if group.mutual { 1.0 / mass[index] / ratios * charges } else { 0.0 };
            let sums = if self.angle > 0.0 {
                let body = |index: usize| Body {
                    position: self.place(index, at),
                    charge: self.charge[index].abs() / charges,
                    velocity: DVec3::new(ratio(index), 0.0, 0.0),
                };
                self.tree_sums(NearTide(square), FarTide(square), group, body, at, at.executor).0
            } else {
                let targets = self.positions(&group.targets, at);
                let sources = self.records(&group.sources, at, |index| {
                    let charge = self.charge[index].abs();
                    [charge / charges, if group.mutual { charge / mass[index] / ratios } else { 0.0 }]
                });
                sums::sum(V::DIMENSION, Tide(square), &targets, &sources, at.executor)
            };
            let mobile = group.targets.iter().zip(sums).filter(|&(&index, _)| !at.properties.is_fixed(index));
            largest = mobile.fold(largest, |largest, (&index, [by_charge, by_ratio])| {
                let charge = self.charge[index].abs();
                largest.max(charge / mass[index] * charges * by_charge + charge * ratios * by_ratio)
            });
        }
        self.constant.abs() / self.length.powi(3) * largest
    }
}

/// Refuses a periodic domain.
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
        About {
            pairs: self.pairs,
            force_error: self.force_error,
            bytes: self.force.bytes() + 8 * (self.charge.len() + self.work.len() + indices),
            layout: "the exact sum over all pairs, in both directions".to_owned(),
            ..About::new(self.name, Reach::Far)
        }
    }

    fn prepare(&mut self, at: &StateView<'_, V>, executor: &Executor) -> Result<()> {
        let mut force = vec![DVec3::ZERO; at.properties.count()];
        self.work.fill(0.0);
        for group in &self.groups {
            let sums = self.attraction::<V::Scalar>(group, at, executor).0;
            executor.check()?;
            // A particle coincides with itself.
            let expected = if group.mutual { 1.0 } else { 0.0 };
            if let Some(target) = sums.iter().position(|sums| self.softening == 0.0 && sums[COINCIDENT] > expected) {
                return Err(self.coincidence(group, target, at));
            }
            for (&index, sums) in group.targets.iter().zip(sums) {
                let scale = self.constant * self.charge[index] * self.units[0] / (self.length * self.length);
                force[index] += scale * DVec3::new(sums[0], sums[1], sums[2]);
                self.work[index] += scale * sums[WORK];
            }
        }
        force.into_iter().enumerate().for_each(|(index, force)| self.force.set(index, V::narrow(force)));
        Ok(())
    }

    fn accumulate(&self, block: Range<usize>, _at: &StateView<'_, V>, rates: &mut Rates<'_, V>) {
        let mine = self.force.view();
        for axis in 0..V::DIMENSION {
            let forces = mine.slice(axis, block.clone());
            rates.force.axes[axis].iter_mut().zip(forces).for_each(|(sum, &force)| *sum += force);
        }
        let power = &mut rates.power[EnergySink::Work as usize];
        for (index, work) in self.work.iter().enumerate().take(block.end).skip(block.start) {
            power[index % LANES] += work;
        }
    }

    /// In double precision, whatever that of the run.
    fn energy(&self, at: &StateView<'_, V>, ledger: &mut Ledger) -> Result<()> {
        let mut energy = 0.0;
        for group in &self.groups {
            let sums = self.attraction::<f64>(group, at, at.executor).0;
            at.executor.check()?;
            // Each mutual pair is summed from both ends, and with softening each particle with itself.
            let share = if group.mutual { 0.5 } else { 1.0 };
            for (&index, sums) in group.targets.iter().zip(sums) {
                let charge = self.charge[index] / self.units[0];
                let itself = if group.mutual && self.softening > 0.0 { charge * (self.length / self.softening) } else { 0.0 };
                energy -= share * charge * (sums[POTENTIAL] - itself);
            }
        }
        ledger.add(Class::Potential, self.name, self.constant * self.units[0] * self.units[0] / self.length * energy);
        Ok(())
    }

    /// No largest stiffness is known of such a force: it limits the accuracy, by the frequency of the fastest orbit.
    fn bound(&self, at: &StateView<'_, V>, bound: &mut SpectralBound) -> Result<()> {
        let frequency_squared = self.frequency_squared(at);
        if frequency_squared > 0.0 && frequency_squared.is_finite() {
            bound.accuracy(self.name, TAU / frequency_squared.sqrt() / STEPS_PER_TURN);
        }
        Ok(())
    }

    fn validity(&self, _at: &StateView<'_, V>, horizon: Horizon) -> Validity {
        if horizon == Horizon::Present { Validity::Now } else { Validity::Always }
    }
}

/// The sums of [`Attraction`]: the field along each axis, the potential, the power of one-sided sources, and the sources at
/// zero distance.
const SUMS: usize = AXES + 3;
const POTENTIAL: usize = AXES;
const WORK: usize = AXES + 1;
const COINCIDENT: usize = AXES + 2;

/// Field Σ cⱼ d/s³ toward the sources and potential Σ cⱼ/s, with the square of the softening; without it a source at zero
/// distance has no terms but is counted. `ONE_SIDED` adds the power Σ cⱼ d·vⱼ/s³.
#[derive(Debug, Clone, Copy)]
struct Attraction<T, const SOFTENED: bool, const ONE_SIDED: bool>(T);

impl<T: Real, const SOFTENED: bool, const ONE_SIDED: bool> SourceLaw<T, WORDS, SUMS> for Attraction<T, SOFTENED, ONE_SIDED> {
    #[inline(always)]
    fn terms<N: Number<Scalar = T>>(&self, offset: [N; AXES], square: N, source: &Record<N>) -> [N; SUMS] {
        let (zero, one) = (N::constant(0.0), N::constant(1.0));
        let softened = if SOFTENED { square + N::of(self.0) } else { square };
        let mut inverse = one / softened.sqrt();
        let mut terms = [zero; SUMS];
        if !SOFTENED {
            let apart = zero.less(square);
            inverse = N::select(apart, inverse, zero);
            terms[COINCIDENT] = N::select(apart, zero, one);
        }
        terms[POTENTIAL] = source[AXES] * inverse;
        let strength = terms[POTENTIAL] * (inverse * inverse);
        for axis in 0..AXES {
            terms[axis] = strength * offset[axis];
            if ONE_SIDED {
                terms[WORK] += terms[axis] * source[AXES + 1 + axis];
            }
        }
        terms
    }
}

/// The sums Σ wⱼ/s³ of two words of each source at another place, with the square of the softening.
#[derive(Debug, Clone, Copy)]
struct Tide<T>(T);

impl<T: Real> SourceLaw<T, WORDS, 2> for Tide<T> {
    #[inline(always)]
    fn terms<N: Number<Scalar = T>>(&self, _offset: [N; AXES], square: N, source: &Record<N>) -> [N; 2] {
        let zero = N::constant(0.0);
        let softened = square + N::of(self.0);
        let cube = N::select(zero.less(square), N::constant(1.0) / (softened * softened.sqrt()), zero);
        [source[AXES] * cube, source[AXES + 1] * cube]
    }
}

/// The sums of [`Tide`] for bodies whose second word is per charge.
#[derive(Debug, Clone, Copy)]
struct NearTide<T>(T);

impl<T: Real> SourceLaw<T, WORDS, 2> for NearTide<T> {
    #[inline(always)]
    fn terms<N: Number<Scalar = T>>(&self, offset: [N; AXES], square: N, source: &Record<N>) -> [N; 2] {
        let mut source = *source;
        source[AXES + 1] = source[AXES] * source[AXES + 1];
        Tide(self.0).terms(offset, square, &source)
    }
}

/// The sums of [`Tide`] for cells: those of their total charges.
#[derive(Debug, Clone, Copy)]
struct FarTide<T>(T);

impl<T: Real> SourceLaw<T, { expansion::WORDS }, 2> for FarTide<T> {
    #[inline(always)]
    fn terms<N: Number<Scalar = T>>(&self, offset: [N; AXES], square: N, source: &[N; expansion::WORDS]) -> [N; 2] {
        let mut record = [N::constant(0.0); WORDS];
        record[AXES] = source[AXES];
        record[AXES + 1] = source[expansion::CURRENT];
        Tide(self.0).terms(offset, square, &record)
    }
}
