//! Projection of points to pixels and mapping of values to inks: the work per particle and frame.

use crate::color::{Ink, Rgb};

/// Projection of points in 2D or 3D to pixels.
#[derive(Clone, Copy, Debug)]
pub struct Projection<const D: usize> {
    /// Unit vectors to the right, up and, in 3D, toward the eye.
    pub axes: [[f64; D]; D],
    /// Coordinates of the center along these axes.
    pub center: [f64; D],
    /// Pixels per unit of length at the center.
    pub scale: f64,
    /// Middle of the picture [pixels].
    pub middle: [f64; 2],
    /// Distance from the eye to the center; infinite for an orthographic projection.
    pub distance: f64,
}

/// Near plane, as a fraction of the distance of the eye from the center.
const NEAREST: f64 = 0.05;

impl<const D: usize> Projection<D> {
    /// Pixel of a point, its depth behind the center, and pixels per unit of length there.
    #[inline(always)]
    pub fn project(&self, point: [f64; D]) -> ([f32; 2], f32, f32) {
        let mut local = [0.0; D];
        for ((value, axis), center) in local.iter_mut().zip(&self.axes).zip(self.center) {
            *value = axis.iter().zip(point).map(|(a, x)| a * x).sum::<f64>() - center;
        }
        let (toward, mut scale) = (if D == 3 { local[D - 1] } else { 0.0 }, self.scale);
        if D == 3 && self.distance < f64::INFINITY {
            scale *= self.distance / (self.distance - toward).max(NEAREST * self.distance);
        }
        let pixel = [self.middle[0] + scale * local[0], self.middle[1] - scale * local[1]];
        (pixel.map(|coordinate| coordinate as f32), -toward as f32, scale as f32)
    }
}

/// Depth fog: distant points fade into the background.
#[derive(Clone, Copy, Debug)]
pub struct Fog {
    /// Half the depth range of the scene.
    pub reach: f32,
    /// Fraction of color that the farthest point loses.
    pub strength: f32,
    /// Color of the fog.
    pub background: Rgb,
}

impl Fog {
    /// Applies fog to a color at a depth behind the center.
    #[inline(always)]
    pub fn seen(&self, color: [f32; 3], depth: f32) -> [f32; 3] {
        let share = self.strength * (0.5 + 0.5 * depth / self.reach).clamp(0.0, 1.0);
        let mut seen = color;
        for (channel, background) in seen.iter_mut().zip(self.background) {
            *channel += (f32::from(background) - *channel) * share;
        }
        seen
    }
}

/// Entry at a fraction of the length of a table; clamped to its ends, also for NaN.
#[inline(always)]
pub fn look_up<T>(table: &[T], fraction: f64) -> &T {
    let last = table.len() - 1;
    &table[((fraction * table.len() as f64) as usize).min(last)]
}

/// Converts a color to an opaque ink.
#[inline(always)]
pub fn opaque(color: [f32; 3]) -> Ink {
    [color[0] as u8, color[1] as u8, color[2] as u8, 255]
}
