//! Cubic splines: curves through points, with continuous first and second derivatives.
//!
//! The parameter u is the length of the polygon through the points. Between the points at uᵢ and uᵢ + hᵢ the curve is the
//! cubic with the slopes mᵢ and mᵢ₊₁ there. With δᵢ = (pᵢ₊₁ − pᵢ)/hᵢ, the second derivatives are continuous if
//!
//!     hᵢ mᵢ₋₁ + 2 (hᵢ₋₁ + hᵢ) mᵢ + hᵢ₋₁ mᵢ₊₁ = 3 (hᵢ δᵢ₋₁ + hᵢ₋₁ δᵢ)
//!
//! A closed curve has such an equation at each point. An open one has one cubic over the first two intervals, and one over
//! the last two (not-a-knot). Through two points it is a line, through three a parabola. Source: C. de Boor, "A Practical
//! Guide to Splines", 1978, chapter IV.

use glam::DVec3;

/// Number of samples per interval in the search for the nearest point.
const SAMPLES: u32 = 16;
/// Maximum number of halvings of an interval that contains the nearest point.
const HALVINGS: usize = 60;

/// Cubic spline through points.
#[derive(Debug, Clone)]
pub struct CubicSpline {
    /// Parameters of the points; one more than intervals.
    knots: Vec<f64>,
    points: Vec<DVec3>,
    slopes: Vec<DVec3>,
    closed: bool,
    /// Points that divide the intervals.
    samples: Vec<CurveSample>,
}

/// Point of a curve for searches.
#[derive(Debug, Clone, Copy)]
struct CurveSample {
    place: f64,
    position: DVec3,
}

/// Point of a curve, with the derivatives by the parameter.
#[derive(Debug, Clone, Copy)]
pub struct CurvePoint {
    /// Position.
    pub position: DVec3,
    /// First derivative.
    pub first: DVec3,
    /// Second derivative.
    pub second: DVec3,
}

impl CurvePoint {
    /// Unit tangent; 0 at a cusp.
    pub fn tangent(&self) -> DVec3 {
        self.first.normalize_or_zero()
    }

    /// Curvature vector, towards the center of curvature [1/m].
    pub fn curvature(&self) -> DVec3 {
        let tangent = self.tangent();
        (self.second - self.second.dot(tangent) * tangent) / self.first.length_squared()
    }
}

impl CubicSpline {
    /// Spline through at least two points, or three if it is closed. Consecutive points differ.
    pub fn through(points: &[DVec3], closed: bool) -> Self {
        let mut points = points.to_vec();
        if closed {
            points.push(points[0]);
        }
        let lengths: Vec<f64> = points.windows(2).map(|ends| (ends[1] - ends[0]).length()).collect();
        let rates: Vec<DVec3> = points.windows(2).zip(&lengths).map(|(ends, h)| (ends[1] - ends[0]) / *h).collect();
        let slopes = if closed { closed_slopes(&lengths, &rates) } else { open_slopes(&lengths, &rates) };
        let mut knots = vec![0.0];
        lengths.iter().for_each(|h| knots.push(knots[knots.len() - 1] + h));
        let mut spline = Self { knots, points, slopes, closed, samples: Vec::new() };
        let sample = |place: f64| CurveSample { place, position: spline.at(place).position };
        spline.samples = spline.divided(SAMPLES).into_iter().map(sample).collect();
        spline
    }

    /// Largest parameter, the length of the polygon through the points [m].
    pub fn end(&self) -> f64 {
        self.knots[self.knots.len() - 1]
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        let points = size_of_val(self.points.as_slice()) + size_of_val(self.slopes.as_slice());
        size_of_val(self.knots.as_slice()) + points + size_of_val(self.samples.as_slice())
    }

    /// Parameter of the same point within the curve; None beyond the ends of an open curve.
    pub fn within(&self, u: f64) -> Option<f64> {
        if self.closed { Some(u.rem_euclid(self.end())) } else { (0.0..=self.end()).contains(&u).then_some(u) }
    }

    /// Point at a parameter. Beyond the ends of an open curve, the last cubic goes on.
    pub fn at(&self, u: f64) -> CurvePoint {
        let u = if self.closed { u.rem_euclid(self.end()) } else { u };
        let interval = self.knots.partition_point(|&knot| knot <= u).clamp(1, self.knots.len() - 1) - 1;
        let (h, [one, other]) = (self.knots[interval + 1] - self.knots[interval], [interval, interval + 1]);
        let (t, rate) = ((u - self.knots[interval]) / h, (self.points[other] - self.points[one]) / h);
        let [start, end] = [self.slopes[one], self.slopes[other]];
        // p + h t (m + t (3δ − 2m − m′ + t (m + m′ − 2δ)))
        let (square, cube) = (3.0 * rate - 2.0 * start - end, start + end - 2.0 * rate);
        CurvePoint {
            position: self.points[one] + h * t * (start + t * (square + t * cube)),
            first: start + t * (2.0 * square + 3.0 * t * cube),
            second: (2.0 * square + 6.0 * t * cube) / h,
        }
    }

    /// Parameters that divide each interval into parts, ends included.
    fn divided(&self, parts: u32) -> Vec<f64> {
        let place = |ends: &[f64], part: u32| ends[0] + (ends[1] - ends[0]) * f64::from(part) / f64::from(parts);
        let intervals = self.knots.windows(2).flat_map(|ends| (0..parts).map(move |part| place(ends, part)));
        intervals.chain([self.end()]).collect()
    }

    /// Points that divide each interval into parts, ends included.
    pub fn sampled(&self, parts: u32) -> Vec<DVec3> {
        self.divided(parts).into_iter().map(|u| self.at(u).position).collect()
    }

    /// Parameter of the point nearest to `x`.
    pub fn nearest(&self, x: DVec3) -> f64 {
        let square = |index: usize| (self.samples[index].position - x).length_squared();
        let last = self.samples.len() - 1;
        // A closed curve goes on at its seam, where the first sample is also the last one.
        let before = |index: usize| {
            if index > 0 {
                index - 1
            } else if self.closed {
                last - 1
            } else {
                0
            }
        };
        let after = |index: usize| {
            if index < last {
                index + 1
            } else if self.closed {
                1
            } else {
                last
            }
        };
        let lowest = (0..=last).filter(|&index| square(index) <= square(before(index)).min(square(after(index))));
        let found =
            lowest.map(|index| self.lowest(x, index, self.samples[before(index)].place, self.samples[after(index)].place));
        let mut best = (0.0, f64::INFINITY);
        for place in found {
            let square = (self.at(place).position - x).length_squared();
            if square < best.1 {
                best = (place, square);
            }
        }
        best.0
    }

    /// Parameter of the point nearest to `x` about a sample, between the parameters of its neighbors.
    fn lowest(&self, x: DVec3, sample: usize, mut low: f64, mut high: f64) -> f64 {
        let middle = self.samples[sample].place;
        if low > middle {
            low -= self.end();
        }
        if high < middle {
            high += self.end();
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            let point = self.at(middle);
            // The derivative of the distance changes its sign at the nearest point.
            if (point.position - x).dot(point.first) > 0.0 {
                high = middle;
            } else {
                low = middle;
            }
        }
        let found = 0.5 * (low + high);
        let square = |u: f64| (self.at(u).position - x).length_squared();
        let found = if square(found) <= square(middle) { found } else { middle };
        self.within(found).unwrap_or(middle)
    }

    /// Least sums, at each sample, of `turn` over the curvature somewhere and of `share` times the distance to there [m].
    pub fn reaches(&self, turn: f64, share: f64) -> Vec<f64> {
        let mut reaches: Vec<f64> = self.samples.iter().map(|sample| turn / self.at(sample.place).curvature().length()).collect();
        let last = reaches.len() - 1;
        let way = |index: usize| share * (self.samples[index].place - self.samples[index - 1].place);
        // The second time it goes on across the seam of a closed curve.
        for _ in 0..2 {
            (1..=last).for_each(|index| reaches[index] = reaches[index].min(reaches[index - 1] + way(index)));
            (1..=last).rev().for_each(|index| reaches[index - 1] = reaches[index - 1].min(reaches[index] + way(index)));
            if self.closed {
                let seam = reaches[0].min(reaches[last]);
                (reaches[0], reaches[last]) = (seam, seam);
            }
        }
        reaches
    }

    /// Least such sum at a place, from those at the samples.
    pub fn reach(&self, reaches: &[f64], place: f64, share: f64) -> f64 {
        let after = self.samples.partition_point(|sample| sample.place <= place).clamp(1, reaches.len() - 1);
        let at = |index: usize| reaches[index] + share * (self.samples[index].place - place).abs();
        at(after - 1).min(at(after))
    }

    /// Difference of two parameters, the smaller way around a closed curve.
    pub fn distance(&self, one: f64, other: f64) -> f64 {
        let way = (other - one).abs();
        if self.closed { way.min(self.end() - way) } else { way }
    }
}

/// Slopes at the points of an open curve with these intervals and rates.
fn open_slopes(h: &[f64], rates: &[DVec3]) -> Vec<DVec3> {
    let last = h.len();
    if last == 1 {
        return vec![rates[0]; 2];
    }
    let mut rows = Vec::with_capacity(last + 1);
    if last == 2 {
        rows.push(([0.0, 1.0, 1.0], 2.0 * rates[0]));
    } else {
        let sum = h[0] + h[1];
        rows.push(([0.0, h[1], sum], ((h[0] + 2.0 * sum) * h[1] * rates[0] + h[0] * h[0] * rates[1]) / sum));
    }
    rows.extend((1..last).map(|point| inner(h, rates, point - 1, point)));
    if last == 2 {
        rows.push(([1.0, 1.0, 0.0], 2.0 * rates[1]));
    } else {
        let (one, other) = (h[last - 1], h[last - 2]);
        let sum = one + other;
        rows.push(([sum, other, 0.0], ((one + 2.0 * sum) * other * rates[last - 1] + one * one * rates[last - 2]) / sum));
    }
    tridiagonal(&rows)
}

/// Slopes at the points of a closed curve with these intervals and rates, the first of them again at the end.
fn closed_slopes(h: &[f64], rates: &[DVec3]) -> Vec<DVec3> {
    let count = h.len();
    let mut rows: Vec<_> = (0..count).map(|point| inner(h, rates, (point + count - 1) % count, point)).collect();
    // The corners of the cyclic matrix are a product of two vectors: one more right side corrects for it (Sherman and
    // Morrison).
    let (upper, lower) = (rows[0].0[0], rows[count - 1].0[2]);
    let gamma = -rows[0].0[1];
    rows[0].0[1] -= gamma;
    rows[count - 1].0[1] -= lower * upper / gamma;
    let slopes = tridiagonal(&rows);
    let unit = |point: usize| if point == 0 { gamma } else { lower * f64::from(u8::from(point + 1 == count)) };
    let corner: Vec<_> = rows.iter().enumerate().map(|(point, &(row, _))| (row, DVec3::splat(unit(point)))).collect();
    let corner = tridiagonal(&corner);
    let dot = |values: &[DVec3]| values[0] + upper / gamma * values[count - 1];
    let factor = dot(&slopes) / (DVec3::ONE + dot(&corner));
    let mut slopes: Vec<DVec3> = slopes.iter().zip(&corner).map(|(slope, corner)| *slope - factor * *corner).collect();
    slopes.push(slopes[0]);
    slopes
}

/// Equation of a point between two intervals: coefficients of three slopes, and right side.
fn inner(h: &[f64], rates: &[DVec3], before: usize, after: usize) -> ([f64; 3], DVec3) {
    let (one, other) = (h[before], h[after]);
    ([other, 2.0 * (one + other), one], 3.0 * (other * rates[before] + one * rates[after]))
}

/// Solution of tridiagonal equations by elimination without pivots. The corners outside the matrix are ignored.
fn tridiagonal(rows: &[([f64; 3], DVec3)]) -> Vec<DVec3> {
    let mut solution: Vec<DVec3> = Vec::with_capacity(rows.len());
    let mut uppers: Vec<f64> = Vec::with_capacity(rows.len());
    for &([lower, diagonal, upper], right) in rows {
        let (last, known) = (uppers.last().copied().unwrap_or(0.0), solution.last().copied().unwrap_or_default());
        let pivot = diagonal - lower * last;
        uppers.push(upper / pivot);
        solution.push((right - lower * known) / pivot);
    }
    for row in (1..rows.len()).rev() {
        let next = solution[row];
        solution[row - 1] -= uppers[row - 1] * next;
    }
    solution
}

#[cfg(test)]
mod tests {
    use super::*;

    fn helix(count: usize, turn: f64) -> Vec<DVec3> {
        let place = |index: usize| turn * index as f64 / (count - 1) as f64;
        (0..count).map(|index| DVec3::new(libm::cos(place(index)), libm::sin(place(index)), 0.3 * place(index))).collect()
    }

    #[test]
    fn derivatives_are_continuous_at_every_point_and_the_curve_passes_through_it() {
        for (points, closed) in [(helix(9, 4.0), false), (helix(8, 5.0), true), (helix(3, 1.0), false), (helix(2, 1.0), false)] {
            let spline = CubicSpline::through(&points, closed);
            for (point, &knot) in points.iter().zip(&spline.knots) {
                assert!((spline.at(knot).position - *point).length() <= 1e-15);
                let inside = closed || (knot > 0.0 && knot < spline.end());
                let step = 1e-9 * spline.end();
                let [before, after] = [-step, step].map(|step| spline.at(knot + step));
                // A third derivative of at most 10/m² over 2e-9 of the length: differences below 1e-7.
                if inside {
                    assert!((before.first - after.first).length() < 1e-7 && (before.second - after.second).length() < 1e-6);
                }
            }
        }
    }

    #[test]
    fn cubics_and_lines_are_reproduced_and_the_error_is_of_order_four() {
        // A graph over equal steps of u is only nearly one over chords: a straight line is one exactly.
        let line: Vec<DVec3> = [0.0, 0.3, 1.0, 1.7].map(|place| place * DVec3::new(2.0, -1.0, 0.5)).to_vec();
        let spline = CubicSpline::through(&line, false);
        let middle = spline.at(0.5 * spline.end());
        assert!(middle.position.cross(line[3]).length() < 1e-15 && middle.curvature().length() < 1e-14);
        let error = |count: usize| {
            let spline = CubicSpline::through(&helix(count, 4.0), false);
            let off = |part: usize| {
                let at = spline.at(spline.end() * part as f64 / 1000.0).position;
                (at.truncate().length() - 1.0).abs()
            };
            (0..=1000).map(off).fold(0.0, f64::max)
        };
        // Halved intervals: 16 times less in the limit.
        let ratio = error(41) / error(81);
        assert!((14.0..18.0).contains(&ratio), "{ratio}");
    }

    #[test]
    fn curvature_of_a_circle_is_that_of_its_radius() {
        let points: Vec<DVec3> = helix(65, std::f64::consts::TAU)[..64].iter().map(|point| 2.0 * point.with_z(0.0)).collect();
        let spline = CubicSpline::through(&points, true);
        for part in 0..100 {
            let point = spline.at(spline.end() * f64::from(part) / 100.0);
            // Second derivatives are off by h²/12 relative to the fourth: (2π/64)²/12 = 8e-4.
            assert!((point.curvature() + 0.25 * point.position).length() < 5e-4, "{:?}", point.curvature());
        }
    }

    #[test]
    fn nearest_points_are_found_at_the_seam_and_at_a_crossing() {
        let eight: Vec<DVec3> = (0..64)
            .map(|index| std::f64::consts::TAU * f64::from(index) / 64.0)
            .map(|turn| DVec3::new(libm::sin(turn), 0.5 * libm::sin(2.0 * turn), 0.0))
            .collect();
        let spline = CubicSpline::through(&eight, true);
        for part in 0..1000 {
            let x = spline.at(spline.end() * f64::from(part) / 1000.0).position;
            assert!((spline.at(spline.nearest(x)).position - x).length() < 1e-12, "{part}");
        }
    }

    #[test]
    fn reaches_are_the_least_over_all_samples_also_across_the_seam() {
        for closed in [false, true] {
            let points: Vec<DVec3> = helix(13, 5.0).into_iter().map(|point| point * DVec3::new(2.0, 0.5, 1.0)).collect();
            let spline = CubicSpline::through(&points, closed);
            let reaches = spline.reaches(0.5, 0.25);
            for part in 0..97 {
                let place = spline.end() * f64::from(part) / 97.0;
                let of = |sample: &CurveSample| {
                    0.5 / spline.at(sample.place).curvature().length() + 0.25 * spline.distance(place, sample.place)
                };
                let least = spline.samples.iter().map(of).fold(f64::INFINITY, f64::min);
                // Both sum up at most 200 rounded terms.
                assert!((spline.reach(&reaches, place, 0.25) - least).abs() <= 200.0 * f64::EPSILON * least);
            }
        }
    }

    #[test]
    fn nearest_points_are_found_also_beyond_the_ends() {
        let spline = CubicSpline::through(&helix(30, 9.0), false);
        for part in 0..57 {
            let u = spline.end() * f64::from(part) / 56.0;
            assert!((spline.at(spline.nearest(spline.at(u).position)).position - spline.at(u).position).length() < 1e-12);
        }
        let beyond = spline.at(0.0).position - 0.1 * spline.at(0.0).first;
        assert!(spline.nearest(beyond) < 1e-12);
    }
}
