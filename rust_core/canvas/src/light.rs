//! Shadows and ambient occlusion on all that has been painted, by the depth of each pixel.
//!
//! A lamp's light is held back by what stands in its way (`shadow`), light from everywhere by what is near: the share of it
//! that does not come through is estimated from the depths of pixels around (after M. McGuire, M. Mara and D. Luebke,
//! "Scalable ambient obscurance", 2012).

#![expect(clippy::cast_possible_wrap, reason = "no side is longer than 65535 pixels")]
#![expect(clippy::doc_markdown, reason = "names of people")]

use crate::band::Band;
use crate::eye::{Eye, OPEN, is_center};
use crate::math::{cross, dot, minus, plus, unit};
use crate::shadow::ShadowMap;

/// The light of a scene in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Unit vector to the lamp: right, up, toward the eye.
    pub lamp: [f32; 3],
    /// The share of light that a place in the deepest shadow has lost.
    pub shadow: f32,
    /// The share of light that a place has lost whose surroundings hide everything.
    pub occlusion: f32,
    /// How far ambient light is looked for [pixels].
    pub reach: f32,
}

/// How much less than red, green and blue lose in a shadow: it is lit by the sky.
const COOL: [f32; 3] = [1.0, 0.97, 0.9];
/// Pixels that are no farther apart in depth than so many pixels are wide lose about as much light.
const NEAR: f32 = 8.0;
/// Places around a pixel that ambient light is looked for at.
const TAPS: usize = 18;
/// The angle from one of them to the next [rad], of which no multiple comes near to a turn.
const GOLDEN: f32 = 2.399_963_2;
/// The cosine below which a place around is not above the surface.
const BIAS: f32 = 0.12;
/// The cosine of the lamp's light from which on a surface shows a full shadow: one that is turned away is dark already.
const FACING: f32 = 0.35;

/// What is looked up at each pixel: depths, row by row.
pub(crate) struct Depths<'a> {
    pub(crate) eye: Eye,
    pub(crate) width: usize,
    pub(crate) values: &'a [f32],
    /// Those of the backdrop; empty if there is none.
    pub(crate) backdrop: &'a [f32],
}

impl Depths<'_> {
    /// Whether a pixel shows the backdrop.
    #[inline(always)]
    fn is_backdrop(&self, pixel: usize) -> bool {
        self.backdrop.get(pixel) == Some(&self.values[pixel])
    }

    /// The place that a pixel shows.
    #[inline(always)]
    fn place(&self, column: usize, row: usize) -> [f32; 3] {
        self.eye.place([column as f32 + 0.5, row as f32 + 0.5], self.values[row * self.width + column])
    }

    /// The step to a pixel beside another one, of the two on both sides the one that is nearer in depth; None if there is none.
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

    /// The normal of the surface at a pixel.
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

/// The side of the tiles that are lit or left out [pixels].
const TILE: usize = 16;

/// A light, prepared for one painting.
pub(crate) struct Lighting {
    light: Light,
    shadows: Option<ShadowMap>,
    /// Where ambient light is looked for around a pixel: columns and rows.
    taps: [[i32; 2]; TAPS],
    /// Tiles that are near to something else than the backdrop, row by row: elsewhere nothing holds back ambient light.
    crowded: Vec<bool>,
    tiles: usize,
    /// The shares of the lamp's and of ambient light that are held back from every second pixel of every second row.
    held: Vec<[f32; 2]>,
}

impl Lighting {
    /// A light for pixels with these depths.
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

    /// The light held back from every second pixel of every second row, by so many threads.
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

    /// The light held back from a pixel: the mean of those around it for which it is known and that lie about as deep; where none
    /// does, its own.
    #[inline(always)]
    fn between(&self, depths: &Depths<'_>, depth: f32, column: usize, row: usize) -> [f32; 2] {
        let across = depths.width.div_ceil(2);
        if !is_center(depth) {
            // At an outline a pixel is a mixture of what lies on both sides.
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

    /// The shares of the lamp's and of ambient light that a pixel's place has lost.
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

    /// The share of ambient light that is held back by what is around a place on a surface, which a pixel shows.
    #[inline(always)]
    fn occlusion(&self, depths: &Depths<'_>, here: [f32; 3], normal: [f32; 3], [column, row]: [i32; 2]) -> f32 {
        let reach = self.light.reach * depths.eye.length(-here[2]);
        let (per_square, width) = (1.0 / (reach * reach), depths.width as i32);
        let height = (depths.values.len() / depths.width) as i32;
        // What stands still takes no light from itself: it would only do so where something is near.
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
            // Written so that a pixel without depth is not above.
            if above > 0.0 && above < reach {
                let away = dot(way, way);
                hidden += (1.0 - away * per_square).max(0.0) * (above / away.sqrt() - BIAS).max(0.0);
            }
        }
        (2.5 * hidden / TAPS as f32).min(1.0)
    }
}

/// The number of tiles across a picture, and which of them are no farther than so many from one that differs from the backdrop.
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
