//! Level ground and a backdrop, behind everything else in space.

use crate::canvas::Canvas;
use crate::color::Rgb;
use crate::eye::{Eye, at_center};
use crate::math::{cross, dot, minus, plus, threshold};

/// Ground: a plane that is lit around a center and fades into the background.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// Unit normal: right, up, toward the eye.
    pub normal: [f32; 3],
    /// Brightest point of the plane, relative to the focus, in the same axes.
    pub center: [f32; 3],
    /// Distance from the center at which half of the color is left.
    pub size: f32,
    /// Color at the center.
    pub color: Rgb,
    /// Color of the grid, distance of its lines, and their opacity at the center. Lines run along `along` and across it.
    pub grid: Option<(Rgb, f32, f32)>,
    /// Direction of half of the lines.
    pub along: [f32; 3],
    /// Visible part of the plane, as of a wall: corners in order [pixels], and uniform opacity. None for the whole plane, which
    /// fades with the distance.
    pub part: Option<([[f32; 2]; 4], f32)>,
}

impl Canvas {
    /// Lightens the background toward a point by a share of the way to a color, at once and everywhere in the clip.
    pub fn backdrop(&mut self, center: [f32; 2], radius: f32, color: Rgb, share: f32) {
        let times = self.samples() as f32;
        let (center, radius) = (center.map(|place| times * place), times * radius);
        self.each(|pixel, [x, y], _| {
            let square = ((x - center[0]) * (x - center[0]) + (y - center[1]) * (y - center[1])) / (radius * radius);
            mix_evenly(pixel, color, share / ((1.0 + square) * (1.0 + square)), [x / times, y / times]);
        });
    }

    /// Draws ground at once, with its depth. No effect without an eye, or if the eye is below the ground.
    pub fn ground(&mut self, ground: &Ground) {
        let Some(eye) = self.eye() else {
            return;
        };
        let times = self.samples() as f32;
        let axes = [ground.along, cross(ground.normal, ground.along)];
        // Position seen at a pixel, and its coordinates on the plane.
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
                        // Width of a pixel of the reduced picture on the plane, across the lines.
                        let wide = (right[axis] - at[axis]).hypot(below[axis] - at[axis]) / pitch;
                        let away = (at[axis] / pitch - (at[axis] / pitch).round()).abs();
                        // Lines closer together than pixels merge to a gray.
                        let line = (1.2 - away / wide.max(1e-9)).clamp(0.0, 1.0) * (0.25 / wide.max(1e-9)).min(1.0);
                        covered = covered.max(line);
                    }
                    mix(pixel, color, opacity * covered * lit * lit);
                }
            }
            *depth = at_center(-place[2]);
        });
    }

    /// Visits each pixel of the clip, with its center and its depth.
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

/// Whether a point lies in a convex polygon with corners in either order.
fn surrounds(corners: &[[f32; 2]; 4], [x, y]: [f32; 2]) -> bool {
    let turn = |index: usize| {
        let ([x0, y0], [x1, y1]) = (corners[index], corners[(index + 1) % 4]);
        (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0)
    };
    (0..4).all(|index| turn(index) >= 0.0) || (0..4).all(|index| turn(index) <= 0.0)
}

/// Intersection of the ray through a pixel with the ground, if it is in front of the eye and hit from above.
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

/// Mixes a color into a pixel with an ordered dither of one level: dark gradients would show steps even of single levels.
#[inline(always)]
fn mix_evenly(pixel: &mut [u8; 4], color: Rgb, share: f32, center: [f32; 2]) {
    let [x, y] = center.map(|coordinate| coordinate as u32);
    let offset = threshold(x, y) - 0.5;
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
