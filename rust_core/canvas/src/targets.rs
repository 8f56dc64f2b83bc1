//! Colors wanted at the pixels of a frame, given the previous frame as it was drawn and as it is on the screen.

use crate::difference::Patch;
use crate::histogram::{Histogram, is_flat};
use crate::lossy::Target;
use crate::lzw::TRANSPARENT;
use crate::math::threshold;
use crate::nearest::Match;
use crate::oklab::{Lab, squared};
use crate::palette::Palette;
use crate::visibility::Visibility;

/// Cost up to which a pixel at the rim of a frame's changes is left as it is [codes].
const RIM: f32 = 0.25;
/// Difference of neighboring palette colors whose border is seen on smooth shading: just noticeable is 0.02 of white [levels].
const BAND: f32 = 0.02 * 255.0;
/// Variance of the brightness up to which shading is smooth [levels²].
const SMOOTH: f32 = 60.0;
/// One pixel of this many is counted for the palette of a frame, and the shift of these pixels from row to row.
pub(crate) const SHARE: usize = 4;
const SHEAR: usize = 2;

/// Screen of a film between two frames.
#[derive(Clone, Debug, Default)]
pub(crate) struct Screen {
    width: usize,
    /// Last frame as it was drawn; empty before the first.
    drawn: Vec<[u8; 4]>,
    /// Colors on the screen.
    shown: Vec<Lab>,
    visibility: Visibility,
}

impl Screen {
    pub(crate) fn new(width: usize) -> Self {
        Self { width, ..Self::default() }
    }

    /// Rectangle of all pixels that are drawn otherwise than in the last frame, if any.
    pub(crate) fn changed(&self, pixels: &[[u8; 4]]) -> Option<Patch> {
        if self.drawn.is_empty() {
            return Some(Patch { left: 0, top: 0, width: self.width, height: pixels.len() / self.width });
        }
        Patch::between(&self.drawn, pixels, self.width)
    }

    /// Fills a histogram with the colors that have changed.
    pub(crate) fn observe(&mut self, pixels: &[[u8; 4]], histogram: &mut Histogram) {
        self.visibility.look(pixels, self.width);
        histogram.clear();
        let (drawn, width) = (&self.drawn, self.width);
        let differs = |index: usize| drawn.get(index) != Some(&pixels[index]);
        histogram.count(pixels, width, &self.visibility, |column, row| {
            (column + row * SHEAR).is_multiple_of(SHARE) && differs(row * width + column)
        });
    }

    /// Writes the targets of a patch to `targets`; returns the part of the patch that must be stored. An error of `tolerance`
    /// levels costs one code. Pixels that are drawn as in the last frame stay as they are on the screen.
    pub(crate) fn targets(
        &mut self,
        pixels: &[[u8; 4]],
        patch: Patch,
        palette: &mut Palette,
        tolerance: f32,
        targets: &mut Vec<Target>,
    ) -> Patch {
        targets.clear();
        let (price, most) = if tolerance > 0.0 { (1.0 / (tolerance * tolerance), 1.0) } else { (1.0, 0.0) };
        for row in patch.top..patch.top + patch.height {
            for column in patch.left..patch.left + patch.width {
                let index = row * self.width + column;
                let (pixel, before) = (pixels[index], self.drawn.get(index));
                if before == Some(&pixel) {
                    targets.push(Target::REST);
                    continue;
                }
                let color = [pixel[0], pixel[1], pixel[2]];
                let Match { mut lab, index: nearest, mut least, .. } = palette.nearest(color);
                let mut nearest = nearest + 1;
                let exact = least == 0.0 && palette.is_fixed(nearest);
                if least > 0.0 && self.visibility.variance(column, row) < SMOOTH && !is_flat(pixels, self.width, column, row) {
                    nearest = palette.dithered(lab, nearest, BAND, threshold(column as u32, row as u32));
                    (lab, least) = (palette.lab(nearest), 0.0);
                }
                let most = if exact { 0.0 } else { most };
                let price = price * self.visibility.weight(column, row);
                let keep = before.map_or(f32::INFINITY, |_| price * (squared(lab, self.shown[index]) - least));
                let keep = if keep <= most { keep } else { f32::INFINITY };
                targets.push(Target { lab, price, least, keep, most, nearest });
            }
        }
        self.drawn.clear();
        self.drawn.extend_from_slice(pixels);
        self.shown.resize(pixels.len(), [0.0; 3]);
        let stored = patch.within(|column, row| targets[row * patch.width + column].keep > RIM);
        let first = (stored.top - patch.top) * patch.width + stored.left - patch.left;
        for row in 0..stored.height {
            targets.copy_within(first + row * patch.width..first + row * patch.width + stored.width, row * stored.width);
        }
        targets.truncate(stored.width * stored.height);
        stored
    }

    /// Puts the symbols of a patch on the screen.
    pub(crate) fn show(&mut self, patch: Patch, symbols: &[u8], palette: &Palette) {
        let rows = self.shown.chunks_exact_mut(self.width).skip(patch.top);
        for (row, symbols) in rows.zip(symbols.chunks_exact(patch.width)) {
            for (color, &symbol) in row[patch.left..].iter_mut().zip(symbols) {
                if symbol != TRANSPARENT {
                    *color = palette.lab(symbol);
                }
            }
        }
    }
}
