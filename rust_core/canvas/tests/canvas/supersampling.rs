//! Tests of supersampling: a picture with several samples per pixel equals a larger picture reduced, with smaller steps in
//! outlines.

use physcore_canvas::{Align, Canvas, Disc, Drop, Eye, Ground, Halo, Light, Line, Painting, Sky, Triangle};

const SIDE: usize = 80;
const GROUND: [u8; 3] = [20, 24, 30];

/// Draws all kinds of shapes, a liquid and light, with lengths in pixels times a factor.
fn scene(canvas: &mut Canvas, times: f32) {
    let place = |x: f32, y: f32| [times * x, times * y];
    canvas.backdrop(place(40.0, 30.0), 60.0 * times, [90, 60, 70], 0.5);
    canvas.look_from(Eye { scale: 20.0 * times, middle: place(40.0, 40.0), distance: f32::INFINITY });
    let half = 0.5_f32.sqrt();
    let floor = Ground {
        normal: [0.0, half, half],
        center: [0.0; 3],
        size: 3.0,
        color: [90; 3],
        grid: None,
        along: [1.0, 0.0, 0.0],
        part: None,
    };
    canvas.ground(&floor);
    canvas.polygon(&[place(2.0, 2.0), place(12.3, 4.0), place(5.1, 14.2)], [0, 200, 100, 128]);
    let mut painting = Painting::default();
    painting.light(Light { lamp: [0.3, 0.6, 0.74], shadow: 0.5, occlusion: 0.4, reach: 6.0 * times });
    let ball = Disc { center: place(30.2, 25.7), radius: 9.0 * times, color: [200, 80, 60, 255], shading: 0.8, softness: 1.0 };
    painting.disc(ball, 0.5);
    painting.line(
        Line { from: place(5.0, 70.0), to: place(70.0, 50.0), width: 3.0 * times, color: [255; 4], softness: 1.0 },
        [0.1; 2],
    );
    painting.halo(Halo { center: place(60.0, 15.0), radius: 12.0 * times, color: [80, 160, 255, 200], shadow: false }, 0.0);
    let corners = [place(45.0, 30.0), place(70.0, 35.0), place(50.0, 60.0)];
    let triangle =
        Triangle { corners, colors: [[250, 220, 30, 255]; 3], depths: [0.0; 3], lit: true, texture_coordinates: [[0.0; 2]; 3] };
    painting.triangle(triangle, None, 0.0);
    painting.begin_liquid(20.0 * times, Sky { horizon: [200; 3], zenith: [200; 3], up: [0.0, 1.0, 0.0], brightness: 1.0 }, 0.0);
    for index in 0..20 {
        let center = place(15.0 + 2.0 * index as f32, 60.0 + (index % 3) as f32);
        painting.drop(Drop { center, radius: 5.0 * times, depth: 0.0, color: [60, 120, 220, 200] });
    }
    painting.paint(canvas);
}

fn drawn(samples: usize) -> Canvas {
    let mut canvas = Canvas::supersampled(SIDE, SIDE, GROUND, samples).expect("a valid size");
    scene(&mut canvas, 1.0);
    canvas.reduced().into_owned()
}

/// Compares with means over squares of a larger picture. An exception is the triangle's half pixel, which is half a drawn pixel
/// in both.
#[test]
fn a_pixel_is_the_mean_of_those_of_a_larger_picture() {
    for samples in [2, 3] {
        let mut large = Canvas::new(samples * SIDE, samples * SIDE, GROUND).expect("a valid size");
        scene(&mut large, samples as f32);
        let small = drawn(samples);
        assert_eq!((small.width(), small.height()), (SIDE, SIDE));
        let mut differing = 0;
        for (index, pixel) in small.pixels().iter().enumerate() {
            let (left, top) = (samples * (index % SIDE), samples * (index / SIDE));
            for channel in 0..3 {
                let square = (0..samples * samples).map(|at| (top + at / samples) * samples * SIDE + left + at % samples);
                let sum: f32 = square.map(|at| f32::from(large.pixels()[at][channel])).sum();
                // The backdrop and the floor are dithered by the pixels of the smaller picture: by at most 1.5 levels each.
                let away = (sum / (samples * samples) as f32 - f32::from(pixel[channel])).abs();
                assert!(away < 4.0, "{index}: {away}");
                differing += usize::from(away > 1.0);
            }
        }
        assert!(differing < 3 * SIDE * SIDE / 2, "{differing}");
    }
}

#[test]
fn a_picture_of_single_samples_is_the_one_that_was_drawn() {
    let mut plain = Canvas::new(SIDE, SIDE, GROUND).expect("a valid size");
    scene(&mut plain, 1.0);
    assert_eq!(plain.pixels(), drawn(1).pixels());
}

/// The clip and text keep their positions of a picture with single samples. The baseline is rounded to a drawn pixel, by at most
/// half a pixel in each.
#[test]
fn text_and_clip_keep_their_places() {
    let mut pictures = [1, 2].map(|samples| Canvas::supersampled(SIDE, SIDE, GROUND, samples).expect("a valid size"));
    let centers = pictures.each_mut().map(|canvas| {
        canvas.clip(10, 20, 60, 50);
        canvas.text("scale", [4, 24], 22, [255; 4], Align::Left);
        let picture = canvas.reduced();
        let (mut sum, mut center) = (0.0, [0.0; 2]);
        for (index, pixel) in picture.pixels().iter().enumerate() {
            let (column, row, light) = (index % SIDE, index / SIDE, f32::from(pixel[0].saturating_sub(GROUND[0])));
            assert!(light == 0.0 || ((10..60).contains(&column) && (20..50).contains(&row)));
            sum += light;
            center = [center[0] + light * column as f32, center[1] + light * row as f32];
        }
        center.map(|part| part / sum)
    });
    let [one, two] = centers;
    assert!((one[0] - two[0]).abs() < 0.5 && (one[1] - two[1]).abs() < 0.75, "{one:?} {two:?}");
}

/// Two surfaces meet in a ridge. They are cut into triangles whose drawing order changes along it. Each is drawn half a pixel
/// larger, so the ridge has steps of one pixel, and of half a pixel with two samples.
#[test]
fn a_ridge_has_smaller_steps() {
    let roughness = [1, 4].map(|samples| {
        let mut canvas = Canvas::supersampled(SIDE, SIDE, GROUND, samples).expect("a valid size");
        let mut painting = Painting::default();
        for index in 0..8 {
            let (left, right) = (10.0 * index as f32, 10.0 * (index + 1) as f32);
            for (side, color) in [(-30.0, [250, 0, 0, 255]), (30.0, [0, 0, 250, 255])] {
                let nearer = if (index % 2 == 0) == (side > 0.0) { 0.0 } else { 1.0 };
                let corners = [[left, 40.3], [right, 40.3], [0.5 * (left + right), 40.3 + side]];
                let colors = [color; 3];
                let triangle = Triangle { corners, colors, depths: [nearer; 3], lit: false, texture_coordinates: [[0.0; 2]; 3] };
                painting.triangle(triangle, None, nearer);
            }
        }
        painting.paint(&mut canvas);
        let picture = canvas.reduced();
        // Height of the red surface in the middles of the triangles, which is equal except for the order.
        let heights: Vec<f32> = (0..8)
            .map(|index| (35..46).map(|row| f32::from(picture.pixels()[row * SIDE + 10 * index + 5][0]) / 250.0).sum())
            .collect();
        heights.windows(2).map(|pair| (pair[1] - pair[0]).abs()).sum::<f32>() / 7.0
    });
    assert!(roughness[0] > 0.5 && roughness[1] < 0.35 * roughness[0], "{roughness:?}");
}
