//! physcore's engine. Data flow:
//!
//! A [`scene::Scene`] declares the model. It is compiled by [`systems::build`] into a [`systems::System`], a state with its
//! law of motion. A [`simulation::Simulation`] is a clock and a divergence monitor over it. Its energy budget is a
//! [`ledger::Ledger`]. Its steps are described by a [`plan::Plan`], and [`stability`] bounds the time step.
//!
//! Matter advances by a method, such as an explicit integrator ([`integrators`]). The method evaluates the [`forces`]; pair
//! forces use the lists of [`neighbors`]. It resolves contacts with the [`boundaries`], block by block, on the threads of
//! [`parallel`] and at the SIMD level of [`simd`].

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "references may be the C library's"))]

pub mod contacts;
pub mod simulation;
pub mod sparse;
pub mod systems;

pub use physcore_base::{
    adjacency, aligned, columns, error, grid, history, integrators, ledger, math, memory, parallel, plan, scene, simd, solvers,
    stability, tally, with_integrator,
};
pub use physcore_matter::{boundaries, catalog, forces, matter, neighbors};
