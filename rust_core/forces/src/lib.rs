//! Forces on particles: the state of matter ([`matter`]), neighbor lists ([`neighbors`]), walls ([`boundaries`]) and the laws
//! ([`forces`]).
//!
//! [`Space`] compiles all forces in this crate, so that an edit elsewhere does not compile them again.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "references may be the C library's"))]

pub mod boundaries;
pub mod forces;
pub mod matter;
pub mod neighbors;

pub use forces::Space;
use physcore_base::{
    adjacency, aligned, columns, error, history, integrators, ledger, math, memory, parallel, scene, simd, stability, tally,
};
