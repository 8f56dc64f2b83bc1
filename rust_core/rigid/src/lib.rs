//! Rigid bodies, in double precision; the plane is z = 0 in space. In the order of imports:
//!
//! - [`pose`]s and points of [`contact`];
//! - shapes, their mass properties and their contacts.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "references may be the C library's"))]

pub mod contact;
pub mod impacts;
pub mod island;
pub mod joints;
pub mod mover;
pub mod pose;
pub mod rotation;
pub mod rows;
pub mod sweeps;
pub mod world;
