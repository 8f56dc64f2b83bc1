//! Nearest palette color of every pixel.

use crate::band::GLOW;
use crate::color::Rgb;
use crate::math::threshold;

/// Colors as one array per channel: the distances to all of them are computed at once.
#[derive(Clone, Debug)]
pub(crate) struct Centers {
    channels: [Vec<f32>; 3],
    distances: Vec<f32>,
}

impl Centers {
    pub(crate) fn new(colors: &[[f32; 3]]) -> Self {
        let channels = [0, 1, 2].map(|channel| colors.iter().map(|color| color[channel]).collect());
        Self { channels, distances: vec![0.0; colors.len()] }
    }

    /// Color with a palette number, from 1.
    fn color(&self, number: u8) -> [f32; 3] {
        std::array::from_fn(|channel| self.channels[channel][usize::from(number) - 1])
    }

    /// Index of the nearest color; the first one of equally near colors.
    pub(crate) fn nearest(&mut self, color: [f32; 3]) -> usize {
        let [x, y, z] = &self.channels;
        for (((distance, x), y), z) in self.distances.iter_mut().zip(x).zip(y).zip(z) {
            let (dx, dy, dz) = (x - color[0], y - color[1], z - color[2]);
            *distance = dx * dx + dy * dy + dz * dz;
        }
        // Eight minima side by side, by comparisons, which are one instruction each, unlike `min`.
        let mut lanes = [f32::INFINITY; 8];
        let (chunks, rest) = self.distances.as_chunks::<8>();
        for chunk in chunks {
            for (lane, &distance) in lanes.iter_mut().zip(chunk) {
                *lane = if distance < *lane { distance } else { *lane };
            }
        }
        let least = lanes.iter().chain(rest).copied().fold(f32::INFINITY, f32::min);
        self.distances.iter().position(|&distance| distance == least).unwrap_or(0)
    }
}

/// Look-up table of the nearest color for each cell of colors with equal upper bits, filled on first use.
#[derive(Clone, Debug)]
pub(crate) struct LookupTable {
    bits: u32,
    centers: Centers,
    /// Palette numbers, from 1; 0 if not yet known.
    numbers: Vec<u8>,
}

/// Number of pixels per group, whose cells are computed by vector instructions.
const GROUP: usize = 16;

impl LookupTable {
    /// Creates a table with 2^`bits` levels of each channel.
    pub(crate) fn new(colors: &[Rgb], bits: u32) -> Self {
        let mut numbers = vec![0; 1 << (3 * bits)];
        for (&[red, green, blue], number) in colors.iter().zip(1..=u8::MAX) {
            let entry = &mut numbers[cell([red, green, blue, 0], bits) as usize];
            *entry = if *entry == 0 { number } else { *entry }; // palette colors map to themselves, reserved ones first
        }
        let centers: Vec<[f32; 3]> = colors.iter().map(|color| color.map(f32::from)).collect();
        Self { bits, centers: Centers::new(&centers), numbers }
    }

    /// Writes the number of each pixel's color to `out`, which has equal length. A pixel of glow gets one of the two colors
    /// between which it lies. The picture has `width` columns.
    pub(crate) fn look_up_dithered(&mut self, pixels: &[[u8; 4]], width: usize, out: &mut [u8]) {
        self.look_up(pixels, out);
        let rows = pixels.chunks_exact(width.max(1)).zip(out.chunks_exact_mut(width.max(1)));
        for (row, (pixels, numbers)) in rows.enumerate() {
            for (column, (&pixel, number)) in pixels.iter().zip(numbers).enumerate() {
                if pixel[3] > GLOW / 2 {
                    *number = self.dithered(pixel, *number, threshold(column as u32, row as u32));
                }
            }
        }
    }

    /// Chooses the nearest color of a pixel, or one on its other side, in proportions whose mean over all thresholds is about the
    /// color. Without a suitable second color, the nearest one is returned.
    ///
    /// Source: B. Bayer, "An optimum method for two-level rendition of continuous-tone pictures" (1973), applied to two levels
    /// that are searched for each color.
    fn dithered(&mut self, pixel: [u8; 4], nearest: u8, threshold: f32) -> u8 {
        /// Search distances of the second color, as multiples of the error of the nearest one.
        const TIMES: [f32; 3] = [2.0, 4.0, 8.0];
        let near = self.centers.color(nearest);
        let off: [f32; 3] = std::array::from_fn(|channel| f32::from(pixel[channel]) - near[channel]);
        let error: f32 = off.iter().map(|part| part * part).sum();
        for times in TIMES.into_iter().filter(|_| error > 0.0) {
            let [red, green, blue] = std::array::from_fn(|channel: usize| (near[channel] + times * off[channel]) as u8);
            let other = self.number([red, green, blue, 0]);
            let far = self.centers.color(other);
            let way: [f32; 3] = std::array::from_fn(|channel| far[channel] - near[channel]);
            let square: f32 = way.iter().map(|part| part * part).sum();
            let along: f32 = way.iter().zip(off).map(|(part, off)| part * off).sum();
            // At most half of the error may remain.
            if other != nearest && error - along * along / square < 0.25 * error {
                return if along > threshold * square { other } else { nearest };
            }
        }
        nearest
    }

    /// Writes the number of each pixel's nearest color to `out`, which has equal length.
    fn look_up(&mut self, pixels: &[[u8; 4]], out: &mut [u8]) {
        let (groups, rest) = pixels.as_chunks::<GROUP>();
        let (targets, tail) = out.as_chunks_mut::<GROUP>();
        for (group, target) in groups.iter().zip(targets) {
            let cells = group.map(|pixel| cell(pixel, self.bits));
            *target = cells.map(|cell| self.numbers[cell as usize]);
            if target.contains(&0) {
                *target = group.map(|pixel| self.number(pixel));
            }
        }
        for (&pixel, target) in rest.iter().zip(tail) {
            *target = self.number(pixel);
        }
    }

    fn number(&mut self, pixel: [u8; 4]) -> u8 {
        let cell = cell(pixel, self.bits) as usize;
        if self.numbers[cell] == 0 {
            let [red, green, blue, _] = pixel.map(|channel| middle(channel, self.bits));
            self.numbers[cell] = self.centers.nearest([red, green, blue]) as u8 + 1;
        }
        self.numbers[cell]
    }
}

/// Cell of a color: the upper `bits` bits of each channel.
#[inline(always)]
pub(crate) fn cell([red, green, blue, _]: [u8; 4], bits: u32) -> u32 {
    let [red, green, blue] = [red, green, blue].map(|channel| u32::from(channel) >> (8 - bits));
    red << (2 * bits) | green << bits | blue
}

/// Middle of the values that share the upper `bits` bits of a channel.
fn middle(channel: u8, bits: u32) -> f32 {
    let below = 0xFF >> bits;
    f32::from(channel & !below) + f32::from(below) / 2.0
}
