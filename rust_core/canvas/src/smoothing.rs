//! Smoothing of planes of values, row by row: box means, and a filter that does not reach across steps.

/// Box means of values over `reach` neighbors on each side, along rows and then along columns. `other` is a buffer of equal size.
pub(crate) fn blur_plane(values: &mut [f32], other: &mut [f32], width: usize, reach: usize) {
    let height = values.len() / width.max(1);
    for row in 0..height {
        blur(&values[row * width..], &mut other[row * width..], width, 1, reach);
    }
    for column in 0..width {
        blur(&other[column..], &mut values[column..], height, width, reach);
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

/// One pass of a narrow-range filter, along rows or along columns. The weights depend on the distance, and values that differ by
/// more than a range are excluded.
///
/// Source: N. Truong and C. Yuksel, "A narrow-range filter for screen-space fluid rendering" (2018).
pub(crate) fn narrow_range(
    plane: &mut [f32],
    width: usize,
    level: bool,
    weights: &[f32],
    range: f32,
    scratch: &mut [Vec<f32>; 3],
) {
    let [sums, totals, before] = scratch;
    let count = plane.len() / width.max(1);
    before.clear();
    before.extend_from_slice(plane);
    sums.resize(width, 0.0);
    totals.resize(width, 0.0);
    for (row, line) in plane.chunks_exact_mut(width).enumerate() {
        let here = &before[row * width..(row + 1) * width];
        sums.iter_mut().zip(here).for_each(|(sum, depth)| *sum = depth * weights[0]);
        totals.fill(weights[0]);
        for (tap, &weight) in weights.iter().enumerate().skip(1) {
            if level {
                let rest = width.saturating_sub(tap);
                let shift = width - rest;
                gather(&mut sums[..rest], &mut totals[..rest], &here[..rest], &here[shift..], weight, range);
                gather(&mut sums[shift..], &mut totals[shift..], &here[shift..], &here[..rest], weight, range);
            } else {
                for other in [row.checked_add(tap).filter(|&other| other < count), row.checked_sub(tap)].into_iter().flatten() {
                    gather(sums, totals, here, &before[other * width..(other + 1) * width], weight, range);
                }
            }
        }
        for ((depth, sum), total) in line.iter_mut().zip(sums.iter()).zip(totals.iter()) {
            *depth = sum / total;
        }
    }
}

/// Adds neighbors within a depth range, with equal weights.
fn gather(sums: &mut [f32], totals: &mut [f32], here: &[f32], there: &[f32], weight: f32, range: f32) {
    for (((sum, total), here), there) in sums.iter_mut().zip(totals).zip(here).zip(there) {
        let share = if (there - here).abs() < range { weight } else { 0.0 };
        *sum += share * there;
        *total += share;
    }
}
