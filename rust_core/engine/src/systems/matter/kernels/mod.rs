//! Inner loops: an integrator's steps or stages over the lanes of one block.
//!
//! - [`linear_steps`]: whole steps of the linear force, in registers.
//! - [`stage`]: one stage with forces that were accumulated before. Only scenes with other forces than the linear one pay for
//!   this general loop; both evaluate the linear force in the same way.
//! - [`point_force_steps`]: whole steps under one force field, such as that of a star or a nucleus.
//! - [`gyration`]: Boris' kick of accumulated forces.
//! - [`gyration_steps`]: whole steps of Boris' method in E and B alone.
//! - [`accelerations`]: for methods with their own stages.

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
pub use stage::{Evaluation, StageAction, kicked, stage};
