//! Weave of threads on a surface: a brightness that varies from thread to thread, without moiré.

use std::f32::consts::PI;

/// Depth of the weave: relative variation of the brightness.
const DEPTH: f32 = 0.3;
/// Standard deviation of the Gaussian that filters the weave [pixels of the picture].
const FILTER: f32 = 0.6;

/// Plain weave on a triangle in a picture. Let u and v be coordinates across the two sets of threads, in threads. Where thread u
/// is above, the brightness follows −cos 2πu, else −cos 2πv. With the smooth indicator (1 + sin πu sin πv)/2 of the former it is
///
/// f = −½ (cos 2πu + cos 2πv) − ¼ (sin 3πu sin πv − sin πu sin 3πv),
///
/// a sum of six plane waves. Each is filtered exactly: those finer than pixels vanish, and the mean color remains.
pub(crate) struct Weave {
    /// Coordinates at the pixel (0, 0), and their derivatives to the right and down.
    start: [f32; 2],
    right: [f32; 2],
    down: [f32; 2],
    /// Amplitudes that the filter leaves: of u and v, and of the waves whose phases have the sum and the difference
    /// of 3πu and πv, and of πu and 3πv.
    kept: [f32; 6],
}

impl Weave {
    /// Weave of a triangle in a picture.
    ///
    /// - `doubled`: doubled signed area.
    /// - `threads`: coordinates of the corners.
    /// - `times`: number of samples along the side of a pixel of the picture.
    pub(crate) fn new([a, b, c]: &[[f32; 2]; 3], doubled: f32, threads: &[[f32; 2]; 3], times: f32) -> Self {
        let per_pixel = |index: usize| {
            let (first, second) = (threads[1][index] - threads[0][index], threads[2][index] - threads[0][index]);
            let right = (first * (c[1] - a[1]) - second * (b[1] - a[1])) / doubled;
            let down = (second * (b[0] - a[0]) - first * (c[0] - a[0])) / doubled;
            [right, down]
        };
        let ([u_right, u_down], [v_right, v_down]) = (per_pixel(0), per_pixel(1));
        let (right, down) = ([u_right, v_right], [u_down, v_down]);
        let start = [0, 1].map(|index: usize| threads[0][index] - a[0] * right[index] - a[1] * down[index]);
        // A wave of f periods per pixel keeps exp(−2π² σ² f²) of its amplitude.
        let kept = |u: f32, v: f32| {
            let (x, y) = (u * right[0] + v * right[1], u * down[0] + v * down[1]);
            (-2.0 * PI * PI * FILTER * FILTER * times * times * (x * x + y * y)).exp()
        };
        let kept = [kept(1.0, 0.0), kept(0.0, 1.0), kept(1.5, 0.5), kept(1.5, -0.5), kept(0.5, 1.5), kept(0.5, -1.5)];
        Self { start, right, down, kept }
    }

    /// Factor of the brightness at a pixel.
    #[inline(always)]
    pub(crate) fn at(&self, x: f32, y: f32) -> f32 {
        let [u, v] = [0, 1].map(|index: usize| {
            let place = self.start[index] + x * self.right[index] + y * self.down[index];
            // Two threads are a period.
            PI * (place - 2.0 * (0.5 * place).floor())
        });
        let ((sin_u, cos_u), (sin_v, cos_v)) = (u.sin_cos(), v.sin_cos());
        let thrice = |sine: f32, cosine: f32| (sine * (3.0 - 4.0 * sine * sine), cosine * (4.0 * cosine * cosine - 3.0));
        let ((sin_3u, cos_3u), (sin_3v, cos_3v)) = (thrice(sin_u, cos_u), thrice(sin_v, cos_v));
        // The product of two sines is half the cosine of the difference of their phases less that of the sum.
        let product = |sines: f32, cosines: f32, [sum, difference]: [f32; 2]| {
            0.5 * (difference * (cosines + sines) - sum * (cosines - sines))
        };
        let [across, along, first @ .., p, q] = self.kept;
        let waves = product(sin_3u * sin_v, cos_3u * cos_v, first) - product(sin_u * sin_3v, cos_u * cos_3v, [p, q]);
        let doubled = |sine: f32| 1.0 - 2.0 * sine * sine;
        1.0 + DEPTH * (-0.5 * (across * doubled(sin_u) + along * doubled(sin_v)) - 0.25 * waves)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [[f32; 2]; 3] = [[0.0, 0.0], [100.0, 0.0], [0.0, 100.0]];

    /// Weave with threads of this width along the axes [pixels].
    fn weave(width: f32) -> Weave {
        Weave::new(&CORNERS, 1e4, &CORNERS.map(|corner| corner.map(|place| place / width)), 1.0)
    }

    /// Threads of 20 pixels: the upper thread is brightest in the middle of a crossing, and darkest at its sides. It lies across
    /// the next crossings, where the other set is above.
    #[test]
    fn threads_go_over_and_under_each_other() {
        let (weave, filter) = (weave(20.0), |periods: f32| (-2.0 * PI * PI * FILTER * FILTER * periods * periods).exp());
        let middle = |column: u8, row: u8| weave.at(20.0 * f32::from(column) + 10.0, 20.0 * f32::from(row) + 10.0);
        for (column, row) in [(0, 0), (1, 0), (0, 1), (2, 3)] {
            assert!((middle(column, row) - 1.0 - DEPTH * filter(0.05)).abs() < 1e-3, "{}", middle(column, row));
        }
        let (side, end) = (weave.at(13.0, 10.0), weave.at(10.0, 13.0));
        assert!(side < end && end < middle(0, 0), "{side} {end}");
        let (next_side, next_end) = (weave.at(30.0, 13.0), weave.at(33.0, 10.0));
        assert!((side - next_side).abs() < 1e-4 && (end - next_end).abs() < 1e-4);
    }

    /// Without a filter, threads of 0.7 pixels would be beats of 3.5 pixels and more. What the filter leaves of a wave of
    /// 1/0.7 periods per pixel is below 1e-4; the mean is the color without weave.
    #[test]
    fn threads_finer_than_pixels_leave_no_beats() {
        let fine = weave(0.7);
        let most = (0..1000_u16).map(|index| (fine.at(f32::from(index), 0.37 * f32::from(index)) - 1.0).abs());
        assert!(most.fold(0.0, f32::max) < 1e-3);
        let coarse = weave(7.0);
        let all = || (0..28_u16).flat_map(|row| (0..28_u16).map(move |column| (f32::from(column), f32::from(row))));
        let mean = all().map(|(x, y)| coarse.at(x, y)).sum::<f32>() / 784.0;
        assert!((mean - 1.0).abs() < 1e-3 && all().any(|(x, y)| coarse.at(x, y) > 1.15));
    }
}
