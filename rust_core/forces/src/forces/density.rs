//! Density of fluids, evolved by a force in addition to the state.

use std::ops::Range;

use super::StateView;
use super::sph::Gauges;
use crate::error::Result;
use crate::math::{Real, Vector};
use crate::matter::{Power, Span, View};
use crate::parallel::Executor;

/// The drift of all particles over a substep, at constant velocity.
#[derive(Debug, Clone, Copy)]
pub struct Drift<'a, V: Vector> {
    /// State of matter at the end of the drift.
    pub end: StateView<'a, V>,
    /// Velocities of the drift [m/s].
    pub velocity: View<'a, V>,
    /// Duration of the drift [s].
    pub h: f64,
}

impl<V: Vector> Drift<'_, V> {
    /// The position of a particle relative to the origin along one axis, at the midpoint of the drift [m].
    #[inline(always)]
    pub fn midpoint(&self, axis: usize, index: usize) -> f64 {
        self.end.exact_position(axis, index) - 0.5 * self.h * self.velocity.axis(axis)[index].to_f64()
    }
}

/// The scheme of the density: by summation or continuity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DensityScheme {
    /// Summed over the positions at every evaluation of the forces.
    Summation,
    /// Advanced over each drift by the equation of continuity.
    Continuity,
}

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

/// Density and pressure of fluid particles, NaN for others.
#[derive(Debug, Clone, Default)]
pub struct Fields {
    /// Density [kg/m³].
    pub density: Vec<f64>,
    /// Pressure [Pa].
    pub pressure: Vec<f64>,
}

/// Evolution of density by a force.
pub trait DensityEvolution<V: Vector> {
    /// The scheme of the density: by summation or continuity.
    fn scheme(&self) -> DensityScheme;

    /// Sums density over the positions at the end of a step without an evaluation of forces.
    ///
    /// # Errors
    /// If positions are too far from the origin for exact separations, or memory is short.
    fn sum(&mut self, at: &StateView<'_, V>, executor: &Executor) -> Result<()>;

    /// Advances density over a drift.
    ///
    /// # Errors
    /// As [`DensityEvolution::sum`].
    fn drift(&mut self, drift: &Drift<'_, V>, executor: &Executor) -> Result<()>;

    /// Adds the energy that diffusion dissipated in the last drift to the sinks of a block [J].
    fn dissipated(&self, block: Range<usize>, energy: &mut Power);

    /// Whether particles are shifted after a drift, independently of their velocity.
    fn shifts(&self) -> bool;

    /// Adds the displacements of the particles of `block` after the last drift [m]. Velocities are unchanged. The change of
    /// pointwise and user-defined potentials counts as work.
    fn shift(&self, block: Range<usize>, displacements: &mut Span<'_, V>);

    /// The Mach number at these velocities.
    fn mach(&self, velocity: View<'_, V>) -> Mach;

    /// The gauges of pressure and force, if any are defined.
    fn gauges(&self) -> Option<&Gauges>;

    /// Writes density and pressure, indexed by particle.
    fn export(&self, fields: &mut Fields);
}
