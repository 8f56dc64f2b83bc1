//! The largest time step: a certified bound from the stiffness and damping of all terms.

/// What the terms of a scene contribute to the bound.
#[derive(Debug, Default)]
pub struct Bound {}
