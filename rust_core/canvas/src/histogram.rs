//! Histogram of the colors of pictures, weighted by how visible an error would be, and the flat colors among them.

use std::collections::HashMap;

use crate::canvas::Canvas;
use crate::color::Rgb;
use crate::oklab::{Lab, lab, squared};
use crate::visibility::Visibility;

/// Weight of a fully visible pixel.
const FULL: f32 = 16.0;
/// Number of pixels as which an included color counts.
const INCLUDED: u64 = 100;
/// Maximum difference of similar colors [levels].
const ALIKE: f32 = 24.0;
/// Least number of flat pixels of a color that is kept exactly.
const FLAT: u32 = 32;
/// Maximum difference of flat colors in each channel that may belong to one gradient [levels of 255].
const GRADIENT: u8 = 3;
/// Number of slots at first.
const SLOTS: usize = 1 << 14;

/// Weighted colors of pictures. A pixel is flat if it has the color of its four neighbors.
#[derive(Clone, Debug)]
pub struct Histogram {
    visibility: Visibility,
    /// Hash table of colors, with open addresses.
    slots: Vec<Tally>,
    /// Number of occupied slots.
    occupied: usize,
    flats: HashMap<Rgb, u32>,
}

/// Color and the weight of its pixels; 0 if the slot is free.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    weight: u64,
    color: Rgb,
}

/// Color with its coordinates and the weight of its pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ColorSample {
    pub(crate) color: Rgb,
    pub(crate) lab: Lab,
    pub(crate) weight: f32,
}

impl Default for Histogram {
    fn default() -> Self {
        Self { visibility: Visibility::default(), slots: vec![Tally::default(); SLOTS], occupied: 0, flats: HashMap::new() }
    }
}

impl Histogram {
    /// Counts the pixels of a frame.
    pub fn observe(&mut self, canvas: &Canvas) {
        let mut visibility = std::mem::take(&mut self.visibility);
        visibility.look(canvas.pixels(), canvas.width());
        self.count(canvas.pixels(), canvas.width(), &visibility, |_, _| true);
        self.visibility = visibility;
    }

    /// Counts those pixels of a picture of `width` columns that are `chosen` by column and row.
    pub(crate) fn count(
        &mut self,
        pixels: &[[u8; 4]],
        width: usize,
        visibility: &Visibility,
        chosen: impl Fn(usize, usize) -> bool,
    ) {
        for (row, line) in pixels.chunks_exact(width).enumerate() {
            let mut run: (Rgb, u32) = ([0; 3], 0);
            for (column, &[red, green, blue, _]) in line.iter().enumerate().filter(|&(column, _)| chosen(column, row)) {
                let color = [red, green, blue];
                self.add(color, (FULL * visibility.weight(column, row)) as u64);
                if is_flat(pixels, width, column, row) {
                    if run.0 != color {
                        self.add_flat(run);
                        run = (color, 0);
                    }
                    run.1 += 1;
                }
            }
            self.add_flat(run);
        }
    }

    /// Counts each color without a similar observed color as a few pixels. A palette from samples of a film then also suits the
    /// frames between the samples.
    pub fn include(&mut self, colors: &[Rgb]) {
        let seen = self.samples();
        for &color in colors {
            let wanted = lab(color);
            if !seen.iter().any(|sample| squared(sample.lab, wanted) < ALIKE * ALIKE) {
                self.add(color, INCLUDED * FULL as u64);
            }
        }
    }

    /// Forgets all pixels.
    pub(crate) fn clear(&mut self) {
        self.slots.fill(Tally::default());
        self.occupied = 0;
        self.flats.clear();
    }

    /// Observed colors with their weights.
    pub(crate) fn samples(&self) -> Vec<ColorSample> {
        let used = self.slots.iter().filter(|tally| tally.weight > 0);
        used.map(|&Tally { weight, color }| ColorSample { color, lab: lab(color), weight: weight as f32 / FULL }).collect()
    }

    /// Appends flat colors to `fixed` ones, the most frequent first, up to `most` in all. Of similar ones, as in a gradient, the most
    /// frequent is taken.
    pub(crate) fn add_flats(&self, fixed: &mut Vec<Rgb>, most: usize) {
        let mut flats: Vec<(u32, Rgb)> =
            self.flats.iter().filter(|&(_, &count)| count >= FLAT).map(|(&color, &count)| (count, color)).collect();
        flats.sort_unstable_by(|p, q| q.cmp(p));
        for (_, color) in flats {
            let similar = |other: &Rgb| other.iter().zip(color).all(|(&one, other)| one.abs_diff(other) <= GRADIENT);
            if fixed.len() < most && !fixed.iter().any(similar) {
                fixed.push(color);
            }
        }
    }

    fn add_flat(&mut self, (color, count): (Rgb, u32)) {
        if count > 0 {
            *self.flats.entry(color).or_default() += count;
        }
    }

    #[inline(always)]
    fn add(&mut self, color: Rgb, weight: u64) {
        let slot = self.slot(color);
        let tally = &mut self.slots[slot];
        if tally.weight > 0 {
            tally.weight += weight;
            return;
        }
        *tally = Tally { weight, color };
        self.occupied += 1;
        if 2 * self.occupied > self.slots.len() {
            let doubled = vec![Tally::default(); 2 * self.slots.len()];
            for tally in std::mem::replace(&mut self.slots, doubled).into_iter().filter(|tally| tally.weight > 0) {
                let slot = self.slot(tally.color);
                self.slots[slot] = tally;
            }
        }
    }

    /// Slot of a color, or the free slot for it.
    #[inline(always)]
    fn slot(&self, color: Rgb) -> usize {
        let key = u32::from_be_bytes([0, color[0], color[1], color[2]]);
        let mut slot = (key.wrapping_mul(0x9E37_79B1) >> (32 - self.slots.len().ilog2())) as usize;
        while self.slots[slot].weight > 0 && self.slots[slot].color != color {
            slot = (slot + 1) % self.slots.len();
        }
        slot
    }
}

/// Whether a pixel has the color of its four neighbors.
#[inline(always)]
pub(crate) fn is_flat(pixels: &[[u8; 4]], width: usize, column: usize, row: usize) -> bool {
    let own = row * width + column;
    let same = |other: usize| pixels[other] == pixels[own];
    (column == 0 || same(own - 1))
        && (column + 1 == width || same(own + 1))
        && (row == 0 || same(own - width))
        && (own + width >= pixels.len() || same(own + width))
}
