//! Tests of motion: closed forms, conservation, and rest.

mod energy;
mod heap;
mod joints;
pub(crate) mod laboratory;
mod plane;
mod springs;
mod surfaces;
