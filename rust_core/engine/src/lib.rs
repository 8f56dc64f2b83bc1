//! physcore's engine. Data flow:
//!
//! [`scene::Scene`] declares the model → [`systems::build`] compiles it into a [`systems::System`], a state with its law of
//! motion → [`simulation::Simulation`] is a clock and a divergence monitor over it → [`ledger::Ledger`] is its energy
//! budget, [`plan::Plan`] describes its steps, [`stability`] bounds the time step.
//!
//! Matter advances by a method, such as an explicit integrator ([`integrators`]), which evaluates the [`forces`] (those
//! between pairs by the lists of [`neighbors`]) and resolves contacts with the [`boundaries`], block by block, on the
//! threads of [`parallel`] and at the SIMD level of [`simd`].

pub mod adjacency;
pub mod aligned;
pub mod boundaries;
pub mod columns;
pub mod contacts;
pub mod error;
pub mod forces;
pub mod grid;
pub mod history;
pub mod integrators;
pub mod ledger;
pub mod math;
pub mod matter;
pub mod memory;
pub mod neighbors;
pub mod parallel;
pub mod plan;
pub mod rods;
pub mod scene;
pub mod self_contact;
pub mod simd;
pub mod simulation;
pub mod sparse;
pub mod stability;
pub mod systems;
pub mod tally;

// The scenes of the integration tests serve unit tests too.
#[cfg(test)]
extern crate self as physcore_engine;
