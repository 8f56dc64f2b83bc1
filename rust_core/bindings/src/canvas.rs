//! The canvas and the GIF for Python: arrays of shapes in, pixels and files out, with the interpreter free meanwhile.

#![expect(clippy::needless_pass_by_value, reason = "PyO3 hands arguments over by value")]

use std::io::{self, Write};
use std::path::PathBuf;

use numpy::{PyArray3, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use physcore_canvas::{Align, Disc, Error, Histogram, Ink, Line, NewFile, Painting, Palette, Rgb};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

/// Pixels that are drawn on.
#[pyclass(module = "physcore._core")]
pub struct Canvas {
    picture: physcore_canvas::Canvas,
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

/// A GIF in the making: first some frames are observed, then all are added.
#[pyclass(module = "physcore._core")]
pub struct Gif {
    histogram: Histogram,
    reserved: Vec<Rgb>,
    state: State,
}

enum State {
    Observing(Sink),
    Writing(Box<physcore_canvas::Gif<Sink>>),
    Closed,
}

/// Where the bytes go.
enum Sink {
    File(NewFile),
    Memory(Vec<u8>),
}

#[pymethods]
impl Gif {
    /// `reserved` are colors that the palette holds exactly. Without a path the bytes stay in memory.
    #[new]
    fn new(path: Option<PathBuf>, reserved: Vec<Rgb>) -> PyResult<Self> {
        let sink = match path {
            Some(path) => Sink::File(NewFile::create(&path)?),
            None => Sink::Memory(Vec::new()),
        };
        Ok(Self { histogram: Histogram::default(), reserved, state: State::Observing(sink) })
    }

    /// Let a frame's colors count for the palette.
    fn observe(&mut self, py: Python<'_>, canvas: &Canvas) {
        let histogram = &mut self.histogram;
        py.detach(|| histogram.observe(&canvas.picture));
    }

    /// Append a frame that is shown for `delay` hundredths of a second; the first one fixes the palette.
    fn frame(&mut self, py: Python<'_>, canvas: &Canvas, delay: u16) -> PyResult<()> {
        let (picture, Self { histogram, reserved, state }) = (&canvas.picture, self);
        let written = py.detach(|| {
            if let State::Observing(_) = state {
                let State::Observing(sink) = std::mem::replace(state, State::Closed) else {
                    return Ok(());
                };
                let palette = Palette::new(histogram, reserved);
                let gif = physcore_canvas::Gif::new(sink, picture, palette)?;
                *state = State::Writing(Box::new(gif));
            }
            match state {
                State::Writing(gif) => gif.frame(picture, delay),
                _ => Err(Error::Write(io::Error::other("the film is closed"))),
            }
        });
        written.map_err(python_error)
    }

    /// End the film: put the file under its name, or give the bytes.
    fn finish<'py>(&mut self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyBytes>>> {
        let State::Writing(gif) = std::mem::replace(&mut self.state, State::Closed) else {
            return Err(PyValueError::new_err("a film must have a frame"));
        };
        let sink = py.detach(|| -> Result<Sink, Error> {
            let sink = gif.finish()?;
            Ok(match sink {
                Sink::File(file) => {
                    file.commit()?;
                    Sink::Memory(Vec::new())
                }
                memory @ Sink::Memory(_) => memory,
            })
        });
        match sink.map_err(python_error)? {
            Sink::Memory(bytes) if !bytes.is_empty() => Ok(Some(PyBytes::new(py, &bytes))),
            _ => Ok(None),
        }
    }

    /// Give up: the file under the name stays as it was. Does nothing after `finish`.
    fn close(&mut self) {
        self.state = State::Closed;
    }
}

impl Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Self::File(file) => file.write(bytes),
            Self::Memory(memory) => memory.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self {
            Self::File(file) => file.flush(),
            Self::Memory(_) => Ok(()),
        }
    }
}

fn python_error(error: Error) -> PyErr {
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
