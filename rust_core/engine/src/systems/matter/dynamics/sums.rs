//! Sums of the forces over the particles of a block, and of the energies and powers.

use std::ops::Range;

use super::super::methods::Treatment;
use super::Dynamics;
use crate::catalog::Space;
use crate::error::Result;
use crate::forces::{Force, Rates, StateView, Strength, VelocityDependence};
use crate::ledger::{Class, Ledger};
use crate::math::Real;
use crate::matter::{Columns, EnergySink, SINKS};
use crate::simd::{LANES, padded};

/// Whether a force only turns velocities.
pub(super) fn is_magnetic<V: Space>(force: &dyn Force<V>) -> bool {
    force.about().velocity == VelocityDependence::Gyroscopic
}

impl<V: Space> Dynamics<V> {
    /// Sets the forces and powers of one block to those of all terms that are not fused.
    #[inline]
    pub fn accumulate(&self, block: &Range<usize>, at: &StateView<'_, V>, rates: &mut Rates<'_, V>) {
        for axis in 0..V::DIMENSION {
            rates.force.axes[axis].fill(V::Scalar::ZERO);
            if let Some(damping) = &mut rates.damping {
                damping.axes[axis].fill(V::Scalar::ZERO);
            }
        }
        let turned = self.magnetic && self.angle.is_some();
        let acting =
            |forces: Range<usize>| self.forces[forces].iter().filter(move |force| !turned || !is_magnetic(force.as_ref()));
        // For a method that projects, springs are the only forces between particles.
        for force in acting(self.fused..if self.treatment == Treatment::Projections { self.fused } else { self.together }) {
            force.accumulate(block.clone(), at, rates);
        }
        if self.driven {
            self.count_reactions(block, at, rates);
        }
        for force in acting(self.together..self.forces.len()) {
            force.accumulate(block.clone(), at, rates);
        }
    }

    /// Adds the powers of springs that dissipate or do work on fixed particles, for a method that projects springs.
    pub fn spring_power(&self, block: &Range<usize>, at: &StateView<'_, V>, rates: &mut Rates<'_, V>) {
        if !self.driven && self.velocity == VelocityDependence::None {
            return;
        }
        (0..V::DIMENSION).for_each(|axis| rates.force.axes[axis].fill(V::Scalar::ZERO));
        self.forces[self.fused..self.together].iter().for_each(|force| force.accumulate(block.clone(), at, rates));
        if self.driven {
            self.count_reactions(block, at, rates);
        }
    }

    /// Adds q B of all magnetic fields at the particles of a range to `strength`.
    pub fn magnetic(&self, range: Range<usize>, at: &StateView<'_, V>, strength: &mut Strength<V>) {
        let fields = self.forces.iter().filter(|force| is_magnetic(force.as_ref()));
        fields.for_each(|force| force.magnetic(range.clone(), at, strength));
    }

    /// Kinetic energy of a kick of `h` seconds from rest [J], Σ ½ m |a|² h²: the smallest energy that steps of `h` can
    /// resolve.
    pub fn kick(&self, at: &StateView<'_, V>, h: f64) -> f64 {
        let accelerations = self.accelerations(at).enumerate().filter(|&(index, _)| !self.properties.is_fixed(index));
        accelerations.map(|(index, a)| 0.5 * self.properties.mass[index] * a.widen().length_squared() * h * h).sum()
    }

    /// Acceleration of every particle at a state [m/s²], without springs for a method that projects them.
    pub fn accelerations<'a>(&'a self, at: &'a StateView<'_, V>) -> impl Iterator<Item = V> + 'a {
        self.accelerated(at, false)
    }

    /// Acceleration of every particle at a state by all forces [m/s²].
    pub fn all_accelerations<'a>(&'a self, at: &'a StateView<'_, V>) -> impl Iterator<Item = V> + 'a {
        self.accelerated(at, self.treatment == Treatment::Projections)
    }

    fn accelerated<'a>(&'a self, at: &'a StateView<'_, V>, springs: bool) -> impl Iterator<Item = V> + 'a {
        let count = self.properties.count();
        let mut force = Columns::<V>::zeros(count);
        let mut power = [[0.0; LANES]; SINKS];
        let mut rates = Rates::new(force.span(), &mut power);
        self.accumulate(&(0..padded(count)), at, &mut rates);
        if springs {
            let between = &self.forces[self.fused..self.together];
            between.iter().for_each(|force| force.accumulate(0..padded(count), at, &mut rates));
        }
        (0..count).map(move |index| {
            let inverse_mass = self.properties.inverse_mass[index];
            V::from_axes(|axis| {
                let (x, v) = (at.position.axis(axis)[index], at.velocity.axis(axis)[index]);
                force.axis(axis)[index] * inverse_mass + self.linear.acceleration(axis, index, x, v)
            })
        })
    }

    /// Adds the power −F·v of the constraint of every fixed particle with velocity v, against the forces F of its partners.
    fn count_reactions(&self, block: &Range<usize>, at: &StateView<'_, V>, rates: &mut Rates<'_, V>) {
        for index in block.start..block.end.min(self.properties.count()) {
            if self.properties.is_fixed(index) {
                let force = rates.force.get(index - block.start).widen();
                rates.power[EnergySink::Work as usize][index % LANES] -= force.dot(at.velocity.get(index).widen());
            }
        }
    }

    /// Potential energy of the particles of one block in pointwise forces [J].
    pub fn potential(&self, block: &Range<usize>, at: &StateView<'_, V>) -> f64 {
        let pointwise = self.forces[..self.fused].iter().chain(&self.forces[self.together..]);
        pointwise.map(|force| force.potential(block.clone(), at)).sum()
    }

    /// Potential energy of all particles in user-defined forces [J].
    pub fn potential_of_callbacks(&self, at: &StateView<'_, V>) -> Result<f64> {
        if self.callbacks == 0 {
            return Ok(0.0);
        }
        let mut ledger = Ledger::new(0, 1);
        let mut callbacks = self.forces.iter().filter(|force| force.about().callback);
        callbacks.try_for_each(|force| force.energy(at, &mut ledger))?;
        Ok(ledger.sum(Class::Potential))
    }
}
