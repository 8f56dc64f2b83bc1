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
use crate::lzw::{Encoder, TRANSPARENT};
use crate::palette::Palette;
use crate::quality::Quality;
use crate::tolerant::{Tolerance, TolerantEncoder, Wish};

/// GIF writer, frame by frame. Memory does not grow with the number of frames, and equal frames give equal bytes.
pub struct Gif<W> {
    out: W,
    written: u64,
    width: usize,
    height: usize,
    palette: Palette,
    bits: u32,
    encoder: Encoder,
    /// Tolerance table of replaceable colors, if any may be replaced, with its encoder.
    tolerance: Option<(Tolerance, TolerantEncoder)>,
    /// Palette indices of the last frame, as drawn.
    drawn: Vec<u8>,
    wishes: Vec<Wish>,
    /// Palette indices on the screen after the last frame; empty before the first.
    shown: Vec<u8>,
    indices: Vec<u8>,
    symbols: Vec<u8>,
    bytes: Vec<u8>,
    /// Bytes of the alternative encoding of a frame.
    rival: Vec<u8>,
}

impl<W: Write> Gif<W> {
    /// Begins a film of frames with the size of `canvas`, in an endless loop.
    pub fn new(out: W, canvas: &Canvas, palette: Palette) -> Result<Self, CanvasError> {
        let (width, height) = (canvas.width(), canvas.height());
        // A table holds 2^bits colors; the first is the transparent index.
        let bits = (palette.colors().len() + 1).next_power_of_two().ilog2().max(1);
        let mut header = b"GIF89a".to_vec();
        header.extend(short(width));
        header.extend(short(height));
        header.extend([0xF0 | (bits - 1) as u8, 0, 0]);
        let table = [[0; 3]].iter().chain(palette.colors()).chain(std::iter::repeat(&[0; 3]));
        header.extend(table.take(1 << bits).flatten());
        header.extend(b"\x21\xFF\x0BNETSCAPE2.0\x03\x01\0\0\0");
        let (encoder, empty) = (Encoder::new(), Vec::new);
        let (shown, indices, symbols, bytes, rival) = (empty(), empty(), empty(), empty(), empty());
        let (written, tolerance, drawn, wishes) = (0, None, empty(), Vec::new());
        let mut gif = Self {
            out,
            written,
            width,
            height,
            palette,
            bits,
            encoder,
            tolerance,
            drawn,
            wishes,
            shown,
            indices,
            symbols,
            bytes,
            rival,
        };
        gif.write(&header)?;
        Ok(gif)
    }

    /// Allows inexact colors from the next frame on, where they make the file smaller. A pixel may then have any color at most
    /// `distance` from the nearest palette color [levels of 255]. Pixels at rest do not change. With 0, the default, every pixel
    /// has the nearest color.
    pub fn tolerate(&mut self, distance: u8) {
        self.tolerance = (distance > 0).then(|| {
            let table = Tolerance::new(self.palette.colors(), self.palette.reserved(), distance);
            (table, TolerantEncoder::new())
        });
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
        self.palette.indices(pixels, self.width, &mut self.indices);
        if let Some((tolerance, encoder)) = self.tolerance.take() {
            return self.append_about(tolerance, encoder, delay);
        }
        let (patch, cleared) = self.compose();
        let mut bytes = std::mem::take(&mut self.bytes);
        self.store(patch, cleared > 0, delay, &mut bytes);
        // If most of a patch has changed, it may be smaller without transparent pixels.
        if self.palette.quality() == Quality::High && cleared > 0 && 2 * cleared < patch.width * patch.height {
            patch.cut(&self.indices, self.width, &mut self.symbols);
            let mut rival = std::mem::take(&mut self.rival);
            self.store(patch, false, delay, &mut rival);
            if rival.len() < bytes.len() {
                std::mem::swap(&mut rival, &mut bytes);
            }
            self.rival = rival;
        }
        std::mem::swap(&mut self.shown, &mut self.indices);
        self.drawn.clone_from(&self.shown);
        let result = self.write(&bytes);
        self.bytes = bytes;
        result
    }

    /// Appends the frame of `indices` within a tolerance.
    fn append_about(&mut self, tolerance: Tolerance, mut encoder: TolerantEncoder, delay: u16) -> Result<(), CanvasError> {
        let first = self.shown.is_empty();
        self.shown.resize(self.indices.len(), TRANSPARENT);
        self.drawn.resize(self.indices.len(), TRANSPARENT);
        // Pixels that may keep their color count as unchanged.
        let stays: Vec<u8> = self
            .indices
            .iter()
            .zip(&self.shown)
            .map(|(&wanted, &shown)| if tolerance.allows(wanted, shown) { shown } else { wanted })
            .collect();
        let whole = Patch { left: 0, top: 0, width: self.width, height: self.height };
        let patch = if first { whole } else { Patch::between(&self.shown, &stays, self.width) };
        self.wishes.clear();
        for row in patch.top..patch.top + patch.height {
            for pixel in row * self.width + patch.left..row * self.width + patch.left + patch.width {
                let (wanted, shown) = (self.indices[pixel], self.shown[pixel]);
                let keep = tolerance.allows(wanted, shown);
                let rests = keep && wanted == self.drawn[pixel];
                self.wishes.push(if rests { Wish::rest(shown) } else { Wish::about(wanted, keep) });
            }
        }
        let mut bytes = std::mem::take(&mut self.bytes);
        Self::describe(patch, true, delay, &mut bytes);
        encoder.encode(&self.wishes, &tolerance, self.bits, &mut self.symbols, &mut bytes);
        patch.paste(&self.symbols, self.width, &mut self.shown);
        std::mem::swap(&mut self.drawn, &mut self.indices);
        self.tolerance = Some((tolerance, encoder));
        let result = self.write(&bytes);
        self.bytes = bytes;
        result
    }

    /// Writes the changed patch to `symbols`; returns its rectangle and its number of transparent pixels.
    fn compose(&mut self) -> (Patch, usize) {
        let whole = Patch { left: 0, top: 0, width: self.width, height: self.height };
        let first = self.shown.is_empty();
        let patch = if first { whole } else { Patch::between(&self.shown, &self.indices, self.width) };
        patch.cut(&self.indices, self.width, &mut self.symbols);
        let cleared = if first { 0 } else { patch.clear_unchanged(&self.shown, self.width, &mut self.symbols) };
        (patch, cleared)
    }

    /// Writes the GIF blocks of a frame of `symbols` to `bytes`.
    fn store(&mut self, patch: Patch, transparent: bool, delay: u16, bytes: &mut Vec<u8>) {
        Self::describe(patch, transparent, delay, bytes);
        self.encoder.encode(&self.symbols, self.bits, bytes);
    }

    /// Writes the GIF blocks that precede the symbols of a frame to `bytes`.
    fn describe(patch: Patch, transparent: bool, delay: u16, bytes: &mut Vec<u8>) {
        bytes.clear();
        // Graphic control: leave the frame in place (disposal 1); its lowest bit says whether one index is transparent.
        bytes.extend([0x21, 0xF9, 4, 0b100 | u8::from(transparent)]);
        bytes.extend(delay.to_le_bytes());
        bytes.extend([TRANSPARENT, 0, 0x2C]);
        for value in [patch.left, patch.top, patch.width, patch.height] {
            bytes.extend(short(value));
        }
        bytes.push(0);
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), CanvasError> {
        self.written += bytes.len() as u64;
        Ok(self.out.write_all(bytes)?)
    }
}

fn short(value: usize) -> [u8; 2] {
    (value as u16).to_le_bytes()
}
