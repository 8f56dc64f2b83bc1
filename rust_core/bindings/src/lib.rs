//! Extension module `physcore._core`: converts between Python and the other crates, and does nothing else.

use pyo3::prelude::*;

mod arrays;
mod callback;
mod canvas;
mod curve;
mod elementary;
mod errors;
mod gif;
mod hull;
mod laws;
mod methods;
mod record;
mod scene;
mod shape;
mod view;
mod world;

/// Extension module `physcore._core`.
#[pymodule(gil_used = false)]
mod _core {
    use std::path::Path;

    use physcore_engine::simd::Level;
    use pyo3::exceptions::PyImportError;
    use pyo3::prelude::*;

    /// Refuses unsupported processors, says where a font is, and imports `NumPy` early: an interrupt during its first use would
    /// panic.
    #[pymodule_init]
    fn look_around(module: &Bound<'_, PyModule>) -> PyResult<()> {
        if !Level::is_supported() {
            return Err(PyImportError::new_err(
                "physcore needs a processor with AVX2 and FMA (x86-64 since 2013), which this one lacks",
            ));
        }
        let package = Path::new(module.filename()?.to_str()?).with_file_name("film");
        physcore_canvas::set_fallback_font(package.join("fonts/droid-sans-fallback.ttf"));
        module.py().import("numpy")?;
        numpy::PyArray1::<f64>::zeros(module.py(), 0, false);
        Ok(())
    }

    #[pymodule_export]
    use super::canvas::{PyCanvas, PySky, PyTexture, coverage, heatmap, missing_signs, text_width};
    #[pymodule_export]
    use super::curve::spline_points;
    #[pymodule_export]
    use super::elementary::{arctan2, cos, exp, log, power, sin};
    #[pymodule_export]
    use super::gif::PyGif;
    #[pymodule_export]
    use super::hull::convex_hull;
    #[pymodule_export]
    use super::methods::advances;
    #[pymodule_export]
    use super::shape::{points_inside, rigid_overlaps, shape_properties};
    #[pymodule_export]
    use super::view::{PyProjection, norms, tint};
    #[pymodule_export]
    use super::world::{World, available_memory};
}
