//! Shadow maps: heights of the objects between a lamp and a point, seen from the lamp.
//!
//! Each texel of the map holds the share of blocked light. It also holds the mean height of the blocking objects toward the
//! lamp, and the mean square of this height. These values can be blurred before the look-up, which makes shadows soft (W.
//! Donnelly and A. Lauritzen, "Variance shadow maps", 2006). Two maps with different blur make shadows softer the farther they
//! fall (R. Fernando, "Percentage-closer soft shadows", 2005).

use crate::math::{across, dot};

/// Shadow caster.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Caster {
    /// Ball: center and radius.
    Ball([f32; 3], f32),
    /// Drop of a liquid: center and radius of its support. Drops that overlap block light evenly.
    Drop([f32; 3], f32),
    /// Rod with round ends: ends and radius.
    Rod([f32; 3], [f32; 3], f32),
    /// Corners of a triangle.
    Triangle([[f32; 3]; 3]),
}

impl Caster {
    /// Whether all coordinates are finite.
    pub(crate) fn is_somewhere(&self) -> bool {
        let finite = |place: &[f32; 3]| place.iter().all(|component| component.is_finite());
        match self {
            Self::Ball(center, radius) | Self::Drop(center, radius) => finite(center) && radius.is_finite(),
            Self::Rod(from, to, radius) => finite(from) && finite(to) && radius.is_finite(),
            Self::Triangle(corners) => corners.iter().all(finite),
        }
    }
}

/// Number of texels along the longer side of a map.
const SIDE: usize = 300;
/// Blur radius of the sharper and of the softer map [texels]; both are applied twice.
const BLURS: [usize; 2] = [1, 8];
/// Number of free texels around all shadow casters.
const MARGIN: usize = 2 * BLURS[1] + 2;
/// Height above a point at which its shadow is softest, over the size of the map.
const SOFT: f32 = 0.3;
/// Minimum standard deviation of heights, over the size of the map.
const ROUGH: f32 = 0.003;

/// Share of blocked light, and its products with the height of the blocking object and with the square of this height.
type Texel = [f32; 3];

/// Shadow map of a lamp.
#[derive(Debug)]
pub(crate) struct ShadowMap {
    axes: [[f32; 3]; 3],
    /// Corner of the map along the first two axes.
    corner: [f32; 2],
    per_length: f32,
    width: usize,
    sharp: Vec<Texel>,
    soft: Vec<Texel>,
    size: f32,
}

impl ShadowMap {
    /// Computes the map of a lamp in a direction, for casters that block a share of its light; None without casters.
    pub(crate) fn new(lamp: [f32; 3], casters: &[(Caster, f32)]) -> Option<Self> {
        let [first, second] = across(lamp);
        let axes = [first, second, lamp];
        let seen = |place: [f32; 3]| axes.map(|axis| dot(axis, place));
        let (mut low, mut high) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]);
        let mut include = |place: [f32; 3], radius: f32| {
            let place = seen(place);
            for axis in 0..2 {
                low[axis] = low[axis].min(place[axis] - radius);
                high[axis] = high[axis].max(place[axis] + radius);
            }
        };
        for (caster, _) in casters {
            match *caster {
                Caster::Ball(center, radius) | Caster::Drop(center, radius) => include(center, radius),
                Caster::Rod(from, to, radius) => [from, to].into_iter().for_each(|end| include(end, radius)),
                Caster::Triangle(corners) => corners.into_iter().for_each(|corner| include(corner, 0.0)),
            }
        }
        let size = (high[0] - low[0]).max(high[1] - low[1]);
        if !(size > 0.0 && size.is_finite()) {
            return None;
        }
        let per_length = (SIDE - 2 * MARGIN) as f32 / size;
        let side = |axis: usize| ((high[axis] - low[axis]) * per_length) as usize + 2 * MARGIN + 1;
        let (width, height) = (side(0), side(1));
        let corner = [0, 1].map(|axis: usize| low[axis] - MARGIN as f32 / per_length);
        let mut drawn = Heights { width, held: vec![0.0; width * height], top: vec![f32::NEG_INFINITY; width * height] };
        let texel = |place: [f32; 3]| {
            let [u, v, height] = seen(place);
            [(u - corner[0]) * per_length, (v - corner[1]) * per_length, height]
        };
        for (caster, share) in casters {
            match *caster {
                Caster::Ball(center, radius) => drawn.ball(texel(center), radius * per_length, radius, *share),
                Caster::Drop(center, radius) => drawn.drop(texel(center), radius * per_length, *share),
                Caster::Rod(from, to, radius) => drawn.rod(texel(from), texel(to), radius * per_length, *share),
                Caster::Triangle(corners) => drawn.triangle(corners.map(texel), *share),
            }
        }
        let texels = drawn.held.iter().zip(&drawn.top).map(|(&held, &top)| {
            let top = if held > 0.0 { top } else { 0.0 };
            [held, held * top, held * top * top]
        });
        let sharp = blurred(texels.collect(), width, BLURS[0]);
        let soft = blurred(sharp.clone(), width, BLURS[1]);
        Some(Self { axes, corner, per_length, width, sharp, soft, size })
    }

    /// Whether a point may be in a shadow.
    #[inline(always)]
    pub(crate) fn reaches(&self, place: [f32; 3]) -> bool {
        let x = (dot(self.axes[0], place) - self.corner[0]) * self.per_length;
        let y = (dot(self.axes[1], place) - self.corner[1]) * self.per_length;
        x > 0.0 && y > 0.0 && x < self.width as f32 && y < (self.sharp.len() / self.width) as f32
    }

    /// Length of the side of a texel.
    pub(crate) fn texel(&self) -> f32 {
        1.0 / self.per_length
    }

    /// Share of the light blocked at a point, 0 to 1.
    #[inline(always)]
    pub(crate) fn at(&self, place: [f32; 3]) -> f32 {
        let [u, v, height] = self.axes.map(|axis| dot(axis, place));
        let (x, y) = ((u - self.corner[0]) * self.per_length - 0.5, (v - self.corner[1]) * self.per_length - 0.5);
        let rows = self.sharp.len() / self.width;
        if !(x >= 0.0 && y >= 0.0 && x < (self.width - 1) as f32 && y < (rows - 1) as f32) {
            return 0.0;
        }
        let (column, row) = (x as usize, y as usize);
        let (right, down) = (x - column as f32, y - row as f32);
        let index = row * self.width + column;
        let soft = between(&self.soft, index, self.width, right, down);
        if soft[0] <= 1e-4 {
            return 0.0;
        }
        let above = (soft[1] / soft[0] - height) / (SOFT * self.size);
        let softness = above.clamp(0.0, 1.0);
        let sharp = between(&self.sharp, index, self.width, right, down);
        let (sharp, soft) = (self.held(sharp, height), self.held(soft, height));
        sharp + softness * (soft - sharp)
    }

    /// Share of the light blocked at a height: a lower bound of the part above it (Chebyshev's inequality).
    #[inline(always)]
    fn held(&self, [held, first, second]: Texel, height: f32) -> f32 {
        if held <= 1e-4 {
            return 0.0;
        }
        let mean = first / held;
        if mean <= height {
            return 0.0;
        }
        let least = ROUGH * self.size;
        let variance = (second / held - mean * mean).max(least * least);
        let away = mean - height;
        held * (1.0 - variance / (variance + away * away))
    }
}

/// Mean of four texels, by bilinear interpolation.
#[inline(always)]
fn between(texels: &[Texel], index: usize, width: usize, right: f32, down: f32) -> Texel {
    let (upper, lower) = (&texels[index..index + 2], &texels[index + width..index + width + 2]);
    std::array::from_fn(|part| {
        let above = upper[0][part] + right * (upper[1][part] - upper[0][part]);
        let below = lower[0][part] + right * (lower[1][part] - lower[0][part]);
        above + down * (below - above)
    })
}

/// View of the lamp, before the blur.
struct Heights {
    width: usize,
    held: Vec<f32>,
    top: Vec<f32>,
}

impl Heights {
    /// Adds an object at a texel.
    #[inline(always)]
    fn add(&mut self, index: usize, share: f32, height: f32) {
        self.held[index] = (self.held[index].max(share) + 0.2 * share).min(1.0).min(self.held[index] + share);
        self.top[index] = self.top[index].max(height);
    }

    /// Adds a ball at a texel; its radius is given in texels and in the unit of heights.
    fn ball(&mut self, [x, y, height]: [f32; 3], radius: f32, length: f32, share: f32) {
        if radius < 0.7 {
            // Smaller than a texel: only a part of the light of the texel is blocked.
            let index = y as usize * self.width + x as usize;
            return self.add(index, share * std::f32::consts::PI * radius * radius, height);
        }
        self.each([x - radius, y - radius], [x + radius, y + radius], Self::add, |x1, y1| {
            let square = 1.0 - ((x1 - x) * (x1 - x) + (y1 - y) * (y1 - y)) / (radius * radius);
            (square > 0.0).then(|| (share, height + length * square.sqrt()))
        });
    }

    /// Adds an object that lets light through at a texel: each blocks its share of what the others let through.
    fn veil(&mut self, index: usize, share: f32, height: f32) {
        self.held[index] += share * (1.0 - self.held[index]);
        self.top[index] = self.top[index].max(height);
    }

    /// Adds a drop of a liquid at a texel. Its height is that of its center, below the surface that it is part of.
    fn drop(&mut self, [x, y, height]: [f32; 3], radius: f32, share: f32) {
        if radius < 0.7 {
            // The mean weight within the radius is a third.
            let index = y as usize * self.width + x as usize;
            return self.veil(index, share * std::f32::consts::PI * radius * radius / 3.0, height);
        }
        self.each([x - radius, y - radius], [x + radius, y + radius], Self::veil, |x1, y1| {
            let inside = 1.0 - ((x1 - x) * (x1 - x) + (y1 - y) * (y1 - y)) / (radius * radius);
            (inside > 0.0).then_some((share * inside * inside, height))
        });
    }

    /// Adds a rod between texels.
    fn rod(&mut self, [x0, y0, z0]: [f32; 3], [x1, y1, z1]: [f32; 3], radius: f32, share: f32) {
        let (half, share) = (radius.max(0.6), share * (radius / 0.6).min(1.0));
        let (ux, uy) = (x1 - x0, y1 - y0);
        let per_square = 1.0 / (ux * ux + uy * uy).max(1e-12);
        self.each([x0.min(x1) - half, y0.min(y1) - half], [x0.max(x1) + half, y0.max(y1) + half], Self::add, |x, y| {
            let along = (((x - x0) * ux + (y - y0) * uy) * per_square).clamp(0.0, 1.0);
            let (ex, ey) = (x - x0 - along * ux, y - y0 - along * uy);
            (ex * ex + ey * ey < half * half).then_some((share, z0 + along * (z1 - z0)))
        });
    }

    /// Adds a triangle between texels.
    fn triangle(&mut self, [a, b, c]: [[f32; 3]; 3], share: f32) {
        let doubled = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if doubled == 0.0 {
            return;
        }
        let low = [a[0].min(b[0]).min(c[0]), a[1].min(b[1]).min(c[1])];
        let high = [a[0].max(b[0]).max(c[0]), a[1].max(b[1]).max(c[1])];
        self.each(low, high, Self::add, |x, y| {
            let (dx, dy) = (x - a[0], y - a[1]);
            let along = (dx * (c[1] - a[1]) - dy * (c[0] - a[0])) / doubled;
            let across = (dy * (b[0] - a[0]) - dx * (b[1] - a[1])) / doubled;
            let inside = along >= -1e-3 && across >= -1e-3 && along + across <= 1.001;
            inside.then(|| (share, a[2] + along * (b[2] - a[2]) + across * (c[2] - a[2])))
        });
    }

    /// Adds the object at the centers of the texels between two corners, where it exists.
    #[inline(always)]
    fn each(
        &mut self,
        low: [f32; 2],
        high: [f32; 2],
        add: impl Fn(&mut Self, usize, f32, f32),
        found: impl Fn(f32, f32) -> Option<(f32, f32)>,
    ) {
        let rows = self.held.len() / self.width;
        let last = |edge: f32, count: usize| ((edge + 1.0).max(0.0) as usize).min(count);
        for row in low[1].max(0.0) as usize..last(high[1], rows) {
            for column in low[0].max(0.0) as usize..last(high[0], self.width) {
                if let Some((share, height)) = found(column as f32 + 0.5, row as f32 + 0.5) {
                    add(self, row * self.width + column, share, height);
                }
            }
        }
    }
}

/// Blurs texels twice by the mean over `reach` neighbors on each side, along rows and then along columns.
fn blurred(mut texels: Vec<Texel>, width: usize, reach: usize) -> Vec<Texel> {
    let mut other = texels.clone();
    let height = texels.len() / width;
    for _ in 0..2 {
        for row in 0..height {
            mean(&texels[row * width..], &mut other[row * width..], width, 1, reach);
        }
        for column in 0..width {
            mean(&other[column..], &mut texels[column..], height, width, reach);
        }
    }
    texels
}

/// Means of a row of `count` texels, which are `stride` apart; beyond its ends all values are zero.
fn mean(from: &[Texel], to: &mut [Texel], count: usize, stride: usize, reach: usize) {
    let share = 1.0 / (2 * reach + 1) as f32;
    let mut sum = [0.0_f32; 3];
    let add = |sum: &mut Texel, texel: Texel, sign: f32| {
        for (sum, part) in sum.iter_mut().zip(texel) {
            *sum += sign * part;
        }
    };
    for index in 0..reach.min(count) {
        add(&mut sum, from[index * stride], 1.0);
    }
    for index in 0..count {
        if index + reach < count {
            add(&mut sum, from[(index + reach) * stride], 1.0);
        }
        if index > reach {
            add(&mut sum, from[(index - reach - 1) * stride], -1.0);
        }
        to[index * stride] = sum.map(|part| part * share);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAMP: [f32; 3] = [0.0, 0.0, 1.0];

    /// Drops at the nodes of a square lattice of spacing 1, shifted by up to a fifth of it, with the radius of a liquid in space.
    fn layers(count: u8) -> Vec<(Caster, f32)> {
        let place = |index: u16, axis: u16| f32::from((index * 37 + axis * 61) % 41) / 41.0 * 0.4 - 0.2;
        let all = (0..count).flat_map(|layer| (0..400_u16).map(move |index| (layer, index)));
        all.map(|(layer, index)| {
            let (x, y) = (f32::from(index % 20) + place(index, 0), f32::from(index / 20) + place(index, 1));
            (Caster::Drop([x, y, f32::from(layer)], 1.15), 0.5)
        })
        .collect()
    }

    /// The sum of the weights of the drops over a point is π 1.15²/3 = 1.4 in a layer. A drop of weight w lets 1 − w/2 through, which
    /// is between exp(−0.69 w) and exp(−0.5 w): a layer blocks 0.5 to 0.62. Its shadow is even within a tenth close behind it, and
    /// darker behind three layers. No drop shades the surface of the liquid, half a spacing above the centers.
    #[test]
    fn a_layer_of_drops_has_an_even_shadow() {
        let shadow = |count: u8, height: f32| {
            let map = ShadowMap::new(LAMP, &layers(count)).expect("there are casters");
            let points = (40..150_u8).flat_map(|i| (40..150_u8).map(move |j| [0.1 * f32::from(i), 0.1 * f32::from(j)]));
            let held: Vec<f32> = points.map(|[x, y]| map.at([x, y, height])).collect();
            let mean = held.iter().sum::<f32>() / held.len() as f32;
            let variance = held.iter().map(|held| (held - mean) * (held - mean)).sum::<f32>() / held.len() as f32;
            (mean, variance.sqrt())
        };
        let ((one, rough), (three, _)) = (shadow(1, -0.7), shadow(3, -0.7));
        assert!((0.5..0.62).contains(&one) && rough < 0.1 * one, "{one} {rough}");
        assert!(three > 1.3 * one, "{three}");
        assert!(shadow(1, 0.5).0 < 1e-3);
    }
}
