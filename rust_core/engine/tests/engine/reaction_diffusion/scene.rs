//! Simulations of two species.

use physcore_engine::ledger::Budget;
use physcore_engine::parallel::SERIAL;
use physcore_engine::simulation::Simulation;

pub use crate::grids::*;
pub use crate::scenes::reaction_diffusion::*;

/// Values of a species.
pub fn values(simulation: &Simulation, species: &str) -> Vec<f64> {
    simulation.read(&format!("systems[0].{species}")).unwrap().1
}

/// Budgets of all species.
pub fn budgets(simulation: &Simulation) -> Vec<Budget> {
    simulation.energy(&SERIAL).unwrap().budgets().to_vec()
}
