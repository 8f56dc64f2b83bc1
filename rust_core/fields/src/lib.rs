//! Systems on uniform grids, one folder each.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "references may be the C library's"))]

pub mod reaction_diffusion;
#[cfg(test)]
#[expect(dead_code, reason = "the tests of the engine use the rest")]
mod scenes;
pub mod schrodinger;
pub mod wave;

use physcore_base::{error, grid, history, integrators, ledger, math, memory, parallel, plan, scene, simd, stability, systems};
