//! Couplings: interactions of different systems of a scene.

use super::System;

/// System of a scene.
pub struct SystemPart {
    /// Name of the item that declares the system; empty for matter.
    pub name: String,
    /// The system.
    pub system: Box<dyn System>,
}

/// Interaction of different systems.
pub trait Coupling: Send + Sync {
    /// Indices of the two systems, which take the same steps.
    fn systems(&self) -> [usize; 2];

    /// Updates what the systems know of each other, in a state that no step led to: at the start, after a rollback, and after a
    /// change of fields.
    fn update(&self, systems: &mut [SystemPart]);

    /// Passes on the steps that the system `advanced` has taken, before later systems take theirs.
    fn follow(&self, systems: &mut [SystemPart], advanced: usize);
}
