//! What can go wrong with a picture or a film.

use std::io;

/// Why a canvas could not be made or a film could not be written.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A GIF stores its width and height in 16 bits each, and an empty picture cannot be shown.
    #[error("size: each side must be from 1 to 65535 pixels, got {width} × {height}")]
    Size {
        /// Width asked for [pixels].
        width: usize,
        /// Height asked for [pixels].
        height: usize,
    },
    /// All frames of a film have one size.
    #[error("frame: must be {expected:?} pixels like the film, got {got:?}")]
    FrameSize {
        /// Width and height of the film [pixels].
        expected: (usize, usize),
        /// Width and height of the frame [pixels].
        got: (usize, usize),
    },
    /// There are two qualities.
    #[error("quality: must be \"fast\" or \"high\", got {got:?}")]
    Quality {
        /// What was asked for.
        got: String,
    },
    /// The operating system could not write.
    #[error(transparent)]
    Write(#[from] io::Error),
}
