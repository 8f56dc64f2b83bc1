//! Systems: a state with its law of motion, time stepping, energy budget and fields.

mod control;

use glam::DVec3;

use crate::error::{Error, Result};
use crate::history::History;
use crate::ledger::Ledger;
use crate::parallel::Executor;
use crate::plan::Stages;
use crate::stability::{Horizon, Limit};
pub use control::Control;

/// The Mach number of a flow, speed over speed of sound.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct Mach {
    /// The fraction of particles with a Mach number above [`Mach::FAST`].
    pub fast: f64,
    /// Speed of sound c [m/s].
    pub sound: f64,
}

impl Mach {
    /// Mach number Ma of a fast flow: the density error is about Ma², two percent.
    pub const FAST: f64 = 0.15;
}

/// An interval of equal steps.
#[derive(Debug, Clone, Copy)]
pub struct Interval {
    /// Start time of the clock's segment [s].
    pub start: f64,
    /// Number of earlier steps in that segment.
    pub first: u64,
    /// Step size h [s].
    pub h: f64,
    /// Number of steps.
    pub steps: u64,
}

impl Interval {
    /// The time at a fraction of one of the steps [s], with the same bits for any division into intervals.
    pub fn time(&self, step: u64, node: f64) -> f64 {
        self.start + ((self.first + step) as f64 + node) * self.h
    }
}

/// The recorded activities of a batch of steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Record {
    /// All steps.
    EveryStep,
    /// All steps; every 32nd where the activity costs much more than a step.
    Sampled,
    /// At least the last step: the only one known where linear forces run in registers.
    LastStep,
}

/// An element of a system, such as a particle or a cell.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Element {
    /// Its name: `particle 3`.
    pub name: String,
    /// Its index in the caller's order.
    pub index: usize,
}

/// An element with a quantity that is not finite.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// The element.
    pub element: Element,
    /// The name of the quantity: `position`.
    pub quantity: &'static str,
}

/// The description of a readable quantity.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FieldInfo {
    /// Its name: `positions`; where a scene has several systems, after the name of its item: `pond.heights`.
    pub name: String,
    /// Its unit.
    pub unit: &'static str,
    /// The shape of its array: the elements, and after them the components of each where they are several.
    pub shape: Vec<usize>,
    /// The name of the field that is its rate of change, if there is one: between two steps it is then the cubic through both.
    pub rate: Option<String>,
    /// Whether it is a part of the state, and does not follow from the others.
    pub state: bool,
}

/// A field in space.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// The acceleration of 1 kg at rest by forces on single particles [m/s²].
    Acceleration,
    /// E of fields and charges [V/m].
    ElectricField,
    /// B, three components [T].
    MagneticField,
    /// The potential of E [V].
    ElectricPotential,
}

impl Quantity {
    const ALL: [Self; 4] = [Self::Acceleration, Self::ElectricField, Self::MagneticField, Self::ElectricPotential];

    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Acceleration => "acceleration",
            Self::ElectricField => "electric_field",
            Self::MagneticField => "magnetic_field",
            Self::ElectricPotential => "electric_potential",
        }
    }

    /// That of a name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|quantity| quantity.name() == name)
    }
}

/// Points of a field in space.
#[derive(Debug, Clone, Copy)]
pub struct Sample<'a> {
    /// The field.
    pub quantity: Quantity,
    /// The time of fields that change [s].
    pub time: f64,
    /// Points [m], row by row.
    pub points: &'a [f64],
    /// The body whose forces count; None: those on any.
    pub on: Option<usize>,
}

/// A state with its law of motion, of any dimension and precision.
pub trait System: History + Send + Sync {
    /// The stages of a step: one part for each system of the scene.
    fn stages(&self) -> Vec<Stages>;

    /// Present memory [bytes].
    fn bytes(&self) -> usize;

    /// Estimated duration of a step on one core [s]; it sets the size of batches and the number of threads, and changes no
    /// bit of the result.
    fn cost(&self) -> f64;

    /// Maximum number of steps in a batch.
    fn most_steps(&self) -> u64;

    /// Maximum number of steps in a batch with every activity recorded.
    fn most_recorded(&self) -> u64;

    /// Initializes from the present fields, without history.
    ///
    /// # Errors
    /// If its rates cannot be evaluated, or on an interrupt.
    fn begin(&mut self, time: f64, executor: &Executor) -> Result<()>;

    /// Takes steps, all or none. It [saves](History::save) itself before, and can be [rolled back](History::rollback) to
    /// there afterwards.
    ///
    /// # Errors
    /// If a step fails, or on an interrupt.
    fn advance(&mut self, interval: Interval, record: Record, executor: &Executor) -> Result<()>;

    /// The activity after each recorded step of the last batch [J]: the kinetic energy, or another quantity that grows
    /// without bound where the solution does; NaN or infinite where the state is.
    fn activity(&self) -> &[f64];

    /// The largest |value| of a system whose divergence shows in that alone, because it has no energy.
    fn amplitude(&self) -> Option<f64> {
        None
    }

    /// Whether its steps are linear in the state and autonomous. Steps of at most half of the limit of stability then never
    /// double the energy: the invariant of an oscillator's step is elongated by 1/√(1 − ½²) at most.
    fn is_linear(&self) -> bool {
        false
    }

    /// Whether its method is unconditionally unstable, so that its energy may grow at any step.
    fn gains_energy(&self) -> bool {
        false
    }

    /// The limit of the time step.
    ///
    /// # Errors
    /// If a user-defined function fails, or on an interrupt.
    fn limit(&self, horizon: Horizon, time: f64, executor: &Executor) -> Result<Limit>;

    /// Whether that limit changes with the state.
    fn limit_varies(&self, _horizon: Horizon, _time: f64) -> bool {
        false
    }

    /// The estimated error of the last step of `h` seconds [m], and the order of the method, where a pair is embedded in it.
    fn error(&self, _h: f64) -> Option<(f64, u32)> {
        None
    }

    /// The control of the step size by that error, of a method of this order.
    fn control(&self, order: u32) -> Control {
        Control::pair(order)
    }

    /// The energy budget.
    ///
    /// # Errors
    /// As [`System::limit`].
    fn audit(&self, time: f64, executor: &Executor) -> Result<Ledger>;

    /// The energy budget of an initial state, refused where it overflows.
    ///
    /// # Errors
    /// As [`System::audit`], and on overflow.
    fn finite_audit(&self, time: f64, executor: &Executor) -> Result<Ledger>;

    /// A lower bound of its potential energy, if one is known: an energy that starts as potential is then no rise when it
    /// becomes kinetic [J].
    fn lowest_potential(&self) -> Option<f64> {
        None
    }

    /// The momentum [kg·m/s] and the angular momentum about the origin of coordinates [kg·m²/s]: 0 of what is no matter.
    fn momenta(&self) -> (DVec3, DVec3) {
        (DVec3::ZERO, DVec3::ZERO)
    }

    /// The smallest energy that steps of `h` seconds can resolve [J]: the kinetic energy of one kick from rest, 0 where there is
    /// none.
    fn resolvable(&self, _time: f64, _h: f64) -> f64 {
        0.0
    }

    /// The first element with a quantity that is not finite.
    fn fault(&self) -> Option<Fault>;

    /// The element with the most kinetic energy.
    fn fastest(&self) -> Element;

    /// The Mach number of its flow, if it is a fluid.
    fn mach(&self) -> Option<Mach> {
        None
    }

    /// The descriptions of all fields.
    fn fields(&self) -> Vec<FieldInfo>;

    /// The values of a field, element by element in the caller's order.
    fn read(&self, field: usize) -> Vec<f64>;

    /// Replaces fields by name and reinitializes; the change of energy counts as work.
    ///
    /// # Errors
    /// If a field does not exist or cannot be replaced, a value is out of range, or as [`System::begin`]. The state is then
    /// unchanged.
    fn write(&mut self, fields: &[(&str, &[f64])], time: f64, executor: &Executor) -> Result<()>;

    /// The energy tallies, part by part, for checkpoints.
    fn tallies(&self) -> Vec<f64>;

    /// Restores the tallies.
    ///
    /// # Errors
    /// If they belong to something else.
    fn restore_tallies(&mut self, numbers: &[f64]) -> Result<()>;

    /// A field in space at some points, row by row.
    ///
    /// # Errors
    /// If it has none, or as [`System::audit`].
    fn sample(&self, sample: &Sample<'_>, _executor: &Executor) -> Result<Vec<f64>> {
        Err(Error::parameter(sample.quantity.name(), "a scene with bodies", "none"))
    }
}
