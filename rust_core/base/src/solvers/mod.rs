//! Solvers that implicit methods, projections, fluids and grids share. They know nothing of what their numbers mean.

pub mod coloring;
pub mod conjugate_gradient;
pub mod impulses;

pub use coloring::colored;
pub use conjugate_gradient::{ConjugateGradient, DefiniteSystem, Solved, VectorComponent};
