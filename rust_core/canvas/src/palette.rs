//! One palette for a whole film: up to 255 colors chosen from a few of its frames.
//!
//! Colors are compared as bytes of sRGB, which are about perceptually uniform. Oklab has a larger error by that measure,
//! and its roots and powers depend in their last bit on the machine.

use crate::canvas::Canvas;
use crate::color::Rgb;
use crate::nearest::{Table, cell};
use crate::quality::Quality;
use crate::quantize::{Sample, quantize};

/// Histogram of colors, in cells of 8 × 8 × 8 colors or finer.
#[derive(Clone, Debug)]
pub struct Histogram {
    quality: Quality,
    cells: Vec<Tally>,
}

/// Colors that differ by at most about so much in each channel are alike [levels of 255].
const ALIKE: usize = 24;
/// A color that is included counts as so many pixels.
const INCLUDED: u64 = 100;

/// The number of pixels in a cell and the sums of their channels: a color alone in its cell is kept exactly.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    count: u64,
    sums: [u64; 3],
}

impl Default for Histogram {
    fn default() -> Self {
        Self::new(Quality::default())
    }
}

impl Histogram {
    /// An empty histogram of the resolution of a quality.
    pub fn new(quality: Quality) -> Self {
        Self { quality, cells: vec![Tally::default(); 1 << (3 * quality.histogram_bits())] }
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

    /// Counts those of some colors as a few pixels of which none alike was seen: a palette of samples of a film then has them too,
    /// for what shows them between the samples.
    pub fn include(&mut self, colors: &[Rgb]) {
        let missing: Vec<Rgb> = colors.iter().copied().filter(|&color| !self.has_seen(color)).collect();
        for color in missing {
            let [red, green, blue] = color;
            let tally = &mut self.cells[cell([red, green, blue, 0], self.quality.histogram_bits()) as usize];
            *tally = Tally { count: INCLUDED, sums: color.map(|channel| INCLUDED * u64::from(channel)) };
        }
    }

    /// Whether a color like this one was seen.
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

    /// The mean color and the count of each occupied cell.
    fn colors(&self) -> impl Iterator<Item = (Rgb, u64)> {
        let seen = self.cells.iter().filter(|tally| tally.count > 0);
        seen.map(|&Tally { count, sums }| (sums.map(|sum| ((sum + count / 2) / count) as u8), count))
    }
}

/// Up to 255 colors, numbered from 1: a GIF's table has 256 entries, of which one stands for "transparent".
#[derive(Clone, Debug)]
pub struct Palette {
    quality: Quality,
    colors: Vec<Rgb>,
    /// How many of them, the first ones, were reserved.
    reserved: usize,
    table: Table,
}

impl Palette {
    /// At most `most` colors, fitted to a histogram. The `reserved` ones are contained exactly; so are all colors, if they
    /// are few and no two share a cell.
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
            let samples = others.iter().map(|&(color, count)| Sample::new(color, count)).collect();
            quantize(samples, room).into_iter().for_each(|color| add(&mut colors, color));
        }
        if colors.is_empty() {
            colors.push([0; 3]);
        }
        let quality = histogram.quality;
        Self { table: Table::new(&colors, quality.table_bits()), quality, colors, reserved }
    }

    /// How many colors, the first ones, were reserved.
    pub(crate) fn reserved(&self) -> usize {
        self.reserved
    }

    /// The colors; the first has number 1.
    pub fn colors(&self) -> &[Rgb] {
        &self.colors
    }

    /// The quality of the histogram.
    pub fn quality(&self) -> Quality {
        self.quality
    }

    /// The number of each pixel's color in a picture of so many columns, into `out`: the nearest one, but glow is dithered.
    pub fn indices(&mut self, pixels: &[[u8; 4]], width: usize, out: &mut Vec<u8>) {
        out.resize(pixels.len(), 0);
        self.table.look_up_dithered(pixels, width, out);
    }
}
