//! Simulations of one wave.

use physcore_engine::ledger::Ledger;
use physcore_engine::parallel::SERIAL;
use physcore_engine::simulation::Simulation;

pub use crate::grids::*;
pub use crate::scenes::wave::*;

/// Its displacement and its rate.
pub fn fields(simulation: &Simulation) -> [Vec<f64>; 2] {
    ["displacement", "rate"].map(|name| simulation.read(&format!("systems[0].{name}")).unwrap().1)
}

/// Its energy budget.
pub fn energy(simulation: &Simulation) -> Ledger {
    simulation.energy(&SERIAL).unwrap()
}
