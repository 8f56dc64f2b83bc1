//! Smoothing of planes of values, row by row: box means, and a filter that does not reach across steps.

/// Box means of values over `reach` neighbors on each side, along rows and then along columns, and once more. `other` is a buffer.
pub(crate) fn blur_plane(values: &mut [f32], other: &mut Vec<f32>, width: usize, reach: usize) {
    let height = values.len() / width.max(1);
    other.resize(values.len(), 0.0);
    for _ in 0..2 {
        for row in 0..height {
            blur(&values[row * width..], &mut other[row * width..], width, 1, reach);
        }
        for column in 0..width {
            blur(&other[column..], &mut values[column..], height, width, reach);
        }
    }
}

/// Box means over `reach` neighbors in a row of `count` values, which are `stride` apart; the end values are continued.
fn blur(from: &[f32], to: &mut [f32], count: usize, stride: usize, reach: usize) {
    let share = 1.0 / (2 * reach + 1) as f32;
    let at = |index: usize| from[index.saturating_sub(reach).min(count - 1) * stride];
    let mut sum: f32 = (0..2 * reach).map(at).sum();
    for index in 0..count {
        sum += at(index + 2 * reach);
        to[index * stride] = sum * share;
        sum -= at(index);
    }
}

/// One pass of an edge-avoiding filter, over the eight neighbors `step` pixels away. The weights decrease to zero for values that
/// differ by a range. Passes with steps that are halved, down to one pixel, smooth over twice the first step, alike in all
/// directions. Filters along rows and columns in turn leave streaks at depth steps.
///
/// Source: H. Dammertz, D. Sewtz, J. Hanika and H. Lensch, "Edge-avoiding À-trous wavelet transform for fast global illumination
/// filtering" (2010).
pub(crate) fn avoid_edges(plane: &mut [f32], width: usize, step: usize, range: f32, scratch: &mut [Vec<f32>; 3]) {
    let [sums, totals, before] = scratch;
    let height = plane.len() / width.max(1);
    before.clear();
    before.extend_from_slice(plane);
    sums.resize(width, 0.0);
    totals.resize(width, 0.0);
    let (shift, rest) = (step.min(width), width - step.min(width));
    for (row, line) in plane.chunks_exact_mut(width).enumerate() {
        let here = &before[row * width..(row + 1) * width];
        sums.copy_from_slice(here);
        totals.fill(1.0);
        let rows = [(Some(row), 1.0), (row.checked_sub(step), 0.5), (Some(row + step).filter(|&other| other < height), 0.5)];
        for (other, weight) in rows.into_iter().filter_map(|(other, weight)| other.map(|other| (other, weight))) {
            let there = &before[other * width..(other + 1) * width];
            if other != row {
                gather(sums, totals, here, there, weight, range);
            }
            gather(&mut sums[..rest], &mut totals[..rest], &here[..rest], &there[shift..], 0.5 * weight, range);
            gather(&mut sums[shift..], &mut totals[shift..], &here[shift..], &there[..rest], 0.5 * weight, range);
        }
        for ((depth, sum), total) in line.iter_mut().zip(sums.iter()).zip(totals.iter()) {
            *depth = sum / total;
        }
    }
}

/// Adds neighbors within a depth range.
fn gather(sums: &mut [f32], totals: &mut [f32], here: &[f32], there: &[f32], weight: f32, range: f32) {
    for (((sum, total), here), there) in sums.iter_mut().zip(totals).zip(here).zip(there) {
        let difference = (there - here) / range;
        let near = (1.0 - difference * difference).max(0.0);
        let share = weight * near * near;
        *sum += share * there;
        *total += share;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIDE: usize = 24;

    /// A step along the diagonal of 10 and noise of up to 1, filtered with a range of 5. Values on both sides stay within the
    /// noise, which becomes less, and rows are filtered as columns are, up to rounding.
    #[test]
    fn noise_is_smoothed_alike_along_rows_and_columns_and_steps_stay() {
        let noise = |index: usize| (index * 7919 % 101) as f32 / 100.0;
        let step = |pixel: usize| if pixel / SIDE > pixel % SIDE { 10.0 } else { 0.0 };
        let transposed =
            |plane: &[f32]| (0..SIDE * SIDE).map(|pixel| plane[pixel % SIDE * SIDE + pixel / SIDE]).collect::<Vec<_>>();
        let filtered = |mut plane: Vec<f32>| {
            let mut scratch = Default::default();
            for width in [4, 2, 1] {
                avoid_edges(&mut plane, SIDE, width, 5.0, &mut scratch);
            }
            plane
        };
        let plane: Vec<f32> = (0..SIDE * SIDE).map(|pixel| step(pixel) + noise(pixel)).collect();
        let (found, turned) = (filtered(plane.clone()), transposed(&filtered(transposed(&plane))));
        let variance =
            |plane: &[f32]| plane.iter().enumerate().map(|(pixel, value)| (value - step(pixel) - 0.5).powi(2)).sum::<f32>();
        assert!(found.iter().enumerate().all(|(pixel, value)| (0.0..=1.0).contains(&(value - step(pixel)))));
        assert!(variance(&found) < 0.2 * variance(&plane), "{} {}", variance(&found), variance(&plane));
        assert!(found.iter().zip(&turned).all(|(one, other)| (one - other).abs() < 1e-4));
    }
}
