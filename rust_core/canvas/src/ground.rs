//! Level ground and a backdrop: what stands behind everything in space.

use crate::canvas::Canvas;
use crate::color::Rgb;
use crate::eye::{Eye, at_center};
use crate::math::{cross, dot, minus, plus, threshold};

/// Ground: a plane that is lit around a place and fades into what is behind it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// Unit normal: right, up, toward the eye.
    pub normal: [f32; 3],
    /// The place on it that is lit best, likewise from the focus.
    pub center: [f32; 3],
    /// The distance from there at which half of its color is left.
    pub size: f32,
    /// Its color where it is lit best.
    pub color: Rgb,
    /// The color of its grid, the distance of lines, and their opacity there; lines go along `along`.
    pub grid: Option<(Rgb, f32, f32)>,
    /// The direction of half of the lines.
    pub along: [f32; 3],
    /// The corners of the part of it that is there [pixels], in order, and the opacity that it has everywhere, as of a wall; None:
    /// all of it, which fades with the distance.
    pub part: Option<([[f32; 2]; 4], f32)>,
}

impl Canvas {
    /// Lets the background become lighter toward a place by a share of the way to a color, at once and everywhere in the clip.
    pub fn backdrop(&mut self, center: [f32; 2], radius: f32, color: Rgb, share: f32) {
        let times = self.samples() as f32;
        let (center, radius) = (center.map(|place| times * place), times * radius);
        self.each(|pixel, [x, y], _| {
            let square = ((x - center[0]) * (x - center[0]) + (y - center[1]) * (y - center[1])) / (radius * radius);
            mix_evenly(pixel, color, share / ((1.0 + square) * (1.0 + square)), [x / times, y / times]);
        });
    }

    /// Draws ground at once, with its depth; no effect without an eye, or if the eye is below it.
    pub fn ground(&mut self, ground: &Ground) {
        let Some(eye) = self.eye() else {
            return;
        };
        let times = self.samples() as f32;
        let axes = [ground.along, cross(ground.normal, ground.along)];
        // The place that is seen at a pixel, and its coordinates on the plane.
        let seen = |x: f32, y: f32| {
            let place = meet(eye, ground, x, y)?;
            let from = minus(place, ground.center);
            Some((place, axes.map(|axis| dot(axis, from))))
        };
        let part = ground.part.map(|(corners, opacity)| (corners.map(|corner| corner.map(|place| times * place)), opacity));
        self.each(|pixel, [x, y], depth| {
            if part.is_some_and(|(corners, _)| !surrounds(&corners, [x, y])) {
                return;
            }
            let Some((place, at)) = seen(x, y) else {
                return;
            };
            let square = (at[0] * at[0] + at[1] * at[1]) / (ground.size * ground.size);
            let lit = part.map_or(1.0 / (1.0 + square * square), |(_, opacity)| opacity);
            if lit < 0.01 {
                return;
            }
            mix_evenly(pixel, ground.color, lit, [x / times, y / times]);
            if let Some((color, pitch, opacity)) = ground.grid {
                let (right, below) = (seen(x + times, y), seen(x, y + times));
                if let (Some((_, right)), Some((_, below))) = (right, below) {
                    let mut covered = 0.0_f32;
                    for axis in 0..2 {
                        // The width of a pixel of the reduced picture on the plane, across the lines.
                        let wide = (right[axis] - at[axis]).hypot(below[axis] - at[axis]) / pitch;
                        let away = (at[axis] / pitch - (at[axis] / pitch).round()).abs();
                        // Where lines are nearer together than pixels they become a gray.
                        let line = (1.2 - away / wide.max(1e-9)).clamp(0.0, 1.0) * (0.25 / wide.max(1e-9)).min(1.0);
                        covered = covered.max(line);
                    }
                    mix(pixel, color, opacity * covered * lit * lit);
                }
            }
            *depth = at_center(-place[2]);
        });
    }

    /// Visits each pixel of the clip, its center and its depth.
    fn each(&mut self, mut visit: impl FnMut(&mut [u8; 4], [f32; 2], &mut f32)) {
        let [left, top, right, bottom] = self.clipped();
        for row in top..bottom {
            let (pixels, depths) = self.row_with_depths(row);
            let mut nothing = 0.0;
            for column in left..right {
                let depth = depths.get_mut(column).unwrap_or(&mut nothing);
                visit(&mut pixels[column], [column as f32 + 0.5, row as f32 + 0.5], depth);
            }
        }
    }
}

/// Whether a place lies in a convex polygon with corners in either order.
fn surrounds(corners: &[[f32; 2]; 4], [x, y]: [f32; 2]) -> bool {
    let turn = |index: usize| {
        let ([x0, y0], [x1, y1]) = (corners[index], corners[(index + 1) % 4]);
        (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0)
    };
    (0..4).all(|index| turn(index) >= 0.0) || (0..4).all(|index| turn(index) <= 0.0)
}

/// Where the ray through a pixel meets the ground, if it does so before the eye and from above.
fn meet(eye: Eye, ground: &Ground, x: f32, y: f32) -> Option<[f32; 3]> {
    let focus = eye.place([x, y], 0.0);
    let (from, toward) = if eye.distance < f32::INFINITY {
        let from = [0.0, 0.0, eye.distance];
        (from, minus(focus, from))
    } else {
        (focus, [0.0, 0.0, -1.0])
    };
    let (rise, fall) = (dot(ground.normal, minus(from, ground.center)), dot(ground.normal, toward));
    let way = -rise / fall;
    let seen = fall < 0.0 && (way > 0.0 || eye.distance == f32::INFINITY);
    seen.then(|| plus(from, way, toward)).filter(|place| place[2].is_finite())
}

/// Mixes a color into a pixel with an ordered dither: in the few colors of a GIF, gradients would have steps.
#[inline(always)]
fn mix_evenly(pixel: &mut [u8; 4], color: Rgb, share: f32, center: [f32; 2]) {
    const LEVELS: f32 = 3.0;
    let [x, y] = center.map(|coordinate| coordinate as u32);
    let offset = LEVELS * (threshold(x, y) - 0.5);
    for (channel, toward) in pixel.iter_mut().zip(color) {
        let below = f32::from(*channel);
        *channel = (below + (f32::from(toward) - below) * share + offset * (4.0 * share).min(1.0) + 0.5) as u8;
    }
}

#[inline(always)]
fn mix(pixel: &mut [u8; 4], color: Rgb, share: f32) {
    for (channel, toward) in pixel.iter_mut().zip(color) {
        let below = f32::from(*channel);
        *channel = (below + (f32::from(toward) - below) * share + 0.5) as u8;
    }
}
