//! Foundations of every system, in the order of imports:
//!
//! - arrays, errors and memory;
//! - vector instructions ([`simd`]);
//! - numbers and vectors ([`math`]);
//! - scenes as plain numbers ([`scene`]);
//! - threads ([`parallel`]);
//! - persistent data, energy budgets and tallies ([`history`], [`ledger`], [`tally`]);
//! - columns and [`grid`]s;
//! - [`integrators`];
//! - limits of the time step ([`stability`]), and linear [`solvers`];
//! - the trait [`systems::System`].

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "references may be the C library's"))]

pub mod adjacency;
pub mod aligned;
pub mod columns;
pub mod error;
pub mod grid;
pub mod history;
pub mod integrators;
pub mod ledger;
pub mod math;
pub mod memory;
pub mod parallel;
pub mod plan;
pub mod scene;
pub mod simd;
pub mod solvers;
pub mod stability;
pub mod systems;
pub mod tally;
