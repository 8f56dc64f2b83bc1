//! Benchmarks: `cargo bench -p physcore-benches`.

use physcore_engine::catalog::Catalog;

/// All forces and fluids.
pub const CATALOG: Catalog = Catalog { forces: physcore_forces::FORCES, fluids: physcore_fluids::FLUIDS };
