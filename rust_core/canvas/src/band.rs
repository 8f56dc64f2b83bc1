//! Bands: some rows of a canvas, and the rasterization of shapes on them. Several threads draw on bands at the same time. Each
//! blends all shapes in the same order, so the pixels do not depend on the number of bands.

#![expect(clippy::cast_possible_wrap, reason = "no side is longer than 65535 pixels")]

use std::iter::repeat_with;

use wide::f32x4;

use crate::color::Ink;
use crate::eye::{Eye, OPEN, at_center, beside_center, is_center, is_solid};
use crate::ink::{LANES, Mixing, Paint, Shade};
use crate::shapes::{Disc, Halo, Line, Triangle, drawn_half_width, drawn_radius, ramp, ramps};
use crate::texture::Texture;
use crate::weave::Weave;

/// Rectangle of pixels: columns and rows from `left`, `top` to `right`, `bottom`, the latter excluded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Rectangle {
    pub(crate) left: i32,
    pub(crate) top: i32,
    pub(crate) right: i32,
    pub(crate) bottom: i32,
}

/// Whole rows of a picture.
pub(crate) struct Band<'a> {
    pub(crate) pixels: &'a mut [[u8; 4]],
    /// Depths of the pixels; empty without an eye.
    pub(crate) depths: &'a mut [f32],
    pub(crate) eye: Option<Eye>,
    /// Width of the picture [pixels].
    pub(crate) width: usize,
    /// First row.
    pub(crate) top: i32,
    /// Part of the band to which drawing is restricted.
    pub(crate) clip: Rectangle,
}

/// Maximum width of a disc whose rows are all drawn over its full width. An equal number of pixels is faster, because the
/// processor predicts the end of the loop.
const NARROW: i32 = 2 * LANES as i32;

/// Maximum difference in depth of triangles that may be parts of one surface [pixel widths].
const SEAM: f32 = 3.0;

impl Band<'_> {
    /// Range of the rows.
    pub(crate) fn rows(&self) -> std::ops::Range<usize> {
        let first = self.top as usize;
        first..first + self.pixels.len() / self.width
    }

    /// Draws a disc.
    pub(crate) fn disc(&mut self, disc: Disc) {
        let (radius, opacity) = drawn_radius(disc.radius, disc.softness);
        if disc.softness == 1.0 && radius == 0.5 {
            return self.speck(disc.center, disc.color, opacity);
        }
        let (reach, sharpness) = (radius + 0.5 * disc.softness, 1.0 / disc.softness);
        let [x, y] = disc.center;
        let Some(area) = self.visible([x - reach, y - reach], [x + reach, y + reach]) else {
            return;
        };
        let paint = Paint::new(disc.color, opacity);
        let shade = (disc.shading > 0.0).then(|| Shade { strength: disc.shading, per_radius: 1.0 / radius });
        let across = area.right - area.left;
        for row in area.top..area.bottom {
            let dy = row as f32 + 0.5 - y;
            let (pixels, offset) = if across <= NARROW {
                self.groups(row, area.left, across)
            } else {
                let outer = (reach * reach - dy * dy).max(0.0).sqrt();
                self.span(area, row, x - outer, x + outer)
            };
            if let Some(shade) = &shade {
                for (pixel, column) in pixels.iter_mut().zip(0_u16..) {
                    let dx = offset - x + f32::from(column);
                    let edge = ramp(((dx * dx + dy * dy).sqrt() - radius) * sharpness);
                    paint.with(shade.lit(disc.color, dx, dy)).blend(pixel, edge);
                }
            } else {
                paint.blend_row(pixels, Mixing::Over, |columns| {
                    let dx = columns + (offset - x);
                    ramps(((dx * dx + dy * dy).sqrt() - radius) * sharpness)
                });
            }
        }
    }

    /// Draws the smallest disc. It covers the centers of at most four pixels, and a frame may hold a million of such discs.
    #[inline(always)]
    fn speck(&mut self, [x, y]: [f32; 2], color: Ink, opacity: f32) {
        let Rectangle { left, top, right, bottom } = self.clip;
        let inside = x > left as f32 - 1.0 && x < right as f32 + 1.0 && y > top as f32 - 1.0 && y < bottom as f32 + 1.0;
        if !inside {
            return; // also for NaN
        }
        let paint = Paint::new(color, opacity);
        let (column, row) = ((x + 0.5) as i32 - 1, (y + 0.5) as i32 - 1); // of the upper left pixel of the four
        let (dx, dy) = (column as f32 + 0.5 - x, row as f32 + 0.5 - y);
        let mut amounts = [0; 4];
        for (corner, amount) in amounts.iter_mut().enumerate() {
            let (dx, dy) = (dx + (corner & 1) as f32, dy + (corner >> 1) as f32);
            *amount = paint.amount(ramp((dx * dx + dy * dy).sqrt() - 0.5));
        }
        for (amount, corner) in amounts.into_iter().zip(0..) {
            let (column, row) = (column + (corner & 1), row + (corner >> 1));
            if column >= left && column < right && row >= top && row < bottom {
                let pixel = (row - self.top) as usize * self.width + column as usize;
                paint.mix(&mut self.pixels[pixel], amount);
            }
        }
    }

    /// Draws a line.
    pub(crate) fn line(&mut self, line: Line, mixing: Mixing) {
        let (half, opacity) = drawn_half_width(line.width, line.softness);
        let (reach, sharpness) = (half + 0.5 * line.softness, 1.0 / line.softness);
        let ([x0, y0], [x1, y1]) = (line.from, line.to);
        let low = [x0.min(x1) - reach, y0.min(y1) - reach];
        let high = [x0.max(x1) + reach, y0.max(y1) + reach];
        let Some(area) = self.visible(low, high) else {
            return;
        };
        let (ux, uy) = (x1 - x0, y1 - y0);
        let length = (ux * ux + uy * uy).sqrt();
        let per_square = if length > 0.0 { 1.0 / (length * length) } else { 0.0 };
        // The intersection of a row with the band around the line has twice this width; for a level line it is the whole row.
        let (slope, spread) = if uy == 0.0 { (0.0, f32::INFINITY) } else { (ux / uy, reach * length / uy.abs()) };
        let across = ((2.0 * spread) as i32).saturating_add(1).min(area.right - area.left);
        let paint = Paint::new(line.color, opacity);
        for row in area.top..area.bottom {
            let dy = row as f32 + 0.5 - y0;
            let middle = x0 + dy * slope;
            // Beyond an end, the cap reaches as far as the end itself, which the sides of the box bound.
            let (pixels, offset) = self.groups(row, nearest_edge(middle - spread).max(area.left), across);
            paint.blend_row(pixels, mixing, |columns| {
                let dx = columns + (offset - x0);
                let along = ((dx * ux + dy * uy) * per_square).fast_max(f32x4::ZERO).fast_min(f32x4::ONE);
                let (ex, ey) = (dx - along * ux, dy - along * uy);
                ramps(((ex * ex + ey * ey).sqrt() - half) * sharpness)
            });
        }
    }

    /// Draws a triangle enlarged by half a pixel, and stores its depth. The triangle is not enlarged over pixels whose centers
    /// lie in another triangle of about equal depth. Otherwise an edge between two sides would lie alternately on one side and on
    /// the other.
    ///
    /// - `threads`: coordinates of a weave at the corners, and the number of samples along the side of a pixel.
    pub(crate) fn triangle(&mut self, triangle: &Triangle, texture: Option<&Texture>, threads: Option<(&[[f32; 2]; 3], f32)>) {
        const MORE: f32 = 0.5;
        let [a, b, c] = triangle.corners;
        let low = [a[0].min(b[0]).min(c[0]) - MORE - 0.5, a[1].min(b[1]).min(c[1]) - MORE - 0.5];
        let high = [a[0].max(b[0]).max(c[0]) + MORE + 0.5, a[1].max(b[1]).max(c[1]) + MORE + 0.5];
        let doubled = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        let Some(area) = self.visible(low, high).filter(|_| doubled != 0.0) else {
            return;
        };
        let edges = edges(&triangle.corners);
        let weave = threads.map(|(threads, times)| Weave::new(&triangle.corners, doubled, threads, times));
        let inks = triangle.colors.map(|ink| ink.map(f32::from));
        let eye = self.eye.filter(|_| triangle.colors.iter().all(|&ink| is_solid(ink)));
        for row in area.top..area.bottom {
            let first = (row - self.top) as usize * self.width + area.left as usize;
            let depths = self.depths.get_mut(first..).unwrap_or_default().iter_mut().map(Some).chain(repeat_with(|| None));
            let pixels = self.pixels[first..].iter_mut().take((area.right - area.left) as usize);
            let offset = area.left as f32 + 0.5;
            for ((pixel, kept), column) in pixels.zip(depths).zip(0_u16..) {
                let (x, y) = (offset + f32::from(column), row as f32 + 0.5);
                let outside = beyond(&edges, x, y);
                // Beyond a sharp corner, the lines along the sides meet far away: there the distance from the corner counts.
                let outside = if outside > 0.0 { outside.max(away(&triangle.corners, x, y)) } else { outside };
                let mut coverage = ramp(outside - MORE);
                if coverage > 0.0 {
                    let weights = barycentric(&triangle.corners, doubled, x, y);
                    if let (Some(eye), Some(kept)) = (eye, kept) {
                        let depth = if triangle.lit { depth(triangle, doubled, x, y) } else { OPEN };
                        if outside <= 0.0 {
                            *kept = at_center(depth);
                        } else if is_center(*kept) && (*kept - depth).abs() < SEAM * eye.length(depth) {
                            coverage = ramp(outside);
                        } else if coverage >= 0.5 && depth < *kept {
                            *kept = beside_center(depth);
                        }
                    }
                    let [red, green, blue, alpha] = mean(&inks, weights);
                    let texel = texture.map_or([255.0; 3], |texture| texture.at(mean(&triangle.texture_coordinates, weights)));
                    let bright = weave.as_ref().map_or(1.0, |weave| weave.at(x, y)) * (1.0 / 255.0);
                    let lit = |channel: f32, texel: f32| (channel * texel * bright + 0.5) as u8;
                    let color = [lit(red, texel[0]), lit(green, texel[1]), lit(blue, texel[2]), (alpha + 0.5) as u8];
                    Paint::new(color, 1.0).blend(pixel, coverage);
                }
            }
        }
    }

    /// Draws a halo: light of intensity (1 − d²/r²)² at the distance d from its center. The light is blended by screen blending,
    /// 1 − (1 − a)(1 − b), which saturates at white. A shadow applies the same blending to the complement of its color.
    pub(crate) fn halo(&mut self, halo: Halo) {
        let (radius, [x, y]) = (halo.radius, halo.center);
        let Some(area) = self.visible([x - radius, y - radius], [x + radius, y + radius]).filter(|_| radius > 0.0) else {
            return;
        };
        let ([red, green, blue, alpha], per_square) = (halo.color, 1.0 / (radius * radius));
        let flip = if halo.shadow { 0xFF } else { 0 };
        for row in area.top..area.bottom {
            let dy = row as f32 + 0.5 - y;
            let outer = (radius * radius - dy * dy).max(0.0).sqrt();
            let (pixels, offset) = self.span(area, row, x - outer, x + outer);
            for (pixel, column) in pixels.iter_mut().zip(0_u16..) {
                let dx = offset - x + f32::from(column);
                let inside = (1.0 - (dx * dx + dy * dy) * per_square).max(0.0);
                let amount = (inside * inside * f32::from(alpha) * (256.0 / 255.0) + 0.5) as u32;
                for (channel, light) in pixel.iter_mut().zip([red, green, blue]) {
                    let (below, light) = (*channel ^ flip, light ^ flip);
                    *channel = (below + ((u32::from(255 - below) * u32::from(light) * amount + 0x7F80) / 0xFF00) as u8) ^ flip;
                }
            }
        }
    }

    /// Fills a convex polygon of either orientation.
    pub(crate) fn polygon(&mut self, corners: &[[f32; 2]], color: Ink) {
        let low = corners.iter().fold([f32::MAX; 2], |low, c| [low[0].min(c[0]), low[1].min(c[1])]);
        let high = corners.iter().fold([f32::MIN; 2], |high, c| [high[0].max(c[0]), high[1].max(c[1])]);
        let Some(area) = self.visible([low[0] - 0.5, low[1] - 0.5], [high[0] + 0.5, high[1] + 0.5]) else {
            return;
        };
        let (edges, paint) = (edges(corners), Paint::new(color, 1.0));
        for row in area.top..area.bottom {
            let (pixels, offset) = self.span(area, row, f32::MIN, f32::MAX);
            for (pixel, column) in pixels.iter_mut().zip(0_u16..) {
                let (x, y) = (offset + f32::from(column), row as f32 + 0.5);
                paint.blend(pixel, ramp(beyond(&edges, x, y)));
            }
        }
    }

    /// Blends `color` into one pixel with a coverage of 0–1; no effect outside the clip.
    pub(crate) fn dot(&mut self, x: i32, y: i32, color: Ink, coverage: f32) {
        let Rectangle { left, top, right, bottom } = self.clip;
        if (left..right).contains(&x) && (top..bottom).contains(&y) {
            Paint::new(color, 1.0).blend(&mut self.pixels[(y - self.top) as usize * self.width + x as usize], coverage);
        }
    }

    /// Pixels whose centers lie between two corners and inside the clip; None for NaN coordinates.
    pub(crate) fn visible(&self, low: [f32; 2], high: [f32; 2]) -> Option<Rectangle> {
        let Rectangle { left, top, right, bottom } = self.clip;
        let area = Rectangle {
            left: nearest_edge(low[0]).max(left),
            top: nearest_edge(low[1]).max(top),
            right: nearest_edge(high[0]).min(right),
            bottom: nearest_edge(high[1]).min(bottom),
        };
        let finite = low.iter().chain(&high).all(|value| value.is_finite());
        (finite && area.left < area.right && area.top < area.bottom).then_some(area)
    }

    /// Returns `count` pixels of a row from a column on, and the center of the first. Adjacent pixels within the clip are added
    /// to fill groups of [`LANES`].
    #[inline(always)]
    fn groups(&mut self, row: i32, start: i32, count: i32) -> (&mut [[u8; 4]], f32) {
        let Rectangle { left, right, .. } = self.clip;
        let count = (count as usize).next_multiple_of(LANES) as i32;
        let start = start.min(right - count).max(left);
        let end = (start + count).min(right);
        let first = (row - self.top) as usize * self.width;
        (&mut self.pixels[first + start as usize..first + end as usize], start as f32 + 0.5)
    }

    /// Pixels of a row whose centers lie from `low` to `high`, within `area`, and the center of the first.
    #[inline(always)]
    fn span(&mut self, area: Rectangle, row: i32, low: f32, high: f32) -> (&mut [[u8; 4]], f32) {
        let start = nearest_edge(low).clamp(area.left, area.right);
        let end = nearest_edge(high).clamp(start, area.right);
        let first = (row - self.top) as usize * self.width;
        (&mut self.pixels[first + start as usize..first + end as usize], start as f32 + 0.5)
    }
}

/// Pixel edge nearest to a coordinate: the first center beyond the coordinate is to the right of the edge. Coordinates left of
/// the picture may be rounded the wrong way, which the clip makes harmless. (On the oldest x86-64, `f32::floor` is a function
/// call.)
#[inline(always)]
fn nearest_edge(coordinate: f32) -> i32 {
    (coordinate + 0.5) as i32
}

/// Outward unit normals n and offsets c of the sides of a convex polygon: n·x > c outside.
fn edges(corners: &[[f32; 2]]) -> Vec<[f32; 3]> {
    let count = corners.len() as f32;
    let middle = corners.iter().fold([0.0; 2], |sum, c| [sum[0] + c[0] / count, sum[1] + c[1] / count]);
    let ends = corners.iter().zip(corners.iter().cycle().skip(1));
    ends.filter_map(|(from, to)| {
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        let length = (dx * dx + dy * dy).sqrt();
        let inward = dy * (middle[0] - from[0]) - dx * (middle[1] - from[1]) > 0.0;
        let scale = if inward { -1.0 } else { 1.0 } / length;
        let (nx, ny) = (dy * scale, -dx * scale);
        (length > 0.0).then_some([nx, ny, nx * from[0] + ny * from[1]])
    })
    .collect()
}

/// Signed distance of a point from a convex polygon [pixels], negative inside.
#[inline(always)]
fn beyond(edges: &[[f32; 3]], x: f32, y: f32) -> f32 {
    edges.iter().fold(f32::MIN, |most, [nx, ny, c]| most.max(nx * x + ny * y - c))
}

/// Distance of a point from the outline of a triangle [pixels].
#[inline(always)]
fn away([a, b, c]: &[[f32; 2]; 3], x: f32, y: f32) -> f32 {
    let from = |[x0, y0]: [f32; 2], [x1, y1]: [f32; 2]| {
        let (ux, uy, dx, dy) = (x1 - x0, y1 - y0, x - x0, y - y0);
        let along = ((dx * ux + dy * uy) / (ux * ux + uy * uy).max(1e-12)).clamp(0.0, 1.0);
        let (ex, ey) = (dx - along * ux, dy - along * uy);
        ex * ex + ey * ey
    };
    from(*a, *b).min(from(*b, *c)).min(from(*c, *a)).sqrt()
}

/// Depth of the plane of a triangle at a point, limited to the depths of the triangle. The point may lie slightly outside, and
/// `doubled` is the doubled signed area. (In a thin triangle, clamped barycentric coordinates would belong to a point far away.)
#[inline(always)]
fn depth(Triangle { corners: [a, b, c], depths: [first, second, third], .. }: &Triangle, doubled: f32, x: f32, y: f32) -> f32 {
    let (scale, x, y) = (1.0 / doubled, x - a[0], y - a[1]);
    let along = (x * (c[1] - a[1]) - y * (c[0] - a[0])) * scale;
    let across = (y * (b[0] - a[0]) - x * (b[1] - a[1])) * scale;
    let plane = first + along * (second - first) + across * (third - first);
    plane.max(first.min(*second).min(*third)).min(first.max(*second).max(*third))
}

/// Barycentric coordinates of a point in a triangle of known doubled signed area, clamped to the triangle.
#[inline(always)]
fn barycentric([a, b, c]: &[[f32; 2]; 3], doubled: f32, x: f32, y: f32) -> [f32; 3] {
    let (scale, x, y) = (1.0 / doubled, x - a[0], y - a[1]);
    let within = |value: f32, most: f32| value.max(0.0).min(most); // not `clamp`, which keeps NaN
    let second = within((x * (c[1] - a[1]) - y * (c[0] - a[0])) * scale, 1.0);
    let third = within((y * (b[0] - a[0]) - x * (b[1] - a[1])) * scale, 1.0 - second);
    [1.0 - second - third, second, third]
}

/// Weighted mean of three corner values.
#[inline(always)]
fn mean<const N: usize>(corners: &[[f32; N]; 3], weights: [f32; 3]) -> [f32; N] {
    let [a, b, c] = corners;
    std::array::from_fn(|index| weights[0] * a[index] + weights[1] * b[index] + weights[2] * c[index])
}
