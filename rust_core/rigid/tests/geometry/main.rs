//! Shapes, their mass properties, contacts and distances.

mod resting;
mod samples;
