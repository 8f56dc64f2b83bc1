//! The `GIF89a` container: one global palette, frames that store only what has changed, repeated for ever.
//!
//! A frame is the smallest rectangle that holds every changed pixel, kept on the screen when the next one comes. A frame that
//! equals the last is still a frame: one transparent pixel. Source: `CompuServe`, "Graphics Interchange Format, version 89a" (1990).

use std::io::Write;

use crate::canvas::Canvas;
use crate::error::Error;
use crate::lzw::{Encoder, TRANSPARENT};
use crate::palette::Palette;

/// Runs of unchanged pixels at least this long become transparent. Shorter ones would break the strings that repeat around
/// them: on `benches/frames.rs` the file grows by 8 % when every unchanged pixel is transparent, and by 1 % with 32.
const SHORTEST_RUN: usize = 32;

/// Writes frames as they come; its memory does not grow with their number, and equal frames give equal bytes.
pub struct Gif<W> {
    out: W,
    width: usize,
    height: usize,
    palette: Palette,
    bits: u32,
    encoder: Encoder,
    /// Indices on the screen after the last frame; empty before the first.
    shown: Vec<u8>,
    indices: Vec<u8>,
    symbols: Vec<u8>,
    bytes: Vec<u8>,
}

/// Upper left corner and size of what a frame stores [pixels].
struct Patch {
    left: usize,
    top: usize,
    width: usize,
    height: usize,
}

impl<W: Write> Gif<W> {
    /// Begins a film of frames as large as `canvas`, shown over and over.
    pub fn new(out: W, canvas: &Canvas, palette: Palette) -> Result<Self, Error> {
        let (width, height) = (canvas.width(), canvas.height());
        // A table holds 2^bits colors, of which the first is what "transparent" would look like.
        let bits = (palette.colors().len() + 1).next_power_of_two().ilog2().max(1);
        let mut bytes = b"GIF89a".to_vec();
        bytes.extend(short(width));
        bytes.extend(short(height));
        bytes.extend([0xF0 | (bits - 1) as u8, 0, 0]);
        let table = [[0; 3]].iter().chain(palette.colors()).chain(std::iter::repeat(&[0; 3]));
        bytes.extend(table.take(1 << bits).flatten());
        bytes.extend(b"\x21\xFF\x0BNETSCAPE2.0\x03\x01\0\0\0");
        let (encoder, empty) = (Encoder::new(), Vec::new);
        let mut gif =
            Self { out, width, height, palette, bits, encoder, bytes, shown: empty(), indices: empty(), symbols: empty() };
        gif.out.write_all(&gif.bytes)?;
        Ok(gif)
    }

    /// Appends a frame and shows it for `delay` hundredths of a second.
    pub fn frame(&mut self, canvas: &Canvas, delay: u16) -> Result<(), Error> {
        let (expected, got) = ((self.width, self.height), (canvas.width(), canvas.height()));
        if expected != got {
            return Err(Error::FrameSize { expected, got });
        }
        self.palette.indices(canvas, &mut self.indices);
        let patch = self.changed();
        let transparent = self.compose(&patch);

        self.bytes.clear();
        // Graphic control: leave the frame in place (disposal 1); its lowest bit says whether one index is transparent.
        self.bytes.extend([0x21, 0xF9, 4, 0b100 | u8::from(transparent)]);
        self.bytes.extend(delay.to_le_bytes());
        self.bytes.extend([TRANSPARENT, 0, 0x2C]);
        for value in [patch.left, patch.top, patch.width, patch.height] {
            self.bytes.extend(short(value));
        }
        self.bytes.push(0);
        self.encoder.encode(&self.symbols, self.bits, &mut self.bytes);
        std::mem::swap(&mut self.shown, &mut self.indices);
        Ok(self.out.write_all(&self.bytes)?)
    }

    /// Appends a text that viewers do not show, in UTF-8.
    pub fn comment(&mut self, text: &str) -> Result<(), Error> {
        self.out.write_all(b"\x21\xFE")?;
        for block in text.as_bytes().chunks(255) {
            self.out.write_all(&[block.len() as u8])?;
            self.out.write_all(block)?;
        }
        Ok(self.out.write_all(&[0])?)
    }

    /// Ends the film and gives back what it was written to.
    pub fn finish(mut self) -> Result<W, Error> {
        self.out.write_all(&[0x3B])?;
        self.out.flush()?;
        Ok(self.out)
    }

    /// The smallest patch outside which nothing has changed; one pixel if nothing has, everything for the first frame.
    fn changed(&self) -> Patch {
        let (width, height) = (self.width, self.height);
        if self.shown.is_empty() {
            return Patch { left: 0, top: 0, width, height };
        }
        let rows = || self.indices.chunks_exact(width).zip(self.shown.chunks_exact(width));
        let Some(top) = rows().position(|(now, before)| now != before) else {
            return Patch { left: 0, top: 0, width: 1, height: 1 };
        };
        let bottom = height - rows().rev().position(|(now, before)| now != before).unwrap_or(0);
        let (mut left, mut right) = (width, 0);
        for (now, before) in rows().take(bottom).skip(top) {
            let differs = |(p, q): (&u8, &u8)| p != q;
            left = now[..left].iter().zip(&before[..left]).position(differs).unwrap_or(left);
            let beyond = now[right..].iter().zip(&before[right..]).rposition(differs);
            right = beyond.map_or(right, |offset| right + offset + 1);
        }
        Patch { left, top, width: right - left, height: bottom - top }
    }

    /// The patch as it is stored, into `symbols`; returns whether any of it is transparent.
    fn compose(&mut self, patch: &Patch) -> bool {
        self.symbols.clear();
        let columns = patch.left..patch.left + patch.width;
        for row in patch.top..patch.top + patch.height {
            let start = row * self.width;
            self.symbols.extend_from_slice(&self.indices[start + columns.start..start + columns.end]);
        }
        if self.shown.is_empty() {
            return false;
        }
        let mut transparent = false;
        for row in 0..patch.height {
            let start = (row + patch.top) * self.width;
            let before = &self.shown[start + columns.start..start + columns.end];
            let now = &mut self.symbols[row * patch.width..][..patch.width];
            let mut column = 0;
            while column < patch.width {
                let rest = now[column..].iter().zip(&before[column..]);
                let run = rest.take_while(|(now, before)| now == before).count();
                if run >= SHORTEST_RUN {
                    now[column..column + run].fill(TRANSPARENT);
                    transparent = true;
                }
                column += run + 1;
            }
        }
        transparent
    }
}

fn short(value: usize) -> [u8; 2] {
    (value as u16).to_le_bytes()
}
