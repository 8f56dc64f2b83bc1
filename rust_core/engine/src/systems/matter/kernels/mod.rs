//! The inner loops: an integrator's steps or stages over the lanes of one block.
//!
//! [`linear_steps`] runs whole steps of the linear force in registers. [`stage`] runs one stage with forces that were
//! accumulated before. Both evaluate the linear force in the same way, so only scenes with further forces pay for the
//! general loop. [`point_force_steps`] runs whole steps under one force field, such as that of a star or a nucleus.
//! [`gyration`] makes Boris' kick of accumulated forces, [`gyration_steps`] whole steps of it in E and B alone.
//! [`accelerations`] serves methods that keep the stages themselves.

mod acceleration;
mod activity;
mod axis_force;
mod components;
mod gyration;
mod gyration_steps;
mod linear_steps;
mod point_force_steps;
mod power;
mod stage;

pub use acceleration::accelerations;
pub use activity::{activity, out_of_range};
pub use gyration::gyrate;
pub use gyration_steps::gyration_steps;
pub use linear_steps::steps;
pub use point_force_steps::point_force_steps;
pub use power::{integrate, through_all};
pub use stage::{Action, Evaluation, kicked, stage};
