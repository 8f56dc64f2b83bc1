//! Particles and what acts on them: their state ([`matter`]), neighbor lists ([`neighbors`]), walls ([`boundaries`]), and forces as a
//! step sees them ([`forces`]). The crates of forces and fluids implement these traits. The engine builds them by a [`catalog`].

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "references may be the C library's"))]

pub mod boundaries;
pub mod catalog;
pub mod forces;
pub mod matter;
pub mod neighbors;

use physcore_base::{
    adjacency, aligned, columns, error, history, integrators, ledger, math, memory, parallel, scene, simd, stability, tally,
};
