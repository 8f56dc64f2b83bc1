//! Nearest of up to 255 colors.

use std::sync::LazyLock;

use crate::color::Rgb;
use crate::oklab::{Lab, lab, squared};

/// Bits per channel of the cells for which the colors that may be nearest are listed.
const BITS: u32 = 5;
/// Bits of the number of colors whose match is remembered.
const REMEMBERED: u32 = 16;

/// Middle of each cell and the distance of its corners.
static CELLS: LazyLock<Vec<(Lab, f32)>> = LazyLock::new(|| {
    let low = |cell: u32| [2, 1, 0].map(|channel| ((cell >> (BITS * channel)) << (8 - BITS)) as u8);
    let side = 0xFF >> BITS;
    let radius = |first: Rgb, middle: Lab| {
        let corner = |corner: u8| std::array::from_fn(|channel| first[channel] + side * (corner >> channel & 1));
        (0..8).map(|number| squared(lab(corner(number)), middle)).fold(0.0, f32::max).sqrt()
    };
    let cell = |first: Rgb| {
        let middle = lab(first.map(|channel| channel + side / 2));
        (middle, radius(first, middle))
    };
    (0..1 << (3 * BITS)).map(|number| cell(low(number))).collect()
});

/// Color with its coordinates, the index of the nearest of some colors, and the squared difference from it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Match {
    pub(crate) lab: Lab,
    pub(crate) index: u8,
    pub(crate) least: f32,
    color: u32,
}

/// Search for the nearest of some colors.
#[derive(Clone, Debug)]
pub(crate) struct NearestColor {
    colors: Vec<Lab>,
    distances: Vec<f32>,
    /// Start and end of the list of each cell; equal if not yet known.
    ranges: Vec<[u32; 2]>,
    lists: Vec<(Lab, u8)>,
    /// Last match of each hash of a color.
    known: Vec<Match>,
}

impl NearestColor {
    /// Search among 1 to 256 colors.
    pub(crate) fn new(colors: Vec<Lab>) -> Self {
        let (distances, ranges, lists) = (vec![0.0; colors.len()], vec![[0; 2]; 1 << (3 * BITS)], Vec::new());
        let known = vec![Match { lab: [0.0; 3], index: 0, least: 0.0, color: u32::MAX }; 1 << REMEMBERED];
        Self { colors, distances, ranges, lists, known }
    }

    /// The colors.
    pub(crate) fn colors(&self) -> &[Lab] {
        &self.colors
    }

    /// Finds the color nearest to a color; the first one of equally near colors.
    #[inline(always)]
    pub(crate) fn find(&mut self, color: Rgb) -> Match {
        let key = u32::from_be_bytes([0, color[0], color[1], color[2]]);
        let slot = (key.wrapping_mul(0x9E37_79B1) >> (32 - REMEMBERED)) as usize;
        if self.known[slot].color != key {
            let lab = lab(color);
            let (index, least) = self.search(color, lab);
            self.known[slot] = Match { lab, index: index as u8, least, color: key };
        }
        self.known[slot]
    }

    /// Index of the nearest color and its squared distance.
    #[inline]
    pub(crate) fn search(&mut self, color: Rgb, coordinates: Lab) -> (usize, f32) {
        let cell = cell(color);
        if self.ranges[cell][0] == self.ranges[cell][1] {
            self.list(cell);
        }
        let [start, end] = self.ranges[cell];
        let mut best = (0, f32::INFINITY);
        for &(other, index) in &self.lists[start as usize..end as usize] {
            let distance = squared(other, coordinates);
            if distance < best.1 {
                best = (usize::from(index), distance);
            }
        }
        best
    }

    /// Lists the colors that may be nearest to a color of a cell: no farther from its middle than the nearest one and its diameter.
    fn list(&mut self, cell: usize) {
        let (middle, radius) = CELLS[cell];
        for (distance, &color) in self.distances.iter_mut().zip(&self.colors) {
            *distance = squared(color, middle);
        }
        let least = self.distances.iter().copied().fold(f32::INFINITY, f32::min);
        let most = (least.sqrt() + 2.0 * radius).powi(2);
        let start = self.lists.len() as u32;
        let near = self.distances.iter().zip(&self.colors).zip(0..=u8::MAX).filter(|((distance, _), _)| **distance <= most);
        self.lists.extend(near.map(|((_, &color), index)| (color, index)));
        self.ranges[cell] = [start, self.lists.len() as u32];
    }
}

/// Cell of a color.
#[inline(always)]
pub(crate) fn cell(color: Rgb) -> usize {
    let [red, green, blue] = color.map(|channel| usize::from(channel >> (8 - BITS)));
    red << (2 * BITS) | green << BITS | blue
}
