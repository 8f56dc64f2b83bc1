//! Shapes, their mass properties, contacts and distances.

#![allow(clippy::disallowed_methods, reason = "references may be the C library's")]

mod broad;
mod gaps;
mod mass;
mod reference;
mod resting;
mod samples;
