//! Tests of wave functions.
