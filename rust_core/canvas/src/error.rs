//! Errors of pictures and films.

use std::io;

/// Error of creating a canvas or writing a film.
#[derive(Debug, thiserror::Error)]
pub enum CanvasError {
    /// Invalid size: a GIF stores width and height in 16 bits each, and an empty picture cannot be shown.
    #[error("size: each side must be from 1 to 65535 pixels, got {width} × {height}")]
    Size {
        /// Requested width [pixels].
        width: usize,
        /// Requested height [pixels].
        height: usize,
    },
    /// Size of a frame that differs from that of the film.
    #[error("frame: must be {expected:?} pixels like the film, got {got:?}")]
    FrameSize {
        /// Width and height of the film [pixels].
        expected: (usize, usize),
        /// Width and height of the frame [pixels].
        got: (usize, usize),
    },
    /// Font that cannot be read.
    #[error("font: {0}")]
    Font(String),
    /// Write error of the operating system.
    #[error(transparent)]
    Write(#[from] io::Error),
}
