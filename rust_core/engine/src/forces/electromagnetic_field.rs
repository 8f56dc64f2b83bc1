//! Charges in an electric and a magnetic field: F = q (E + v × B). In 2D, B is its component along z.
//!
//! The electric part is a pointwise force; that of a uniform E has the potential −q E·x. The magnetic part does no work. Boris'
//! method takes its strength, q B, to turn velocities; any other integrator takes its force.

use std::f64::consts::TAU;
use std::ops::Range;
use std::sync::Arc;

use glam::DVec3;

use super::{About, Declared, Force, Forces, Kind, Rates, Reach, StateView, Validity, VelocityDependence};
use crate::error::{Error, Result};
use crate::history::History;
use crate::ledger::{Class, Ledger};
use crate::math::Vector;
use crate::matter::EnergySink;
use crate::parallel::Executor;
use crate::scene::{Argument, Callback, Value};
use crate::simd::LANES;
use crate::stability::{Horizon, SpectralBound};

/// Steps per period of the gyration, 2πm/|qB|, at the limit of accuracy.
const STEPS_PER_TURN: f64 = 100.0;

/// A field as it is declared.
enum Source {
    /// The same everywhere.
    Uniform(DVec3),
    /// A function of time [s] and positions [m].
    Function(Arc<dyn Callback>),
}

/// One of the two fields, with its values at the particles.
struct Field<V: Vector> {
    source: Source,
    path: String,
    /// Whether its only component is that along z.
    axial: bool,
    /// The engine's indices of the charges, in the caller's order.
    members: Vec<usize>,
    /// The charge [C] of each particle in the engine's order; 0 for those that feel nothing.
    charge: Vec<f64>,
    /// Its values at the particles [V/m or T], of the last evaluation.
    values: Vec<DVec3>,
    dimension: std::marker::PhantomData<V>,
}

impl<V: Vector> Field<V> {
    /// A declared field, None if it is zero.
    fn new(declared: &Declared<'_, V>, name: &str) -> Result<Option<Self>> {
        let (item, properties) = (declared.item, declared.properties);
        let axial = name == "magnetic" && V::DIMENSION == 2;
        let source = match item.values.get(name) {
            Some(Value::Callback(function)) => Source::Function(Arc::clone(function)),
            Some(Value::Number(number)) if axial => Source::Uniform(DVec3::Z * *number),
            Some(Value::Vector(vector)) => Source::Uniform(*vector),
            _ => Source::Uniform(DVec3::ZERO),
        };
        if matches!(source, Source::Uniform(DVec3::ZERO)) {
            return Ok(None);
        }
        let mut engine = vec![0; declared.chosen.len()];
        properties.caller.iter().enumerate().for_each(|(index, &caller)| engine[caller as usize] = index);
        let mobile = declared.mobile();
        let charge: Vec<f64> =
            mobile.iter().zip(&properties.charge).map(|(&mobile, &charge)| if mobile { charge } else { 0.0 }).collect();
        let members = engine.into_iter().filter(|&index| declared.chosen[index]).collect();
        let start = if let Source::Uniform(vector) = source { vector } else { DVec3::ZERO };
        let values = vec![start; charge.len()];
        let path = format!("{}.{name}", item.path);
        Ok(Some(Self { source, path, axial, members, charge, values, dimension: std::marker::PhantomData }))
    }

    fn is_function(&self) -> bool {
        matches!(self.source, Source::Function(_))
    }

    fn about(&self) -> About {
        let function = self.is_function();
        About {
            callback: function,
            bytes: 32 * self.charge.len(),
            layout: if function { "a function, called in every evaluation".to_owned() } else { String::new() },
            ..About::new("electromagnetic field", if function { Reach::Whole } else { Reach::Pointwise })
        }
    }

    /// The values of a function at a state; finite.
    fn called(&self, at: &StateView<'_, V>) -> Result<Option<Vec<DVec3>>> {
        let Source::Function(function) = &self.source else { return Ok(None) };
        let mut values = vec![DVec3::ZERO; self.values.len()];
        if self.members.is_empty() {
            return Ok(Some(values));
        }
        let positions: Vec<DVec3> =
            self.members.iter().map(|&index| at.properties.origin + at.position.get(index).widen()).collect();
        let shape = [positions.len(), V::DIMENSION];
        let shape = if self.axial { &shape[..1] } else { &shape[..] };
        let arguments = [Argument::Number(at.time), Argument::Vectors(&positions)];
        let numbers = function.call(&arguments, "the field", shape).map_err(|failure| failure.at(self.path.clone()))?;
        let width = numbers.len() / positions.len();
        for (row, (&index, numbers)) in self.members.iter().zip(numbers.chunks_exact(width)).enumerate() {
            if let Some(found) = numbers.iter().find(|number| !number.is_finite()) {
                let place = &positions[row].to_array()[..V::DIMENSION];
                let found = format!("{found} in row {row}, for the particle at {place:?} m");
                return Err(Error::parameter(self.path.clone(), "a finite field", found));
            }
            let component = |axis: usize| numbers.get(axis).copied().unwrap_or(0.0);
            values[index] = if self.axial { DVec3::Z * numbers[0] } else { DVec3::new(component(0), component(1), component(2)) };
        }
        Ok(Some(values))
    }

    fn prepare(&mut self, at: &StateView<'_, V>) -> Result<()> {
        if let Some(values) = self.called(at)? {
            self.values = values;
        }
        Ok(())
    }

    /// The charge times the field at a particle.
    fn strength(&self, index: usize) -> DVec3 {
        self.values[index] * self.charge[index]
    }

    /// The particles of a block, with their places in it.
    fn charges(&self, block: Range<usize>) -> impl Iterator<Item = (usize, usize)> {
        let start = block.start;
        (start..block.end.min(self.charge.len())).map(move |index| (index - start, index))
    }
}

/// The force q E.
struct Electric<V: Vector> {
    field: Field<V>,
    potential: Option<Arc<dyn Callback>>,
    path: String,
}

/// The force q v × B.
struct Magnetic<V: Vector>(Field<V>);

/// The registry's entry.
pub fn kind<V: Vector>() -> Kind<V> {
    let build = |declared: &Declared<'_, V>| -> Result<Forces<V>> {
        let potential = declared.item.optional_callback("potential")?;
        let path = format!("{}.potential", declared.item.path);
        let mut forces: Forces<V> = Vec::new();
        if let Some(field) = Field::new(declared, "electric")? {
            forces.push(Box::new(Electric { field, potential, path }));
        }
        if let Some(field) = Field::new(declared, "magnetic")? {
            forces.push(Box::new(Magnetic(field)));
        }
        Ok(forces)
    };
    Kind { name: "ElectromagneticField", reach: Reach::Pointwise, build }
}

impl<V: Vector> History for Electric<V> {}
impl<V: Vector> History for Magnetic<V> {}

impl<V: Vector> Electric<V> {
    /// Whether its force is the gradient of a potential.
    fn is_conservative(&self) -> bool {
        self.potential.is_some() || !self.field.is_function()
    }
}

impl<V: Vector> Force<V> for Electric<V> {
    fn about(&self) -> About {
        let about = self.field.about();
        About { potential: self.is_conservative().then_some(about.name), ..about }
    }

    fn prepare(&mut self, at: &StateView<'_, V>, _executor: &Executor) -> Result<()> {
        self.field.prepare(at)
    }

    fn accumulate(&self, block: Range<usize>, at: &StateView<'_, V>, rates: &mut Rates<'_, V>) {
        let conservative = self.is_conservative();
        for (place, index) in self.field.charges(block) {
            let force = self.field.strength(index);
            rates.force.set(place, rates.force.get(place) + V::narrow(force));
            if !conservative {
                rates.power[EnergySink::Work as usize][place % LANES] += force.dot(at.velocity.get(index).widen());
            }
        }
    }

    fn potential(&self, block: Range<usize>, at: &StateView<'_, V>) -> f64 {
        if self.field.is_function() {
            return 0.0;
        }
        let energy = |index: usize| -self.field.strength(index).dot(at.properties.origin + at.position.get(index).widen());
        self.field.charges(block).map(|(_, index)| energy(index)).sum()
    }

    fn energy(&self, at: &StateView<'_, V>, ledger: &mut Ledger) -> Result<()> {
        let Some(potential) = &self.potential else {
            if let Some(name) = self.about().potential {
                ledger.add_blocks(Class::Potential, name, |block| self.potential(block, at));
            }
            return Ok(());
        };
        let positions: Vec<DVec3> =
            self.field.members.iter().map(|&index| at.properties.origin + at.position.get(index).widen()).collect();
        if positions.is_empty() {
            return Ok(());
        }
        let energy = potential.call(&[Argument::Vectors(&positions)], "one energy", &[]);
        let energy = energy.map_err(|failure| failure.at(self.path.clone()))?.first().copied().unwrap_or(f64::NAN);
        if !energy.is_finite() {
            return Err(Error::parameter(self.path.clone(), "a finite energy", format!("{energy} J")));
        }
        ledger.add(Class::Potential, "electromagnetic field", energy);
        Ok(())
    }

    fn bound(&self, _at: &StateView<'_, V>, _bound: &mut SpectralBound) -> Result<()> {
        Ok(())
    }

    fn validity(&self, _at: &StateView<'_, V>, _horizon: Horizon) -> Validity {
        Validity::Always
    }
}

impl<V: Vector> Force<V> for Magnetic<V> {
    fn about(&self) -> About {
        About { velocity: VelocityDependence::Gyroscopic, potential: None, ..self.0.about() }
    }

    fn prepare(&mut self, at: &StateView<'_, V>, _executor: &Executor) -> Result<()> {
        self.0.prepare(at)
    }

    fn accumulate(&self, block: Range<usize>, at: &StateView<'_, V>, rates: &mut Rates<'_, V>) {
        for (place, index) in self.0.charges(block) {
            let force = at.velocity.get(index).widen().cross(self.0.strength(index));
            rates.force.set(place, rates.force.get(place) + V::narrow(force));
        }
    }

    fn magnetic_strength(&self, index: usize) -> DVec3 {
        self.0.strength(index)
    }

    /// The gyration limits the accuracy: a hundred steps per period of the fastest one.
    fn bound(&self, at: &StateView<'_, V>, bound: &mut SpectralBound) -> Result<()> {
        let called = self.0.called(at)?;
        let values = called.as_ref().unwrap_or(&self.0.values);
        let rates =
            (0..self.0.charge.len()).map(|index| (self.0.charge[index] * values[index]).length() / at.properties.mass[index]);
        let fastest = rates.fold(0.0, f64::max);
        if fastest > 0.0 {
            bound.accuracy("gyration in the magnetic field", TAU / fastest / STEPS_PER_TURN);
        }
        Ok(())
    }

    fn validity(&self, _at: &StateView<'_, V>, _horizon: Horizon) -> Validity {
        if self.0.is_function() { Validity::Now } else { Validity::Always }
    }
}
