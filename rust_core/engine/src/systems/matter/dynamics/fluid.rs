//! Densities of fluids, which a method advances together with the positions.

use std::ops::Range;

use super::{Dynamics, state_view};
use crate::catalog::Space;
use crate::error::Result;
use crate::forces::Drift;
use crate::math::Real;
use crate::matter::{Matter, Power, Span, View};
use crate::parallel::Executor;

impl<V: Space> Dynamics<V> {
    /// Sums density over the positions at the end of a step without an evaluation of forces.
    pub fn sum_density(&mut self, matter: &Matter<V>, time: f64, executor: &Executor) -> Result<()> {
        let Self { properties, forces, .. } = self;
        let drift = Drift { end: state_view(properties, matter, time, executor), velocity: matter.velocity.view(), h: 0.0 };
        forces.iter_mut().filter_map(|force| force.fluid_mut()).try_for_each(|fluid| fluid.drift(&drift, executor))
    }

    /// Advances density over the drift that led to a state.
    pub fn drift_density(&mut self, matter: &Matter<V>, velocity: View<'_, V>, h: f64, executor: &Executor) -> Result<()> {
        let Self { properties, forces, .. } = self;
        let drift = Drift { end: state_view(properties, matter, 0.0, executor), velocity, h };
        forces.iter_mut().filter_map(|force| force.fluid_mut()).try_for_each(|fluid| fluid.drift(&drift, executor))
    }

    /// Adds the energy that diffusion of density dissipated in the last drift to the sinks of a block [J].
    pub fn diffused(&self, block: &Range<usize>, energy: &mut Power) {
        let fluids = self.forces.iter().filter_map(|force| force.fluid());
        fluids.for_each(|fluid| fluid.dissipated(block.clone(), energy));
    }

    /// Displacements of the particles of one block by shifting [m].
    pub fn shift(&self, block: &Range<usize>, displacements: &mut Span<'_, V>) {
        for axis in 0..V::DIMENSION {
            displacements.axes[axis].fill(V::Scalar::ZERO);
        }
        let fluids = self.forces.iter().filter_map(|force| force.fluid());
        fluids.for_each(|fluid| fluid.shift(block.clone(), displacements));
    }
}
