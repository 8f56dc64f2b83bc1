//! GIF encoder for Python: canvases in, a file or bytes out. The interpreter is free meanwhile.

use std::io::{self, Write};
use std::path::PathBuf;

use physcore_canvas::{Background, CanvasError, Histogram, NewFile, Palette, Rgb};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::canvas::{PyCanvas, python_error};

/// GIF writer: some frames are observed for the palette, then all frames are appended.
#[pyclass(name = "Gif", module = "physcore._core")]
pub struct PyGif {
    histogram: Histogram,
    reserved: Vec<Rgb>,
    colors: u8,
    tolerance: f32,
    state: WriterState,
}

enum WriterState {
    Observing(Sink),
    Writing(Box<Background<Sink>>),
    Closed,
}

/// Destination of the encoded bytes.
enum Sink {
    File(NewFile),
    Memory(Vec<u8>),
}

#[pymethods]
impl PyGif {
    /// Create a writer. `reserved` are colors that the palette holds exactly, among `colors` from 2 to 255. Without a path the
    /// bytes stay in memory.
    #[new]
    #[pyo3(signature = (path, reserved, *, colors = 255))]
    fn new(path: Option<PathBuf>, reserved: Vec<Rgb>, colors: i64) -> PyResult<Self> {
        let colors = match u8::try_from(colors) {
            Ok(count) if count >= 2 => count,
            _ => return Err(PyValueError::new_err(format!("colors: must be from 2 to 255, got {colors}"))),
        };
        let sink = match path {
            Some(path) => Sink::File(NewFile::create(&path)?),
            None => Sink::Memory(Vec::new()),
        };
        Ok(Self { histogram: Histogram::default(), reserved, colors, tolerance: 0.0, state: WriterState::Observing(sink) })
    }

    /// Add a frame's colors to the histogram of the palette.
    fn observe(&mut self, py: Python<'_>, canvas: &PyCanvas) {
        let histogram = &mut self.histogram;
        py.detach(|| histogram.observe(&canvas.picture.reduced()));
    }

    /// Add colors similar to none observed.
    #[expect(clippy::needless_pass_by_value, reason = "PyO3 hands arguments over by value")]
    fn include(&mut self, colors: Vec<Rgb>) {
        self.histogram.include(&colors);
    }

    /// Append a frame that is shown for `delay` hundredths of a second; the first one fixes the palette. The frame is copied, and
    /// encoded while the next one is drawn. The canvas is therefore free at once, and a failure may be reported by a later call.
    fn frame(&mut self, py: Python<'_>, canvas: &PyCanvas, delay: u16) -> PyResult<()> {
        let Self { histogram, reserved, colors, tolerance, state } = self;
        let written = py.detach(|| {
            let picture = &canvas.picture.reduced();
            if let WriterState::Observing(_) = state {
                let WriterState::Observing(sink) = std::mem::replace(state, WriterState::Closed) else {
                    return Ok(());
                };
                let palette = Palette::new(histogram, reserved, *colors);
                let mut gif = physcore_canvas::Gif::new(sink, picture, palette)?;
                gif.tolerate(*tolerance);
                *state = WriterState::Writing(Box::new(Background::new(gif)?));
            }
            match state {
                WriterState::Writing(gif) => gif.frame(picture, delay),
                _ => Err(CanvasError::Write(io::Error::other("the film is closed"))),
            }
        });
        written.map_err(python_error)
    }

    /// Allow inexact colors from the next frame on, where they make the file smaller. An error of `tolerance` levels of 255 on a
    /// smooth surface then counts as much as a code of the compression.
    fn tolerate(&mut self, tolerance: f32) -> PyResult<()> {
        self.tolerance = tolerance;
        match &mut self.state {
            WriterState::Writing(gif) => gif.tolerate(tolerance).map_err(python_error),
            _ => Ok(()),
        }
    }

    /// Append a comment extension, which viewers do not show. Allowed only after a frame.
    fn comment(&mut self, text: &str) -> PyResult<()> {
        match &mut self.state {
            WriterState::Writing(gif) => gif.comment(text).map_err(python_error),
            _ => Err(PyValueError::new_err("a film must have a frame")),
        }
    }

    /// Size of the frames appended so far [bytes], after waiting for their encoding; 0 before the first.
    fn written(&mut self, py: Python<'_>) -> PyResult<u64> {
        match &mut self.state {
            WriterState::Writing(gif) => py.detach(|| gif.written()).map_err(python_error),
            _ => Ok(0),
        }
    }

    /// End the film: rename the file to its final name, or return the bytes.
    fn finish<'py>(&mut self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyBytes>>> {
        let WriterState::Writing(gif) = std::mem::replace(&mut self.state, WriterState::Closed) else {
            return Err(PyValueError::new_err("a film must have a frame"));
        };
        let sink = py.detach(|| -> Result<Sink, CanvasError> {
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

    /// Discard the film. An existing file with this name stays unchanged. No effect after `finish`.
    fn close(&mut self, py: Python<'_>) {
        py.detach(|| self.state = WriterState::Closed);
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
