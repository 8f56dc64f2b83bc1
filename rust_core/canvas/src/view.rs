//! From points in space to pixels, and from values to inks: what is done for every particle of every frame.

use crate::color::{Ink, Rgb};

/// How points in 2D or 3D become pixels.
#[derive(Clone, Copy, Debug)]
pub struct Projection<const D: usize> {
    /// Unit vectors to the right, up and, in 3D, toward the eye.
    pub axes: [[f64; D]; D],
    /// What is shown in the middle, along these axes.
    pub center: [f64; D],
    /// Pixels per unit of length at the center.
    pub scale: f64,
    /// The middle of the picture [pixels].
    pub middle: [f64; 2],
    /// From the eye to the center; infinite for an orthographic view.
    pub distance: f64,
}

/// Nothing is drawn nearer to the eye than this fraction of its distance from the center.
const NEAREST: f64 = 0.05;

impl<const D: usize> Projection<D> {
    /// The pixel of a point, how far it is behind the center, and pixels per unit of length there.
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

/// Far things fade into the background.
#[derive(Clone, Copy, Debug)]
pub struct Fog {
    /// Half the depth of all that is seen.
    pub reach: f32,
    /// How much of its color the farthest thing loses.
    pub strength: f32,
    /// What it fades to.
    pub background: Rgb,
}

impl Fog {
    /// A color as it is seen at some depth behind the center.
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

/// The entry at a fraction of a table's length; beyond its ends, and for what is not a number, the ends.
#[inline(always)]
pub fn look_up<T>(table: &[T], fraction: f64) -> &T {
    let last = table.len() - 1;
    &table[((fraction * table.len() as f64) as usize).min(last)]
}

/// An opaque ink.
#[inline(always)]
pub fn opaque(color: [f32; 3]) -> Ink {
    [color[0] as u8, color[1] as u8, color[2] as u8, 255]
}
