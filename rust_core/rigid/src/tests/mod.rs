//! Tests of motion: closed forms, conservation, and rest.

mod laboratory;
mod plane;
