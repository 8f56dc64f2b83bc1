//! Charges in an electric and a magnetic field: F = q (E + v × B). In 2D, B is its component along z.
//!
//! Each field is a sum of fields that the engine computes ([`laws`]), or a user-defined function ([`function`]). The magnetic
//! force does no work. Boris' method rotates velocities by q B ([`Force::magnetic`]); any other integrator takes the force.
//!
//! Source: J. D. Jackson, Classical Electrodynamics, 3rd edition (1999), § 6.7 and § 12.1.

mod function;

use std::ops::Range;
use std::sync::Arc;

use glam::DVec3;

use super::pointwise::{self, ForceField, PointRate};
use super::{About, Declared, Force, ForceKind, Forces, PART, Rates, Reach, StateView, Strength, Validity, VelocityDependence};
use crate::error::Result;
use crate::history::History;
use crate::math::{AXES, Real, Vector};
use crate::scene::Value;
use crate::simd::LANES;
use crate::stability::{Horizon, SpectralBound};
use function::{ElectricFunction, MagneticFunction};
use physcore_matter::forces::{ElectromagneticLaw, FieldLaw, ReadyField, Use, times};

/// Name in plans and energy budgets.
const NAME: &str = "electromagnetic field";
/// Steps per period of a time-dependent field at an automatic time step.
const STEPS_PER_PERIOD: f64 = 50.0;

/// Entry in the registry of forces.
pub fn kind<V: Vector>() -> ForceKind<V> {
    let build = |declared: &Declared<'_, V>| -> Result<Forces<V>> {
        let mut forces: Forces<V> = Vec::new();
        let charges: Arc<[V::Scalar]> = charges(declared).into();
        let computed = |value: Option<&Value>| -> Result<Option<Computed<V>>> {
            let laws = laws(value)?;
            Ok((!laws.is_empty()).then(|| Computed { laws, charges: Arc::clone(&charges) }))
        };
        match declared.item.values.get("electric") {
            Some(Value::Callback(callback)) => forces.push(Box::new(ElectricFunction::new(declared, callback)?)),
            value => forces.extend(computed(value)?.map(|field| Box::new(Electric(field)) as Box<dyn Force<V>>)),
        }
        match declared.item.values.get("magnetic") {
            Some(Value::Callback(callback)) => forces.push(Box::new(MagneticFunction::new(declared, callback))),
            Some(&Value::Number(number)) if number != 0.0 => {
                let laws = vec![ElectromagneticLaw::Uniform(DVec3::Z * number)];
                forces.push(Box::new(Magnetic(Computed { laws, charges: Arc::clone(&charges) })));
            }
            value => forces.extend(computed(value)?.map(|field| Box::new(Magnetic(field)) as Box<dyn Force<V>>)),
        }
        Ok(forces)
    };
    ForceKind { name: "ElectromagneticField", reach: Reach::Pointwise, charges: true, build }
}

/// Fields that a value declares: a vector, a field, or a list of fields; empty if zero.
fn laws(value: Option<&Value>) -> Result<Vec<ElectromagneticLaw>> {
    Ok(match value {
        Some(&Value::Vector(vector)) if vector != DVec3::ZERO => vec![ElectromagneticLaw::Uniform(vector)],
        Some(Value::Record(item)) => vec![ElectromagneticLaw::new(item)?],
        Some(Value::Records(items)) => items.iter().map(ElectromagneticLaw::new).collect::<Result<_>>()?,
        _ => Vec::new(),
    })
}

/// Charges [C] of the particles that a force acts on, in the engine's order; 0 for all other and for fixed particles. Padded.
fn charges<V: Vector>(declared: &Declared<'_, V>) -> Vec<V::Scalar> {
    let mut charges = declared.mask();
    for (charge, &given) in charges.iter_mut().zip(&declared.properties.charge) {
        *charge = if *charge == V::Scalar::ZERO { V::Scalar::ZERO } else { V::Scalar::from_f64(given) };
    }
    charges
}

/// Sum of fields that the engine computes.
struct Computed<V: Vector> {
    laws: Vec<ElectromagneticLaw>,
    charges: Arc<[V::Scalar]>,
}

impl<V: Vector> Computed<V> {
    fn ready(&self, is_magnetic: bool) -> Option<ReadyField<'_, V::Scalar>> {
        let &[law] = self.laws.as_slice() else { return None };
        (law.period() == f64::INFINITY).then(|| ReadyField { law, charges: &self.charges, is_magnetic })
    }

    fn about(&self) -> About {
        About { bytes: size_of_val(&*self.charges), ..About::new(NAME, Reach::Pointwise) }
    }

    /// Adds the contribution `role` of each law to the forces and powers of a block.
    fn accumulate(&self, role: Role, block: Range<usize>, at: &StateView<'_, V>, rates: &mut Rates<'_, V>) {
        for &law in &self.laws {
            let sum = FieldSum { role, charges: &self.charges, block: block.clone(), at, rates: rates.reborrow() };
            law.with(at.time, at.properties.origin, sum);
        }
    }
}

/// Contribution of a field to a charge.
#[derive(Debug, Clone, Copy)]
enum Role {
    /// The force q E.
    Electric,
    /// The force q v × B.
    Magnetic,
    /// The strength q B.
    Strength,
}

/// Sum over the particles of a block.
struct FieldSum<'a, 'b, V: Vector> {
    role: Role,
    charges: &'a [V::Scalar],
    block: Range<usize>,
    at: &'a StateView<'b, V>,
    rates: Rates<'a, V>,
}

impl<V: Vector> Use<V::Scalar> for FieldSum<'_, '_, V> {
    fn with(self, law: impl FieldLaw<V::Scalar>) {
        let Self { role, charges, block, at, mut rates } = self;
        match role {
            Role::Electric => pointwise::accumulate::<V>(ElectricLaw(law), charges, block, at, &mut rates),
            Role::Magnetic => pointwise::accumulate::<V>(MagneticLaw(law), charges, block, at, &mut rates),
            Role::Strength => pointwise::accumulate::<V>(StrengthLaw(law), charges, block, at, &mut rates),
        }
    }
}

#[derive(Clone, Copy)]
struct ElectricLaw<L>(L);

impl<V: Vector, L: FieldLaw<V::Scalar>> ForceField<V> for ElectricLaw<L> {
    #[inline(always)]
    fn at(&self, charge: V::Scalar, x: [V::Scalar; AXES], v: [V::Scalar; AXES]) -> PointRate<V::Scalar> {
        let force = times(charge, self.0.at(x));
        PointRate { force, dissipated: V::Scalar::ZERO, work: charge * self.0.power(x, v) }
    }
}

#[derive(Clone, Copy)]
struct MagneticLaw<L>(L);

impl<V: Vector, L: FieldLaw<V::Scalar>> ForceField<V> for MagneticLaw<L> {
    #[inline(always)]
    fn at(&self, charge: V::Scalar, x: [V::Scalar; AXES], v: [V::Scalar; AXES]) -> PointRate<V::Scalar> {
        let strength = times(charge, self.0.at(x));
        PointRate { force: cross(v, strength), dissipated: V::Scalar::ZERO, work: V::Scalar::ZERO }
    }
}

/// In 2D the z component is stored in place of x.
#[derive(Clone, Copy)]
struct StrengthLaw<L>(L);

impl<V: Vector, L: FieldLaw<V::Scalar>> ForceField<V> for StrengthLaw<L> {
    #[inline(always)]
    fn at(&self, charge: V::Scalar, x: [V::Scalar; AXES], _v: [V::Scalar; AXES]) -> PointRate<V::Scalar> {
        let [x, y, z] = times(charge, self.0.at(x));
        let force = if V::DIMENSION == 2 { [z, V::Scalar::ZERO, V::Scalar::ZERO] } else { [x, y, z] };
        PointRate { force, dissipated: V::Scalar::ZERO, work: V::Scalar::ZERO }
    }
}

#[inline(always)]
fn cross<T: Real>(a: [T; AXES], b: [T; AXES]) -> [T; AXES] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The force q E of computed fields.
struct Electric<V: Vector>(Computed<V>);

impl<V: Vector> History for Electric<V> {}

impl<V: Vector> Force<V> for Electric<V> {
    fn about(&self) -> About {
        let potential = self.0.laws.iter().any(|law| law.is_conservative()).then_some(NAME);
        About { potential, ..self.0.about() }
    }

    fn accumulate(&self, block: Range<usize>, at: &StateView<'_, V>, rates: &mut Rates<'_, V>) {
        self.0.accumulate(Role::Electric, block, at, rates);
    }

    fn ready_field(&self) -> Option<ReadyField<'_, V::Scalar>> {
        self.0.ready(false)
    }

    fn potential(&self, block: Range<usize>, at: &StateView<'_, V>) -> f64 {
        let energy = |index: usize| {
            let place = at.properties.origin + at.position.get(index).widen();
            self.0.charges[index].to_f64() * self.0.laws.iter().map(|law| law.potential(place, at.time)).sum::<f64>()
        };
        block.filter(|&index| self.0.charges[index] != V::Scalar::ZERO).map(energy).sum()
    }

    fn bound(&self, at: &StateView<'_, V>, bound: &mut SpectralBound) -> Result<()> {
        let gradient: f64 = self.0.laws.iter().map(|law| law.gradient()).sum();
        for index in 0..at.properties.count() {
            let stiffness = gradient * self.0.charges[index].to_f64().abs();
            if stiffness > 0.0 {
                bound.point(index, NAME, stiffness, 0.0);
            }
        }
        let period = self.0.laws.iter().map(|law| law.period()).fold(f64::INFINITY, f64::min);
        if period.is_finite() {
            bound.accuracy(NAME, period / STEPS_PER_PERIOD);
        }
        Ok(())
    }

    fn validity(&self, _at: &StateView<'_, V>, _horizon: Horizon) -> Validity {
        Validity::Always
    }
}

/// The force q v × B of computed fields.
struct Magnetic<V: Vector>(Computed<V>);

impl<V: Vector> History for Magnetic<V> {}

impl<V: Vector> Force<V> for Magnetic<V> {
    fn about(&self) -> About {
        About { velocity: VelocityDependence::Gyroscopic, potential: None, ..self.0.about() }
    }

    fn accumulate(&self, block: Range<usize>, at: &StateView<'_, V>, rates: &mut Rates<'_, V>) {
        self.0.accumulate(Role::Magnetic, block, at, rates);
    }

    fn ready_field(&self) -> Option<ReadyField<'_, V::Scalar>> {
        self.0.ready(true)
    }

    fn magnetic(&self, block: Range<usize>, at: &StateView<'_, V>, strength: &mut Strength<V>) {
        let force = strength.span(block.len());
        let power = &mut Default::default();
        self.0.accumulate(Role::Strength, block, at, &mut Rates::new(force, power));
    }

    fn bound(&self, at: &StateView<'_, V>, bound: &mut SpectralBound) -> Result<()> {
        let count = at.properties.count();
        let mut strength = Strength::<V>::default();
        for start in (0..count).step_by(PART) {
            strength.clear();
            let block = start..(start + PART).min(count.next_multiple_of(LANES));
            self.magnetic(block.clone(), at, &mut strength);
            for index in block.start..block.end.min(count) {
                bound.gyration(index, strength.get(index - start).length());
            }
        }
        let period = self.0.laws.iter().map(|law| law.period()).fold(f64::INFINITY, f64::min);
        if period.is_finite() {
            bound.accuracy(NAME, period / STEPS_PER_PERIOD);
        }
        Ok(())
    }

    fn validity(&self, _at: &StateView<'_, V>, _horizon: Horizon) -> Validity {
        if self.0.laws.iter().all(|law| matches!(law, ElectromagneticLaw::Uniform(_))) { Validity::Always } else { Validity::Now }
    }
}
