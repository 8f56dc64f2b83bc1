//! The density of fluids, which a force evolves beside the state.

use std::ops::Range;

use super::StateView;
use crate::error::Result;
use crate::math::{Real, Vector};
use crate::matter::{Power, Span, View};
use crate::parallel::Executor;

/// The drift of all particles over a substep, at constant velocity.
#[derive(Debug, Clone, Copy)]
pub struct Drift<'a, V: Vector> {
    /// The matter at its end.
    pub end: StateView<'a, V>,
    /// The velocity of the drift [m/s].
    pub velocity: View<'a, V>,
    /// Its duration [s].
    pub h: f64,
}

impl<V: Vector> Drift<'_, V> {
    /// The position of a particle relative to the origin along one axis, at the midpoint of the drift [m].
    #[inline(always)]
    pub fn midpoint(&self, axis: usize, index: usize) -> f64 {
        self.end.exact_position(axis, index) - 0.5 * self.h * self.velocity.axis(axis)[index].to_f64()
    }
}

/// How density follows the particles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scheme {
    /// Summed over the positions, whenever forces are asked for.
    Summation,
    /// Advanced over each drift by the equation of continuity.
    Continuity,
}

/// Density and pressure of the particles that are fluid, NaN for the others.
#[derive(Debug, Clone, Default)]
pub struct Fields {
    /// Density [kg/m³].
    pub density: Vec<f64>,
    /// Pressure [Pa].
    pub pressure: Vec<f64>,
}

/// The speed of a fluid in units of its speed of sound.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct Mach {
    /// The share of its particles that are faster than [`Mach::FAST`].
    pub fast: f64,
    /// The speed of sound [m/s].
    pub sound: f64,
}

impl Mach {
    /// The Mach number from which on a flow is fast: density is then off by about the square of it, two percent.
    pub const FAST: f64 = 0.15;
}

/// The evolution of density, of a force that has one.
pub trait DensityEvolution<V: Vector> {
    /// How density follows the particles.
    fn scheme(&self) -> Scheme;

    /// Sums density over the positions at the end of a step where no force was asked for.
    ///
    /// # Errors
    /// If positions are too far away to tell distances, or there is too little memory.
    fn sum(&mut self, at: &StateView<'_, V>, executor: &Executor) -> Result<()>;

    /// Advances density over a drift.
    ///
    /// # Errors
    /// As [`DensityEvolution::sum`].
    fn drift(&mut self, drift: &Drift<'_, V>, executor: &Executor) -> Result<()>;

    /// Adds the energy that diffusion took over the last drift to what passed through the sinks of a block [J].
    fn dissipated(&self, block: Range<usize>, energy: &mut Power);

    /// Whether it displaces particles beside their velocity, after a drift.
    fn shifts(&self) -> bool;

    /// Adds the displacements of the particles of `block` after the last drift [m]. Velocities stay, and the change of
    /// pointwise and user-defined potentials counts as work.
    fn shift(&self, block: Range<usize>, displacements: &mut Span<'_, V>);

    /// The Mach number at these velocities.
    fn mach(&self, velocity: View<'_, V>) -> Mach;

    /// Writes density and pressure, by the index of the particle.
    fn export(&self, fields: &mut Fields);
}
