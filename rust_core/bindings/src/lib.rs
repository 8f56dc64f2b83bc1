//! The extension module `physcore._core`: it converts between Python and the crates beside it, and does nothing else.

use pyo3::prelude::*;

mod arrays;
mod callback;
mod canvas;
mod errors;
mod gif;
mod hull;
mod record;
mod scene;
mod view;
mod world;

/// The module `physcore._core`.
#[pymodule(gil_used = false)]
mod _core {
    use pyo3::prelude::*;

    /// Imports `NumPy` at module initialization: an interrupt during its first use would panic.
    #[pymodule_init]
    fn find_numpy(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.py().import("numpy")?;
        numpy::PyArray1::<f64>::zeros(module.py(), 0, false);
        Ok(())
    }

    #[pymodule_export]
    use super::canvas::{Canvas, Texture, coverage, heatmap, missing_signs, text_width};
    #[pymodule_export]
    use super::gif::Gif;
    #[pymodule_export]
    use super::hull::convex_hull;
    #[pymodule_export]
    use super::view::{Projection, norms, tint};
    #[pymodule_export]
    use super::world::{World, available_memory};
}
