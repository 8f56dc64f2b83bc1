//! Color quantization by variance cuts, improved by rounds of k-means (Lloyd 1982). A variance cut splits the box with the
//! greatest spread at its mean (after Wu 1991).

use crate::color::Rgb;
use crate::histogram::ColorSample;
use crate::nearest::NearestColor;
use crate::oklab::{Lab, lab};

/// Number of k-means rounds after the variance cuts.
const ROUNDS: usize = 3;

/// Computes at most `count` colors that minimize the weighted squared differences of the samples from the nearest color, or from
/// a `fixed` one.
pub(crate) fn quantize(samples: &[ColorSample], fixed: &[Rgb], count: usize) -> Vec<Rgb> {
    let mut cut = samples.to_vec();
    let mut colors = variance_cut(&mut cut, count);
    for _ in 0..ROUNDS {
        colors = improve(samples, fixed, &colors).0;
    }
    colors
}

/// Weighted sums of the samples that are nearest to a color.
#[derive(Clone, Copy, Debug, Default)]
struct Cluster {
    weight: f32,
    channels: [f32; 3],
    axes: Lab,
}

/// A round of k-means; returns the new colors, and a bound of the weighted squared differences that they leave. A color that is
/// nearest to no sample becomes that of the sample with the largest error.
pub(crate) fn improve(samples: &[ColorSample], fixed: &[Rgb], colors: &[Rgb]) -> (Vec<Rgb>, f32) {
    let labs: Vec<Lab> = fixed.iter().chain(colors).map(|&color| lab(color)).collect();
    let mut clusters = vec![Cluster::default(); labs.len()];
    let mut errors: Vec<(f32, u32)> = Vec::with_capacity(samples.len());
    let mut left = 0.0;
    let mut search = NearestColor::new(labs);
    for (sample, number) in samples.iter().zip(0..) {
        let (nearest, error) = search.search(sample.color, sample.lab);
        let cluster = &mut clusters[nearest];
        cluster.weight += sample.weight;
        for axis in 0..3 {
            cluster.channels[axis] += sample.weight * f32::from(sample.color[axis]);
            cluster.axes[axis] += sample.weight * sample.lab[axis];
        }
        left += sample.weight * error;
        errors.push((sample.weight * error, number));
    }
    let unused = clusters[fixed.len()..].iter().filter(|cluster| cluster.weight == 0.0).count().min(errors.len());
    let by_error = |p: &(f32, u32), q: &(f32, u32)| q.0.total_cmp(&p.0).then(p.1.cmp(&q.1));
    if (1..errors.len()).contains(&unused) {
        errors.select_nth_unstable_by(unused, by_error);
    }
    errors.truncate(unused);
    errors.sort_unstable_by(by_error);
    let mut worst = errors.into_iter().filter(|&(error, _)| error > 0.0);
    let mut moved = Vec::with_capacity(colors.len());
    for (index, &color) in colors.iter().enumerate() {
        let Cluster { weight, channels, axes } = clusters[fixed.len() + index];
        if weight > 0.0 {
            // By the parallel axis theorem, the squares about the mean are less by the square of its shift.
            let before = search.colors()[fixed.len() + index];
            left -= (0..3).map(|axis| (axes[axis] - weight * before[axis]).powi(2)).sum::<f32>() / weight;
            moved.push(channels.map(|sum| (sum / weight + 0.5) as u8));
        } else if let Some((error, number)) = worst.next() {
            left -= error;
            moved.push(samples[number as usize].color);
        } else {
            moved.push(color);
        }
    }
    (moved, left)
}

/// Divides the samples repeatedly: cuts the part with the greatest spread at the mean of its widest coordinate. Returns the mean
/// colors of the parts.
fn variance_cut(samples: &mut [ColorSample], count: usize) -> Vec<Rgb> {
    if count == 0 || samples.is_empty() {
        return Vec::new();
    }
    let whole = SampleRange::of(samples, 0);
    let mut parts = vec![whole];
    while parts.len() < count {
        let widest = (0..parts.len()).max_by(|&p, &q| parts[p].spread.total_cmp(&parts[q].spread).then(q.cmp(&p)));
        let Some(index) = widest.filter(|&index| parts[index].spread > 0.0) else {
            break;
        };
        let SampleRange { start, length, axis, mean, .. } = parts.swap_remove(index);
        let part = &mut samples[start..start + length];
        part.sort_unstable_by(|p, q| p.lab[axis].total_cmp(&q.lab[axis]).then(p.color.cmp(&q.color)));
        let below = part.partition_point(|sample| sample.lab[axis] < mean[axis]).clamp(1, length - 1);
        let (low, high) = part.split_at(below);
        parts.extend([SampleRange::of(low, start), SampleRange::of(high, start + below)]);
    }
    parts.iter().map(|part| mean_color(&samples[part.start..part.start + part.length])).collect()
}

fn mean_color(samples: &[ColorSample]) -> Rgb {
    let total: f32 = samples.iter().map(|sample| sample.weight).sum();
    let sum = |channel: usize| samples.iter().map(|s| s.weight * f32::from(s.color[channel])).sum::<f32>();
    [0, 1, 2].map(|channel| (sum(channel) / total + 0.5) as u8)
}

/// Range of the samples, with its mean and spread.
struct SampleRange {
    start: usize,
    length: usize,
    mean: Lab,
    axis: usize,
    /// Weighted sum of squares along the widest axis.
    spread: f32,
}

impl SampleRange {
    fn of(samples: &[ColorSample], start: usize) -> Self {
        let total: f32 = samples.iter().map(|sample| sample.weight).sum();
        let mean = [0, 1, 2].map(|axis| samples.iter().map(|s| s.weight * s.lab[axis]).sum::<f32>() / total);
        let square = |axis: usize| samples.iter().map(|s| s.weight * (s.lab[axis] - mean[axis]).powi(2)).sum::<f32>();
        let squares = [square(0), square(1), square(2)];
        let axis = (0..3).max_by(|&p, &q| squares[p].total_cmp(&squares[q])).unwrap_or(0);
        let spread = if samples.len() > 1 { squares[axis] } else { 0.0 };
        Self { start, length: samples.len(), mean, axis, spread }
    }
}
