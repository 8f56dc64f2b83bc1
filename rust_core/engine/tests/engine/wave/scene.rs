//! Simulations of one wave.

use physcore_engine::ledger::Ledger;
use physcore_engine::parallel::SERIAL;
use physcore_engine::simulation::Simulation;

pub use crate::grids::*;
pub use crate::scenes::wave::*;

/// Displacement and rate of the wave.
pub fn fields(simulation: &Simulation) -> [Vec<f64>; 2] {
    ["displacement", "rate"].map(|name| simulation.read(&format!("systems[0].{name}")).unwrap().1)
}

/// Energy budget of the wave.
pub fn energy(simulation: &Simulation) -> Ledger {
    simulation.energy(&SERIAL).unwrap()
}
