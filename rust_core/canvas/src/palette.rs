//! Palettes of up to 255 colors, chosen in Oklab from the weighted colors of pictures.

use crate::color::Rgb;
use crate::histogram::{ColorSample, Histogram};
use crate::nearest::{Match, NearestColor};
use crate::oklab::{Lab, lab, squared};
use crate::quantize::{improve, quantize};

/// Largest number of flat colors that are kept exactly, as a share of the palette.
const FLAT_SHARE: usize = 4;
/// Least share of a second color in a dithered one: fewer pixels would be single dots.
const LEAST_SHARE: f32 = 0.125;
/// Number of near colors known for each color.
pub(crate) const NEAR: usize = 12;

/// Up to 255 colors, numbered from 1: a GIF's table has 256 entries, one of which is transparent.
#[derive(Clone, Debug)]
pub struct Palette {
    colors: Vec<Rgb>,
    most: usize,
    /// Number of exact colors, which come first.
    fixed: usize,
    search: NearestColor,
    /// Numbers of the nearest colors of each color, itself first.
    near: Vec<[u8; NEAR]>,
}

impl Palette {
    /// Fits a palette of at most `most` colors to a histogram. It contains the `reserved` colors and the flat
    /// colors of the pictures exactly, the latter up to a quarter of the palette. It contains all others exactly if they are few.
    pub fn new(histogram: &Histogram, reserved: &[Rgb], most: u8) -> Self {
        let most = usize::from(most.max(1));
        let mut fixed: Vec<Rgb> = Vec::new();
        for &color in reserved {
            if !fixed.contains(&color) && fixed.len() < most {
                fixed.push(color);
            }
        }
        histogram.add_flats(&mut fixed, most / FLAT_SHARE);
        let samples = histogram.samples();
        let colors = quantize(&samples, &fixed, most - fixed.len());
        Self::of(fixed, colors, most)
    }

    /// Adapts the palette to the colors of a histogram by a round of k-means; returns a bound of its error too.
    pub(crate) fn adapted(&self, histogram: &Histogram, samples: &[ColorSample]) -> (Self, f32) {
        let mut fixed = self.colors[..self.fixed].to_vec();
        histogram.add_flats(&mut fixed, self.most / FLAT_SHARE);
        let mut others: Vec<Rgb> = self.colors[self.fixed..].to_vec();
        others.resize(self.most - fixed.len(), self.colors[0]); // an equal color is nearest to no sample
        let (others, error) = improve(samples, &fixed, &others);
        (Self::of(fixed, others, self.most), error)
    }

    fn of(mut colors: Vec<Rgb>, others: Vec<Rgb>, most: usize) -> Self {
        let fixed = colors.len();
        for color in others {
            if !colors.contains(&color) && colors.len() < most {
                colors.push(color);
            }
        }
        if colors.is_empty() {
            colors.push([0; 3]);
        }
        let labs: Vec<Lab> = colors.iter().map(|&color| lab(color)).collect();
        let near = labs.iter().map(|&color| neighbors(&labs, color)).collect();
        Self { search: NearestColor::new(labs), colors, most, fixed, near }
    }

    /// Colors; the first has number 1.
    pub fn colors(&self) -> &[Rgb] {
        &self.colors
    }

    /// Whether the color with a number is kept exactly wherever it occurs.
    #[inline(always)]
    pub(crate) fn is_fixed(&self, number: u8) -> bool {
        usize::from(number) <= self.fixed
    }

    /// Whether the flat colors of a histogram are kept exactly, as far as a palette has room.
    pub(crate) fn suits(&self, histogram: &Histogram) -> bool {
        let mut fixed = self.colors[..self.fixed].to_vec();
        histogram.add_flats(&mut fixed, self.most / FLAT_SHARE);
        fixed.len() == self.fixed
    }

    /// Coordinates of the color with a number.
    #[inline(always)]
    pub(crate) fn lab(&self, number: u8) -> Lab {
        self.search.colors()[usize::from(number) - 1]
    }

    /// Numbers of the colors nearest to one, itself first; filled up by itself.
    pub(crate) fn near(&self, number: u8) -> &[u8; NEAR] {
        &self.near[usize::from(number) - 1]
    }

    /// Finds the palette color nearest to a color.
    #[inline(always)]
    pub(crate) fn nearest(&mut self, color: Rgb) -> Match {
        self.search.find(color)
    }

    /// Number of the nearest color, or of one on the other side of a color. The mean over all thresholds is about the color. The
    /// nearest one is returned if a neighbor is less than `band` away from it, or if no color is suitable.
    ///
    /// Source: B. Bayer, "An optimum method for two-level rendition of continuous-tone pictures" (1973), applied to two levels
    /// that are searched for each color.
    pub(crate) fn dithered(&self, color: Lab, nearest: u8, band: f32, threshold: f32) -> u8 {
        let near = self.lab(nearest);
        let others = &self.near(nearest)[1..];
        let step = squared(self.lab(others[0]), near);
        if step < band * band {
            return nearest;
        }
        let off: Lab = std::array::from_fn(|axis| color[axis] - near[axis]);
        let error = squared(color, near);
        for &other in others {
            let far = self.lab(other);
            let way: Lab = std::array::from_fn(|axis| far[axis] - near[axis]);
            let along: f32 = way.iter().zip(off).map(|(part, off)| part * off).sum();
            let square = squared(far, near);
            // At most half of the error may remain. A color beyond twice the distance of neighbors would make single dots.
            if along > 0.0 && square <= 4.0 * step && error - along * along / square < 0.25 * error {
                let mixed = along > LEAST_SHARE * square && along > threshold * square;
                return if mixed { other } else { nearest };
            }
        }
        nearest
    }

    /// Sum of the weighted squared differences of the colors of a histogram from the nearest palette color.
    pub(crate) fn error(&mut self, samples: &[ColorSample]) -> f32 {
        samples.iter().map(|sample| sample.weight * self.search.search(sample.color, sample.lab).1).sum()
    }
}

/// Numbers of the colors nearest to one of them, itself first; repeated if there are few.
fn neighbors(colors: &[Lab], own: Lab) -> [u8; NEAR] {
    let mut order: Vec<(f32, u8)> =
        colors.iter().zip(1..=u8::MAX).map(|(&color, number)| (squared(own, color), number)).collect();
    let by_distance = |p: &(f32, u8), q: &(f32, u8)| p.0.total_cmp(&q.0).then(p.1.cmp(&q.1));
    if order.len() > NEAR {
        order.select_nth_unstable_by(NEAR, by_distance);
        order.truncate(NEAR);
    }
    order.sort_unstable_by(by_distance);
    std::array::from_fn(|index| order[index.min(order.len() - 1)].1)
}
