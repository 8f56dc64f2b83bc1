//! Forces on particles: the state of matter ([`matter`]), neighbor lists ([`neighbors`]), walls ([`boundaries`]), and the laws
//! ([`forces`]). Methods for fluids ([`fluids`]) stand on parts that they share ([`particles`]).

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
    adjacency, aligned, columns, error, history, integrators, ledger, math, memory, parallel, scene, simd, stability, tally,
};
