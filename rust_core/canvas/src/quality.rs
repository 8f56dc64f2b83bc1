//! How much time goes into the colors and the size of a film.
//!
//! There is no dithering in either. Two colors mixed in a pattern that stands still on the screen were tried: they keep less of
//! each frame, and the pattern makes films of smooth gradients two to three times as large.

use std::str::FromStr;

use crate::error::Error;

/// How much time goes into the colors and the size of a film.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    /// Colors are told apart in cells of 4 × 4 × 4 when the nearest of the palette is looked up.
    #[default]
    Fast,
    /// In cells of 2 × 2 × 2, by a palette from a finer histogram, and each frame is stored in the smaller of two ways.
    High,
}

impl Quality {
    /// Bits per channel of the histogram that the palette is found from.
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
