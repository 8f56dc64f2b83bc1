//! Liquid surfaces in screen space, reconstructed from particles.
//!
//! In 2D they are metaballs, in `flat`. In 3D the drops are spheres. Their front is smoothed in screen space by a filter that does
//! not reach across depth steps. The slope of the front gives the shading. The thickness of the liquid at each pixel gives the
//! opacity (W. van der Laan, S. Green and M. Sainz, "Screen space fluid rendering with curvature flow", 2009).

#![expect(clippy::cast_possible_wrap, reason = "no side is longer than 65535 pixels")]

use std::ops::Range;

use crate::band::Band;
use crate::color::Ink;
use crate::eye::Eye;
use crate::ink::LAMP;
use crate::shadow::Caster;
use crate::sky::Sky;
use crate::smoothing::{avoid_edges, blur_plane};
use crate::view::opaque;

mod flat;
mod glow;
mod spray;

/// Particle of a liquid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drop {
    /// Center, as [`Disc::center`](crate::Disc::center) [pixels].
    pub center: [f32; 2],
    /// Support radius [pixels]: in 2D [`Drop::REACH`] times the particle spacing, in 3D about that spacing.
    pub radius: f32,
    /// Depth behind the focus, in the unit of depths; without meaning in 2D.
    pub depth: f32,
    /// Color. The opacity says how little light passes through: 255 for milk, less for water.
    pub color: Ink,
}

impl Drop {
    /// Support radius of a drop in 2D over the particle spacing.
    pub const REACH: f32 = 1.7;
}

/// Depth of an empty pixel: beyond any drop.
const NOTHING: f32 = 1e30;
/// Thickness of a liquid in 3D at its edge.
const BRIM: f32 = 0.12;
/// Optical depth for scattered light of a liquid as thick as the support of a drop: for a clear and for an opaque liquid.
const SCATTERS: [f32; 2] = [0.05, 4.0];
/// Exponent of the tint of transmitted light, for a liquid as thick as the support of a drop.
const TINTS: f32 = 0.1;
/// Lateral refraction of transmitted light, over the thickness.
const BENDS: f32 = 0.35;
/// Maximum refraction [pixels].
const FARTHEST: f32 = 24.0;
/// Reach of the color of a drop in 3D, over its support.
const SMOOTH: f32 = 1.7;
/// Widest step of the filter of the front, over the support of a drop.
const WIDEST: f32 = 0.7;
/// Number of times that the front is filtered, with all steps.
const ROUNDS: usize = 2;
/// Maximum step of the filter [pixels].
const FARTHEST_STEP: usize = 24;
/// Thickness above which shadows fall on a liquid in 3D instead of on the background seen through it: for a clear and for an
/// opaque liquid.
const SHADED: [f32; 2] = [1.2, 0.5 * BRIM];
/// Blur radius of the thickness of a liquid in 3D, over the support of a drop.
const SOFT: f32 = 0.45;
/// Maximum blur radius [pixels].
const FARTHEST_BLUR: usize = 16;
/// Brightness of the reflected lamp.
const HIGHLIGHT: f32 = 110.0;
/// Share of light that the middle of an opaque drop blocks; one that glows lights what is in its shadow.
const HELD: f32 = 0.5;

/// Drops of one frame, and their screen-space buffers, which are reused for the next frame.
#[derive(Debug, Default)]
pub struct Liquid {
    drops: Vec<Drop>,
    /// Sky that the liquid reflects in 3D.
    sky: Option<Sky>,
    /// Share of its color that the liquid emits, 0 to 1.
    glow: f32,
    /// Pixels per unit of depth; 0 in 2D.
    scale: f32,
    width: usize,
    /// Rows that contain liquid in 3D, with a margin.
    rows: Range<usize>,
    /// Depth difference above which neighboring pixels belong to different parts of the surface [pixels].
    range: f32,
    /// Depth of the front in 3D [pixels].
    front: Vec<f32>,
    /// Field over its mean inside (2D), or thickness over the support of a drop (3D).
    amount: Vec<f32>,
    /// Normalized distance from the edge in 2D, 0 to 1.
    inside: Vec<f32>,
    /// Weighted sums of the colors and opacities of the visible drops, and sums of the weights.
    colors: Vec<[f32; 5]>,
    /// Light of a glowing liquid in 3D on its surroundings, by channel.
    light: [Vec<f32>; 3],
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

    /// Scales the liquid to a picture with `times` as many pixels along each side.
    pub(crate) fn magnify(&mut self, times: f32) {
        self.scale *= times;
        for drop in &mut self.drops {
            let center = drop.center.map(|place| times * place);
            *drop = Drop { center, radius: times * drop.radius, depth: times * drop.depth, ..*drop };
        }
    }

    /// Begins a frame, before any drop.
    ///
    /// - `scale`: pixels per unit of depth (0 in 2D).
    /// - `sky`: sky that the liquid reflects in 3D.
    /// - `glow`: share of its color that the liquid emits.
    pub fn begin(&mut self, scale: f32, sky: Sky, glow: f32) {
        (self.scale, self.sky, self.glow) = (scale, Some(sky), glow.clamp(0.0, 1.0));
    }

    /// Number of drops.
    pub fn len(&self) -> usize {
        self.drops.len()
    }

    /// Whether there are no drops.
    pub fn is_empty(&self) -> bool {
        self.drops.is_empty()
    }

    /// Reconstructs the surface of the drops for a canvas of this size.
    pub(crate) fn settle(&mut self, width: usize, height: usize) {
        self.width = width;
        for (plane, empty) in [(&mut self.front, NOTHING), (&mut self.amount, 0.0)] {
            plane.clear();
            plane.resize(width * height, empty);
        }
        self.colors.clear();
        self.colors.resize(width * height, [0.0; 5]);
        if self.scale > 0.0 {
            spray::spray(&mut self.drops);
        }
        let radii = self.drops.iter().map(|drop| drop.radius);
        self.range = 4.0 * (radii.sum::<f32>() / self.drops.len().max(1) as f32);
        if self.scale > 0.0 {
            self.rows = self.occupied(height);
            self.splat_front();
            self.splat_visible_colors();
            self.smooth();
            self.soften();
            if self.glow > 0.0 {
                self.shine();
            }
        } else {
            self.splat_field();
            self.find_inside();
        }
    }

    /// Rows of a picture that drops reach, with a margin for the blur of the thickness.
    fn occupied(&self, height: usize) -> Range<usize> {
        let ends = self.drops.iter().map(|drop| (drop.center[1] - drop.radius, drop.center[1] + drop.radius));
        let (low, high) = ends.fold((f32::MAX, f32::MIN), |(low, high), ends| (low.min(ends.0), high.max(ends.1)));
        let around = FARTHEST_BLUR as f32 + 1.0;
        let last = (high + around).clamp(0.0, height as f32) as usize;
        ((low - around).clamp(0.0, height as f32) as usize).min(last)..last
    }

    /// Whether a shape at a depth is in front of the liquid at a pixel; always true in 2D.
    pub(crate) fn leaves_in_front(&self, [x, y]: [f32; 2], depth: f32) -> bool {
        let (column, row) = (x as usize, y as usize);
        let inside = column < self.width && row < self.front.len() / self.width;
        self.scale == 0.0 || !inside || depth * self.scale <= self.front[row * self.width + column]
    }

    /// Shadow casters of the drops in 3D, with the share of light that they block.
    pub(crate) fn casters(&self, eye: Eye) -> impl Iterator<Item = (Caster, f32)> {
        let held = HELD * (1.0 - self.glow);
        self.drops.iter().filter(|_| self.scale > 0.0).map(move |drop| {
            let (depth, share) = (drop.depth / self.scale, held * f32::from(drop.color[3]) / 255.0);
            (Caster::Drop(eye.place(drop.center, depth), drop.radius / eye.magnification(depth)), share)
        })
    }

    /// Whether the liquid is in 3D and shows the background through it.
    pub(crate) fn is_deep(&self) -> bool {
        self.scale > 0.0
    }

    /// Paints the liquid on some rows. `behind` is the whole picture without the liquid, for 3D.
    pub(crate) fn paint(&self, band: &mut Band<'_>, behind: &[[u8; 4]]) {
        for row in band.rows() {
            for column in 0..self.width {
                let pixel = row * self.width + column;
                if self.is_deep() && self.glow > 0.0 {
                    let lit = std::array::from_fn(|channel| f32::from(behind[pixel][channel]) + self.light[channel][pixel]);
                    band.dot(column as i32, row as i32, opaque(lit), 1.0);
                }
                if self.amount[pixel] <= 0.0 {
                    continue;
                }
                if self.is_deep() {
                    let (color, coverage) = self.lit(row, column, behind);
                    band.dot(column as i32, row as i32, color, coverage);
                    let opacity = self.mean(pixel).1;
                    let shaded = self.amount[pixel] > SHADED[0] + (SHADED[1] - SHADED[0]) * opacity;
                    if shaded && self.front[pixel] < NOTHING {
                        band.deepen_dot(column as i32, row as i32, self.front[pixel] / self.scale);
                    }
                } else {
                    let (color, coverage) = self.rimmed(row, column);
                    band.dot(column as i32, row as i32, color, coverage);
                }
            }
        }
    }

    /// Removes all drops.
    pub(crate) fn clear(&mut self) {
        self.drops.clear();
    }

    /// Computes the front depth of the union of all spheres, and the sum of their thicknesses over the support.
    fn splat_front(&mut self) {
        let Self { drops, front, amount, width, .. } = self;
        for drop in drops.iter() {
            for_each_pixel(drop, *width, front.len(), |pixel, square| {
                let half = (1.0 - square).max(0.0).sqrt();
                let near = drop.depth - half * drop.radius;
                front[pixel] = if near < front[pixel] { near } else { front[pixel] };
                // Drops overlap: if their spacing is their support radius, each represents r³ of the 4π/3 r³ of its sphere.
                amount[pixel] += half * (1.5 / std::f32::consts::PI);
            });
        }
    }

    /// Computes the colors of the drops no deeper than their own size behind the front.
    fn splat_visible_colors(&mut self) {
        let Self { drops, front, colors, width, .. } = self;
        for drop in drops.iter().filter(|drop| !is_hidden(drop, front, *width)) {
            // Wider than the drop: colors change more smoothly than the surface.
            let wide = Drop { radius: SMOOTH * drop.radius, ..*drop };
            for_each_pixel(&wide, *width, front.len(), |pixel, square| {
                let behind = (drop.depth - front[pixel]) / (2.0 * drop.radius);
                // Where there is no front, it is far behind; the sums stay finite.
                let share = (1.0 - square).max(0.0) * (1.0 - behind).clamp(0.001, 1000.0);
                tint(&mut colors[pixel], drop.color, share);
            });
        }
    }

    /// Smooths the front over about a drop. Neighbors that differ in depth by more than the range are excluded.
    fn smooth(&mut self) {
        let part = self.rows.start * self.width..self.rows.end * self.width;
        let widest = ((WIDEST * self.mean_radius()) as usize).clamp(1, FARTHEST_STEP);
        for _ in 0..ROUNDS {
            for step in std::iter::successors(Some(widest), |step| Some(step / 2)).take_while(|&step| step > 0) {
                avoid_edges(&mut self.front[part.clone()], self.width, step, self.range, &mut self.scratch);
            }
        }
    }

    /// Blurs the thickness slightly: otherwise the rim would be jagged where the outlines of drops meet.
    fn soften(&mut self) {
        let reach = ((SOFT * self.mean_radius()) as usize).clamp(1, FARTHEST_BLUR);
        let (width, [other, ..]) = (self.width, &mut self.scratch);
        let rows = self.rows.start * width..self.rows.end * width;
        blur_plane(&mut self.amount[rows], other, width, reach);
    }

    /// Color and coverage of a pixel in 3D, as the sum of:
    ///
    /// - the background, refracted and tinted by the liquid (Beer–Lambert law);
    /// - light of the lamp and the sky, scattered in the liquid;
    /// - a highlight;
    /// - the reflected sky.
    fn lit(&self, row: usize, column: usize, behind: &[[u8; 4]]) -> (Ink, f32) {
        let pixel = row * self.width + column;
        let steepest = 3.0;
        let near = |a: f32, b: f32| (a - b).abs() < self.range;
        let [dx, dy] = self.slope(&self.front, row, column, near).map(|slope| slope.clamp(-steepest, steepest));
        let scale = 1.0 / (1.0 + dx * dx + dy * dy).sqrt();
        // The viewer is at small depths: the normal leans toward increasing depth.
        let (nx, ny, nz) = (dx * scale, dy * scale, scale);
        let light = nx * LAMP[0] + ny * LAMP[1] + nz * LAMP[2];
        let half = [LAMP[0], LAMP[1], LAMP[2] + 1.0].map(|component| component / (2.0 + 2.0 * LAMP[2]).sqrt());
        let shining = (nx * half[0] + ny * half[1] + nz * half[2]).max(0.0);
        let (color, opacity) = self.mean(pixel);
        let amount = self.amount[pixel];
        let optical = SCATTERS[0] * (SCATTERS[1] / SCATTERS[0]).powf(opacity) * amount;
        let passes = (-optical).exp();
        let mirrored = (1.0 - self.glow) * (amount / BRIM).min(1.0);
        let highlight = (1.0 - self.glow) * HIGHLIGHT * shining.powi(64) * (0.7 * amount).min(1.0) * (0.7 * amount).min(1.0);
        let diffuse = 0.62 + 0.12 * (0.5 - 0.5 * ny) + 0.38 * light;
        let diffuse = diffuse + (1.0 - diffuse) * self.glow;
        let bent = (BENDS * amount * self.mean_radius()).min(FARTHEST);
        let seen = self.behind(row as f32 - ny * bent, column as f32 - nx * bent, behind);
        let body = std::array::from_fn(|index| {
            let tinted = (color[index] / 255.0).max(0.02).powf(TINTS * amount);
            f32::from(seen[index]) * tinted * passes + color[index] * diffuse * (1.0 - passes)
        });
        // The y axis of pixels points down.
        let lit = self.sky.map_or(body, |sky| sky.reflected(body, [nx, -ny, nz], [0.0, 0.0, 1.0], mirrored));
        let [red, green, blue] = lit.map(|channel| (channel + highlight).clamp(0.0, 255.0) as u8);
        let [dx, dy] = self.slope(&self.amount, row, column, |_, _| true);
        let steepness = (dx * dx + dy * dy).sqrt().max(1e-3);
        ([red, green, blue, 255], (0.5 + (amount - BRIM) / steepness).clamp(0.0, 1.0))
    }

    /// Mean support radius of the drops [pixels].
    fn mean_radius(&self) -> f32 {
        0.25 * self.range
    }

    /// Background pixel at a row and column, or the nearest pixel in the picture.
    fn behind(&self, row: f32, column: f32, pixels: &[[u8; 4]]) -> [u8; 4] {
        let last = (pixels.len() / self.width - 1) as f32;
        let (row, column) = (row.clamp(0.0, last), column.clamp(0.0, (self.width - 1) as f32));
        pixels[(row + 0.5) as usize * self.width + (column + 0.5) as usize]
    }

    /// Gradient of a buffer to the right and down. If one of the two one-sided differences is much smaller, it is used alone, so
    /// a depth step counts on one side only.
    fn slope(&self, plane: &[f32], row: usize, column: usize, joined: impl Fn(f32, f32) -> bool) -> [f32; 2] {
        let pixel = row * self.width + column;
        let here = plane[pixel];
        let side = |exists: bool, there: usize| {
            let there = if exists { plane[there] } else { here };
            if joined(here, there) { Some(there - here) } else { None }
        };
        let gentler = |after: Option<f32>, before: Option<f32>| match (after, before.map(|step| -step)) {
            (Some(p), Some(q)) if p.abs().min(q.abs()) > 0.25 * p.abs().max(q.abs()) => 0.5 * (p + q),
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

    /// Weighted mean color of the drops at a pixel, and their opacity, 0 to 1.
    fn mean(&self, pixel: usize) -> ([f32; 3], f32) {
        let [red, green, blue, opacity, weight] = self.colors[pixel];
        let per_weight = 1.0 / weight.max(1e-12);
        ([red, green, blue].map(|sum| sum * per_weight), opacity * per_weight / 255.0)
    }
}

/// Visits every pixel in the support of a drop, with the squared distance from its center over its squared radius.
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

/// Whether a drop in 3D is far behind the front at its center and at its sides.
fn is_hidden(drop: &Drop, front: &[f32], width: usize) -> bool {
    let ([x, y], r) = (drop.center, drop.radius);
    let height = front.len() / width.max(1);
    [[x, y], [x - r, y], [x + r, y], [x, y - r], [x, y + r]].into_iter().all(|[x, y]| {
        let inside = x >= 0.0 && y >= 0.0 && x < width as f32 && y < height as f32;
        inside && drop.depth - 4.0 * r > front[y as usize * width + x as usize]
    })
}

fn tint(sum: &mut [f32; 5], color: Ink, weight: f32) {
    let [red, green, blue, opacity] = color.map(f32::from);
    for (sum, channel) in sum.iter_mut().zip([red, green, blue, opacity, 1.0]) {
        *sum += weight * channel;
    }
}
