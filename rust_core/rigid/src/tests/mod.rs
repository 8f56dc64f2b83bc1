//! Tests of motion: closed forms, conservation, and rest.

mod joints;
mod laboratory;
mod plane;
mod springs;
mod surfaces;
