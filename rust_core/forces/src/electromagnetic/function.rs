//! Fields as user-defined functions of time and positions, called for all particles at once.

use std::ops::Range;
use std::sync::Arc;

use glam::DVec3;

use super::{NAME, charges};
use crate::error::{Error, Result};
use crate::history::History;
use crate::ledger::{Class, Ledger};
use crate::math::{Real, Vector};
use crate::matter::EnergySink;
use crate::parallel::Executor;
use crate::placed::PlacedFunction;
use crate::scene::{Argument, Callback};
use crate::simd::LANES;
use crate::stability::{Horizon, SpectralBound};
use crate::{About, Declared, Force, Rates, Reach, StateView, Strength, Validity, VelocityDependence};

/// Field of a user-defined function, with its values times the charge at the particles.
struct FunctionField<V: Vector> {
    function: PlacedFunction,
    /// Engine indices of the particles, in the caller's order.
    members: Vec<usize>,
    charges: Vec<V::Scalar>,
    /// Values q E [N] or q B [C·T] at each particle, of the last evaluation.
    values: Vec<DVec3>,
}

impl<V: Vector> FunctionField<V> {
    fn new(declared: &Declared<'_, V>, name: &str, function: &Arc<dyn Callback>) -> Self {
        Self {
            function: PlacedFunction {
                function: Arc::clone(function),
                path: format!("{}.{name}", declared.item.path),
                what: "the field",
                dimension: V::DIMENSION,
                axial: name == "magnetic" && V::DIMENSION == 2,
            },
            members: declared.members(),
            charges: charges(declared),
            values: vec![DVec3::ZERO; declared.chosen.len()],
        }
    }

    fn about(&self) -> About {
        About {
            callback: true,
            bytes: size_of_val(self.values.as_slice()) + size_of_val(self.charges.as_slice()),
            layout: "a function, called in every evaluation".to_owned(),
            ..About::new(NAME, Reach::Whole)
        }
    }

    fn prepare(&mut self, at: &StateView<'_, V>) -> Result<()> {
        if self.members.is_empty() {
            return Ok(());
        }
        let fields = self.function.at(at.time, &at.places(&self.members))?;
        for (&index, field) in self.members.iter().zip(fields) {
            self.values[index] = self.charges[index].to_f64() * field;
        }
        Ok(())
    }

    /// Particles of a block, each with its index in the block.
    fn particles(&self, block: Range<usize>) -> impl Iterator<Item = (usize, usize)> {
        let start = block.start;
        (start..block.end.min(self.values.len())).map(move |index| (index - start, index))
    }
}

/// The force q E. Without a potential, all its power counts as external work.
pub struct ElectricFunction<V: Vector> {
    field: FunctionField<V>,
    potential: Option<Arc<dyn Callback>>,
    path: String,
}

impl<V: Vector> ElectricFunction<V> {
    /// Force of an item.
    #[inline]
    pub fn new(declared: &Declared<'_, V>, function: &Arc<dyn Callback>) -> Result<Self> {
        let potential = declared.item.optional_callback("potential")?;
        let path = format!("{}.potential", declared.item.path);
        Ok(Self { field: FunctionField::new(declared, "electric", function), potential, path })
    }
}

impl<V: Vector> History for ElectricFunction<V> {}

impl<V: Vector> Force<V> for ElectricFunction<V> {
    fn about(&self) -> About {
        About { potential: self.potential.is_some().then_some(NAME), ..self.field.about() }
    }

    fn prepare(&mut self, at: &StateView<'_, V>, _executor: &Executor) -> Result<()> {
        self.field.prepare(at)
    }

    fn accumulate(&self, block: Range<usize>, at: &StateView<'_, V>, rates: &mut Rates<'_, V>) {
        for (place, index) in self.field.particles(block) {
            let force = self.field.values[index];
            rates.force.set(place, V::narrow(rates.force.get(place).widen() + force));
            if self.potential.is_none() {
                rates.power[EnergySink::Work as usize][place % LANES] += force.dot(at.velocity.get(index).widen());
            }
        }
    }

    fn energy(&self, at: &StateView<'_, V>, ledger: &mut Ledger) -> Result<()> {
        let Some(potential) = &self.potential else { return Ok(()) };
        if self.field.members.is_empty() {
            return Ok(());
        }
        let energy = potential.call(&[Argument::Vectors(&at.places(&self.field.members))], "one energy", &[]);
        let energy = energy.map_err(|failure| failure.at(self.path.clone()))?.first().copied().unwrap_or(f64::NAN);
        if !energy.is_finite() {
            return Err(Error::undefined(self.path.clone(), "a finite energy", format!("{energy} J")));
        }
        ledger.add(Class::Potential, NAME, energy);
        Ok(())
    }

    /// Norm of the gradient of the field by central differences, times the charge.
    fn bound(&self, at: &StateView<'_, V>, bound: &mut SpectralBound) -> Result<()> {
        let norms = self.field.function.gradient_norms(at.time, &at.places(&self.field.members))?;
        for (&index, norm) in self.field.members.iter().zip(norms) {
            let stiffness = norm * self.field.charges[index].to_f64().abs();
            if stiffness > 0.0 {
                bound.point(index, NAME, stiffness, 0.0);
            }
        }
        Ok(())
    }

    fn validity(&self, _at: &StateView<'_, V>, _horizon: Horizon) -> Validity {
        Validity::Now
    }
}

/// The force q v × B.
pub struct MagneticFunction<V: Vector>(FunctionField<V>);

impl<V: Vector> MagneticFunction<V> {
    /// Force of an item.
    #[inline]
    pub fn new(declared: &Declared<'_, V>, function: &Arc<dyn Callback>) -> Self {
        Self(FunctionField::new(declared, "magnetic", function))
    }
}

impl<V: Vector> History for MagneticFunction<V> {}

impl<V: Vector> Force<V> for MagneticFunction<V> {
    fn about(&self) -> About {
        About { velocity: VelocityDependence::Gyroscopic, potential: None, ..self.0.about() }
    }

    fn prepare(&mut self, at: &StateView<'_, V>, _executor: &Executor) -> Result<()> {
        self.0.prepare(at)
    }

    fn accumulate(&self, block: Range<usize>, at: &StateView<'_, V>, rates: &mut Rates<'_, V>) {
        for (place, index) in self.0.particles(block) {
            let force = at.velocity.get(index).widen().cross(self.0.values[index]);
            rates.force.set(place, V::narrow(rates.force.get(place).widen() + force));
        }
    }

    fn magnetic(&self, block: Range<usize>, _at: &StateView<'_, V>, strength: &mut Strength<V>) {
        for (place, index) in self.0.particles(block) {
            strength.add(place, self.0.values[index]);
        }
    }

    fn bound(&self, at: &StateView<'_, V>, bound: &mut SpectralBound) -> Result<()> {
        if self.0.members.is_empty() {
            return Ok(());
        }
        let fields = self.0.function.at(at.time, &at.places(&self.0.members))?;
        for (&index, field) in self.0.members.iter().zip(fields) {
            bound.gyration(index, self.0.charges[index].to_f64().abs() * field.length());
        }
        Ok(())
    }

    fn validity(&self, _at: &StateView<'_, V>, _horizon: Horizon) -> Validity {
        Validity::Now
    }
}
