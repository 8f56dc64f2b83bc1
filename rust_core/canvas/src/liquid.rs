//! Liquid surfaces in screen space, reconstructed from particles.
//!
//! In 2D the drops add up to a field, whose isoline bounds the liquid (metaballs: J. Blinn, "A generalization of algebraic
//! surface drawing", 1982). In 3D the drops are spheres; their front is smoothed in screen space by a filter that does not
//! reach across depth steps (N. Truong and C. Yuksel, "A narrow-range filter for screen-space fluid rendering", 2018), its
//! slope gives the shading, and the thickness of liquid behind each pixel the opacity (W. van der Laan, S. Green and M.
//! Sainz, "Screen space fluid rendering with curvature flow", 2009).

#![expect(clippy::cast_possible_wrap, reason = "no side is longer than 65535 pixels")]

use crate::band::Band;
use crate::color::{Ink, Rgb};
use crate::ink::LAMP;
use crate::view::opaque;

/// A particle of a liquid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drop {
    /// Center, as [`Disc::center`](crate::Disc::center) [pixels].
    pub center: [f32; 2],
    /// Support radius [pixels]: in 2D [`Drop::REACH`] times the particle spacing, in 3D about that spacing.
    pub radius: f32,
    /// Depth behind the focus, in the unit of depths; without meaning in 2D.
    pub depth: f32,
    /// Color and opacity.
    pub color: Ink,
}

impl Drop {
    /// Support radius of a drop in 2D over the particle spacing.
    pub const REACH: f32 = 1.7;
}

/// Depth of an empty pixel: beyond any drop.
const NOTHING: f32 = 1e30;
/// Isovalue of the edge of a liquid in 2D, as a fraction of the field inside: an isolated drop then has a radius of a third
/// of its support.
const EDGE: f32 = 0.3;
/// Isovalue at which the lighter rim of a liquid in 2D ends.
const RIM: f32 = 0.6;
const RIM_LIGHT: f32 = 0.35;
/// Thickness below which the edge of a liquid in 3D fades.
const BRIM: f32 = 0.3;
/// Transmittance of the thinnest liquid; a liquid as thick as a drop's support transmits a quarter of that.
const CLEAR: f32 = 0.45;
const ROUNDS: usize = 2;

/// The drops of one frame, and their screen-space buffers, which are reused for the next frame.
#[derive(Debug, Default)]
pub struct Liquid {
    drops: Vec<Drop>,
    sky: Rgb,
    /// Pixels per unit of depth; 0 in 2D.
    scale: f32,
    width: usize,
    /// Depth difference above which neighboring pixels belong to different parts of the surface [pixels].
    range: f32,
    /// Depth of the front in 3D [pixels].
    front: Vec<f32>,
    /// In 2D the field over its mean inside, in 3D the thickness over a drop's support.
    amount: Vec<f32>,
    /// Weighted sums of the colors of the visible drops, and of the weights.
    colors: Vec<[f32; 4]>,
    scratch: [Vec<f32>; 3],
}

impl Liquid {
    /// Adds a drop.
    pub fn drop(&mut self, drop: Drop) {
        let (Drop { radius, .. }, [x, y], depth) = (drop, drop.center, drop.depth * self.scale);
        if x.is_finite() && y.is_finite() && depth.is_finite() && radius > 0.0 {
            self.drops.push(Drop { depth, ..drop });
        }
    }

    /// Begins a frame, before any drop: `scale` in pixels per unit of depth (0 in 2D), and the color reflected at grazing
    /// angles.
    pub fn begin(&mut self, scale: f32, sky: Rgb) {
        (self.scale, self.sky) = (scale, sky);
    }

    /// The number of drops.
    pub fn len(&self) -> usize {
        self.drops.len()
    }

    /// Whether there is any.
    pub fn is_empty(&self) -> bool {
        self.drops.is_empty()
    }

    /// Reconstructs the surface of the drops, for a canvas of this size.
    pub(crate) fn settle(&mut self, width: usize, height: usize) {
        self.width = width;
        for (plane, empty) in [(&mut self.front, NOTHING), (&mut self.amount, 0.0)] {
            plane.clear();
            plane.resize(width * height, empty);
        }
        self.colors.clear();
        self.colors.resize(width * height, [0.0; 4]);
        if self.scale > 0.0 {
            self.splat_front();
            self.splat_visible_colors();
            self.smooth();
        } else {
            self.splat_field();
        }
    }

    /// Whether a shape at a depth is in front of the liquid at a pixel; always in 2D.
    pub(crate) fn leaves_in_front(&self, [x, y]: [f32; 2], depth: f32) -> bool {
        let (column, row) = (x as usize, y as usize);
        let inside = column < self.width && row < self.front.len() / self.width;
        self.scale == 0.0 || !inside || depth * self.scale <= self.front[row * self.width + column]
    }

    /// Paints the liquid on some rows.
    pub(crate) fn paint(&self, band: &mut Band<'_>) {
        for row in band.rows() {
            for column in 0..self.width {
                let pixel = row * self.width + column;
                if self.amount[pixel] > 0.0 {
                    let (color, coverage) = if self.scale > 0.0 { self.lit(row, column) } else { self.rimmed(row, column) };
                    band.dot(column as i32, row as i32, color, coverage);
                }
            }
        }
    }

    /// Removes all drops.
    pub(crate) fn clear(&mut self) {
        self.drops.clear();
    }

    /// The field Σ (1 − d²/r²)³ of all drops, over its mean π/4 (r/s)² inside a liquid whose drops are s apart.
    fn splat_field(&mut self) {
        const INSIDE: f32 = 0.25 * std::f32::consts::PI * Drop::REACH * Drop::REACH;
        let Self { drops, amount, colors, width, .. } = self;
        for drop in drops.iter() {
            for_each_pixel(drop, *width, amount.len(), |pixel, square| {
                let share = (1.0 - square) * (1.0 - square) * (1.0 - square) / INSIDE;
                amount[pixel] += share;
                tint(&mut colors[pixel], drop.color, share);
            });
        }
    }

    /// The front depth of the union of all spheres, and the sum of their thicknesses over the support.
    fn splat_front(&mut self) {
        let Self { drops, front, amount, width, .. } = self;
        for drop in drops.iter() {
            for_each_pixel(drop, *width, front.len(), |pixel, square| {
                let half = (1.0 - square).max(0.0).sqrt();
                let near = drop.depth - half * drop.radius;
                front[pixel] = if near < front[pixel] { near } else { front[pixel] };
                // Drops overlap: where their spacing is their support radius, each stands for r³ of the 4π/3 r³ of its
                // sphere.
                amount[pixel] += half * (1.5 / std::f32::consts::PI);
            });
        }
    }

    /// The colors of the drops no deeper than their own size behind the front.
    fn splat_visible_colors(&mut self) {
        let Self { drops, front, colors, width, .. } = self;
        for drop in drops.iter() {
            for_each_pixel(drop, *width, front.len(), |pixel, square| {
                let behind = (drop.depth - front[pixel]) / (2.0 * drop.radius);
                let share = (1.0 - square) * (1.0 - behind).max(0.001);
                tint(&mut colors[pixel], drop.color, share);
            });
        }
    }

    /// Narrow-range filter: smooths the front over about a drop by the weights (1 − d²)², along rows and columns in turn,
    /// without neighbors that differ by more than the range in depth.
    fn smooth(&mut self) {
        let mean = self.drops.iter().map(|drop| drop.radius).sum::<f32>() / self.drops.len().max(1) as f32;
        let reach = (1.5 * mean).clamp(1.0, 32.0);
        self.range = 4.0 * mean;
        let taps = reach.ceil() as usize;
        let weights: Vec<f32> = (0..=taps).map(|tap| (1.0 - (tap as f32 / (taps + 1) as f32).powi(2)).powi(2)).collect();
        for _ in 0..ROUNDS {
            for stride in [1, self.width] {
                self.filter(stride, &weights);
            }
        }
    }

    /// One pass of the filter over neighbors at multiples of a stride. At the ends of rows it wraps into the next row,
    /// which blurs a few pixels where there is liquid at both edges.
    fn filter(&mut self, stride: usize, weights: &[f32]) {
        let Self { front, range, scratch: [sums, totals, before], .. } = self;
        let count = front.len();
        before.clone_from(front);
        sums.clear();
        sums.extend(front.iter().map(|depth| depth * weights[0]));
        totals.clear();
        totals.resize(count, weights[0]);
        for (tap, &weight) in weights.iter().enumerate().skip(1) {
            let shift = (tap * stride).min(count);
            let (here, there) = (&before[..count - shift], &before[shift..]);
            gather(&mut sums[..count - shift], &mut totals[..count - shift], here, there, weight, *range);
            gather(&mut sums[shift..], &mut totals[shift..], there, here, weight, *range);
        }
        for ((depth, sum), total) in front.iter_mut().zip(sums.iter()).zip(totals.iter()) {
            *depth = sum / total;
        }
    }

    /// The color and coverage of a pixel in 2D: the edge is one pixel wide, and a lighter rim follows it.
    fn rimmed(&self, row: usize, column: usize) -> (Ink, f32) {
        let [dx, dy] = self.slope(&self.amount, row, column, |_, _| true);
        let steepness = (dx * dx + dy * dy).sqrt().max(1e-3);
        let amount = self.amount[row * self.width + column];
        let coverage = (0.5 + (amount - EDGE) / steepness).clamp(0.0, 1.0);
        let rim = RIM_LIGHT * ((RIM - amount) / (RIM - EDGE)).clamp(0.0, 1.0);
        let [red, green, blue] = self.mean(row * self.width + column).map(|channel| channel + (255.0 - channel) * rim);
        (opaque([red + 0.5, green + 0.5, blue + 0.5]), coverage)
    }

    /// The color and coverage of a pixel in 3D: half-Lambert light, a highlight, and the sky where the surface is seen flat.
    fn lit(&self, row: usize, column: usize) -> (Ink, f32) {
        let pixel = row * self.width + column;
        let steepest = 3.0;
        let near = |a: f32, b: f32| (a - b).abs() < self.range;
        let [dx, dy] = self.slope(&self.front, row, column, near).map(|slope| slope.clamp(-steepest, steepest));
        let scale = 1.0 / (1.0 + dx * dx + dy * dy).sqrt();
        // The viewer is where depths are small: the normal leans to where the depth grows.
        let (nx, ny, nz) = (dx * scale, dy * scale, scale);
        let light = nx * LAMP[0] + ny * LAMP[1] + nz * LAMP[2];
        let half = [LAMP[0], LAMP[1], LAMP[2] + 1.0].map(|component| component / (2.0 + 2.0 * LAMP[2]).sqrt());
        let highlight = 190.0 * (nx * half[0] + ny * half[1] + nz * half[2]).max(0.0).powi(48);
        let mirrored = 0.02 + 0.75 * (1.0 - nz).powi(3);
        let diffuse = 0.55 + 0.45 * light;
        let color = self.mean(pixel);
        let channel = |index: usize| {
            let body = color[index] * diffuse;
            (body + (f32::from(self.sky[index]) - body) * mirrored + highlight).clamp(0.0, 255.0) as u8
        };
        let amount = self.amount[pixel];
        let coverage = (amount / BRIM).min(1.0) * (1.0 - CLEAR / ((1.0 + amount) * (1.0 + amount)));
        ([channel(0), channel(1), channel(2), 255], coverage)
    }

    /// Gradient of a buffer to the right and down; the smaller of the two one-sided differences, so that a depth step
    /// counts on one side only.
    fn slope(&self, plane: &[f32], row: usize, column: usize, joined: impl Fn(f32, f32) -> bool) -> [f32; 2] {
        let pixel = row * self.width + column;
        let here = plane[pixel];
        let side = |exists: bool, there: usize| {
            let there = if exists { plane[there] } else { here };
            if joined(here, there) { Some(there - here) } else { None }
        };
        let gentler = |after: Option<f32>, before: Option<f32>| match (after, before.map(|step| -step)) {
            (Some(p), Some(q)) if q.abs() < p.abs() => q,
            (Some(p), _) => p,
            (None, q) => q.unwrap_or(0.0),
        };
        let (width, count) = (self.width, plane.len());
        [
            gentler(side(column + 1 < width, pixel + 1), side(column > 0, pixel.wrapping_sub(1))),
            gentler(side(pixel + width < count, pixel + width), side(row > 0, pixel.wrapping_sub(width))),
        ]
    }

    /// The weighted mean color of the drops at a pixel.
    fn mean(&self, pixel: usize) -> [f32; 3] {
        let [red, green, blue, weight] = self.colors[pixel];
        [red, green, blue].map(|sum| sum / weight.max(1e-12))
    }
}

/// Visits every pixel in a drop's support, with the squared distance from its center over its radius.
#[inline(always)]
fn for_each_pixel(drop: &Drop, width: usize, count: usize, mut visit: impl FnMut(usize, f32)) {
    let ([x, y], radius, height) = (drop.center, drop.radius, count / width.max(1));
    let first = |low: f32| (low + 0.5).max(0.0) as usize;
    let per_square = 1.0 / (radius * radius);
    for row in first(y - radius)..first(y + radius).min(height) {
        let dy = row as f32 + 0.5 - y;
        let half = (radius * radius - dy * dy).max(0.0).sqrt();
        for column in first(x - half)..first(x + half).min(width) {
            let dx = column as f32 + 0.5 - x;
            visit(row * width + column, (dx * dx + dy * dy) * per_square);
        }
    }
}

fn tint(sum: &mut [f32; 4], color: Ink, weight: f32) {
    let [red, green, blue, _] = color.map(f32::from);
    for (sum, channel) in sum.iter_mut().zip([red, green, blue, 1.0]) {
        *sum += weight * channel;
    }
}

/// Adds neighbors within a depth range, with equal weights.
fn gather(sums: &mut [f32], totals: &mut [f32], here: &[f32], there: &[f32], weight: f32, range: f32) {
    for (((sum, total), here), there) in sums.iter_mut().zip(totals).zip(here).zip(there) {
        let share = if (there - here).abs() < range { weight } else { 0.0 };
        *sum += share * there;
        *total += share;
    }
}
