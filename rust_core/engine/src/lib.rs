//! physcore's engine. The way of the data:
//!
//! [`scene::Scene`] says what there is → [`plan::Plan`] is what that requires → [`simulation::Simulation`] owns the state
//! and the clock, and lets a [`systems::System`] advance it: [`systems`] drive an integrator ([`integrators`]) over
//! [`matter`], asking the [`forces`] for accelerations (those between pairs go by the lists of [`neighbors`]) and the
//! [`boundaries`] for contacts, block by block, on the threads of [`parallel`] and at the SIMD level of [`simd`] →
//! [`audit`] proves the energy, [`stability`] bounds the step.

pub mod audit;
pub mod boundaries;
pub mod columns;
pub mod contacts;
pub mod error;
pub mod forces;
pub mod integrators;
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
