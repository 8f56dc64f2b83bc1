//! Container format `GIF89a`: one global palette, frames that store only changed pixels, in an endless loop.
//!
//! A frame is the smallest rectangle that contains every changed pixel. It stays on the screen when the next frame comes. A frame
//! equal to the previous one is still stored, as one transparent pixel.
//!
//! Source: `CompuServe`, "Graphics Interchange Format, version 89a" (1990).

use std::io::Write;

use crate::canvas::Canvas;
use crate::difference::Patch;
use crate::error::CanvasError;
use crate::histogram::Histogram;
use crate::lossy::{LossyEncoder, Target};
use crate::lzw::TRANSPARENT;
use crate::palette::Palette;
use crate::targets::{SHARE, Screen};

/// Bytes of a color table, in codes of 12 bits.
const TABLE_COST: f32 = 512.0;

/// GIF writer, frame by frame. Memory does not grow with the number of frames, and equal frames give equal bytes.
pub struct Gif<W> {
    out: W,
    written: u64,
    width: usize,
    height: usize,
    palette: Palette,
    /// Last palette of a single frame.
    last: Option<Palette>,
    tolerance: f32,
    screen: Screen,
    histogram: Histogram,
    encoder: LossyEncoder,
    targets: Vec<Target>,
    symbols: Vec<u8>,
    bytes: Vec<u8>,
}

impl<W: Write> Gif<W> {
    /// Begins a film of frames with the size of `canvas`, in an endless loop.
    pub fn new(out: W, canvas: &Canvas, palette: Palette) -> Result<Self, CanvasError> {
        let (width, height) = (canvas.width(), canvas.height());
        let mut header = b"GIF89a".to_vec();
        header.extend(short(width));
        header.extend(short(height));
        header.extend([0xF0 | (bits(&palette) - 1) as u8, 0, 0]);
        header.extend(table(&palette));
        header.extend(b"\x21\xFF\x0BNETSCAPE2.0\x03\x01\0\0\0");
        let (screen, encoder, histogram) = (Screen::new(width), LossyEncoder::new(), Histogram::default());
        let (targets, symbols, bytes) = (Vec::new(), Vec::new(), Vec::new());
        let (written, tolerance, last) = (0, 0.0, None);
        let mut gif =
            Self { out, written, width, height, palette, last, tolerance, screen, histogram, encoder, targets, symbols, bytes };
        gif.write(&header)?;
        Ok(gif)
    }

    /// Allows inexact colors from the next frame on, where they make the file smaller. An error of `tolerance` levels of 255 on a
    /// smooth surface counts as much as a code of the compression. With 0, the default, every pixel has the nearest color.
    pub fn tolerate(&mut self, tolerance: f32) {
        self.tolerance = tolerance;
    }

    /// Appends a frame and shows it for `delay` hundredths of a second.
    pub fn frame(&mut self, canvas: &Canvas, delay: u16) -> Result<(), CanvasError> {
        let (expected, got) = (self.size(), (canvas.width(), canvas.height()));
        if expected != got {
            return Err(CanvasError::FrameSize { expected, got });
        }
        self.append(canvas.pixels(), delay)
    }

    /// Appends a comment extension in UTF-8, which viewers do not show.
    pub fn comment(&mut self, text: &str) -> Result<(), CanvasError> {
        let mut bytes = b"\x21\xFE".to_vec();
        for block in text.as_bytes().chunks(255) {
            bytes.push(block.len() as u8);
            bytes.extend_from_slice(block);
        }
        bytes.push(0);
        self.write(&bytes)
    }

    /// Size of the file so far [bytes]; [`Gif::finish`] adds one.
    pub fn written(&self) -> u64 {
        self.written
    }

    /// Ends the film and returns its writer.
    pub fn finish(mut self) -> Result<W, CanvasError> {
        self.write(&[0x3B])?;
        self.out.flush()?;
        Ok(self.out)
    }

    /// Width and height [pixels].
    pub fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// Appends a frame of the film's size.
    pub(crate) fn append(&mut self, pixels: &[[u8; 4]], delay: u16) -> Result<(), CanvasError> {
        let mut bytes = std::mem::take(&mut self.bytes);
        let nothing = Patch { left: 0, top: 0, width: 1, height: 1 };
        let changed = self.screen.changed(pixels);
        let mut local = changed.and_then(|_| self.adapt(pixels));
        let palette = local.as_mut().unwrap_or(&mut self.palette);
        let patch = self.screen.targets(pixels, changed.unwrap_or(nothing), palette, self.tolerance, &mut self.targets);
        Self::describe(patch, local.as_ref(), delay, &mut bytes);
        let palette = local.as_ref().unwrap_or(&self.palette);
        self.encoder.encode(&self.targets, palette, bits(palette), &mut self.symbols, &mut bytes);
        self.screen.show(patch, &self.symbols, palette);
        self.last = local.or_else(|| self.last.take());
        let result = self.write(&bytes);
        self.bytes = bytes;
        result
    }

    /// Palette for the colors that change in a frame, if it saves more than it costs, or if a flat color is missing.
    fn adapt(&mut self, pixels: &[[u8; 4]]) -> Option<Palette> {
        self.screen.observe(pixels, &mut self.histogram);
        let samples = self.histogram.samples();
        let price = SHARE as f32 / self.tolerance.max(1.0).powi(2);
        let present = price * self.palette.error(&samples);
        let suits = self.palette.suits(&self.histogram);
        if suits && present < TABLE_COST {
            return None;
        }
        let (local, left) = self.last.as_ref().unwrap_or(&self.palette).adapted(&self.histogram, &samples);
        (!suits || present - price * left > TABLE_COST).then_some(local)
    }

    /// Writes the GIF blocks that precede the symbols of a frame to `bytes`.
    fn describe(patch: Patch, local: Option<&Palette>, delay: u16, bytes: &mut Vec<u8>) {
        bytes.clear();
        // Graphic control: leave the frame in place (disposal 1); the lowest bit says that one index is transparent.
        bytes.extend([0x21, 0xF9, 4, 0b101]);
        bytes.extend(delay.to_le_bytes());
        bytes.extend([TRANSPARENT, 0, 0x2C]);
        for value in [patch.left, patch.top, patch.width, patch.height] {
            bytes.extend(short(value));
        }
        match local {
            Some(palette) => {
                bytes.push(0x80 | (bits(palette) - 1) as u8);
                bytes.extend(table(palette));
            }
            None => bytes.push(0),
        }
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), CanvasError> {
        self.written += bytes.len() as u64;
        Ok(self.out.write_all(bytes)?)
    }
}

/// Base-2 logarithm of the size of a palette's table, whose first color is the transparent index.
fn bits(palette: &Palette) -> u32 {
    (palette.colors().len() + 1).next_power_of_two().ilog2().max(1)
}

/// Color table of a palette.
fn table(palette: &Palette) -> Vec<u8> {
    let mut table = vec![0; 3 << bits(palette)];
    let colors = palette.colors().as_flattened();
    table[3..3 + colors.len()].copy_from_slice(colors);
    table
}

fn short(value: usize) -> [u8; 2] {
    (value as u16).to_le_bytes()
}
