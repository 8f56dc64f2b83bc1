//! The extension module `physcore._core`: it converts between Python and the crates beside it, and does nothing else.

use pyo3::prelude::*;

mod arrays;
mod callback;
mod canvas;
mod errors;
mod gif;
mod scene;
mod view;
mod world;

/// What `import physcore._core` gives.
#[pymodule(gil_used = false)]
mod _core {
    #[pymodule_export]
    use super::canvas::{Canvas, Texture};
    #[pymodule_export]
    use super::gif::Gif;
    #[pymodule_export]
    use super::view::{Projection, norms, tint};
    #[pymodule_export]
    use super::world::{World, available_memory};
}
