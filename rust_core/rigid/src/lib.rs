//! Rigid bodies, in double precision; the plane is z = 0 in space. In the order of imports:
//!
//! - [`pose`]s and points of [`contact`];
//! - [`shapes`] and their mass properties;
//! - contacts of convex parts, planar and spatial, and of whole shapes ([`collision`]);
//! - pairs of bodies that are near each other ([`broad`]).

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "references may be the C library's"))]

pub mod broad;
pub mod collision;
pub mod contact;
mod couple;
mod planar;
pub mod pose;
pub mod shapes;
mod spatial;
