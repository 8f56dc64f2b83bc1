//! Trails of moving points: lines that taper and fade with age.

use crate::color::{Ink, Rgb};
use crate::ink::Mixing;
use crate::shapes::Line;
use crate::view::{Fog, opaque};

/// Last positions of N points at K times, the oldest first.
#[derive(Clone, Copy, Debug)]
pub struct Trails<'a> {
    /// Positions of all points, time by time, K·N in total [pixels].
    pub past: &'a [[f32; 2]],
    /// Width of each point's trail at its fresh end [pixels].
    pub widths: &'a [f32],
    /// Color of each point's trail at its fresh end.
    pub colors: &'a [Ink],
    /// Background into which trails fade, and the fraction of color left at the fresh end. Trails fade by color, not by opacity,
    /// so the joints of opaque lines do not show. They only add light to the background, or subtract it on a light ground, so a
    /// faint end does not cover other shapes. With None, trails only taper, as suits a multicolored background.
    pub fade: Option<(Rgb, f32)>,
    /// Whether the path of a point between two times is not straight, (K−1)·N in total.
    pub gaps: Option<&'a [bool]>,
    /// Depths of all points, K·N in total.
    pub depths: Option<&'a [f32]>,
}

/// Minimum length of a segment, if the trail is long enough [pixels]. Shorter segments are not visible, and omitting them saves
/// half of the lines.
const SHORTEST: f32 = 5.0;

impl Trails<'_> {
    /// Blending mode of the lines.
    pub fn mixing(&self) -> Mixing {
        const MIDDLE: u32 = 384; // of the sum of the three channels
        match self.fade {
            None => Mixing::Over,
            Some((ground, _)) if ground.map(u32::from).iter().sum::<u32>() > MIDDLE => Mixing::Darker,
            Some(_) => Mixing::Lighter,
        }
    }

    /// Lines with their depths, the oldest first.
    pub fn lines(&self) -> impl Iterator<Item = (Line, f32)> {
        let count = self.widths.len().max(1);
        let moments = self.past.len() / count;
        let joints = self.joints(count, moments);
        (1..moments).flat_map(move |step| {
            let fresh = step as f32 / moments as f32;
            let fade = self.fade.map(|(background, left)| Fog { reach: 1.0, strength: 1.0 - left * fresh, background });
            let joints = joints[step * count..][..count].to_vec();
            joints.into_iter().enumerate().filter(|(_, back)| *back > 0).map(move |(index, back)| {
                let now = step * count + index;
                let (mut color, mut width) = (self.colors[index], self.widths[index] * fresh);
                if let Some(fade) = fade {
                    let [red, green, blue, alpha] = color;
                    let [red, green, blue, _] = opaque(fade.seen([red, green, blue].map(f32::from), 1.0));
                    (color, width) = ([red, green, blue, alpha], width.max(1.0));
                }
                let from = self.past[now - usize::from(back) * count];
                let line = Line { from, to: self.past[now], width, color, softness: 1.0 };
                (line, self.depths.map_or(0.0, |depths| depths[now]))
            })
        })
    }

    /// Number of times since the start of the line that ends there, for each point and time; 0 if none ends. Lines are counted
    /// from the fresh end, so they move with it.
    fn joints(&self, count: usize, moments: usize) -> Vec<u8> {
        let mut joints = vec![0; self.past.len()];
        for index in 0..count {
            let mut end = moments.saturating_sub(1);
            for step in (1..moments).rev() {
                let before = (step - 1) * count + index;
                if self.gaps.is_some_and(|gaps| gaps[before]) {
                    // The line ends before the gap, and the next one begins there.
                    joints[end * count + index] = (end - step) as u8;
                    end = step - 1;
                    continue;
                }
                let ([x0, y0], [x1, y1]) = (self.past[before], self.past[end * count + index]);
                let square = (x1 - x0) * (x1 - x0) + (y1 - y0) * (y1 - y0);
                let steps = end + 1 - step;
                if square >= SHORTEST * SHORTEST || step == 1 || steps == usize::from(u8::MAX) {
                    joints[end * count + index] = steps as u8;
                    end = step - 1;
                }
            }
        }
        joints
    }
}
