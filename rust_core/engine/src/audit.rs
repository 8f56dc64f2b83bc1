//! The audit: where the energy is, and what the momentum is. Always in double precision, always summed block by block in
//! the order of the particles.

use std::ops::Range;

use glam::DVec3;

use crate::error::Result;
use crate::math::Vector;
use crate::matter::{EnergySink, Matter};
use crate::parallel::Executor;
use crate::systems::matter::Dynamics;

/// The energy at one moment.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Energy {
    /// Kinetic energy of all particles that are not fixed [J].
    pub kinetic: f64,
    /// Potential energy by the name of the force [J].
    pub potential: Vec<(&'static str, f64)>,
    /// Internal energy of fluids, by compression [J].
    pub internal: f64,
    /// What has been dissipated since the start [J], by what took it: drag, damping of springs, contacts, viscosity.
    pub dissipated: [f64; 4],
    /// The work done since the start by drivers, wind, custom forces, fixed particles that move, and the shifting of fluids [J].
    pub work: f64,
}

impl Energy {
    /// Kinetic, potential and internal energy [J].
    pub fn total(&self) -> f64 {
        self.kinetic + self.internal + self.potential.iter().map(|(_, energy)| energy).sum::<f64>()
    }

    /// All that has been dissipated [J].
    pub fn dissipated(&self) -> f64 {
        self.dissipated.iter().sum()
    }

    /// What stays constant but for the integrator's error [J].
    pub fn balance(&self) -> f64 {
        self.total() + self.dissipated() - self.work
    }

    /// The size of the numbers that the balance is the sum of [J].
    pub fn magnitude(&self) -> f64 {
        let potential: f64 = self.potential.iter().map(|(_, energy)| energy.abs()).sum();
        self.kinetic + potential + self.internal + self.dissipated() + self.work.abs()
    }
}

fn blocks<V: Vector>(matter: &Matter<V>) -> impl Iterator<Item = Range<usize>> {
    let (count, block) = (matter.count(), matter.block);
    (0..count.div_ceil(block)).map(move |index| index * block..((index + 1) * block).min(count))
}

/// The energy of matter at a time.
///
/// # Errors
/// If a function of the user's fails, or the executor was asked to stop.
pub fn energy<V: Vector>(dynamics: &Dynamics<V>, matter: &Matter<V>, time: f64, executor: &Executor) -> Result<Energy> {
    let properties = &dynamics.properties;
    let kinetic = |index: usize| {
        let square = matter.velocity.get(index).widen().length_squared();
        if properties.is_fixed(index) { 0.0 } else { 0.5 * properties.mass[index] * square }
    };
    let at = dynamics.view_of(matter, time, executor);
    let mut potential: Vec<(&'static str, f64)> = Vec::new();
    for force in dynamics.forces().iter().filter(|force| force.has_potential()) {
        let energy = blocks(matter).map(|block| force.potential(block, &at)).sum::<f64>() + force.potential_of_all(&at)?;
        executor.check()?;
        let name = force.potential_name();
        match potential.iter_mut().find(|(other, _)| *other == name) {
            Some((_, sum)) => *sum += energy,
            None => potential.push((name, energy)),
        }
    }
    Ok(Energy {
        kinetic: blocks(matter).map(|block| block.map(kinetic).sum::<f64>()).sum(),
        potential,
        internal: dynamics.forces().iter().map(|force| force.internal()).sum(),
        dissipated: [EnergySink::Drag, EnergySink::Damping, EnergySink::Contact, EnergySink::Viscosity]
            .map(|sink| matter.tallied(sink)),
        work: matter.tallied(EnergySink::Work),
    })
}

/// The momentum [kg·m/s] and the angular momentum about the coordinates' origin [kg·m²/s] of all particles that are not
/// fixed.
pub fn momenta<V: Vector>(dynamics: &Dynamics<V>, matter: &Matter<V>) -> (DVec3, DVec3) {
    let properties = &dynamics.properties;
    let of = |index: usize| {
        let momentum = matter.velocity.get(index).widen() * properties.mass[index];
        (momentum, (properties.origin + matter.position.get(index).widen()).cross(momentum))
    };
    let add = |sum: (DVec3, DVec3), term: (DVec3, DVec3)| (sum.0 + term.0, sum.1 + term.1);
    let mobile =
        |block: Range<usize>| block.filter(|&index| !properties.is_fixed(index)).map(of).fold((DVec3::ZERO, DVec3::ZERO), add);
    blocks(matter).map(mobile).fold((DVec3::ZERO, DVec3::ZERO), add)
}
