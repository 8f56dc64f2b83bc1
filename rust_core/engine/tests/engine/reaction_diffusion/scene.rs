//! Simulations of two species.

use physcore_engine::ledger::Budget;
use physcore_engine::parallel::SERIAL;
use physcore_engine::simulation::Simulation;

pub use crate::grids::*;
pub use crate::scenes::reaction_diffusion::*;

/// The values of a species.
pub fn values(simulation: &Simulation, species: &str) -> Vec<f64> {
    simulation.read(&format!("systems[0].{species}")).unwrap().1
}

/// The budgets of all species.
pub fn budgets(simulation: &Simulation) -> Vec<Budget> {
    simulation.energy(&SERIAL).unwrap().budgets().to_vec()
}
