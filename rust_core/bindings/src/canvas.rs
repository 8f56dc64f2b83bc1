//! The canvas for Python: arrays of shapes in, pixels out, with the interpreter free meanwhile.

#![expect(clippy::needless_pass_by_value, reason = "PyO3 hands arguments over by value")]

use numpy::{PyArray3, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use physcore_canvas::{Align, Disc, Error, Ink, Line, Painting, Rgb};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Pixels that are drawn on.
#[pyclass(module = "physcore._core")]
pub struct Canvas {
    pub(crate) picture: physcore_canvas::Canvas,
    painting: Painting,
}

#[pymethods]
impl Canvas {
    #[new]
    fn new(width: usize, height: usize, background: Rgb) -> PyResult<Self> {
        let picture = physcore_canvas::Canvas::new(width, height, background).map_err(python_error)?;
        Ok(Self { picture, painting: Painting::default() })
    }

    /// Go back to the backdrop.
    fn clear(&mut self) {
        self.picture.clear();
    }

    /// Make the present picture the backdrop.
    fn keep(&mut self) {
        self.picture.keep();
    }

    /// Draw only on these columns and rows from now on.
    fn clip(&mut self, left: usize, top: usize, right: usize, bottom: usize) {
        self.picture.clip(left, top, right, bottom);
    }

    /// Add discs to the painting.
    #[pyo3(signature = (centers, radii, colors, depths=None, shading=0.0))]
    fn discs(
        &mut self,
        centers: PyReadonlyArray2<'_, f32>,
        radii: PyReadonlyArray1<'_, f32>,
        colors: PyReadonlyArray2<'_, u8>,
        depths: Option<PyReadonlyArray1<'_, f32>>,
        shading: f32,
    ) -> PyResult<()> {
        let count = centers.shape()[0];
        let centers = rows::<f32, 2>(&centers, count, "centers")?;
        let colors = rows::<u8, 4>(&colors, count, "colors")?;
        let (radii, depths) = (column(&radii, count, "radii")?, depth(depths.as_ref(), count)?);
        for (index, ((&center, &radius), &color)) in centers.iter().zip(radii).zip(colors).enumerate() {
            let disc = Disc { center, radius, color, shading };
            self.painting.disc(disc, depths.map_or(0.0, |depths| depths[index]));
        }
        Ok(())
    }

    /// Add lines to the painting.
    #[pyo3(signature = (ends, widths, colors, depths=None))]
    fn lines(
        &mut self,
        ends: PyReadonlyArray2<'_, f32>,
        widths: PyReadonlyArray1<'_, f32>,
        colors: PyReadonlyArray2<'_, u8>,
        depths: Option<PyReadonlyArray1<'_, f32>>,
    ) -> PyResult<()> {
        let count = ends.shape()[0];
        let ends = rows::<f32, 4>(&ends, count, "ends")?;
        let colors = rows::<u8, 4>(&colors, count, "colors")?;
        let (widths, depths) = (column(&widths, count, "widths")?, depth(depths.as_ref(), count)?);
        for (index, ((&[x0, y0, x1, y1], &width), &color)) in ends.iter().zip(widths).zip(colors).enumerate() {
            let line = Line { from: [x0, y0], to: [x1, y1], width, color };
            self.painting.line(line, depths.map_or(0.0, |depths| depths[index]));
        }
        Ok(())
    }

    /// Paint all that was added, from the far to the near.
    fn paint(&mut self, py: Python<'_>) {
        let Self { picture, painting } = self;
        py.detach(|| painting.paint(picture));
    }

    /// Fill a convex polygon at once.
    fn polygon(&mut self, corners: PyReadonlyArray2<'_, f32>, color: Ink) -> PyResult<()> {
        let corners = rows::<f32, 2>(&corners, corners.shape()[0], "corners")?;
        self.picture.polygon(corners, color);
        Ok(())
    }

    /// Write one line of text at once; `align` is -1, 0 or 1 for left, center and right.
    fn text(&mut self, text: &str, x: i32, y: i32, height: usize, color: Ink, align: i32) {
        let align = match align {
            ..0 => Align::Left,
            0 => Align::Center,
            1.. => Align::Right,
        };
        self.picture.text(text, [x, y], height, color, align);
    }

    /// A copy of the pixels, (height, width, 3).
    fn pixels<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<u8>>> {
        let bytes: Vec<u8> = self.picture.pixels().iter().flat_map(|&[red, green, blue, _]| [red, green, blue]).collect();
        numpy::PyArray1::from_vec(py, bytes).reshape([self.picture.height(), self.picture.width(), 3])
    }
}

pub(crate) fn python_error(error: Error) -> PyErr {
    match error {
        Error::Write(cause) => cause.into(),
        other => PyValueError::new_err(other.to_string()),
    }
}

/// An (N, W) array as N rows of W values.
fn rows<'a, T: numpy::Element, const W: usize>(
    array: &'a PyReadonlyArray2<'_, T>,
    count: usize,
    name: &str,
) -> PyResult<&'a [[T; W]]> {
    let values = array.as_slice().map_err(|_| PyValueError::new_err(format!("{name}: must be C-contiguous")))?;
    let (rows, rest) = values.as_chunks::<W>();
    if array.shape() != [count, W] || !rest.is_empty() {
        return Err(PyValueError::new_err(format!("{name}: must have the shape ({count}, {W}), got {:?}", array.shape())));
    }
    Ok(rows)
}

fn column<'a>(array: &'a PyReadonlyArray1<'_, f32>, count: usize, name: &str) -> PyResult<&'a [f32]> {
    let values = array.as_slice().map_err(|_| PyValueError::new_err(format!("{name}: must be C-contiguous")))?;
    if values.len() != count {
        return Err(PyValueError::new_err(format!("{name}: must have the shape ({count},), got ({},)", values.len())));
    }
    Ok(values)
}

fn depth<'a>(depths: Option<&'a PyReadonlyArray1<'_, f32>>, count: usize) -> PyResult<Option<&'a [f32]>> {
    depths.map(|depths| column(depths, count, "depths")).transpose()
}
