//! Constraints: conditions on the positions and velocities of particles.

pub mod rods;
pub mod self_contact;
pub mod tearing;
