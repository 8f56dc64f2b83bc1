//! Blending of colors into pixels, and shading of spheres.

use wide::{f32x4, u8x16, u16x8, u32x4};

use crate::color::Ink;

/// Blending mode of a shape.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mixing {
    /// Covers the background.
    #[default]
    Over,
    /// Lighten: each channel becomes lighter or stays, as when light is added.
    Lighter,
    /// Darken: each channel becomes darker or stays.
    Darker,
}

/// Number of pixels blended at a time.
pub(crate) const LANES: usize = 4;

/// Constant 2²³: a small number added to it is rounded, and stands in the last bits. This is several times cheaper than `as`,
/// which handles NaN.
const ROUNDING: f32 = 8_388_608.0;

/// Mask of every second channel of a pixel.
const PAIR: u32 = 0x00FF_00FF;

/// Color whose alpha is replaced by a factor that converts coverage to 256ths of opacity.
#[derive(Clone, Copy)]
pub(crate) struct Paint {
    color: u32,
    full: f32,
}

impl Paint {
    pub(crate) fn new([red, green, blue, alpha]: Ink, opacity: f32) -> Self {
        Self { color: u32::from_le_bytes([red, green, blue, 0]), full: opacity * f32::from(alpha) * (256.0 / 255.0) }
    }

    /// Replaces the color, keeping the opacity.
    pub(crate) fn with(self, color: u32) -> Self {
        Self { color, ..self }
    }

    /// Blends into a pixel.
    #[inline(always)]
    pub(crate) fn blend(self, pixel: &mut [u8; 4], coverage: f32) {
        self.mix(pixel, self.amount(coverage));
    }

    /// Blends into adjacent pixels. The function gives the coverages of [`LANES`] pixels at a time from their columns.
    #[inline(always)]
    pub(crate) fn blend_row(self, pixels: &mut [[u8; 4]], mixing: Mixing, coverage: impl Fn(f32x4) -> f32x4) {
        let (groups, rest) = pixels.as_chunks_mut::<LANES>();
        let mut columns = f32x4::new([0.0, 1.0, 2.0, 3.0]);
        for group in groups {
            *group = self.mixed(*group, coverage(columns), mixing);
            columns += LANES as f32;
        }
        if !rest.is_empty() {
            let mut group = [[0; 4]; LANES];
            group[..rest.len()].copy_from_slice(rest);
            group = self.mixed(group, coverage(columns), mixing);
            rest.copy_from_slice(&group[..rest.len()]);
        }
    }

    /// Blends into several pixels: [`Paint::amount`] and [`Paint::mix`] for a group.
    #[inline(always)]
    fn mixed(self, pixels: [[u8; 4]; LANES], coverages: f32x4, mixing: Mixing) -> [[u8; 4]; LANES] {
        let amounts: u32x4 = bytemuck::cast(coverages * self.full + ROUNDING);
        let amounts = amounts & u32x4::splat(0x1FF);
        let amounts: u16x8 = bytemuck::cast(amounts | (amounts << 16));
        let keep = u16x8::splat(256) - amounts;
        let pair = |shift: u32| -> u16x8 { bytemuck::cast(u32x4::splat((self.color >> shift) & PAIR)) };
        let (below, halves): (u16x8, _) = (bytemuck::cast(pixels), u16x8::splat(0x80));
        let red_blue = (below & u16x8::splat(0xFF)) * keep + pair(0) * amounts + halves;
        let green = (below >> 8) * keep + pair(8) * amounts + halves;
        let blended: u8x16 = bytemuck::cast((red_blue >> 8) | (green & u16x8::splat(0xFF00)));
        let below: u8x16 = bytemuck::cast(below);
        bytemuck::cast(match mixing {
            Mixing::Over => blended,
            Mixing::Lighter => blended.max(below),
            Mixing::Darker => blended.min(below),
        })
    }

    /// Opacity of a coverage of 0–1, in 256ths.
    #[inline(always)]
    pub(crate) fn amount(self, coverage: f32) -> u32 {
        (coverage * self.full + ROUNDING).to_bits() & 0x1FF
    }

    /// Blends into a pixel, two channels per multiplication.
    #[inline(always)]
    pub(crate) fn mix(self, pixel: &mut [u8; 4], amount: u32) {
        const HALVES: u32 = 0x0080_0080;
        let (below, keep) = (u32::from_le_bytes(*pixel), 256 - amount);
        let red_blue = (below & PAIR) * keep + (self.color & PAIR) * amount + HALVES;
        let green = ((below >> 8) & PAIR) * keep + ((self.color >> 8) & PAIR) * amount + HALVES;
        *pixel = ((red_blue >> 8) & PAIR | green & !PAIR).to_le_bytes();
    }
}

/// Unit vector to the lamp at the upper left: right, down, toward the viewer.
pub(crate) const LAMP: [f32; 3] = [-0.42, -0.62, 0.66];
/// Wrap-around of light at a ball, as from an extended lamp.
const WRAP: f32 = 0.2;
/// Intensities of light from below, from the sky and from the lamp.
const FILL: f32 = 0.3;
const SKY: f32 = 0.16;
const KEY: f32 = 0.72;
/// Intensity of light at the rim, from a lamp behind.
const RIM: f32 = 0.3;
const HIGHLIGHT: f32 = 70.0;

/// Shading of a sphere: Lambert's cosine law for a lamp at the upper left, light from the sky and at the rim, and a highlight.
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
