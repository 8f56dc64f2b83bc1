//! Tests of motion: closed forms, conservation, and rest.

mod bundles;
mod energy;
mod faces;
mod heap;
mod joints;
pub(crate) mod laboratory;
mod plane;
mod points;
mod sleep;
mod springs;
mod surfaces;
