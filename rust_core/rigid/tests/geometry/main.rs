//! Shapes, their mass properties, contacts and distances.

#![allow(clippy::disallowed_methods, reason = "references may be the C library's")]

mod boundaries;
mod broad;
mod extremes;
mod gaps;
mod mass;
mod moved;
mod reference;
mod resting;
mod samples;
mod surfaces;
