//! Color quantization by variance cuts, improved by a few rounds of k-means (Lloyd 1982). A variance cut splits the box with the
//! greatest spread at its mean (after Wu 1991).

use crate::color::Rgb;
use crate::nearest::Centers;

/// Number of k-means rounds. With the film of `benches/film.py`, three rounds gain 0.3 dB, and seven more rounds 0.04 dB.
const ROUNDS: usize = 3;

type Color = [f32; 3];

/// Color and its weight.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WeightedColor {
    color: Color,
    weight: f32,
}

impl WeightedColor {
    /// Weight of a color by area^¾. Least squares would take the area itself, which neglects small bright objects beside a large
    /// dark surface. With `benches/film.py` this weight costs 0.3 dB, and the square root would cost 1.6 dB.
    pub(crate) fn new(color: Rgb, count: u64) -> Self {
        let root = (count as f32).sqrt();
        Self { color: color.map(f32::from), weight: root * root.sqrt() }
    }
}

/// Computes at most `count` colors that minimize the weighted squared distances of the samples.
pub(crate) fn quantize(mut samples: Vec<WeightedColor>, count: usize) -> Vec<Rgb> {
    let mut centers = variance_cut(&mut samples, count);
    for _ in 0..ROUNDS {
        let mut sums = vec![([0.0; 3], 0.0); centers.len()];
        let mut search = Centers::new(&centers);
        for sample in &samples {
            let (sum, weight) = &mut sums[search.nearest(sample.color)];
            (0..3).for_each(|channel| sum[channel] += sample.weight * sample.color[channel]);
            *weight += sample.weight;
        }
        for (center, (sum, weight)) in centers.iter_mut().zip(sums) {
            if weight > 0.0 {
                *center = sum.map(|value: f32| value / weight);
            }
        }
    }
    centers.into_iter().map(|center| center.map(|channel| channel.round() as u8)).collect()
}

/// Divides the samples repeatedly: cuts the part with the greatest spread at the mean of its widest channel. Returns the means of
/// the parts.
fn variance_cut(samples: &mut [WeightedColor], count: usize) -> Vec<Color> {
    if count == 0 {
        return Vec::new();
    }
    let whole = SampleRange::of(samples, 0);
    let mut parts = vec![whole];
    while parts.len() < count {
        let widest = (0..parts.len()).max_by(|&p, &q| parts[p].spread.total_cmp(&parts[q].spread).then(q.cmp(&p)));
        let Some(index) = widest.filter(|&index| parts[index].spread > 0.0) else {
            break;
        };
        let SampleRange { start, length, channel, mean, .. } = parts.swap_remove(index);
        let part = &mut samples[start..start + length];
        part.sort_unstable_by(|p, q| p.color[channel].total_cmp(&q.color[channel]));
        let below = part.partition_point(|sample| sample.color[channel] < mean[channel]).clamp(1, length - 1);
        let (low, high) = part.split_at(below);
        parts.extend([SampleRange::of(low, start), SampleRange::of(high, start + below)]);
    }
    parts.iter().map(|part| part.mean).collect()
}

/// Range of the samples, with its mean color and spread.
struct SampleRange {
    start: usize,
    length: usize,
    mean: Color,
    channel: usize,
    /// Weighted sum of squares along the widest channel.
    spread: f32,
}

impl SampleRange {
    fn of(samples: &[WeightedColor], start: usize) -> Self {
        let total: f32 = samples.iter().map(|sample| sample.weight).sum();
        let mean = [0, 1, 2].map(|channel| samples.iter().map(|s| s.weight * s.color[channel]).sum::<f32>() / total);
        let square = |channel: usize| samples.iter().map(|s| s.weight * (s.color[channel] - mean[channel]).powi(2)).sum::<f32>();
        let squares = [square(0), square(1), square(2)];
        let channel = (0..3).max_by(|&p, &q| squares[p].total_cmp(&squares[q])).unwrap_or(0);
        let spread = if samples.len() > 1 { squares[channel] } else { 0.0 };
        Self { start, length: samples.len(), mean, channel, spread }
    }
}
