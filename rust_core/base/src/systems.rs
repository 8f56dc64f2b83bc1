//! Systems: a state with its equations of motion, time stepping, energy budget and fields.

mod control;

use glam::DVec3;

use crate::error::{Error, Result};
use crate::history::History;
use crate::ledger::Ledger;
use crate::parallel::Executor;
use crate::plan::Stages;
use crate::stability::{Horizon, Limit};
pub use control::Control;

/// Mach number of a flow: speed over speed of sound.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct Mach {
    /// Fraction of particles with a Mach number above [`Mach::FAST`].
    pub fast: f64,
    /// Speed of sound c [m/s].
    pub sound: f64,
}

impl Mach {
    /// Mach number Ma of a fast flow: the density error is about Ma², two percent.
    pub const FAST: f64 = 0.15;
}

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
    /// Shape of the array: the number of elements; then, if there are several, the components of each element.
    pub shape: Vec<usize>,
    /// Name of the field that is the rate of change, if any. The field is then interpolated between two steps by the cubic
    /// through both.
    pub rate: Option<String>,
    /// Whether the field is a part of the state, not a function of other fields.
    pub state: bool,
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

/// State with its equations of motion, of any dimension and precision.
pub trait System: History + Send + Sync {
    /// Stages of a step: one part for each system of the scene.
    fn stages(&self) -> Vec<Stages>;

    /// Memory in use [bytes].
    fn bytes(&self) -> usize;

    /// Estimated duration of a step on one core [s]. It sets the size of batches and the number of threads, and changes no bit of
    /// the result.
    fn cost(&self) -> f64;

    /// Whether steps iterate, so that no estimate of their duration holds and interrupts are polled for.
    fn iterates(&self) -> bool {
        false
    }

    /// Maximum number of steps in a batch.
    fn most_steps(&self) -> u64;

    /// Maximum number of steps in a batch with every activity recorded.
    fn most_recorded(&self) -> u64;

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

    /// Largest |value| of a system without an energy, whose divergence shows only in this value.
    fn amplitude(&self) -> Option<f64> {
        None
    }

    /// Whether the steps are linear in the state and autonomous. Steps of at most half of the limit of stability then never
    /// double the energy. The reason is that the invariant of an oscillator's step is elongated by at most 1/√(1 − ½²).
    fn is_linear(&self) -> bool {
        false
    }

    /// Whether the method is unconditionally unstable, so that the energy may grow at any step size.
    fn gains_energy(&self) -> bool {
        false
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

    /// Estimated error of the last step of `h` seconds [m], and the order of the method; None without an embedded pair.
    fn error(&self, _h: f64) -> Option<(f64, u32)> {
        None
    }

    /// Step-size control by the estimated error, for a method of this order.
    fn control(&self, order: u32) -> Control {
        Control::pair(order)
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
    fn finite_audit(&self, time: f64, executor: &Executor) -> Result<Ledger>;

    /// Lower bound of the potential energy [J], if known. Initial potential energy is then no rise when it becomes kinetic.
    fn lowest_potential(&self) -> Option<f64> {
        None
    }

    /// Momentum [kg·m/s] and angular momentum about the origin of coordinates [kg·m²/s]; 0 for systems other than matter.
    fn momenta(&self) -> (DVec3, DVec3) {
        (DVec3::ZERO, DVec3::ZERO)
    }

    /// Smallest energy that steps of `h` seconds can resolve [J]: the kinetic energy of one kick from rest; 0 if none.
    fn resolvable(&self, _time: f64, _h: f64) -> f64 {
        0.0
    }

    /// First element with a quantity that is not finite.
    fn fault(&self) -> Option<Fault>;

    /// Element with the most kinetic energy.
    fn fastest(&self) -> Element;

    /// Mach number of the flow, if the system is a fluid.
    fn mach(&self) -> Option<Mach> {
        None
    }

    /// Descriptions of all fields.
    fn fields(&self) -> Vec<FieldInfo>;

    /// Values of a field, element by element in the caller's order.
    fn read(&self, field: usize) -> Vec<f64>;

    /// Replaces fields by name and reinitializes the system. The change of energy counts as work.
    ///
    /// # Errors
    /// If a field does not exist or cannot be replaced, if a value is out of range, or as [`System::begin`]. The state is then
    /// unchanged.
    fn write(&mut self, fields: &[(&str, &[f64])], time: f64, executor: &Executor) -> Result<()>;

    /// Energy tallies, part by part, for checkpoints.
    fn tallies(&self) -> Vec<f64>;

    /// Restores the tallies.
    ///
    /// # Errors
    /// If the tallies belong to something else.
    fn restore_tallies(&mut self, numbers: &[f64]) -> Result<()>;

    /// Samples a field in space at some points, row by row.
    ///
    /// # Errors
    /// If the system has no such field, or as [`System::audit`].
    fn sample(&self, sample: &Sample<'_>, _executor: &Executor) -> Result<Vec<f64>> {
        Err(Error::parameter(sample.quantity.name(), "a scene with bodies", "none"))
    }
}
