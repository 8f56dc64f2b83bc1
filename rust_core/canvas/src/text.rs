//! Text labels: anti-aliased glyphs of Noto Sans Mono, pre-rendered in four sizes.

#![expect(clippy::cast_possible_wrap, reason = "no label is longer than a picture is wide by far")]

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

use crate::canvas::Canvas;
use crate::color::Ink;

/// Alignment of a label at the given x.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Align {
    /// Its left end.
    Left,
    /// Its middle.
    Center,
    /// Its right end.
    Right,
}

/// Width of a label whose line is about `height` pixels high [pixels].
pub fn text_width(text: &str, height: usize) -> usize {
    text.chars().count() * get_raster_width(FontWeight::Regular, raster_height(height))
}

impl Canvas {
    /// Writes one line of text with its upper edge at `y`, in the greatest of the sizes 16, 20, 24 and 32 that fits `height`.
    /// A character outside Latin script is shown as a question mark.
    pub fn text(&mut self, text: &str, [x, y]: [i32; 2], height: usize, color: Ink, align: Align) {
        let size = raster_height(height);
        let advance = get_raster_width(FontWeight::Regular, size);
        let width = (text.chars().count() * advance) as i32;
        let left = match align {
            Align::Left => x,
            Align::Center => x - width / 2,
            Align::Right => x - width,
        };
        for (index, character) in text.chars().enumerate() {
            let glyph = get_raster(character, FontWeight::Regular, size);
            let Some(glyph) = glyph.or_else(|| get_raster('?', FontWeight::Regular, size)) else {
                continue;
            };
            for (row, coverages) in glyph.rows().enumerate() {
                for (column, &coverage) in coverages.iter().enumerate() {
                    self.dot(left + (index * advance + column) as i32, y + row as i32, color, f32::from(coverage) / 255.0);
                }
            }
        }
    }
}

fn raster_height(height: usize) -> RasterHeight {
    match height {
        0..20 => RasterHeight::Size16,
        20..24 => RasterHeight::Size20,
        24..32 => RasterHeight::Size24,
        _ => RasterHeight::Size32,
    }
}
