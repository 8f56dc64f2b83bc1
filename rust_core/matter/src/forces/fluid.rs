//! Schemes for fluids: what a step of matter and its results ask of them besides forces.

use std::ops::Range;

use super::{Readings, StateView};
use crate::error::Result;
use crate::math::{Real, Vector};
use crate::matter::{Power, Span, View};
use crate::parallel::Executor;
use crate::scene::{Item, Scene};

/// Kind of a body that is a fluid.
pub const KIND: &str = "Fluid";

/// Fluids of a scene, each with the index of its body.
#[inline]
pub fn fluids(scene: &Scene) -> impl Iterator<Item = (usize, &Item)> {
    scene.bodies.iter().map(|body| &body.item).enumerate().filter(|(_, item)| item.kind == KIND)
}

/// Whether a scene has a fluid.
#[inline]
pub fn is_in(scene: &Scene) -> bool {
    fluids(scene).next().is_some()
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

/// Origin of the density, which says when a step brings it up to date.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DensityScheme {
    /// Density follows from the positions: at every evaluation of the forces, and at the end of a step without one.
    Summation,
    /// Density is carried along every drift. With `shifts`, particles are displaced after it, independently of their velocity.
    Continuity {
        /// Whether particles are displaced.
        shifts: bool,
    },
}

impl DensityScheme {
    /// Whether density is carried along drifts.
    #[inline]
    pub fn is_carried(self) -> bool {
        matches!(self, Self::Continuity { .. })
    }
}

/// Density and pressure of fluid particles, NaN for others.
#[derive(Debug, Clone, Default)]
pub struct Fields {
    /// Density [kg/m³].
    pub density: Vec<f64>,
    /// Pressure [Pa].
    pub pressure: Vec<f64>,
}

/// A scheme for fluids, as a step of matter sees it besides its forces.
///
/// Results need the fields, the gauges and the Mach number. A step asks for [`density`](Self::density), and calls the last three
/// methods as that says.
///
/// A divergence-free scheme implements [`export`](Self::export), with gauges if it measures, and leaves the rest at its defaults.
/// Its density follows from the positions, and nothing is carried along a drift. A pressure that keeps the density is a force,
/// solved for in [`Force::prepare`](super::Force::prepare). A pressure that makes the velocities of a drift divergence-free is a
/// constraint on them, which a step meets before the drift, as it meets rods.
pub trait FluidScheme<V: Vector> {
    /// Writes density and pressure, indexed by particle.
    fn export(&self, fields: &mut Fields);

    /// Replaces the density by one that is indexed by particle [kg/m³], if it is carried along drifts.
    fn import(&mut self, _density: &[f64]) {}

    /// Readings of the gauges of pressure and force, if any are defined.
    fn gauges(&self) -> Option<&Readings> {
        None
    }

    /// The Mach number at these velocities, if the fluid has a speed of sound.
    fn mach(&self, _velocity: View<'_, V>) -> Option<Mach> {
        None
    }

    /// Origin of the density.
    fn density(&self) -> DensityScheme {
        DensityScheme::Summation
    }

    /// Brings density up to date after a drift. If density is carried, this follows every drift. Otherwise it follows a step
    /// that does not end with an evaluation of forces; the drift then has no duration.
    ///
    /// # Errors
    /// If positions are too far from the origin for exact separations, or memory is short.
    fn drift(&mut self, _drift: &Drift<'_, V>, _executor: &Executor) -> Result<()> {
        Ok(())
    }

    /// Adds the energy that was dissipated in the last drift to the sinks of a block [J].
    fn dissipated(&self, _block: Range<usize>, _energy: &mut Power) {}

    /// Adds the displacements of the particles of `block` after the last drift [m]. Velocities are unchanged. The change of
    /// pointwise and user-defined potentials counts as work.
    fn shift(&self, _block: Range<usize>, _displacements: &mut Span<'_, V>) {}
}
