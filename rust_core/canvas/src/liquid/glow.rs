//! Light of a glowing liquid in 3D on what is around it in the picture.

use super::{BRIM, Liquid};
use crate::smoothing::blur_plane;

/// Reach of the light of a glowing liquid, over the support of a drop; its maximum [pixels]; and its brightness.
const LIT: f32 = 4.0;
const FARTHEST_LIGHT: usize = 100;
const SHINE: f32 = 0.7;

impl Liquid {
    /// Computes the light of a glowing liquid on what is around it in the picture: its emission, blurred.
    pub(super) fn shine(&mut self) {
        let (width, reach) = (self.width, ((LIT * self.mean_radius()) as usize).clamp(1, FARTHEST_LIGHT));
        for channel in 0..3 {
            let emitted = |pixel: usize| {
                let bright = SHINE * self.glow * self.mean(pixel).0[channel];
                bright * (self.amount[pixel] / BRIM).min(1.0)
            };
            let mut plane: Vec<f32> = (0..self.amount.len()).map(emitted).collect();
            let [other, ..] = &mut self.scratch;
            blur_plane(&mut plane, other, width, reach);
            self.light[channel] = plane;
        }
    }
}
