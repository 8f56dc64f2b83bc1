//! Shadows and ambient occlusion of a painted picture, from the depth of each pixel.
//!
//! The light of a lamp is blocked by objects in its way (`shadow`). Ambient light is blocked by nearby surfaces. The blocked
//! share is estimated from the depths of surrounding pixels (after M. McGuire, M. Mara and D. Luebke, "Scalable ambient
//! obscurance", 2012).

#![expect(clippy::cast_possible_wrap, reason = "no side is longer than 65535 pixels")]
#![expect(clippy::doc_markdown, reason = "names of people")]

use crate::band::Band;
use crate::eye::{Eye, OPEN, is_center};
use crate::math::{cross, dot, minus, plus, unit};
use crate::shadow::ShadowMap;

/// Light of a scene in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Unit vector to the lamp: right, up, toward the eye.
    pub lamp: [f32; 3],
    /// Share of light lost in the deepest shadow.
    pub shadow: f32,
    /// Share of light lost where the surroundings block everything.
    pub occlusion: f32,
    /// Radius of ambient occlusion [pixels].
    pub reach: f32,
}

/// Relative losses of red, green and blue in a shadow, which is still lit by the sky.
const COOL: [f32; 3] = [1.0, 0.97, 0.9];
/// Maximum difference in depth of pixels that lose about equal light [pixel widths].
const NEAR: f32 = 8.0;
/// Number of sample positions of ambient occlusion around a pixel.
const TAPS: usize = 18;
/// Golden angle between successive sample positions [rad]; none of its multiples is near a full turn.
const GOLDEN: f32 = 2.399_963_2;
/// Cosine below which a sample position does not count as above the surface.
const BIAS: f32 = 0.12;
/// Cosine of the lamp's incidence above which a surface shows the full shadow. A surface turned away is dark already.
const FACING: f32 = 0.35;

/// Depths of the pixels, row by row.
pub(crate) struct Depths<'a> {
    pub(crate) eye: Eye,
    pub(crate) width: usize,
    pub(crate) values: &'a [f32],
    /// Depths of the backdrop; empty without a backdrop.
    pub(crate) backdrop: &'a [f32],
}

impl Depths<'_> {
    /// Whether a pixel shows the backdrop.
    #[inline(always)]
    fn is_backdrop(&self, pixel: usize) -> bool {
        self.backdrop.get(pixel) == Some(&self.values[pixel])
    }

    /// Position that a pixel shows.
    #[inline(always)]
    fn place(&self, column: usize, row: usize) -> [f32; 3] {
        self.eye.place([column as f32 + 0.5, row as f32 + 0.5], self.values[row * self.width + column])
    }

    /// Step to an adjacent pixel: of the two neighbors, the one nearer in depth; None if both are missing.
    #[inline(always)]
    fn step(&self, here: [f32; 3], before: Option<(usize, usize)>, after: Option<(usize, usize)>) -> Option<[f32; 3]> {
        let found = |pixel: Option<(usize, usize)>| {
            let (column, row) = pixel?;
            let there = self.place(column, row);
            there[2].is_finite().then_some(there)
        };
        match (found(before), found(after)) {
            (Some(one), Some(other)) if (one[2] - here[2]).abs() < (other[2] - here[2]).abs() => Some(minus(here, one)),
            (_, Some(other)) => Some(minus(other, here)),
            (Some(one), None) => Some(minus(here, one)),
            (None, None) => None,
        }
    }

    /// Normal of the surface at a pixel.
    fn normal(&self, here: [f32; 3], column: usize, row: usize) -> [f32; 3] {
        let height = self.values.len() / self.width;
        let left = column.checked_sub(1).map(|column| (column, row));
        let right = (column + 1 < self.width).then_some((column + 1, row));
        let above = row.checked_sub(1).map(|row| (column, row));
        let below = (row + 1 < height).then_some((column, row + 1));
        match (self.step(here, left, right), self.step(here, below, above)) {
            (Some(along), Some(up)) => unit(cross(along, up)),
            _ => [0.0, 0.0, 1.0],
        }
    }
}

/// Side of the tiles that are lit or skipped [pixels].
const TILE: usize = 16;

/// Light prepared for one painting.
pub(crate) struct Lighting {
    light: Light,
    shadows: Option<ShadowMap>,
    /// Offsets of the sample positions of ambient occlusion: columns and rows.
    taps: [[i32; 2]; TAPS],
    /// Mask of tiles near something other than the backdrop, row by row. Elsewhere no ambient light is blocked.
    crowded: Vec<bool>,
    tiles: usize,
    /// Blocked shares of the lamp's and of ambient light, for every second pixel of every second row.
    held: Vec<[f32; 2]>,
}

impl Lighting {
    /// Prepares a light for pixels with these depths.
    pub(crate) fn new(light: Light, shadows: Option<ShadowMap>, depths: &Depths<'_>, threads: usize) -> Self {
        let taps = std::array::from_fn(|index| {
            let (radius, angle) = (light.reach * ((index as f32 + 0.5) / TAPS as f32).sqrt(), GOLDEN * index as f32);
            [radius * angle.cos(), radius * angle.sin()].map(|offset| offset.round() as i32)
        });
        let (tiles, crowded) = crowded(depths, (light.reach / TILE as f32).ceil() as usize);
        let mut found = Self { light, shadows, taps, crowded, tiles, held: Vec::new() };
        found.held = found.sparse(depths, threads);
        found
    }

    /// Blocked light for every second pixel of every second row, computed by `threads` threads.
    fn sparse(&self, depths: &Depths<'_>, threads: usize) -> Vec<[f32; 2]> {
        let (across, height) = (depths.width.div_ceil(2), depths.values.len() / depths.width);
        let mut held = vec![[0.0; 2]; across * height.div_ceil(2)];
        let rows = height.div_ceil(2).div_ceil(threads.max(1));
        std::thread::scope(|scope| {
            for (part, held) in held.chunks_mut((rows * across).max(1)).enumerate() {
                scope.spawn(move || {
                    for (index, held) in held.iter_mut().enumerate() {
                        let (column, row) = (2 * (index % across), 2 * (part * rows + index / across));
                        if depths.values[row * depths.width + column] != OPEN {
                            *held = self.at(depths, column, row);
                        }
                    }
                });
            }
        });
        held
    }

    /// Blocked light of a pixel: the mean over surrounding samples of about equal depth. Without such samples, it is computed for
    /// the pixel itself.
    #[inline(always)]
    fn between(&self, depths: &Depths<'_>, depth: f32, column: usize, row: usize) -> [f32; 2] {
        let across = depths.width.div_ceil(2);
        if !is_center(depth) {
            // At an outline, a pixel is a mixture of both sides.
            let around = |place: usize, count: usize| [place.saturating_sub(1) / 2, place.div_ceil(2).min(count - 1)];
            let rows = around(row, self.held.len() / across).map(|row| row * across);
            let [left, right] = around(column, across);
            let held = rows.map(|row| [self.held[row + left], self.held[row + right]]);
            return [0, 1].map(|share: usize| held.as_flattened().iter().map(|held| 0.25 * held[share]).sum());
        }
        let (left, above) = (column / 2, row / 2);
        if column.is_multiple_of(2) && row.is_multiple_of(2) {
            return self.held[above * across + left];
        }
        let (right, below) = (column.div_ceil(2).min(across - 1), row.div_ceil(2).min(self.held.len() / across - 1));
        let near = NEAR * depths.eye.length(depth);
        let (mut sum, mut count) = ([0.0; 2], 0.0);
        for (column, row) in [(left, above), (right, above), (left, below), (right, below)] {
            if (depths.values[2 * row * depths.width + 2 * column] - depth).abs() < near {
                let held = self.held[row * across + column];
                sum = [sum[0] + held[0], sum[1] + held[1]];
                count += 1.0;
            }
        }
        if count > 0.0 { sum.map(|sum| sum / count) } else { self.at(depths, column, row) }
    }

    /// Lights the rows of a band.
    pub(crate) fn shade(&self, band: &mut Band<'_>, depths: &Depths<'_>) {
        let clip = band.clip;
        for row in clip.top..clip.bottom {
            let first = (row - band.top) as usize * band.width;
            for column in clip.left..clip.right {
                let depth = depths.values[row as usize * depths.width + column as usize];
                if depth == OPEN {
                    continue;
                }
                let [dark, hidden] = self.between(depths, depth, column as usize, row as usize);
                if dark > 0.0 || hidden > 0.0 {
                    let pixel = &mut band.pixels[first + column as usize];
                    for (channel, cool) in pixel.iter_mut().zip(COOL) {
                        let left = (1.0 - cool * dark) * (1.0 - hidden);
                        *channel = (f32::from(*channel) * left + 0.5) as u8;
                    }
                }
            }
        }
    }

    /// Shares of the lamp's and of ambient light that the position of a pixel loses.
    fn at(&self, depths: &Depths<'_>, column: usize, row: usize) -> [f32; 2] {
        let here = depths.place(column, row);
        let crowded = self.crowded[row / TILE * self.tiles + column / TILE];
        let shadows = self.shadows.as_ref().filter(|shadows| shadows.reaches(here));
        if !crowded && shadows.is_none() {
            return [0.0; 2];
        }
        let normal = depths.normal(here, column, row);
        let facing = (dot(normal, self.light.lamp) / FACING).clamp(0.0, 1.0);
        let dark = match shadows {
            Some(shadows) if facing > 0.0 => facing * shadows.at(plus(here, 2.0 * shadows.texel(), normal)),
            _ => 0.0,
        };
        let hidden = if crowded { self.occlusion(depths, here, normal, [column as i32, row as i32]) } else { 0.0 };
        [self.light.shadow * dark, self.light.occlusion * hidden]
    }

    /// Share of ambient light blocked by the surroundings of a surface point that a pixel shows.
    #[inline(always)]
    fn occlusion(&self, depths: &Depths<'_>, here: [f32; 3], normal: [f32; 3], [column, row]: [i32; 2]) -> f32 {
        let reach = self.light.reach * depths.eye.length(-here[2]);
        let (per_square, width) = (1.0 / (reach * reach), depths.width as i32);
        let height = (depths.values.len() / depths.width) as i32;
        // Static shapes take no light from themselves: they would do so only near moving ones.
        let still = depths.is_backdrop((row * width + column) as usize);
        let mut hidden = 0.0;
        for [right, down] in self.taps {
            let (column, row) = (column + right, row + down);
            let outside = column < 0 || row < 0 || column >= width || row >= height;
            if outside || (still && depths.is_backdrop((row * width + column) as usize)) {
                continue;
            }
            let way = minus(depths.place(column as usize, row as usize), here);
            let above = dot(way, normal);
            // Comparisons are written so that a pixel without depth is not above.
            if above > 0.0 && above < reach {
                let away = dot(way, way);
                hidden += (1.0 - away * per_square).max(0.0) * (above / away.sqrt() - BIAS).max(0.0);
            }
        }
        (2.5 * hidden / TAPS as f32).min(1.0)
    }
}

/// Number of tiles across a picture, and mask of the tiles within `reach` tiles of one that differs from the backdrop.
fn crowded(depths: &Depths<'_>, reach: usize) -> (usize, Vec<bool>) {
    let (across, height) = (depths.width.div_ceil(TILE), depths.values.len() / depths.width);
    let down = height.div_ceil(TILE);
    let mut crowded = vec![false; across * down];
    for row in 0..height {
        for tile in 0..across {
            let pixels = row * depths.width + tile * TILE..row * depths.width + ((tile + 1) * TILE).min(depths.width);
            if depths.backdrop.get(pixels.clone()) != Some(&depths.values[pixels]) {
                let (above, left) = ((row / TILE).saturating_sub(reach), tile.saturating_sub(reach));
                for line in above..(row / TILE + reach + 1).min(down) {
                    crowded[line * across + left..line * across + (tile + reach + 1).min(across)].fill(true);
                }
            }
        }
    }
    (across, crowded)
}
