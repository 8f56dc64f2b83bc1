//! Energy budget and momenta of matter.

use std::ops::Range;

use glam::DVec3;

use super::constraints::Constraints;
use super::dynamics::Dynamics;
use crate::catalog::Space;
use crate::error::Result;
use crate::ledger::{Class, Ledger};
use crate::matter::{EnergySink, Matter};
use crate::parallel::Executor;

/// Sinks of energy, with their names in the budget.
const SINKS: [(EnergySink, Class, &str); 5] = [
    (EnergySink::Drag, Class::Dissipated, "drag"),
    (EnergySink::Damping, Class::Dissipated, "damping"),
    (EnergySink::Contact, Class::Dissipated, "contacts"),
    (EnergySink::Viscosity, Class::Dissipated, "viscosity"),
    (EnergySink::Work, Class::Work, "work"),
];

/// Energy budget of matter at a time.
///
/// # Errors
/// If a user-defined function fails, or on an interrupt.
pub fn energy<V: Space>(
    dynamics: &Dynamics<V>,
    constraints: &Constraints<V>,
    matter: &Matter<V>,
    time: f64,
    executor: &Executor,
) -> Result<Ledger> {
    let mut ledger = Ledger::new(matter.count(), matter.block);
    ledger.add_blocks(Class::Kinetic, "particles", |block| block.map(|index| kinetic(dynamics, matter, index)).sum());
    let at = dynamics.view_of(matter, time, executor);
    for force in dynamics.forces() {
        force.energy(&at, &mut ledger)?;
        executor.check()?;
    }
    constraints.iter().for_each(|constraint| constraint.energy(&at, &mut ledger));
    for (sink, class, name) in SINKS {
        ledger.add(class, name, matter.tallied(sink));
    }
    Ok(ledger)
}

/// Kinetic energy of a particle [J]; 0 if it is fixed.
pub fn kinetic<V: Space>(dynamics: &Dynamics<V>, matter: &Matter<V>, index: usize) -> f64 {
    let square = matter.velocity.get(index).widen().length_squared();
    if dynamics.properties.is_fixed(index) { 0.0 } else { 0.5 * dynamics.properties.mass[index] * square }
}

/// Momentum [kg·m/s] and angular momentum about the coordinates' origin [kg·m²/s] of all particles that are not fixed.
pub fn momenta<V: Space>(dynamics: &Dynamics<V>, matter: &Matter<V>) -> (DVec3, DVec3) {
    let properties = &dynamics.properties;
    let of = |index: usize| {
        let momentum = matter.velocity.get(index).widen() * properties.mass[index];
        (momentum, (properties.origin + matter.position.get(index).widen()).cross(momentum))
    };
    let add = |sum: (DVec3, DVec3), term: (DVec3, DVec3)| (sum.0 + term.0, sum.1 + term.1);
    let mobile =
        |block: Range<usize>| block.filter(|&index| !properties.is_fixed(index)).map(of).fold((DVec3::ZERO, DVec3::ZERO), add);
    let (count, block) = (matter.count(), matter.block);
    let blocks = (0..count.div_ceil(block)).map(|index| index * block..((index + 1) * block).min(count));
    blocks.map(mobile).fold((DVec3::ZERO, DVec3::ZERO), add)
}
