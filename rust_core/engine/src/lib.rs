//! physcore's engine. Data flow:
//!
//! [`scene::Scene`] declares the model → [`systems::build`] compiles it into a [`systems::System`], a state with its law of
//! motion → [`simulation::Simulation`] is a clock and a divergence monitor over it → [`ledger::Ledger`] is its energy
//! budget, [`plan::Plan`] describes its steps, [`stability`] bounds the time step.
//!
//! Matter advances by a method, such as an explicit integrator ([`integrators`]), which evaluates the [`forces`] (those
//! between pairs by the lists of [`neighbors`]) and resolves contacts with the [`boundaries`], block by block, on the
//! threads of [`parallel`] and at the SIMD level of [`simd`].

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "references may be the C library's"))]

pub mod boundaries;
pub mod contacts;
pub mod forces;
pub mod matter;
pub mod neighbors;
pub mod rods;
pub mod self_contact;
pub mod simulation;
pub mod sparse;
pub mod systems;

pub use physcore_base::{
    adjacency, aligned, columns, error, grid, history, integrators, ledger, math, memory, parallel, plan, scene, simd, stability,
    tally, with_integrator,
};
