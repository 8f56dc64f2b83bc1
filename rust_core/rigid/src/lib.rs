//! Rigid bodies, in double precision; the plane is z = 0 in space. In the order of imports:
//!
//! - [`pose`]s and points of [`contact`];
//! - [`shapes`] and their mass properties;
//! - contacts of convex parts, planar and spatial, and of whole shapes ([`collision`]);
//! - pairs of bodies that are near each other ([`broad`]);
//! - free [`rotation`], bodies during a step ([`mover`]), [`joints`] and their [`rows`] of impulses;
//! - steps of a group of bodies ([`island`]): with each impact at its time ([`impacts`]), or of large groups ([`sweeps`]);
//! - the [`world`] of all bodies, and the springs between them.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "references may be the C library's"))]

pub mod broad;
pub mod collision;
pub mod contact;
mod couple;
mod direct;
mod ground;
pub mod impacts;
pub mod island;
pub mod joints;
pub mod mover;
mod planar;
pub mod pose;
pub mod rotation;
pub mod rows;
pub mod shapes;
mod spatial;
mod springs;
pub mod sweeps;
mod thinning;
pub mod world;

#[cfg(test)]
mod tests;
