//! Drops that flow together: a liquid as the eye sees it, found on the screen from the particles that it is made of.
//!
//! In 2D the drops add up to a field, and the liquid is where the field is strong (J. Blinn, "A generalization of algebraic surface
//! drawing", 1982). In 3D the drops are balls; their front is smoothed on the screen by a filter that does not reach across steps
//! (N. Truong and C. Yuksel, "A narrow-range filter for screen-space fluid rendering", 2018), its slope gives the light, and how
//! much liquid lies behind each pixel gives the opacity (W. van der Laan, S. Green and M. Sainz, "Screen space fluid rendering with
//! curvature flow", 2009).

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
    /// How far it reaches [pixels]: in 2D [`Drop::REACH`] times the distance between particles, in 3D about that distance.
    pub radius: f32,
    /// How far it is beyond the focus, in the unit of depths; without meaning in 2D.
    pub depth: f32,
    /// What it is painted with.
    pub color: Ink,
}

impl Drop {
    /// How far a drop reaches in 2D, over the distance between particles.
    pub const REACH: f32 = 1.7;
}

/// Where there is nothing: farther than anything.
const NOTHING: f32 = 1e30;
/// The edge of a liquid in 2D, as a fraction of the field inside: a drop by itself then has a third of its reach as its radius.
const EDGE: f32 = 0.3;
/// Where the lighter rim of a liquid in 2D ends.
const RIM: f32 = 0.6;
const RIM_LIGHT: f32 = 0.35;
/// Where a liquid in 3D is thinner than this, its edge fades.
const BRIM: f32 = 0.3;
/// How much of what is behind is seen through the thinnest liquid; through one as thick as a drop's reach, a quarter of
/// that.
const CLEAR: f32 = 0.45;
const ROUNDS: usize = 2;

/// The drops of one frame, and the planes of pixels on which they meet; the memory is kept for the next frame.
#[derive(Debug, Default)]
pub struct Liquid {
    drops: Vec<Drop>,
    sky: Rgb,
    /// Pixels per unit of depth; 0 in 2D.
    scale: f32,
    width: usize,
    /// Neighboring pixels farther apart in depth than this belong to different parts of the surface [pixels].
    range: f32,
    /// In 3D the depth of the front [pixels].
    front: Vec<f32>,
    /// In 2D the field, in 3D how thick the liquid is, both relative to what is typical inside and to a drop's reach.
    amount: Vec<f32>,
    /// Sums of the colors of the drops that can be seen, and of their weights.
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

    /// Before any drop is added: how many pixels a unit of depth is (0 in 2D), and what is mirrored where the surface is seen under
    /// a flat angle.
    pub fn begin(&mut self, scale: f32, sky: Rgb) {
        (self.scale, self.sky) = (scale, sky);
    }

    /// How many drops there are.
    pub fn len(&self) -> usize {
        self.drops.len()
    }

    /// Whether there is any.
    pub fn is_empty(&self) -> bool {
        self.drops.is_empty()
    }

    /// Finds the surface of what was added, for a canvas of this size.
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

    /// Whether a shape at some depth in front of a pixel is nearer than the liquid there; in 2D everything is.
    pub(crate) fn leaves_in_front(&self, [x, y]: [f32; 2], depth: f32) -> bool {
        let (column, row) = (x as usize, y as usize);
        let inside = column < self.width && row < self.front.len() / self.width;
        self.scale == 0.0 || !inside || depth * self.scale <= self.front[row * self.width + column]
    }

    /// Paints the liquid on some rows.
    pub(crate) fn paint(&self, band: &mut Band<'_>) {
        for row in band.rows() {
            for column in 0..self.width {
                let place = row * self.width + column;
                if self.amount[place] > 0.0 {
                    let (color, coverage) = if self.scale > 0.0 { self.lit(row, column) } else { self.rimmed(row, column) };
                    band.dot(column as i32, row as i32, color, coverage);
                }
            }
        }
    }

    /// Forgets the drops.
    pub(crate) fn clear(&mut self) {
        self.drops.clear();
    }

    /// The field Σ (1 − d²/r²)³ of all drops, over its mean π/4 (r/s)² inside a liquid whose drops are s apart.
    fn splat_field(&mut self) {
        const INSIDE: f32 = 0.25 * std::f32::consts::PI * Drop::REACH * Drop::REACH;
        let Self { drops, amount, colors, width, .. } = self;
        for drop in drops.iter() {
            for_each_pixel(drop, *width, amount.len(), |place, square| {
                let share = (1.0 - square) * (1.0 - square) * (1.0 - square) / INSIDE;
                amount[place] += share;
                tint(&mut colors[place], drop.color, share);
            });
        }
    }

    /// The nearest point of all balls, and the thickness of all of them over their reach.
    fn splat_front(&mut self) {
        let Self { drops, front, amount, width, .. } = self;
        for drop in drops.iter() {
            for_each_pixel(drop, *width, front.len(), |place, square| {
                let half = (1.0 - square).max(0.0).sqrt();
                let near = drop.depth - half * drop.radius;
                front[place] = if near < front[place] { near } else { front[place] };
                // Drops overlap: in a liquid whose drops are their reach apart, each stands for r³ of the 4π/3 r³ of its ball.
                amount[place] += half * (1.5 / std::f32::consts::PI);
            });
        }
    }

    /// The colors of the drops no deeper than their own size behind the front.
    fn splat_visible_colors(&mut self) {
        let Self { drops, front, colors, width, .. } = self;
        for drop in drops.iter() {
            for_each_pixel(drop, *width, front.len(), |place, square| {
                let behind = (drop.depth - front[place]) / (2.0 * drop.radius);
                let share = (1.0 - square) * (1.0 - behind).max(0.001);
                tint(&mut colors[place], drop.color, share);
            });
        }
    }

    /// Smooths the front over about a drop by the weights (1 − d²)², along rows and columns in turn, leaving out what is a drop farther or
    /// nearer.
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

    /// One pass of the filter over neighbors that are multiples of a stride away. Across the ends of rows it reaches into the next
    /// row, which is as far as the picture is wide and so, where there is liquid at both edges, blurs a few pixels of them.
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
        let place = row * self.width + column;
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
        let color = self.mean(place);
        let channel = |index: usize| {
            let body = color[index] * diffuse;
            (body + (f32::from(self.sky[index]) - body) * mirrored + highlight).clamp(0.0, 255.0) as u8
        };
        let amount = self.amount[place];
        let coverage = (amount / BRIM).min(1.0) * (1.0 - CLEAR / ((1.0 + amount) * (1.0 + amount)));
        ([channel(0), channel(1), channel(2), 255], coverage)
    }

    /// How steeply a plane rises to the right and down; of the two sides the gentler, so that steps count on one side only.
    fn slope(&self, plane: &[f32], row: usize, column: usize, joined: impl Fn(f32, f32) -> bool) -> [f32; 2] {
        let place = row * self.width + column;
        let here = plane[place];
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
            gentler(side(column + 1 < width, place + 1), side(column > 0, place.wrapping_sub(1))),
            gentler(side(place + width < count, place + width), side(row > 0, place.wrapping_sub(width))),
        ]
    }

    /// The mean color of the drops seen at a pixel.
    fn mean(&self, place: usize) -> [f32; 3] {
        let [red, green, blue, weight] = self.colors[place];
        [red, green, blue].map(|sum| sum / weight.max(1e-12))
    }
}

/// Every pixel that a drop reaches, with the square of the distance from its center over its reach.
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

/// Adds neighbors that are no farther in depth than a range, each with the same weight.
fn gather(sums: &mut [f32], totals: &mut [f32], here: &[f32], there: &[f32], weight: f32, range: f32) {
    for (((sum, total), here), there) in sums.iter_mut().zip(totals).zip(here).zip(there) {
        let share = if (there - here).abs() < range { weight } else { 0.0 };
        *sum += share * there;
        *total += share;
    }
}
