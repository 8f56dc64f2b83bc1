//! Liquids in 2D: a field whose isoline bounds the liquid.
//!
//! The field is wide, so that single drops make no steps in the outline. Where it is thin, drops of their own size are added:
//! spray is seen.
//!
//! Source: J. Blinn, "A generalization of algebraic surface drawing" (1982): metaballs.

use super::{Drop, Liquid, for_each_pixel, tint};
use crate::color::Ink;
use crate::smoothing::blur_plane;
use crate::view::opaque;

/// Reach of the wide field of a liquid in 2D, over the support of a drop.
const WIDE: f32 = 1.5;
/// Isovalue of the edge of a liquid in 2D, as a fraction of the field inside. It is one half at a straight edge; a little less,
/// so that two liquids leave no gap between them.
const EDGE: f32 = 0.42;
/// Isovalue of the edge of a single drop in 2D, which then has a radius of a quarter of its support.
const SPRAY_EDGE: f32 = 0.36;
/// Weight of the field of single drops beside the wide field.
const SPRAY: f32 = 3.0;
/// Wide field up to which single drops are seen in full; at [`EDGE`] they are not.
const THIN: f32 = 0.2;
/// Isovalue at which the lighter rim of a liquid in 2D ends.
const RIM: f32 = 0.7;
const RIM_LIGHT: f32 = 0.3;
/// Depth over which a liquid in 2D darkens inward from its edge, over the support of a drop, and the maximum darkening.
const DEEP: f32 = 4.0;
const DARKER: f32 = 0.2;

impl Liquid {
    /// Computes the fields Σ (1 − d²/r²)³ of all drops, over their mean π/4 (r/s)² inside a liquid with drop spacing s. There is a
    /// wide one, and where that is thin also that of single drops.
    pub(super) fn splat_field(&mut self) {
        const INSIDE: f32 = 0.25 * std::f32::consts::PI * Drop::REACH * Drop::REACH;
        let Self { drops, amount, colors, width, scratch: [single, ..], .. } = self;
        single.clear();
        single.resize(amount.len(), 0.0);
        for drop in drops.iter() {
            for_each_pixel(drop, *width, amount.len(), |pixel, square| {
                single[pixel] += (1.0 - square) * (1.0 - square) * (1.0 - square) / INSIDE;
            });
            let wide = Drop { radius: WIDE * drop.radius, ..*drop };
            for_each_pixel(&wide, *width, amount.len(), |pixel, square| {
                let share = (1.0 - square) * (1.0 - square) * (1.0 - square) / (INSIDE * WIDE * WIDE);
                amount[pixel] += share;
                tint(&mut colors[pixel], drop.color, share);
            });
        }
        for (amount, single) in amount.iter_mut().zip(single.iter()).filter(|(amount, _)| **amount < EDGE) {
            let alone = EDGE + SPRAY * (single - SPRAY_EDGE);
            *amount += ((EDGE - *amount) / (EDGE - THIN)).min(1.0) * (alone - *amount).max(0.0);
        }
    }

    /// Estimates the distance of pixels in a 2D liquid from its edge, by the mean coverage around them.
    pub(super) fn find_inside(&mut self) {
        let reach = (DEEP * self.mean_radius()).clamp(1.0, 64.0) as usize;
        self.inside.clear();
        self.inside.extend(self.amount.iter().map(|&amount| if amount > EDGE { 1.0 } else { 0.0 }));
        let (width, [other, ..]) = (self.width, &mut self.scratch);
        blur_plane(&mut self.inside, other, width, reach);
    }

    /// Color and coverage of a pixel in 2D. The edge is one pixel wide. The rim along it is lighter above than below, and the
    /// interior is darker.
    pub(super) fn rimmed(&self, row: usize, column: usize) -> (Ink, f32) {
        let pixel = row * self.width + column;
        let [dx, dy] = self.slope(&self.amount, row, column, |_, _| true);
        let steepness = (dx * dx + dy * dy).sqrt().max(1e-3);
        let amount = self.amount[pixel];
        let coverage = (0.5 + (amount - EDGE) / steepness).clamp(0.0, 1.0);
        let up = 0.5 + 0.5 * dy / steepness;
        let rim = RIM_LIGHT * (0.25 + 0.75 * up) * ((RIM - amount) / (RIM - EDGE)).clamp(0.0, 1.0);
        let deep = 1.0 - (1.0 - self.glow) * DARKER * ((self.inside[pixel] - 0.5) / 0.5).clamp(0.0, 1.0);
        let ([red, green, blue], _) = self.mean(pixel);
        let lit = |channel: f32| channel * deep + (255.0 - channel * deep) * rim + 0.5;
        (opaque([lit(red), lit(green), lit(blue)]), coverage)
    }
}
