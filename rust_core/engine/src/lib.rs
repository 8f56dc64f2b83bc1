//! physcore's engine. The way of the data:
//!
//! [`scene::Scene`] says what there is → [`systems::build`] compiles it into a [`systems::System`], a state with its law of
//! motion → [`simulation::Simulation`] is a clock and a divergence monitor over it → [`ledger::Ledger`] is its energy budget,
//! [`plan::Plan`] says what it does, [`stability`] bounds the step.
//!
//! Matter advances by a method, as an explicit integrator ([`integrators`]), which asks the [`forces`] for accelerations (those
//! between pairs go by the lists of [`neighbors`]) and the [`boundaries`] for contacts, block by block, on the threads of
//! [`parallel`] and at the SIMD level of [`simd`].

pub mod boundaries;
pub mod columns;
pub mod contacts;
pub mod error;
pub mod forces;
pub mod history;
pub mod integrators;
pub mod ledger;
pub mod math;
pub mod matter;
pub mod memory;
pub mod neighbors;
pub mod parallel;
pub mod plan;
pub mod scene;
pub mod simd;
pub mod simulation;
pub mod stability;
pub mod systems;
pub mod tally;
