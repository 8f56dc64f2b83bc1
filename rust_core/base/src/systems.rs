//! Systems: a state with its equations of motion, time stepping, energy budget and fields.

mod control;
mod coupling;

use std::any::Any;
use std::ops::RangeInclusive;

use crate::error::{Error, Result};
use crate::history::History;
use crate::ledger::Ledger;
use crate::parallel::Executor;
use crate::plan::Stages;
use crate::stability::{Horizon, Limit};
pub use control::Control;
pub use coupling::{Coupling, SystemPart};

/// Interval of equal steps.
#[derive(Debug, Clone, Copy)]
pub struct Interval {
    /// Start time of the clock's segment [s].
    pub start: f64,
    /// Number of earlier steps in this segment.
    pub first: u64,
    /// Step size h [s].
    pub h: f64,
    /// Number of steps.
    pub steps: u64,
}

impl Interval {
    /// Time at a fraction of one of the steps [s], with equal bits for any division into intervals.
    pub fn time(&self, step: u64, node: f64) -> f64 {
        self.start + ((self.first + step) as f64 + node) * self.h
    }

    /// Interval of the same duration, each step in `parts` equal parts.
    #[must_use]
    pub fn in_parts(self, parts: u64) -> Self {
        Self { first: self.first * parts, h: self.h / parts as f64, steps: self.steps * parts, ..self }
    }
}

/// Steps of a batch whose activity is recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RecordedSteps {
    /// All steps.
    EveryStep,
    /// All steps; only every 32nd if the activity costs much more than a step.
    Sampled,
    /// At least the last step; other steps are unknown where linear forces run in registers.
    LastStep,
}

/// Element of a system, such as a particle or a cell.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Element {
    /// Name of the element: `particle 3`.
    pub name: String,
    /// Index of the element in the caller's order.
    pub index: usize,
}

/// Element with a quantity that is not finite.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// Affected element.
    pub element: Element,
    /// Name of the quantity: `position`.
    pub quantity: &'static str,
}

/// Description of a readable quantity.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FieldInfo {
    /// Name of the field: `positions`. In a scene of several systems, the name of the item precedes it: `pond.heights`.
    pub name: String,
    /// Unit of the field.
    pub unit: &'static str,
    /// Elements that have a value each.
    pub location: Location,
    /// Shape of the array: the number of elements, if they are counted; then, if there are several, the components of each.
    pub shape: Vec<usize>,
    /// Name of the field that is the rate of change, if any. The field is then interpolated between two steps by the cubic
    /// through both.
    pub rate: Option<String>,
    /// Whether the field is a part of the state, not a function of other fields.
    pub state: bool,
}

/// Elements of a system at which the values of a field stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Location {
    /// Particles, tracers or vortices.
    Points,
    /// Particles on wires, wire by wire.
    Beads,
    /// Cells of a grid.
    Cells,
    /// Springs of all networks, as declared.
    Springs,
    /// Boundaries, then bodies that are obstacles in a fluid.
    Walls,
    /// Probes.
    Probes,
    /// Rigid bodies.
    Bodies,
    /// Joints.
    Joints,
    /// Particles that are tied to rigid bodies, anchor by anchor.
    Ties,
    /// The system as a whole.
    Whole,
}

impl Location {
    /// Name of the elements.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Points => "points",
            Self::Beads => "beads",
            Self::Cells => "cells",
            Self::Springs => "springs",
            Self::Walls => "walls",
            Self::Probes => "probes",
            Self::Bodies => "bodies",
            Self::Joints => "joints",
            Self::Ties => "ties",
            Self::Whole => "whole",
        }
    }
}

/// Field in space.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Acceleration of 1 kg at rest by forces on single particles [m/s²].
    Acceleration,
    /// Electric field E of fields and charges [V/m].
    ElectricField,
    /// Magnetic field B, three components [T].
    MagneticField,
    /// Potential of E [V].
    ElectricPotential,
}

impl Quantity {
    const ALL: [Self; 4] = [Self::Acceleration, Self::ElectricField, Self::MagneticField, Self::ElectricPotential];

    /// Name of the field.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Acceleration => "acceleration",
            Self::ElectricField => "electric_field",
            Self::MagneticField => "magnetic_field",
            Self::ElectricPotential => "electric_potential",
        }
    }

    /// Field with a given name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|quantity| quantity.name() == name)
    }
}

/// Points at which a field in space is sampled.
#[derive(Debug, Clone, Copy)]
pub struct Sample<'a> {
    /// Field to sample.
    pub quantity: Quantity,
    /// Time, for time-dependent fields [s].
    pub time: f64,
    /// Points [m], row by row.
    pub points: &'a [f64],
    /// Index of the body whose forces are sampled; None for forces on any body.
    pub on: Option<usize>,
}

/// Facts about a system for the clock and the divergence monitor. Only the amplitude changes with the state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hints {
    /// Maximum number of steps in a batch.
    pub most_steps: u64,
    /// Maximum number of steps in a batch with every activity recorded.
    pub most_recorded: u64,
    /// Whether steps iterate, so that no estimate of their duration holds and interrupts are polled for.
    pub iterates: bool,
    /// Whether the steps are linear in the state and autonomous. Steps of at most half of the limit of stability then never
    /// double the energy. The reason is that the invariant of an oscillator's step is elongated by at most 1/√(1 − ½²).
    pub linear: bool,
    /// Whether the method is unconditionally unstable, so that the energy may grow at any step size.
    pub gains_energy: bool,
    /// Lower bound of the potential energy [J], if known. Initial potential energy is then no rise when it becomes kinetic.
    pub lowest_potential: Option<f64>,
    /// Largest |value| of a system without an energy, whose divergence shows only in this value.
    pub amplitude: Option<f64>,
}

impl Hints {
    /// Duration of a batch of steps [s]: long against the cost per batch, short enough that an interrupt loses little.
    const BATCH: f64 = 0.05;

    /// Hints of a system whose steps take `cost` seconds, in batches of a number of steps in this range.
    pub fn new(cost: f64, steps: RangeInclusive<u64>) -> Self {
        Self {
            most_steps: ((Self::BATCH / cost) as u64).clamp(*steps.start(), *steps.end()),
            most_recorded: *steps.end(),
            iterates: false,
            linear: false,
            gains_energy: false,
            lowest_potential: None,
            amplitude: None,
        }
    }

    /// Hints of steps that consist of `parts` equal parts, each with these hints.
    #[must_use]
    pub fn in_parts(self, parts: u64) -> Self {
        let [most_steps, most_recorded] = [self.most_steps, self.most_recorded].map(|steps| (steps / parts).max(1));
        Self { most_steps, most_recorded, ..self }
    }

    /// Hints of two systems that are advanced together.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            most_steps: self.most_steps.min(other.most_steps),
            most_recorded: self.most_recorded.min(other.most_recorded),
            iterates: self.iterates || other.iterates,
            linear: self.linear && other.linear,
            gains_energy: self.gains_energy || other.gains_energy,
            lowest_potential: self.lowest_potential.zip(other.lowest_potential).map(|(one, other)| one + other),
            amplitude: self.amplitude.into_iter().chain(other.amplitude).reduce(f64::max),
        }
    }
}

/// State with its equations of motion, of any dimension and precision.
pub trait System: History + Any + Send + Sync {
    /// Stages of a step: one part for each system of the scene.
    fn stages(&self) -> Vec<Stages>;

    /// Memory in use [bytes].
    fn bytes(&self) -> usize;

    /// Estimated duration of a step on one core [s]. It sets the size of batches and the number of threads, and changes no bit of
    /// the result.
    fn cost(&self) -> f64;

    /// Facts for the clock and the divergence monitor.
    fn hints(&self) -> Hints;

    /// Initializes the system from the present fields, without history.
    ///
    /// # Errors
    /// If the rates cannot be evaluated, or on an interrupt.
    fn begin(&mut self, time: f64, executor: &Executor) -> Result<()>;

    /// Takes steps, all or none. The system [saves](History::save) itself before, and can be [rolled back](History::rollback) to
    /// that state afterwards.
    ///
    /// # Errors
    /// If a step fails, or on an interrupt.
    fn advance(&mut self, interval: Interval, record: RecordedSteps, executor: &Executor) -> Result<()>;

    /// Activity after each recorded step of the last batch [J]: the kinetic energy, or another quantity that grows without bound
    /// if the solution does. NaN or infinite if the state is.
    fn activity(&self) -> &[f64];

    /// Smallest energy that steps of `h` seconds can resolve [J]: the kinetic energy of one kick from rest; 0 if none.
    fn resolvable(&self, _time: f64, _h: f64) -> f64 {
        0.0
    }

    /// Limit of the time step.
    ///
    /// # Errors
    /// If a user-defined function fails, or on an interrupt.
    fn limit(&self, horizon: Horizon, time: f64, executor: &Executor) -> Result<Limit>;

    /// Whether the limit changes with the state.
    fn limit_varies(&self, _horizon: Horizon, _time: f64) -> bool {
        false
    }

    /// Estimated error of the last step of `h` seconds [m], and the step-size control by it; None without an estimate.
    fn error(&self, _h: f64) -> Option<(f64, Control)> {
        None
    }

    /// Energy budget.
    ///
    /// # Errors
    /// As [`System::limit`].
    fn audit(&self, time: f64, executor: &Executor) -> Result<Ledger>;

    /// Energy budget of an initial state, refused on overflow.
    ///
    /// # Errors
    /// As [`System::audit`], and on overflow.
    fn finite_audit(&self, time: f64, executor: &Executor) -> Result<Ledger> {
        self.audit(time, executor)?.finite()
    }

    /// First element with a quantity that is not finite.
    fn fault(&self) -> Option<Fault>;

    /// Element with the most kinetic energy.
    fn fastest(&self) -> Element;

    /// Descriptions of all fields.
    fn fields(&self) -> Vec<FieldInfo>;

    /// Values of a field at a time, element by element in the caller's order.
    fn read(&self, field: usize, time: f64) -> Vec<f64>;

    /// Writes the values of a field to a slice of their number; small fields of the whole without allocation.
    fn read_into(&self, field: usize, time: f64, values: &mut [f64]) {
        values.copy_from_slice(&self.read(field, time));
    }

    /// Replaces fields by name and reinitializes the system. The change of energy counts as work.
    ///
    /// # Errors
    /// If a field does not exist or cannot be replaced, if a value is out of range, or as [`System::begin`]. The state is then
    /// unchanged.
    fn write(&mut self, fields: &[(&str, &[f64])], time: f64, executor: &Executor) -> Result<()>;

    /// Samples a field in space at some points, row by row.
    ///
    /// # Errors
    /// If the system has no such field, or as [`System::audit`].
    fn sample(&self, sample: &Sample<'_>, _executor: &Executor) -> Result<Vec<f64>> {
        Err(Error::parameter(sample.quantity.name(), "a scene with bodies", "none"))
    }
}
