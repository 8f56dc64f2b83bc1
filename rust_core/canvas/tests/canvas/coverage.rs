//! Tests of coverage: shapes cover as many pixels as their areas require.

use physcore_canvas::{Canvas, Disc, Line, Mixing, Painting};
use proptest::prelude::*;

const SIDE: usize = 64;
const WHITE: [u8; 4] = [255; 4];

fn black() -> Canvas {
    Canvas::new(SIDE, SIDE, [0; 3]).expect("a valid size")
}

/// Sum of the coverages of all pixels.
fn covered(canvas: &Canvas) -> f64 {
    canvas.pixels().iter().map(|pixel| f64::from(pixel[0]) / 255.0).sum()
}

/// Bound of the sampling error. The ramp is Lipschitz continuous with constant 1. It varies only in a band one pixel wide along
/// the perimeter p. Sampling at pixel centers is the midpoint rule. Its error per pixel of the band is at most the mean distance
/// from the center of the pixel, 0.383. The errors of about p + 4 pixels have varying signs, so they add up like the square root
/// of their number. Rounding to 1/256 adds at most 1/256 for each pixel of the band.
fn sampling_error(perimeter: f64) -> f64 {
    let pixels = perimeter + 4.0;
    0.383 * pixels.sqrt() + pixels / 256.0
}

proptest! {
    #[test]
    fn a_disc_covers_its_area(x in 20.0..40.0_f32, y in 20.0..40.0_f32, radius in 0.05..15.0_f32) {
        let mut canvas = black();
        canvas.disc(Disc { center: [x, y], radius, color: WHITE, shading: 0.0, softness: 1.0 });
        let (r, pi) = (f64::from(radius), std::f64::consts::PI);
        let error = (covered(&canvas) - pi * r * r).abs();
        prop_assert!(error < sampling_error(2.0 * pi * r).min(0.35 * pi * r * r + 0.05), "{error}");
    }

    #[test]
    fn a_line_covers_its_length_times_its_width(
        from in [15.0..45.0_f32, 15.0..45.0_f32], to in [15.0..45.0_f32, 15.0..45.0_f32], width in 0.1..8.0_f32,
    ) {
        let mut canvas = black();
        canvas.line(Line { from, to, width, color: WHITE, softness: 1.0 });
        let length = f64::from((to[0] - from[0]).hypot(to[1] - from[1]));
        // The two round ends form a disc of the drawn half width h, to which the ramp gives π(h² + 1/12).
        let (w, half) = (f64::from(width), f64::from(width.max(1.0)) / 2.0);
        let ends = std::f64::consts::PI * (half * half + 1.0 / 12.0) * w.min(1.0);
        let error = (covered(&canvas) - (w * length + ends)).abs();
        prop_assert!(error < sampling_error(2.0 * length + 7.0 * half), "{error}");
    }

    #[test]
    fn a_triangle_covers_its_area(
        a in [15.0..45.0_f32, 15.0..45.0_f32], b in [15.0..45.0_f32, 15.0..45.0_f32], c in [15.0..45.0_f32, 15.0..45.0_f32],
    ) {
        let mut canvas = black();
        canvas.polygon(&[a, b, c], WHITE);
        let doubled = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        let side = |p: [f32; 2], q: [f32; 2]| f64::from((p[0] - q[0]).hypot(p[1] - q[1]));
        let perimeter = side(a, b) + side(b, c) + side(c, a);
        let error = (covered(&canvas) - f64::from(doubled.abs()) / 2.0).abs();
        // Half of the ramp lies outside each side, and the outer halves meet in corners, at most half a pixel each way. A very
        // flat triangle may thus gain up to a quarter of its perimeter (both sides' half ramps, of area 1/8 each).
        prop_assert!(error < sampling_error(perimeter) + perimeter / 4.0, "{error}");
    }

    /// Pixels are blended in groups. If the clip begins or ends within a group, its pixels outside the clip stay unchanged.
    /// Distances are then rounded from another first pixel, which may change an opacity by one level.
    #[test]
    fn a_clip_changes_nothing_within_it(
        from in [5.0..60.0_f32, 5.0..60.0_f32], to in [5.0..60.0_f32, 5.0..60.0_f32], width in 0.1..8.0_f32,
        left in 0..60_usize, columns in 1..9_usize,
    ) {
        let draw = |canvas: &mut Canvas| {
            canvas.line(Line { from, to, width, color: WHITE, softness: 1.0 });
            canvas.disc(Disc { center: to, radius: 0.7 * width, color: [255, 0, 0, 255], shading: 0.0, softness: 1.0 });
        };
        let (mut whole, mut part) = (black(), black());
        part.clip(left, 0, left + columns, SIDE);
        draw(&mut whole);
        draw(&mut part);
        for (index, (whole, part)) in whole.pixels().iter().zip(part.pixels()).enumerate() {
            let expected = if (left..left + columns).contains(&(index % SIDE)) { *whole } else { [0; 4] };
            prop_assert!(expected.iter().zip(part).all(|(one, other)| one.abs_diff(*other) <= 1), "{expected:?} {part:?}");
        }
    }

    #[test]
    fn a_trail_only_makes_lighter_or_only_darker(
        ground in [any::<u8>(), any::<u8>(), any::<u8>()], ink in [any::<u8>(), any::<u8>(), any::<u8>(), any::<u8>()],
        from in [5.0..60.0_f32, 5.0..60.0_f32], to in [5.0..60.0_f32, 5.0..60.0_f32], width in 0.1..8.0_f32,
    ) {
        let line = Line { from, to, width, color: ink, softness: 1.0 };
        let plain = Canvas::new(SIDE, SIDE, ground).expect("a valid size");
        let mut covered = plain.clone();
        covered.line(line);
        for (mixing, of) in [(Mixing::Lighter, u8::max as fn(u8, u8) -> u8), (Mixing::Darker, u8::min)] {
            let (mut canvas, mut painting) = (plain.clone(), Painting::default());
            painting.trail(line, mixing, 0.0);
            painting.paint(&mut canvas);
            for ((before, over), after) in plain.pixels().iter().zip(covered.pixels()).zip(canvas.pixels()) {
                prop_assert_eq!(*after, std::array::from_fn(|channel| of(before[channel], over[channel])));
            }
        }
    }

    #[test]
    fn nothing_panics_and_nothing_leaves_the_clip(values in prop::collection::vec(prop::num::f32::ANY, 6)) {
        let mut canvas = black();
        canvas.clip(10, 20, 30, 40);
        let ends = ([values[0], values[1]], [values[2], values[3]]);
        canvas.line(Line { from: ends.0, to: ends.1, width: values[4], color: WHITE, softness: 1.0 });
        canvas.disc(Disc { center: ends.0, radius: values[4].abs().min(1e4), color: WHITE, shading: values[5], softness: 1.0 });
        canvas.polygon(&[ends.0, ends.1, [values[4], values[5]]], WHITE);
        for (index, pixel) in canvas.pixels().iter().enumerate() {
            let inside = (10..30).contains(&(index % SIDE)) && (20..40).contains(&(index / SIDE));
            prop_assert!(inside || pixel[0] == 0);
        }
    }
}

/// Averages over 16 × 16 sub-pixel offsets, which removes the sampling error. The integral of the ramp remains, and the rounding
/// of each edge pixel to 1/256. Rounding is at most (2πr + 8)/512, and far less in practice because it has both signs.
#[test]
fn a_disc_covers_exactly_its_area_on_average() {
    for radius in [0.1, 0.3, 0.57, 0.59, 1.0, 2.3, 7.0_f32] {
        let mut sum = 0.0;
        for (i, j) in (0..16_u8).flat_map(|i| (0..16_u8).map(move |j| (i, j))) {
            let mut canvas = black();
            let center = [32.0 + f32::from(i) / 16.0, 32.0 + f32::from(j) / 16.0];
            canvas.disc(Disc { center, radius, color: WHITE, shading: 0.0, softness: 1.0 });
            sum += covered(&canvas);
        }
        let (r, pi) = (f64::from(radius), std::f64::consts::PI);
        let error = (sum / 256.0 - pi * r * r).abs();
        assert!(error < (2.0 * pi * r + 8.0) / 512.0, "radius {radius}: {error}");
    }
}

#[test]
fn a_disc_is_the_same_in_all_eight_orientations() {
    let mut canvas = black();
    canvas.disc(Disc { center: [32.0, 32.0], radius: 9.3, color: WHITE, shading: 0.0, softness: 1.0 });
    let at = |x: usize, y: usize| canvas.pixels()[y * SIDE + x][0];
    for x in 0..SIDE {
        for y in 0..SIDE {
            assert_eq!(at(x, y), at(y, x));
            assert_eq!(at(x, y), at(SIDE - 1 - x, y));
        }
    }
}

#[test]
fn the_near_hides_the_far_whatever_was_added_first() {
    let disc = |color| Disc { center: [32.0, 32.0], radius: 5.0, color, shading: 0.0, softness: 1.0 };
    let (red, green) = ([255, 0, 0, 255], [0, 255, 0, 255]);
    for (first, second, front) in [(1.0, 2.0, red), (2.0, 1.0, green), (1.0, 1.0, green)] {
        let (mut painting, mut canvas) = (Painting::default(), black());
        painting.disc(disc(red), first);
        painting.disc(disc(green), second);
        painting.paint(&mut canvas);
        assert_eq!(canvas.pixels()[32 * SIDE + 32][..3], front[..3]);
    }
}

#[test]
fn a_canvas_goes_back_to_what_was_kept() {
    let mut canvas = black();
    canvas.polygon(&[[0.0, 40.0], [64.0, 40.0], [64.0, 64.0], [0.0, 64.0]], [90, 90, 90, 255]);
    canvas.keep();
    let kept = canvas.pixels().to_vec();
    canvas.disc(Disc { center: [32.0, 40.0], radius: 8.0, color: WHITE, shading: 0.5, softness: 1.0 });
    assert_ne!(canvas.pixels(), kept);
    canvas.clear();
    assert_eq!(canvas.pixels(), kept);
}

#[test]
fn a_canvas_without_pixels_is_refused() {
    for (width, height) in [(0, 10), (10, 0), (65_536, 10)] {
        assert!(Canvas::new(width, height, [0; 3]).is_err());
    }
}
