//! The extension module `physcore._core`: it converts between Python and the crates beside it, and does nothing else.

use pyo3::prelude::*;

mod canvas;
mod errors;
mod gif;
mod scene;
mod world;

/// What `import physcore._core` gives.
#[pymodule(gil_used = false)]
mod _core {
    #[pymodule_export]
    use super::canvas::Canvas;
    #[pymodule_export]
    use super::gif::Gif;
    #[pymodule_export]
    use super::world::World;
}
