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

impl Trails<'_> {
    /// The lines with their depths, the oldest first.
    pub fn lines(&self) -> impl Iterator<Item = (Line, f32)> {
        let count = self.widths.len().max(1);
        let moments = self.past.len() / count;
        (1..moments).flat_map(move |step| {
            let fresh = step as f32 / moments as f32;
            let fade = self.fade.map(|(background, left)| Fog { reach: 1.0, strength: 1.0 - left * fresh, background });
            (0..count).filter_map(move |index| {
                let (before, now) = ((step - 1) * count + index, step * count + index);
                if self.gaps.is_some_and(|gaps| gaps[before]) {
                    return None;
                }
                let (mut color, mut width) = (self.colors[index], self.widths[index] * fresh);
                if let Some(fade) = fade {
                    let [red, green, blue, alpha] = color;
                    let [red, green, blue, _] = opaque(fade.seen([red, green, blue].map(f32::from), 1.0));
                    (color, width) = ([red, green, blue, alpha], width.max(1.0));
                }
                let line = Line { from: self.past[before], to: self.past[now], width, color, softness: 1.0 };
                Some((line, self.depths.map_or(0.0, |depths| depths[now])))
            })
        })
    }
}
