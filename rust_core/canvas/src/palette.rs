//! One palette for a whole film: 255 colors chosen from a few of its frames, and the nearest of them for every pixel.
//!
//! Colors are compared in Oklab, where equal distances look about equally different. The palette begins with a variance cut
//! (split the box with the greatest spread at its mean; after Wu 1991) and is improved by a few rounds of k-means (Lloyd 1982).

use std::collections::BTreeMap;

use crate::canvas::Canvas;
use crate::color::{Oklab, Rgb, distance_squared, oklab, srgb};

/// A GIF's table has 256 entries, of which one stands for "transparent".
const MOST_COLORS: usize = 255;
const ROUNDS: usize = 4;

/// How often each color was seen.
#[derive(Clone, Debug, Default)]
pub struct Histogram {
    counts: BTreeMap<Rgb, u64>,
}

impl Histogram {
    /// Counts the pixels of a frame.
    pub fn observe(&mut self, canvas: &Canvas) {
        let mut colors: Vec<Rgb> = canvas.pixels().iter().map(|&[r, g, b, _]| [r, g, b]).collect();
        colors.sort_unstable();
        for run in colors.chunk_by(|p, q| p == q) {
            *self.counts.entry(run[0]).or_default() += run.len() as u64;
        }
    }
}

/// Up to 255 colors, numbered from 1.
#[derive(Clone, Debug)]
pub struct Palette {
    colors: Vec<Rgb>,
    lightness: Vec<Oklab>,
    /// The number of the nearest color for each of the 2²⁴, found when it is first seen; 0 is not yet known. The system gives
    /// memory only for the pages that are touched.
    nearest: Vec<u8>,
}

#[derive(Clone, Copy, Debug)]
struct Sample {
    color: Oklab,
    weight: f32,
}

impl Palette {
    /// The colors that suit what was seen best. Those `reserved` are in the palette exactly; so are all, if they are few enough.
    pub fn new(histogram: &Histogram, reserved: &[Rgb]) -> Self {
        let mut colors: Vec<Rgb> = Vec::new();
        for &color in reserved.iter().take(MOST_COLORS) {
            if !colors.contains(&color) {
                colors.push(color);
            }
        }
        let others: Vec<(Rgb, u64)> =
            histogram.counts.iter().filter(|(color, _)| !colors.contains(color)).map(|(c, n)| (*c, *n)).collect();
        let room = MOST_COLORS - colors.len();
        if others.len() <= room {
            colors.extend(others.iter().map(|(color, _)| color));
        } else {
            // By the root of the area, so that a small thing in a bright color counts beside a large dark surface.
            let weigh = |&(color, count): &(Rgb, u64)| Sample { color: oklab(color), weight: (count as f32).sqrt() };
            colors.extend(quantize(others.iter().map(weigh).collect(), room));
            colors.sort_unstable();
            colors.dedup();
        }
        if colors.is_empty() {
            colors.push([0; 3]);
        }
        let lightness = colors.iter().map(|&color| oklab(color)).collect();
        Self { colors, lightness, nearest: vec![0; 1 << 24] }
    }

    /// The colors; the first has number 1.
    pub fn colors(&self) -> &[Rgb] {
        &self.colors
    }

    /// The number of each pixel's color, into `out`.
    pub fn indices(&mut self, canvas: &Canvas, out: &mut Vec<u8>) {
        out.clear();
        out.reserve(canvas.pixels().len());
        let (mut last, mut number) = ([0; 3], 0);
        for &[r, g, b, _] in canvas.pixels() {
            if [r, g, b] != last || number == 0 {
                last = [r, g, b];
                number = self.number(last);
            }
            out.push(number);
        }
    }

    fn number(&mut self, color: Rgb) -> u8 {
        let place = u32::from_be_bytes([0, color[0], color[1], color[2]]) as usize;
        if self.nearest[place] == 0 {
            self.nearest[place] = nearest(&self.lightness, oklab(color)) as u8 + 1;
        }
        self.nearest[place]
    }
}

/// The position of the nearest color, of equally near ones the first.
fn nearest(colors: &[Oklab], color: Oklab) -> usize {
    let mut best = (f32::INFINITY, 0);
    for (index, &candidate) in colors.iter().enumerate() {
        let distance = distance_squared(candidate, color);
        if distance < best.0 {
            best = (distance, index);
        }
    }
    best.1
}

/// At most `count` colors near which the samples lie.
fn quantize(mut samples: Vec<Sample>, count: usize) -> Vec<Rgb> {
    let mut centers = variance_cut(&mut samples, count);
    for _ in 0..ROUNDS {
        let mut sums = vec![([0.0; 3], 0.0); centers.len()];
        for sample in &samples {
            let (sum, weight) = &mut sums[nearest(&centers, sample.color)];
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

/// Cuts the samples into boxes, always the one with the greatest spread, at the mean of its widest axis; gives the boxes' means.
fn variance_cut(samples: &mut [Sample], count: usize) -> Vec<Oklab> {
    let whole = Cell::of(samples, 0);
    let mut boxes = vec![whole];
    while boxes.len() < count {
        let widest = (0..boxes.len()).max_by(|&p, &q| boxes[p].spread.total_cmp(&boxes[q].spread).then(q.cmp(&p)));
        let Some(index) = widest.filter(|&index| boxes[index].spread > 0.0) else { break };
        let Cell { start, length, axis, mean, .. } = boxes.swap_remove(index);
        let part = &mut samples[start..start + length];
        part.sort_unstable_by(|p, q| p.color[axis].total_cmp(&q.color[axis]));
        let below = part.partition_point(|sample| sample.color[axis] < mean[axis]).clamp(1, length - 1);
        let (low, high) = part.split_at(below);
        boxes.extend([Cell::of(low, start), Cell::of(high, start + below)]);
    }
    boxes.iter().map(|cell| cell.mean).collect()
}

/// A range of the samples, the mean of its colors and how far they lie from it.
struct Cell {
    start: usize,
    length: usize,
    mean: Oklab,
    axis: usize,
    /// Weighted sum of squares along the widest axis.
    spread: f32,
}

impl Cell {
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
