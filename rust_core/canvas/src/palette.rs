//! Palette of a whole film: up to 255 colors chosen from a few of its frames.
//!
//! Colors are compared as bytes of sRGB, which are approximately perceptually uniform. Oklab has a larger error by this measure.
//! The last bits of its roots and powers depend on the machine.

use crate::canvas::Canvas;
use crate::color::Rgb;
use crate::nearest::{LookupTable, cell};
use crate::quality::Quality;
use crate::quantize::{WeightedColor, quantize};

/// Histogram of colors, in cells of 8 × 8 × 8 colors or finer.
#[derive(Clone, Debug)]
pub struct Histogram {
    quality: Quality,
    cells: Vec<ColorTally>,
}

/// Maximum difference of similar colors, approximately, in each channel [levels of 255].
const ALIKE: usize = 24;
/// Number of pixels as which an included color counts.
const INCLUDED: u64 = 100;

/// Number of pixels in a cell and the sums of their channels: a color that is alone in its cell is kept exactly.
#[derive(Clone, Copy, Debug, Default)]
struct ColorTally {
    count: u64,
    sums: [u64; 3],
}

impl Default for Histogram {
    fn default() -> Self {
        Self::new(Quality::default())
    }
}

impl Histogram {
    /// Returns an empty histogram with the resolution of a quality.
    pub fn new(quality: Quality) -> Self {
        Self { quality, cells: vec![ColorTally::default(); 1 << (3 * quality.histogram_bits())] }
    }

    /// Counts the pixels of a frame.
    pub fn observe(&mut self, canvas: &Canvas) {
        for &pixel in canvas.pixels() {
            let tally = &mut self.cells[cell(pixel, self.quality.histogram_bits()) as usize];
            tally.count += 1;
            for (sum, channel) in tally.sums.iter_mut().zip(pixel) {
                *sum += u64::from(channel);
            }
        }
    }

    /// Counts each color without a similar observed color as a few pixels. A palette from samples of a film then also suits the
    /// frames between the samples.
    pub fn include(&mut self, colors: &[Rgb]) {
        let missing: Vec<Rgb> = colors.iter().copied().filter(|&color| !self.has_seen(color)).collect();
        for color in missing {
            let [red, green, blue] = color;
            let tally = &mut self.cells[cell([red, green, blue, 0], self.quality.histogram_bits()) as usize];
            *tally = ColorTally { count: INCLUDED, sums: color.map(|channel| INCLUDED * u64::from(channel)) };
        }
    }

    /// Whether a color similar to this one was observed.
    fn has_seen(&self, color: Rgb) -> bool {
        let bits = self.quality.histogram_bits();
        let (size, last) = (256 >> bits, (1_usize << bits) - 1);
        let [reds, greens, blues] = color.map(|channel| {
            let (own, reach) = (usize::from(channel) / size, ALIKE / size);
            own.saturating_sub(reach)..=(own + reach).min(last)
        });
        let columns = reds.flat_map(|red| greens.clone().map(move |green| red << (2 * bits) | green << bits));
        columns.flat_map(|column| blues.clone().map(move |blue| column | blue)).any(|cell| self.cells[cell].count > 0)
    }

    /// Mean color and count of each occupied cell.
    fn colors(&self) -> impl Iterator<Item = (Rgb, u64)> {
        let seen = self.cells.iter().filter(|tally| tally.count > 0);
        seen.map(|&ColorTally { count, sums }| (sums.map(|sum| ((sum + count / 2) / count) as u8), count))
    }
}

/// Up to 255 colors, numbered from 1: a GIF's table has 256 entries, one of which is transparent.
#[derive(Clone, Debug)]
pub struct Palette {
    quality: Quality,
    colors: Vec<Rgb>,
    /// Number of reserved colors, which come first.
    reserved: usize,
    table: LookupTable,
}

impl Palette {
    /// Fits a palette of at most `most` colors to a histogram. It contains the `reserved` colors exactly. It also contains all
    /// other colors exactly, if they are few and no two share a cell.
    pub fn new(histogram: &Histogram, reserved: &[Rgb], most: u8) -> Self {
        let most = usize::from(most.max(1));
        let mut colors: Vec<Rgb> = Vec::new();
        let add = |colors: &mut Vec<Rgb>, color: Rgb| {
            if !colors.contains(&color) && colors.len() < most {
                colors.push(color);
            }
        };
        reserved.iter().for_each(|&color| add(&mut colors, color));
        let reserved = colors.len();
        let others: Vec<(Rgb, u64)> = histogram.colors().filter(|(color, _)| !colors.contains(color)).collect();
        let room = most - colors.len();
        if others.len() <= room {
            colors.extend(others.iter().map(|(color, _)| color));
        } else {
            let samples = others.iter().map(|&(color, count)| WeightedColor::new(color, count)).collect();
            quantize(samples, room).into_iter().for_each(|color| add(&mut colors, color));
        }
        if colors.is_empty() {
            colors.push([0; 3]);
        }
        let quality = histogram.quality;
        Self { table: LookupTable::new(&colors, quality.table_bits()), quality, colors, reserved }
    }

    /// Number of reserved colors, which come first.
    pub(crate) fn reserved(&self) -> usize {
        self.reserved
    }

    /// Colors; the first has number 1.
    pub fn colors(&self) -> &[Rgb] {
        &self.colors
    }

    /// Quality of the histogram.
    pub fn quality(&self) -> Quality {
        self.quality
    }

    /// Writes the number of each pixel's color in a picture of `width` columns to `out`: the nearest color, except that glow is
    /// dithered.
    pub fn indices(&mut self, pixels: &[[u8; 4]], width: usize, out: &mut Vec<u8>) {
        out.resize(pixels.len(), 0);
        self.table.look_up_dithered(pixels, width, out);
    }
}
