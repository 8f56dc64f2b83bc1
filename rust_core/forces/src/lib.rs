//! Forces on particles: the state of matter ([`matter`]), neighbor lists ([`neighbors`]), walls ([`boundaries`]), parts of particle
//! methods for fluids ([`particles`]), the laws ([`forces`]), and methods for fluids ([`fluids`]).
//!
//! [`Space`] compiles all forces in this crate, so that an edit elsewhere does not compile them again.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "references may be the C library's"))]

pub mod boundaries;
pub mod fluids;
pub mod forces;
pub mod matter;
pub mod neighbors;
pub mod particles;
mod space;

pub use forces::Space;
use physcore_base::{
    adjacency, aligned, columns, error, history, integrators, ledger, math, memory, parallel, scene, simd, stability, systems,
    tally,
};
