//! Laws that scenes can declare in Python.

use physcore_engine::catalog::Catalog;
use physcore_fluids::FLUIDS;
use physcore_forces::FORCES;

/// All forces and fluids.
pub const CATALOG: Catalog = Catalog { forces: FORCES, fluids: FLUIDS };
