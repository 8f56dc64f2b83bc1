//! Eye of a picture in space: positions of pixels of known depth, and the depths of drawn shapes.
//!
//! A canvas with an eye records the depth of the surface that each pixel shows. Later lighting (`light`) uses these depths to
//! compute shadows. Shapes are painted from far to near, so the depth is that of the last shape that covers a pixel.

use crate::band::Band;
use crate::color::Ink;
use crate::shapes::{Disc, Line};

/// Eye point of a projection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eye {
    /// Pixels per unit of length at the focus.
    pub scale: f32,
    /// Pixel of the focus.
    pub middle: [f32; 2],
    /// Distance of the eye from the focus; infinite for an orthographic projection.
    pub distance: f32,
}

/// Depth of a pixel that shows no surface, or a surface that receives no shadow.
pub(crate) const OPEN: f32 = f32::INFINITY;
/// Minimum opacity of a shape that counts as a surface [1/255].
const SOLID: u8 = 200;

impl Eye {
    /// Pixels per unit of length at a depth behind the focus.
    #[inline(always)]
    pub(crate) fn magnification(self, depth: f32) -> f32 {
        1.0 / self.length(depth)
    }

    /// Length of a pixel at a depth behind the focus.
    #[inline(always)]
    pub(crate) fn length(self, depth: f32) -> f32 {
        const NEAREST: f32 = 0.05;
        let per_scale = 1.0 / self.scale;
        // Hoisted out of loops: the eye is equal for all pixels.
        let per_depth = if self.distance < f32::INFINITY { per_scale / self.distance } else { 0.0 };
        (per_scale + per_depth * depth).max(NEAREST * per_scale)
    }

    /// Position of a pixel at a depth: right, up and toward the eye from the focus.
    #[inline(always)]
    pub(crate) fn place(self, [x, y]: [f32; 2], depth: f32) -> [f32; 3] {
        let per_pixel = self.length(depth);
        [(x - self.middle[0]) * per_pixel, (self.middle[1] - y) * per_pixel, -depth]
    }
}

/// Marks the depth of a shape that covers the center of a pixel. The mark is the last bit, far below the accuracy of depths.
#[inline(always)]
pub(crate) fn at_center(depth: f32) -> f32 {
    if depth == OPEN { OPEN } else { f32::from_bits(depth.to_bits() & !1) }
}

/// Marks the depth of a shape that covers half of a pixel or more, but not its center.
#[inline(always)]
pub(crate) fn beside_center(depth: f32) -> f32 {
    if depth == OPEN { OPEN } else { f32::from_bits(depth.to_bits() | 1) }
}

/// Whether a depth is that of a shape that covers the center of the pixel.
#[inline(always)]
pub(crate) fn is_center(depth: f32) -> bool {
    depth.to_bits() & 1 == 0
}

/// Whether a shape of this ink hides the background.
pub(crate) fn is_solid(ink: Ink) -> bool {
    ink[3] >= SOLID
}

impl Band<'_> {
    /// Records the depth of a disc. A shaded disc is a ball; an unshaded disc receives no shadow.
    pub(crate) fn deepen_disc(&mut self, disc: &Disc, depth: f32) {
        let Some(eye) = self.eye.filter(|_| is_solid(disc.color)) else {
            return;
        };
        let ([x, y], radius, per_pixel) = (disc.center, disc.radius.max(0.5), eye.length(depth));
        let lit = disc.shading > 0.0 && depth.is_finite();
        self.deepen([x - radius, y - radius], [x + radius, y + radius], |column, row, _| {
            let square = radius * radius - (column - x) * (column - x) - (row - y) * (row - y);
            (square > 0.0).then(|| if lit { depth - square.sqrt() * per_pixel } else { OPEN })
        });
    }

    /// Records the depth of a line, which is a rod with round ends at two depths. Where rods meet in an end, the depth is that of
    /// the one in front. Otherwise each rod would have a notch where the round end of the other covers it.
    ///
    /// Let z = z₀ + s t be the axis over the position t along the line, all in pixels. At the distance e from the axis, the front
    /// of a rod of radius h is z₀ + s t − b √(1 + s²), with b = √(h² − e²). Its foot on the axis is at t − s b / √(1 + s²). If
    /// the foot is beyond an end, the front is that of the ball at this end.
    pub(crate) fn deepen_line(&mut self, line: &Line, [first, last]: [f32; 2]) {
        let Some(eye) = self.eye.filter(|_| is_solid(line.color)) else {
            return;
        };
        let ([x0, y0], [x1, y1], half) = (line.from, line.to, 0.5 * line.width.max(1.0));
        let (low, high) = ([x0.min(x1) - half, y0.min(y1) - half], [x0.max(x1) + half, y0.max(y1) + half]);
        let ([ux, uy], per_pixel) = ([x1 - x0, y1 - y0], eye.length(0.5 * (first + last)));
        let length = (ux * ux + uy * uy).sqrt();
        let [ux, uy] = [ux, uy].map(|component| component / length.max(1e-6));
        let slope = (last - first) / (length.max(1e-6) * per_pixel);
        let lean = (1.0 + slope * slope).sqrt();
        self.deepen(low, high, |column, row, before| {
            let (dx, dy) = (column - x0, row - y0);
            let (along, across) = (dx * ux + dy * uy, dx * uy - dy * ux);
            let beyond = along - along.clamp(0.0, length);
            if across * across + beyond * beyond >= half * half {
                return None;
            }
            if !slope.is_finite() {
                return Some(OPEN);
            }
            let bulge = (half * half - across * across).sqrt();
            let foot = along - slope * bulge / lean;
            let front = if foot < 0.0 || foot > length {
                let end = foot.clamp(0.0, length);
                slope * end - (bulge * bulge - (along - end) * (along - end)).max(0.0).sqrt()
            } else {
                slope * along - lean * bulge
            };
            Some(before.min(first + per_pixel * front))
        });
    }

    /// Records depths of the pixels between two corners. The function gives the depth, if any, from the center of a pixel and its
    /// previous depth.
    #[inline(always)]
    fn deepen(&mut self, low: [f32; 2], high: [f32; 2], depth: impl Fn(f32, f32, f32) -> Option<f32>) {
        let Some(area) = self.visible(low, high) else {
            return;
        };
        for row in area.top..area.bottom {
            let first = (row - self.top) as usize * self.width;
            for column in area.left..area.right {
                let kept = &mut self.depths[first + column as usize];
                if let Some(depth) = depth(column as f32 + 0.5, row as f32 + 0.5, *kept) {
                    *kept = at_center(depth);
                }
            }
        }
    }

    /// Records the depth of one pixel inside the clip.
    pub(crate) fn deepen_dot(&mut self, x: i32, y: i32, depth: f32) {
        let clip = self.clip;
        if self.eye.is_some() && (clip.left..clip.right).contains(&x) && (clip.top..clip.bottom).contains(&y) {
            self.depths[(y - self.top) as usize * self.width + x as usize] = at_center(depth);
        }
    }
}
