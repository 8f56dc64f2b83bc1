//! Shapes, their mass properties, contacts and distances.

mod broad;
mod gaps;
mod mass;
mod reference;
mod resting;
mod samples;
