//! Rigid bodies, in double precision; the plane is z = 0 in space. In the order of imports:
//!
//! - [`pose`]s and points of [`contact`];
//! - [`shapes`] and their mass properties;
//! - contacts of convex parts, planar and spatial, and of whole shapes ([`collision`]);
//! - pairs of bodies that are near each other ([`broad`]);
//! - free rotation by splitting, [`rotation`]s, bodies during a step ([`mover`]), [`face`]s of networks, [`surface`]s, [`joints`], and
//!   rows of impulses;
//! - steps of a group of bodies: with each impact at its time, or of large groups in sweeps;
//! - the [`world`] of all bodies, and the springs between them.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "references may be the C library's"))]

pub mod broad;
pub mod collision;
pub mod contact;
mod couple;
mod direct;
pub mod face;
mod ground;
mod impacts;
mod island;
mod joint_system;
pub mod joints;
mod limits;
mod lu;
pub mod mover;
mod planar;
pub mod pose;
pub mod rotation;
mod rows;
pub mod shapes;
mod spatial;
mod splitting;
pub mod surface;
mod sweep_steps;
mod sweeps;
mod thinning;
pub mod world;

#[cfg(test)]
mod tests;
