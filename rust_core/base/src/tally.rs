//! Tallies: time integrals of the dissipated and supplied power.

use crate::simd::{LANES, Lanes};

/// Sinks and sources of energy.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EnergySink {
    /// Dissipated by drag.
    Drag,
    /// Dissipated by the damping of springs.
    Damping,
    /// Dissipated by contacts: by restitution and friction, and by the work of a fluid against the pressure of walls and
    /// obstacles.
    Contact,
    /// Dissipated by the viscosity of fluids, and by the diffusion of their density.
    Viscosity,
    /// Work done on the matter by drivers, wind, moving fixed particles, and the shifting of fluids.
    Work,
}

/// Number of sinks.
pub const SINKS: usize = 5;

/// Power [W] for every sink and lane.
pub type Power = [Lanes<f64>; SINKS];

/// Energy through each sink in one block. It is accumulated lane by lane in double precision and summed in a fixed order on
/// demand. It therefore costs next to nothing and never depends on threads or batches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnergyTally {
    /// Time integral of the power so far [J].
    pub energy: Power,
    /// Power at the last evaluation, with which the next step of an FSAL integrator begins [W].
    pub last: Power,
}

impl EnergyTally {
    /// Tally at zero.
    pub const ZERO: Self = Self { energy: [[0.0; LANES]; SINKS], last: [[0.0; LANES]; SINKS] };

    /// Energy through one sink [J].
    #[inline]
    pub fn total(&self, sink: EnergySink) -> f64 {
        self.energy[sink as usize].iter().sum()
    }

    /// Adds the energy of an instantaneous event [J].
    #[inline]
    pub fn add(&mut self, sink: EnergySink, energy: f64) {
        self.energy[sink as usize][0] += energy;
    }
}
