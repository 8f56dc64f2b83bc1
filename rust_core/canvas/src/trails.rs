//! Where things have been: lines that grow thinner, and fade, with age.

use crate::color::{Ink, Rgb};
use crate::shapes::Line;
use crate::view::{Fog, opaque};

/// The last positions of N things at K times, the oldest first.
#[derive(Clone, Copy, Debug)]
pub struct Trails<'a> {
    /// Positions of all things at one time after the other, K·N in all [pixels].
    pub past: &'a [[f32; 2]],
    /// Width of each thing's trail at its fresh end [pixels].
    pub widths: &'a [f32],
    /// Color of each thing's trail at its fresh end.
    pub colors: &'a [Ink],
    /// What trails fade into, and how much of the color is left at the fresh end. They fade by color, not by opacity: where two
    /// opaque lines meet, no joint shows. Without it they only grow thinner, as fits a ground of many colors.
    pub fade: Option<(Rgb, f32)>,
    /// Whether a thing has not gone the straight way from one time to the next, (K−1)·N in all.
    pub gaps: Option<&'a [bool]>,
    /// Depths of all things, K·N in all.
    pub depths: Option<&'a [f32]>,
}

/// A piece of a trail is at least so long, if the trail is [pixels]: nobody sees shorter ones, and half of the lines are saved.
const SHORTEST: f32 = 5.0;

impl Trails<'_> {
    /// The lines with their depths, the oldest first.
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

    /// For each thing at each time how many times ago the line that ends there begins; 0 where none ends. Lines are counted from
    /// the fresh end, so that they move with it.
    fn joints(&self, count: usize, moments: usize) -> Vec<u8> {
        let mut joints = vec![0; self.past.len()];
        for index in 0..count {
            let mut end = moments.saturating_sub(1);
            for step in (1..moments).rev() {
                let before = (step - 1) * count + index;
                if self.gaps.is_some_and(|gaps| gaps[before]) {
                    // The line ends where it was before the gap, and the next one begins there.
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
