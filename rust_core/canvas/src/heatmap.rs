//! Heatmaps: values on a uniform grid as colors, resampled by a cubic to the pixels of a picture, with isolines and masked cells.

use crate::color::{Ink, Rgb};

/// Values at the cell centers of a grid of `columns` × `rows` cells, and the part of the grid that a picture shows.
#[derive(Clone, Copy, Debug)]
pub struct Samples<'a> {
    /// Values, column by column, each from the lower edge upward.
    pub values: &'a [f64],
    /// Number of cells in the horizontal and vertical direction.
    pub cells: [usize; 2],
    /// Number of pixels in the horizontal and vertical direction.
    pub size: [usize; 2],
    /// Coordinates of the center of the upper left pixel, in cells from the center of the lower left cell.
    pub corner: [f64; 2],
    /// Cells per pixel, above 0.
    pub step: f64,
}

/// Mapping of values to colors.
#[derive(Clone, Copy, Debug)]
pub struct Shading<'a> {
    /// Colors of values from the first to the last of `ends`.
    pub table: &'a [Rgb],
    /// Values of the first and the last color.
    pub ends: [f64; 2],
    /// Distance between isolines, and their ink.
    pub isolines: Option<(f64, Ink)>,
    /// Strength of the light from the upper left on the surface of values; 0 for none.
    pub relief: f32,
}

/// Reach of the cubic kernel [samples].
const REACH: f64 = 2.0;
/// Values that count as zero, relative to the range of colors. Gaussian tails are below: as numbers of f32 they would be subnormal,
/// with which processors compute a hundred times slower.
const NEGLIGIBLE: f64 = 1e-28;
/// Number of output columns whose samples are gathered at once, so whole cache lines are written.
const GROUP: usize = 16;

/// Catmull–Rom cubic, which interpolates the samples.
///
/// Source: R. Keys, "Cubic convolution interpolation for digital image processing", IEEE Trans. ASSP 29, 1153 (1981), a = −1/2.
fn cubic(x: f64) -> f64 {
    let x = x.abs();
    match x {
        ..1.0 => (1.5 * x - 2.5) * x * x + 1.0,
        ..REACH => ((-0.5 * x + 2.5) * x - 4.0) * x + 2.0,
        _ => 0.0,
    }
}

/// Quadratic B-spline. For a mask it is one half on the faces of straight walls, however thin, and smooth along stairs.
fn smooth(x: f64) -> f64 {
    let x = x.abs();
    match x {
        ..0.5 => 0.75 - x * x,
        ..1.5 => 0.5 * (1.5 - x) * (1.5 - x),
        _ => 0.0,
    }
}

/// Weights of the samples in each pixel along one axis. If a pixel spans several samples, the kernel is wider by this factor. The
/// pixel then is a mean of the samples instead of a selection.
struct Weights {
    /// First sample of each pixel.
    first: Vec<usize>,
    /// Weights of the `taps` samples from there on, for each pixel.
    factors: Vec<f32>,
    taps: usize,
}

impl Weights {
    fn new(kernel: fn(f64) -> f64, count: usize, pixels: usize, start: f64, step: f64) -> Self {
        let width = step.abs().max(1.0);
        let taps = ((2.0 * REACH * width).ceil() as usize + 1).min(count);
        let (mut first, mut factors) = (Vec::with_capacity(pixels), vec![0.0; pixels * taps]);
        for (pixel, factors) in factors.chunks_exact_mut(taps).enumerate() {
            let at = start + pixel as f64 * step;
            let lowest = (at - REACH * width).ceil();
            let begin = lowest.clamp(0.0, (count - taps) as f64) as usize;
            let mut sum = 0.0;
            let mut spread = vec![0.0; taps];
            for index in 0..=(2.0 * REACH * width) as usize {
                let place = lowest + index as f64;
                let weight = kernel((place - at) / width);
                sum += weight;
                // Beyond the edges, the outermost samples are continued.
                let sample = place.clamp(0.0, (count - 1) as f64) as usize;
                spread[sample.clamp(begin, begin + taps - 1) - begin] += weight;
            }
            first.push(begin);
            factors.iter_mut().zip(spread).for_each(|(factor, spread)| *factor = (spread / sum) as f32);
        }
        Self { first, factors, taps }
    }

    fn of(&self, pixel: usize) -> (usize, &[f32]) {
        (self.first[pixel], &self.factors[pixel * self.taps..(pixel + 1) * self.taps])
    }
}

impl Samples<'_> {
    /// Values at the pixels, row by row from the top. Values below `least` count as zero.
    fn resampled(&self, kernel: fn(f64) -> f64, least: f64) -> Vec<f32> {
        let ([columns, rows], [width, height], [x, y]) = (self.cells, self.size, self.corner);
        let across = Weights::new(kernel, columns, width, x, self.step);
        let along = Weights::new(kernel, rows, height, y, -self.step);
        // Only visible rows of cells.
        let lowest = along.first.iter().copied().min().unwrap_or(0);
        let highest = along.first.iter().copied().max().unwrap_or(0) + along.taps;
        let seen = highest - lowest;
        let mut wide = vec![0.0_f32; seen * width];
        let mut group = vec![0.0_f32; GROUP * seen];
        for start in (0..width).step_by(GROUP) {
            let count = GROUP.min(width - start);
            for (pixel, sums) in (start..start + count).zip(group.chunks_exact_mut(seen)) {
                sums.fill(0.0);
                let (first, weights) = across.of(pixel);
                for (column, &weight) in (first..).zip(weights) {
                    let cells = &self.values[column * rows + lowest..column * rows + highest];
                    let kept = |value: f64| if value.abs() < least { 0.0 } else { value };
                    sums.iter_mut().zip(cells).for_each(|(sum, &value)| *sum += weight * kept(value) as f32);
                }
            }
            for (row, line) in wide.chunks_exact_mut(width).enumerate() {
                for (index, pixel) in line[start..start + count].iter_mut().enumerate() {
                    *pixel = group[index * seen + row];
                }
            }
        }
        let mut result = vec![0.0_f32; width * height];
        for (pixel, line) in result.chunks_exact_mut(width.max(1)).enumerate() {
            let (first, weights) = along.of(pixel);
            for (row, &weight) in (first - lowest..).zip(weights) {
                line.iter_mut().zip(&wide[row * width..(row + 1) * width]).for_each(|(sum, &value)| *sum += weight * value);
            }
        }
        result
    }
}

/// Coverage of each pixel by cells whose values are 1, not 0: 0–255, row by row from the top.
pub fn coverage(samples: Samples<'_>) -> Vec<u8> {
    // The edge of the smoothed mask is the isoline of one half, one pixel wide.
    let steepness = (1.0 / samples.step).max(1.0) as f32;
    let covered = samples.resampled(smooth, 0.0).into_iter();
    covered.map(|share| (255.0 * ((share - 0.5) * steepness + 0.5).clamp(0.0, 1.0) + 0.5) as u8).collect()
}

/// Pixels of a heatmap, row by row from the top. `walls` is the coverage of pixels by walls, and the ink of walls.
pub fn heatmap(samples: Samples<'_>, shading: &Shading<'_>, walls: Option<(&[u8], Rgb)>) -> Vec<Rgb> {
    let values = samples.resampled(cubic, NEGLIGIBLE * (shading.ends[1] - shading.ends[0]).abs());
    let mut pixels = colors(&values, shading);
    let width = samples.size[0];
    if shading.relief > 0.0 {
        light(&mut pixels, &values, width, shading);
    }
    if let Some((distance, ink)) = shading.isolines {
        draw_isolines(&mut pixels, &values, width, distance, ink);
    }
    if let Some((covered, ink)) = walls {
        let walled = pixels.iter_mut().zip(covered).filter(|(_, covered)| **covered > 0);
        walled.for_each(|(pixel, &covered)| blend(pixel, ink, f32::from(covered) / 255.0));
    }
    pixels
}

/// Colors of values; NaN has the color of the middle.
fn colors(values: &[f32], shading: &Shading<'_>) -> Vec<Rgb> {
    let ([low, high], table) = (shading.ends, shading.table);
    let scale = (table.len() as f64 / (high - low)) as f32;
    let (low, most) = (low as f32, (table.len() - 1) as f32);
    let color = |&value: &f32| {
        let place = (value - low) * scale;
        table[if place.is_nan() { table.len() / 2 } else { place.clamp(0.0, most) as usize }]
    };
    values.iter().map(color).collect()
}

/// Shades the surface of values by light from the upper left: pixels become lighter or darker by the slope along the light.
fn light(pixels: &mut [Rgb], values: &[f32], width: usize, shading: &Shading<'_>) {
    let height = values.len() / width;
    let steepest = shading.relief * 2.0 / (shading.ends[1] - shading.ends[0]) as f32;
    for row in 0..height {
        let (above, below) = (row.saturating_sub(1) * width, (row + 1).min(height - 1) * width);
        for column in 0..width {
            let (left, right) = (column.saturating_sub(1), (column + 1).min(width - 1));
            let down = values[below + right] - values[above + left];
            let light = (steepest * down * width as f32 / 64.0).clamp(-1.0, 1.0);
            let (toward, share) = if light < 0.0 { ([0; 3], -0.6 * light) } else { ([255; 3], 0.45 * light) };
            blend(&mut pixels[row * width + column], toward, share);
        }
    }
}

/// Draws lines one pixel wide where values are nonzero multiples of a distance.
fn draw_isolines(pixels: &mut [Rgb], values: &[f32], width: usize, distance: f64, ink: Ink) {
    let height = values.len() / width;
    let (per_line, strength) = ((1.0 / distance) as f32, f32::from(ink[3]) / 255.0);
    for row in 0..height {
        let (above, below) = (row.saturating_sub(1) * width, (row + 1).min(height - 1) * width);
        for column in 0..width {
            let (left, right) = (column.saturating_sub(1), (column + 1).min(width - 1));
            let value = values[row * width + column] * per_line;
            let nearest = value.round();
            let slope =
                [values[row * width + right] - values[row * width + left], values[below + column] - values[above + column]];
            let steep = 0.5 * per_line * slope[0].hypot(slope[1]);
            if nearest != 0.0 && steep > 0.0 {
                // Distance from the line in pixels, from the slope.
                let away = (value - nearest).abs() / steep;
                let thinned = (1.0 / (4.0 * steep)).min(1.0);
                blend(&mut pixels[row * width + column], [ink[0], ink[1], ink[2]], strength * thinned * (1.0 - away).max(0.0));
            }
        }
    }
}

fn blend(pixel: &mut Rgb, color: Rgb, share: f32) {
    for (channel, toward) in pixel.iter_mut().zip(color) {
        *channel = (f32::from(*channel) + (f32::from(toward) - f32::from(*channel)) * share + 0.5) as u8;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRAY: [Rgb; 3] = [[0; 3], [100; 3], [200; 3]];

    fn plain(table: &[Rgb]) -> Shading<'_> {
        Shading { table, ends: [-1.0, 1.0], isolines: None, relief: 0.0 }
    }

    /// Samples of x + 10 y on 8 × 6 cells, shown in `size` pixels.
    fn slope(values: &[f64], size: [usize; 2], corner: [f64; 2], step: f64) -> Samples<'_> {
        Samples { values, cells: [8, 6], size, corner, step }
    }

    fn plane() -> Vec<f64> {
        (0..8).flat_map(|column| (0..6).map(move |row| f64::from(column) + 10.0 * f64::from(row))).collect()
    }

    #[test]
    fn negligible_values_become_zero_and_no_subnormal_numbers() {
        let values: Vec<f64> = (0..48).map(|cell| if cell < 24 { 1e-40 } else { 1.0 }).collect();
        let tail = slope(&values, [8, 6], [0.0, 5.0], 1.0).resampled(cubic, NEGLIGIBLE);
        assert!(tail.iter().all(|value| *value == 0.0 || value.is_normal()), "{tail:?}");
        assert!(tail.contains(&1.0));
    }

    #[test]
    fn cells_are_upright_and_a_plane_stays_a_plane() {
        let values = plane();
        let seen = slope(&values, [8, 6], [0.0, 5.0], 1.0).resampled(cubic, 0.0);
        assert_eq!((seen[0], seen[7], seen[40], seen[47]), (50.0, 57.0, 0.0, 7.0));
        let fine = slope(&values, [9, 5], [3.0, 3.0], 0.25).resampled(cubic, 0.0);
        for (index, value) in fine.iter().enumerate() {
            let (x, y) = (3.0 + 0.25 * (index % 9) as f32, 3.0 - 0.25 * (index / 9) as f32);
            assert!((value - x - 10.0 * y).abs() < 1e-4, "{index}: {value}");
        }
    }

    #[test]
    fn coarse_pixels_are_means_of_their_cells() {
        let checkered: Vec<f64> = (0..64 * 64).map(|index| f64::from((index / 64 + index) % 2)).collect();
        let samples = Samples { values: &checkered, cells: [64, 64], size: [4, 4], corner: [19.5, 43.5], step: 8.0 };
        assert!(samples.resampled(cubic, 0.0).iter().all(|value| (value - 0.5).abs() < 1e-3));
    }

    #[test]
    fn values_have_the_colors_of_the_table() {
        let values = [-9.0, -1.0, 0.0, 0.99, 9.0, f64::NAN];
        let values: Vec<f32> = values.iter().map(|&value| value as f32).collect();
        let gray = |rgb: Rgb| rgb[0];
        let found: Vec<u8> = colors(&values, &plain(&GRAY)).into_iter().map(gray).collect();
        assert_eq!(found, [0, 0, 100, 200, 200, 100]);
    }

    #[test]
    fn walls_are_as_wide_as_their_cells() {
        let (values, mut mask) = (vec![0.0; 48], vec![0.0; 48]);
        mask[3 * 6..4 * 6].fill(1.0);
        let samples = slope(&values, [80, 60], [-0.45, 5.45], 0.1);
        let covered = coverage(Samples { values: &mask, ..samples });
        let pixels = heatmap(samples, &plain(&GRAY), Some((&covered, [255; 3])));
        let row: Vec<u8> = pixels[30 * 80..31 * 80].iter().map(|pixel| pixel[0]).collect();
        assert_eq!(row.iter().filter(|&&value| value > 200).count(), 10);
        assert_eq!((row[28], row[35], row[41]), (100, 255, 100));
    }

    #[test]
    fn isolines_stand_where_values_are_multiples() {
        let values: Vec<f64> = (0..48).map(|index| f64::from(index / 6) / 4.0).collect();
        let shading = Shading { isolines: Some((0.5, [255, 0, 0, 255])), ..plain(&GRAY) };
        let pixels = heatmap(slope(&values, [71, 1], [0.0, 2.0], 0.1), &shading, None);
        let red: Vec<usize> = (0..71).filter(|&column| pixels[column][0] > 230).collect();
        assert_eq!(red, [20, 40, 60]);
    }
}
