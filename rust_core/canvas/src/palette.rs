//! One palette for a whole film: 255 colors chosen from a few of its frames, and the nearest of them for every pixel.
//!
//! Colors are compared in Oklab, where equal distances look about equally different. The palette begins with a variance cut
//! (split the box with the greatest spread at its mean; after Wu 1991) and is improved by a few rounds of k-means (Lloyd 1982).

use crate::canvas::Canvas;
use crate::color::{Oklab, Rgb, oklab, srgb};

/// A GIF's table has 256 entries, of which one stands for "transparent".
const MOST_COLORS: usize = 255;
const ROUNDS: usize = 3;
const CELLS: usize = 1 << 18;

/// How often each color was seen, in cells of 4 × 4 × 4 colors: finer than 255 colors can tell apart.
#[derive(Clone, Debug)]
pub struct Histogram {
    cells: Vec<Tally>,
}

/// The number of pixels in a cell and the sums of their channels: what lies alone in its cell keeps its color exactly.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    count: u64,
    sums: [u64; 3],
}

impl Default for Histogram {
    fn default() -> Self {
        Self { cells: vec![Tally::default(); CELLS] }
    }
}

impl Histogram {
    /// Counts the pixels of a frame.
    pub fn observe(&mut self, canvas: &Canvas) {
        for &[red, green, blue, _] in canvas.pixels() {
            let tally = &mut self.cells[cell([red, green, blue])];
            tally.count += 1;
            tally.sums[0] += u64::from(red);
            tally.sums[1] += u64::from(green);
            tally.sums[2] += u64::from(blue);
        }
    }

    /// The mean color of each cell in which something was seen, and how often.
    fn colors(&self) -> impl Iterator<Item = (Rgb, u64)> {
        let seen = self.cells.iter().filter(|tally| tally.count > 0);
        seen.map(|&Tally { count, sums }| (sums.map(|sum| ((sum + count / 2) / count) as u8), count))
    }
}

/// Up to 255 colors, numbered from 1.
#[derive(Clone, Debug)]
pub struct Palette {
    colors: Vec<Rgb>,
    centers: Centers,
    /// The number of the nearest color for each cell of 4 × 4 × 4 colors, found when one is first seen; 0 is not yet known.
    /// So small a table stays in the cache, and 255 colors lie much farther apart than the colors of a cell.
    nearest: Vec<u8>,
}

#[derive(Clone, Copy, Debug)]
struct Sample {
    color: Oklab,
    weight: f32,
}

impl Palette {
    /// The colors that suit what was seen best. Those `reserved` are in the palette exactly; so are
    /// all, if they are few and no two lie in one cell.
    pub fn new(histogram: &Histogram, reserved: &[Rgb]) -> Self {
        let mut colors: Vec<Rgb> = Vec::new();
        let add = |colors: &mut Vec<Rgb>, color: Rgb| {
            if !colors.contains(&color) && colors.len() < MOST_COLORS {
                colors.push(color);
            }
        };
        for &color in reserved {
            add(&mut colors, color);
        }
        let others: Vec<(Rgb, u64)> = histogram.colors().filter(|(color, _)| !colors.contains(color)).collect();
        let room = MOST_COLORS - colors.len();
        if others.len() <= room {
            colors.extend(others.iter().map(|(color, _)| color));
        } else {
            // By the root of the area, so that a small thing in a bright color counts beside a large dark surface.
            let weigh = |&(color, count): &(Rgb, u64)| Sample { color: oklab(color), weight: (count as f32).sqrt() };
            let found = quantize(others.iter().map(weigh).collect(), room);
            for color in found {
                add(&mut colors, color);
            }
        }
        if colors.is_empty() {
            colors.push([0; 3]);
        }
        let mut nearest = vec![0; CELLS];
        for (&color, number) in colors.iter().zip(1..=u8::MAX) {
            let place = &mut nearest[cell(color)];
            *place = if *place == 0 { number } else { *place }; // a color of the palette stays what it is, those reserved first
        }
        let perceived: Vec<Oklab> = colors.iter().map(|&color| oklab(color)).collect();
        Self { colors, centers: Centers::new(&perceived), nearest }
    }

    /// The colors; the first has number 1.
    pub fn colors(&self) -> &[Rgb] {
        &self.colors
    }

    /// The number of each pixel's color, into `out`.
    pub fn indices(&mut self, canvas: &Canvas, out: &mut Vec<u8>) {
        out.clear();
        out.reserve(canvas.pixels().len());
        out.extend(canvas.pixels().iter().map(|&[red, green, blue, _]| self.number([red, green, blue])));
    }

    #[inline(always)]
    fn number(&mut self, color: Rgb) -> u8 {
        let place = cell(color);
        if self.nearest[place] == 0 {
            let middle = color.map(|channel| channel & 0xFC | 2);
            self.nearest[place] = self.centers.nearest(oklab(middle)) as u8 + 1;
        }
        self.nearest[place]
    }
}

/// The cell of 4 × 4 × 4 colors that a color lies in.
#[inline(always)]
fn cell([red, green, blue]: Rgb) -> usize {
    usize::from(red >> 2) << 12 | usize::from(green >> 2) << 6 | usize::from(blue >> 2)
}

/// Colors as one array per axis, so that the distances to all of them are found at once.
#[derive(Clone, Debug)]
struct Centers {
    axes: [Vec<f32>; 3],
    distances: Vec<f32>,
}

impl Centers {
    fn new(colors: &[Oklab]) -> Self {
        let axes = [0, 1, 2].map(|axis| colors.iter().map(|color| color[axis]).collect());
        Self { axes, distances: vec![0.0; colors.len()] }
    }

    /// The position of the nearest color, of equally near ones the first.
    fn nearest(&mut self, color: Oklab) -> usize {
        let [x, y, z] = &self.axes;
        for (((distance, x), y), z) in self.distances.iter_mut().zip(x).zip(y).zip(z) {
            let (dx, dy, dz) = (x - color[0], y - color[1], z - color[2]);
            *distance = dx * dx + dy * dy + dz * dz;
        }
        // Eight minima side by side; comparing, not `min`, because only that is one instruction.
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

/// At most `count` colors near which the samples lie.
fn quantize(mut samples: Vec<Sample>, count: usize) -> Vec<Rgb> {
    let mut centers = variance_cut(&mut samples, count);
    for _ in 0..ROUNDS {
        let mut sums = vec![([0.0; 3], 0.0); centers.len()];
        let mut search = Centers::new(&centers);
        for sample in &samples {
            let (sum, weight) = &mut sums[search.nearest(sample.color)];
            (0..3).for_each(|axis| sum[axis] += sample.weight * sample.color[axis]);
            *weight += sample.weight;
        }
        for (center, (sum, weight)) in centers.iter_mut().zip(sums) {
            if weight > 0.0 {
                *center = sum.map(|value: f32| value / weight);
            }
        }
    }
    centers.into_iter().map(srgb).collect()
}

/// Cuts the samples into parts, always the one with the greatest spread, at the mean of its widest axis; gives the parts' means.
fn variance_cut(samples: &mut [Sample], count: usize) -> Vec<Oklab> {
    let whole = Part::of(samples, 0);
    let mut parts = vec![whole];
    while parts.len() < count {
        let widest = (0..parts.len()).max_by(|&p, &q| parts[p].spread.total_cmp(&parts[q].spread).then(q.cmp(&p)));
        let Some(index) = widest.filter(|&index| parts[index].spread > 0.0) else {
            break;
        };
        let Part { start, length, axis, mean, .. } = parts.swap_remove(index);
        let part = &mut samples[start..start + length];
        part.sort_unstable_by(|p, q| p.color[axis].total_cmp(&q.color[axis]));
        let below = part.partition_point(|sample| sample.color[axis] < mean[axis]).clamp(1, length - 1);
        let (low, high) = part.split_at(below);
        parts.extend([Part::of(low, start), Part::of(high, start + below)]);
    }
    parts.iter().map(|cell| cell.mean).collect()
}

/// A range of the samples, the mean of its colors and how far they lie from it.
struct Part {
    start: usize,
    length: usize,
    mean: Oklab,
    axis: usize,
    /// Weighted sum of squares along the widest axis.
    spread: f32,
}

impl Part {
    fn of(samples: &[Sample], start: usize) -> Self {
        let total: f32 = samples.iter().map(|sample| sample.weight).sum();
        let mean = [0, 1, 2].map(|axis| samples.iter().map(|s| s.weight * s.color[axis]).sum::<f32>() / total);
        let square = |axis: usize| samples.iter().map(|s| s.weight * (s.color[axis] - mean[axis]).powi(2)).sum::<f32>();
        let squares = [square(0), square(1), square(2)];
        let axis = (0..3).max_by(|&p, &q| squares[p].total_cmp(&squares[q])).unwrap_or(0);
        let spread = if samples.len() > 1 { squares[axis] } else { 0.0 };
        Self { start, length: samples.len(), mean, axis, spread }
    }
}
