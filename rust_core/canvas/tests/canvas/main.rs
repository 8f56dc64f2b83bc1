//! Tests of the canvas through its public interface, in one binary.

mod coverage;
mod film;
mod light;
mod looks;
mod supersampling;
mod text;
