//! Systems on grids as items, for unit tests and for the tests of the engine, which include this folder.

pub mod grids;
pub mod reaction_diffusion;
pub mod wave;
