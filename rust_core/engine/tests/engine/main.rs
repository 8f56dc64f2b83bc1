//! Tests of the engine through its public interface, in one binary: the engine is linked once.

#![allow(clippy::disallowed_methods, reason = "references may be the C library's")]

mod allocations;
mod contacts;
mod derivatives;
mod forces;
mod fuzz;
mod grids;
mod items;
mod layers;
mod linear_forces;
mod neighbors;
mod reaction_diffusion;
#[path = "../../../fields/src/scenes/mod.rs"]
mod scenes;
mod stability;
mod wave;

use physcore_engine::catalog::Catalog;

/// All forces and fluids.
const CATALOG: Catalog = Catalog { forces: physcore_forces::FORCES, fluids: physcore_fluids::FLUIDS };
