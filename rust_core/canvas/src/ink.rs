//! Blending of colors into pixels, and shading of spheres.

use crate::color::Ink;

/// How a shape changes what is below it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mixing {
    /// It covers that.
    #[default]
    Over,
    /// Each channel becomes lighter or stays, as where light is added.
    Lighter,
    /// Each channel becomes darker or stays.
    Darker,
}

/// A color, its alpha replaced by a factor that turns coverage into 256ths of opacity.
#[derive(Clone, Copy)]
pub(crate) struct Paint {
    color: u32,
    full: f32,
}

impl Paint {
    pub(crate) fn new([red, green, blue, alpha]: Ink, opacity: f32) -> Self {
        Self { color: u32::from_le_bytes([red, green, blue, 0]), full: opacity * f32::from(alpha) * (256.0 / 255.0) }
    }

    /// The same opacity in another color.
    pub(crate) fn with(self, color: u32) -> Self {
        Self { color, ..self }
    }

    /// Blends into a pixel.
    #[inline(always)]
    pub(crate) fn blend(self, pixel: &mut [u8; 4], coverage: f32) {
        self.mix(pixel, self.amount(coverage));
    }

    /// Blends into the channels of a pixel that this changes in one direction; the others stay.
    #[inline(always)]
    pub(crate) fn shift(self, pixel: &mut [u8; 4], coverage: f32, mixing: Mixing) {
        let before = *pixel;
        self.blend(pixel, coverage);
        for (channel, before) in pixel.iter_mut().zip(before) {
            *channel = match mixing {
                Mixing::Over => *channel,
                Mixing::Lighter => before.max(*channel),
                Mixing::Darker => before.min(*channel),
            };
        }
    }

    /// The opacity of a coverage of 0–1, in 256ths.
    #[inline(always)]
    pub(crate) fn amount(self, coverage: f32) -> u32 {
        // A small number added to 2²³ stands, rounded, in the last bits: several times cheaper than `as`, which handles
        // NaN.
        (coverage * self.full + 8_388_608.0).to_bits() & 0x1FF
    }

    /// Blends into a pixel, two channels in one multiplication.
    #[inline(always)]
    pub(crate) fn mix(self, pixel: &mut [u8; 4], amount: u32) {
        const PAIR: u32 = 0x00FF_00FF;
        const HALVES: u32 = 0x0080_0080;
        let (below, keep) = (u32::from_le_bytes(*pixel), 256 - amount);
        let red_blue = (below & PAIR) * keep + (self.color & PAIR) * amount + HALVES;
        let green = ((below >> 8) & PAIR) * keep + ((self.color >> 8) & PAIR) * amount + HALVES;
        *pixel = ((red_blue >> 8) & PAIR | green & !PAIR).to_le_bytes();
    }
}

/// Direction to the lamp: left, up, toward the viewer; a unit vector.
pub(crate) const LAMP: [f32; 3] = [-0.42, -0.62, 0.66];
/// How far a lamp's light reaches around a ball, as that of a lamp that is not a point.
const WRAP: f32 = 0.2;
/// Light from below and from the sky, and that of the lamp.
const FILL: f32 = 0.3;
const SKY: f32 = 0.16;
const KEY: f32 = 0.72;
/// Light at the rim, of a lamp behind.
const RIM: f32 = 0.3;
const HIGHLIGHT: f32 = 70.0;

/// Shading of a sphere: Lambert's cosine of a lamp at the upper left, light from the sky and at the rim, and a highlight.
pub(crate) struct Shade {
    pub(crate) strength: f32,
    pub(crate) per_radius: f32,
}

impl Shade {
    #[inline(always)]
    pub(crate) fn lit(&self, color: Ink, dx: f32, dy: f32) -> u32 {
        let (nx, ny) = (dx * self.per_radius, dy * self.per_radius);
        let nz = (1.0 - nx * nx - ny * ny).max(0.0).sqrt();
        let (cosine, up) = (nx * LAMP[0] + ny * LAMP[1] + nz * LAMP[2], 0.5 - 0.5 * ny);
        let light = FILL + SKY * up + KEY * ((cosine + WRAP) / (1.0 + WRAP)).max(0.0);
        let square = cosine.max(0.0) * cosine.max(0.0);
        let highlight = HIGHLIGHT * self.strength * (square * square) * (square * square) * (square * square);
        let factor = 1.0 - self.strength * (1.0 - light);
        let rim = self.strength * RIM * up * (1.0 - nz) * (1.0 - nz);
        let channel = |value: u8| {
            let value = f32::from(value);
            ((value + (255.0 - value) * rim) * factor + highlight).min(255.0) as u8
        };
        u32::from_le_bytes([channel(color[0]), channel(color[1]), channel(color[2]), 0])
    }
}
