//! Trade-off between the time and the color error and size of a film.
//!
//! Neither dithers anything but glow. Ordered dithering of all pixels with a static pattern was tried: its error per frame is
//! larger, and films of smooth gradients become two to three times as large; of glow alone, films become a sixth larger.

use std::str::FromStr;

use crate::error::Error;

/// Trade-off between the time and the color error and size of a film.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    /// The nearest palette color is looked up in cells of 4 × 4 × 4 colors.
    #[default]
    Fast,
    /// Cells of 2 × 2 × 2, a palette from a finer histogram, and each frame in the smaller of two encodings.
    High,
}

impl Quality {
    /// Bits per channel of the palette's histogram.
    ///
    /// On `benches/film.py` a bit more gives 0.3 dB and takes four times as long, once for a film.
    pub(crate) fn histogram_bits(self) -> u32 {
        match self {
            Self::Fast => 5,
            Self::High => 6,
        }
    }

    /// Bits per channel of the table of nearest colors; all eight would gain less than 0.1 dB over seven.
    pub(crate) fn table_bits(self) -> u32 {
        self.histogram_bits() + 1
    }
}

impl FromStr for Quality {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self, Error> {
        match name {
            "fast" => Ok(Self::Fast),
            "high" => Ok(Self::High),
            _ => Err(Error::Quality { got: name.to_owned() }),
        }
    }
}
