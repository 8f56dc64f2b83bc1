//! The eye of a picture in space: places of pixels whose depth is known, and the depths of what is drawn.
//!
//! A canvas that has an eye keeps the depth of the surface that each pixel shows: later lights find by it where shadows fall
//! (`light`). Shapes are painted from the far to the near, so that the depth is that of the last one that covers a pixel.

use crate::band::Band;
use crate::color::Ink;
use crate::shapes::{Disc, Line};

/// The eye: from where a projection sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eye {
    /// Pixels per unit of length at the focus.
    pub scale: f32,
    /// The pixel of the focus.
    pub middle: [f32; 2],
    /// Distance of the eye from the focus; infinite for an orthographic projection.
    pub distance: f32,
}

/// Depth of a pixel that shows no surface, or one that takes no shadow.
pub(crate) const OPEN: f32 = f32::INFINITY;
/// Opacity from which on a shape is a surface [1/255].
const SOLID: u8 = 200;

impl Eye {
    /// Pixels per unit of length at a depth behind the focus.
    #[inline(always)]
    pub(crate) fn magnification(self, depth: f32) -> f32 {
        1.0 / self.length(depth)
    }

    /// The length of a pixel at a depth behind the focus.
    #[inline(always)]
    pub(crate) fn length(self, depth: f32) -> f32 {
        const NEAREST: f32 = 0.05;
        let per_scale = 1.0 / self.scale;
        // Hoisted out of loops: the eye is the same for all pixels.
        let per_depth = if self.distance < f32::INFINITY { per_scale / self.distance } else { 0.0 };
        (per_scale + per_depth * depth).max(NEAREST * per_scale)
    }

    /// The place of a pixel at a depth: to the right, up and toward the eye from the focus.
    #[inline(always)]
    pub(crate) fn place(self, [x, y]: [f32; 2], depth: f32) -> [f32; 3] {
        let per_pixel = self.length(depth);
        [(x - self.middle[0]) * per_pixel, (self.middle[1] - y) * per_pixel, -depth]
    }
}

/// The depth of what covers the center of a pixel. Its last bit says so, which is far smaller than what depths are known to.
#[inline(always)]
pub(crate) fn at_center(depth: f32) -> f32 {
    if depth == OPEN { OPEN } else { f32::from_bits(depth.to_bits() & !1) }
}

/// The depth of what covers half of a pixel or more, but not its center.
#[inline(always)]
pub(crate) fn beside_center(depth: f32) -> f32 {
    if depth == OPEN { OPEN } else { f32::from_bits(depth.to_bits() | 1) }
}

/// Whether it is the former.
#[inline(always)]
pub(crate) fn is_center(depth: f32) -> bool {
    depth.to_bits() & 1 == 0
}

/// Whether a shape of this ink hides what is behind it.
pub(crate) fn is_solid(ink: Ink) -> bool {
    ink[3] >= SOLID
}

impl Band<'_> {
    /// Keeps the depth of a disc, which is a ball if it is shaded; one that is not takes no shadow.
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

    /// Keeps the depth of a line, which is a rod with round ends at two depths; of rods that meet in an end, that of the one in
    /// front, or each would have a notch where the round end of the other covers it.
    ///
    /// With the axis z = z₀ + s t over the place t along the line, all in pixels, a rod of radius h has at the distance e from
    /// it the front z₀ + s t − b √(1 + s²), b = √(h² − e²), whose foot on the axis is at t − s b / √(1 + s²). Where that is
    /// beyond an end, the front is that of the ball there.
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

    /// Keeps depths of the pixels between two corners for whose centers, and the depths there before, there is one.
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

    /// Keeps the depth of one pixel inside the clip.
    pub(crate) fn deepen_dot(&mut self, x: i32, y: i32, depth: f32) {
        let clip = self.clip;
        if self.eye.is_some() && (clip.left..clip.right).contains(&x) && (clip.top..clip.bottom).contains(&y) {
            self.depths[(y - self.top) as usize * self.width + x as usize] = at_center(depth);
        }
    }
}
