//! Tallies: the energy that leaves and enters, integrated over time as it flows.

use crate::simd::{LANES, Lanes};

/// Where energy leaves or enters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EnergySink {
    /// Dissipated by drag.
    Drag,
    /// Dissipated by the damping of springs.
    Damping,
    /// Dissipated by contacts: restitution and friction, and what the pressure of walls and obstacles takes from a fluid.
    Contact,
    /// Dissipated by the viscosity of fluids, and by the diffusion of their density.
    Viscosity,
    /// Work done on the matter by drivers, wind, fixed particles that move, and the shifting of fluids.
    Work,
}

/// The number of sinks.
pub const SINKS: usize = 5;

/// A power [W] for every sink and lane.
pub type Power = [Lanes<f64>; SINKS];

/// The energy that has passed through each sink in one block. Kept lane by lane in double precision and summed in a
/// fixed order only when somebody asks, so that it costs next to nothing and never depends on threads or batches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnergyTally {
    /// The time integral of the power so far [J].
    pub energy: Power,
    /// The power at the last evaluation, which an integrator's next step may begin with [W].
    pub last: Power,
}

impl EnergyTally {
    /// A tally at zero.
    pub const ZERO: Self = Self { energy: [[0.0; LANES]; SINKS], last: [[0.0; LANES]; SINKS] };

    /// The energy that has passed through one sink [J].
    pub fn total(&self, sink: EnergySink) -> f64 {
        self.energy[sink as usize].iter().sum()
    }

    /// Adds energy that passed in an instant [J].
    pub fn add(&mut self, sink: EnergySink, energy: f64) {
        self.energy[sink as usize][0] += energy;
    }
}
