//! Trade-off between encoding time and the color error and size of a film.
//!
//! No quality dithers anything but glow. Ordered dithering of all pixels with a static pattern was tried. It has a larger error
//! per frame, and films of smooth gradients become two to three times as large. With dithering of glow alone, films become a
//! sixth larger.

use std::str::FromStr;

use crate::error::CanvasError;

/// Trade-off between encoding time and the color error and size of a film.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    /// Looks up the nearest palette color in cells of 4 × 4 × 4 colors.
    #[default]
    Fast,
    /// Uses cells of 2 × 2 × 2 colors, a palette from a finer histogram, and the smaller of two encodings of each frame.
    High,
}

impl Quality {
    /// Bits per channel of the palette's histogram.
    ///
    /// With `benches/film.py`, one more bit gains 0.3 dB and takes four times as long, once per film.
    pub(crate) fn histogram_bits(self) -> u32 {
        match self {
            Self::Fast => 5,
            Self::High => 6,
        }
    }

    /// Bits per channel of the table of nearest colors; eight bits would gain less than 0.1 dB over seven.
    pub(crate) fn table_bits(self) -> u32 {
        self.histogram_bits() + 1
    }
}

impl FromStr for Quality {
    type Err = CanvasError;

    fn from_str(name: &str) -> Result<Self, CanvasError> {
        match name {
            "fast" => Ok(Self::Fast),
            "high" => Ok(Self::High),
            _ => Err(CanvasError::Quality { got: name.to_owned() }),
        }
    }
}
