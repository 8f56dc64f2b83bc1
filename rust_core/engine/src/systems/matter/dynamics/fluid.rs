//! Densities of fluids, which a method advances together with the positions.

use std::ops::Range;

use super::{Dynamics, state_view};
use crate::error::Result;
use crate::forces::{Drift, Space};
use crate::math::Real;
use crate::matter::{Matter, Power, Span, View};
use crate::parallel::Executor;

impl<V: Space> Dynamics<V> {
    /// Sums density over the positions at the end of a step without an evaluation of forces.
    pub fn sum_density(&mut self, matter: &Matter<V>, time: f64, executor: &Executor) -> Result<()> {
        let Self { properties, forces, .. } = self;
        let at = state_view(properties, matter, time, executor);
        forces.iter_mut().filter_map(|force| force.density_mut()).try_for_each(|density| density.sum(&at, executor))
    }

    /// Advances density over the drift that led to a state.
    pub fn drift_density(&mut self, matter: &Matter<V>, velocity: View<'_, V>, h: f64, executor: &Executor) -> Result<()> {
        let Self { properties, forces, .. } = self;
        let drift = Drift { end: state_view(properties, matter, 0.0, executor), velocity, h };
        forces.iter_mut().filter_map(|force| force.density_mut()).try_for_each(|density| density.drift(&drift, executor))
    }

    /// Adds the energy that diffusion of density dissipated in the last drift to the sinks of a block [J].
    pub fn diffused(&self, block: &Range<usize>, energy: &mut Power) {
        let densities = self.forces.iter().filter_map(|force| force.density());
        densities.for_each(|density| density.dissipated(block.clone(), energy));
    }

    /// Displacements of the particles of one block by shifting [m].
    pub fn shift(&self, block: &Range<usize>, displacements: &mut Span<'_, V>) {
        for axis in 0..V::DIMENSION {
            displacements.axes[axis].fill(V::Scalar::ZERO);
        }
        let densities = self.forces.iter().filter_map(|force| force.density());
        densities.for_each(|density| density.shift(block.clone(), displacements));
    }
}
