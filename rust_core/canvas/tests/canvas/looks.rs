//! Tests of appearance: blur, glow and seams conserve light; liquids merge and hide their background.

use std::sync::Arc;

use physcore_canvas::{Canvas, Disc, Drop, Halo, Lens, Line, Painting, Sky, Texture, Trails, Triangle};
use proptest::prelude::*;

const SIDE: usize = 96;
const WHITE: [u8; 4] = [255; 4];
const PI: f64 = std::f64::consts::PI;

fn plain(gray: u8) -> Canvas {
    Canvas::new(SIDE, SIDE, [gray; 3]).expect("a valid size")
}

/// Sky of one gray.
fn sky(gray: u8) -> Sky {
    Sky { horizon: [gray; 3], zenith: [gray; 3], up: [0.0, 1.0, 0.0], brightness: 1.0 }
}

/// Sum of the light of all pixels.
fn light(canvas: &Canvas) -> f64 {
    canvas.pixels().iter().map(|pixel| f64::from(pixel[0]) / 255.0).sum()
}

fn at(canvas: &Canvas, x: usize, y: usize) -> [u8; 3] {
    let [red, green, blue, _] = canvas.pixels()[y * SIDE + x];
    [red, green, blue]
}

proptest! {
    /// Opacity is rounded to 1/255, an error of up to half of this over the covered area, and the share of each pixel to 1/256.
    /// The ramp is sampled at pixel centers: an error of at most 0.383 for each edge pixel of a sharp disc, of varying sign.
    #[test]
    fn a_disc_out_of_focus_keeps_its_light(radius in 1.0..8.0_f32, confusion in 0.0..16.0_f32, x in 40.0..50.0_f32) {
        let mut canvas = plain(0);
        let disc = Disc { center: [x, 48.0], radius, color: WHITE, shading: 0.0, softness: 1.0 };
        canvas.disc(disc.blurred(confusion));
        let (r, reach) = (f64::from(radius), f64::from(radius + confusion) + 1.0);
        let error = (light(&canvas) - PI * r * r).abs();
        let rounding = PI * reach * reach * (0.5 / 255.0 + 0.5 / 256.0);
        prop_assert!(error < rounding + 0.383 * (2.0 * PI * reach + 4.0).sqrt(), "{error}");
    }

    /// Tolerances are those of discs; the ends of a line are eliminated by the difference of two lengths.
    #[test]
    fn a_line_out_of_focus_keeps_its_light(width in 1.0..6.0_f32, confusion in 0.0..8.0_f32, slope in -1.0..1.0_f32) {
        let drawn = |length: f32| {
            let mut canvas = plain(0);
            let from = [48.0 - length / 2.0, 48.0 - slope * length / 2.0];
            let to = [48.0 + length / 2.0, 48.0 + slope * length / 2.0];
            canvas.line(Line { from, to, width, color: WHITE, softness: 1.0 }.blurred(confusion));
            light(&canvas)
        };
        let gained = drawn(50.0) - drawn(20.0);
        let longer = 30.0 * f64::from(1.0 + slope * slope).sqrt();
        let across = f64::from(width + 2.0 * confusion) + 2.0;
        let rounding = longer * across * (0.5 / 255.0 + 0.5 / 256.0) + across * across / 128.0;
        let error = (gained - longer * f64::from(width)).abs();
        prop_assert!(error < rounding + 0.383 * 2.0 * (2.0 * longer).sqrt(), "{error}");
    }

    /// Light of a halo: ∫ (1 − d²/r²)² dA = πr²/3. The profile has no edge, so the midpoint rule over pixels has a small error.
    /// It is less than the largest second derivative, 4/r², over 24 for each of the πr² pixels, and 1/255 for rounding.
    #[test]
    fn a_halo_adds_the_light_that_it_has(radius in 4.0..30.0_f32, alpha in 40..=255_u8, shadow: bool) {
        let mut canvas = plain(if shadow { 255 } else { 0 });
        let gray = if shadow { 0 } else { 255 };
        canvas.halo(Halo { center: [48.3, 47.6], radius, color: [gray, gray, gray, alpha], shadow });
        let (r, opacity) = (f64::from(radius), f64::from(alpha) / 255.0);
        let changed = if shadow { (SIDE * SIDE) as f64 - light(&canvas) } else { light(&canvas) };
        let error = (changed - opacity * PI * r * r / 3.0).abs();
        prop_assert!(error < PI * r * r * (4.0 / (r * r) / 12.0 + 1.0 / 255.0), "{error}");
    }

    /// Cells of a wavy grid, cut into two triangles each: inside, every pixel has the color of the surface.
    #[test]
    fn no_seam_shows_between_triangles(phase in 0.0..6.0_f32, size in 3.0..12.0_f32) {
        let (mut painting, mut canvas) = (Painting::default(), plain(0));
        let corner = |i: u8, j: u8| {
            let (u, v) = (f32::from(i) * size, f32::from(j) * size);
            [10.3 + u + 0.2 * size * (v + phase).sin(), 9.7 + v + 0.2 * size * (u - phase).cos()]
        };
        let cells = (70.0 / size) as u8;
        for (i, j) in (0..cells).flat_map(|i| (0..cells).map(move |j| (i, j))) {
            let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
            for corners in [[a, b, c], [a, c, d]] {
                painting.triangle(Triangle { corners, colors: [WHITE; 3], depths: [0.0; 3], lit: false, texture_coordinates: [[0.0; 2]; 3] }, None, 0.0);
            }
        }
        painting.paint(&mut canvas);
        let (low, high) = (10.3 + 0.3 * size, 9.7 + f32::from(cells) * size - 0.3 * size);
        for (x, y) in (low as usize + 1..high as usize).flat_map(|x| (low as usize + 1..high as usize).map(move |y| (x, y))) {
            prop_assert_eq!(at(&canvas, x, y), [255; 3]);
        }
    }

    /// Many shapes are painted by several threads, and drawn one by one by this thread.
    #[test]
    fn threads_do_not_show(seeds in prop::collection::vec([-20.0..120.0_f32, -20.0..120.0_f32, 0.1..6.0_f32], 1000..1200)) {
        let (mut painting, mut canvas, mut alone) = (Painting::default(), plain(20), plain(20));
        for (index, &[x, y, size]) in seeds.iter().enumerate() {
            let color = [(index * 37) as u8, (index * 91) as u8, (index * 13) as u8, 100 + (index % 150) as u8];
            let disc = Disc { center: [x, y], radius: size, color, shading: 0.4, softness: 1.0 };
            let line = Line { from: [x, y], to: [y, x], width: size, color, softness: 1.0 };
            let halo = Halo { center: [y, x], radius: 2.0 * size, color, shadow: index % 2 == 0 };
            alone.disc(disc);
            painting.disc(disc, 0.0);
            alone.line(line);
            painting.line(line, [0.0; 2]);
            alone.halo(halo);
            painting.halo(halo, 0.0);
        }
        painting.paint(&mut canvas);
        prop_assert!(canvas.pixels() == alone.pixels());
    }

    #[test]
    fn nothing_panics_and_nothing_leaves_the_clip(values in prop::collection::vec(prop::num::f32::ANY, 8), deep: bool) {
        let (mut painting, mut canvas) = (Painting::default(), plain(0));
        canvas.clip(10, 20, 30, 40);
        let (a, b, c) = ([values[0], values[1]], [values[2], values[3]], [values[4], values[5]]);
        painting.look_through(Lens { blur: values[6].abs().min(1e3), distance: values[7] });
        painting.triangle(Triangle { corners: [a, b, c], colors: [WHITE; 3], depths: [values[6]; 3], lit: deep, texture_coordinates: [a, b, c] }, None, values[6]);
        painting.halo(Halo { center: a, radius: values[4].abs().min(1e4), color: WHITE, shadow: false }, values[7]);
        painting.disc(Disc { center: b, radius: values[4].abs().min(1e3), color: WHITE, shading: 0.5, softness: 1.0 }, values[5]);
        painting.begin_liquid(if deep { 1.0 } else { 0.0 }, sky(255), 0.0);
        painting.drop(Drop { center: c, radius: values[6].abs().min(1e3), depth: values[7], color: WHITE });
        painting.drop(Drop { center: [20.0, 30.0], radius: 6.0, depth: 0.0, color: WHITE });
        painting.paint(&mut canvas);
        for (index, pixel) in canvas.pixels().iter().enumerate() {
            let inside = (10..30).contains(&(index % SIDE)) && (20..40).contains(&(index / SIDE));
            prop_assert!(inside || pixel[0] == 0);
        }
    }
}

/// The eye focuses at depth 0. The farther a point is from the focus, the larger its disc. In front of the focus the disc grows
/// without limit; behind it up to b·d, where d is the distance of the eye.
#[test]
fn only_what_is_at_the_focus_is_sharp() {
    let width = |depth: f32| {
        let (mut painting, mut canvas) = (Painting::default(), plain(0));
        painting.look_through(Lens { blur: 4.0, distance: 3.0 });
        painting.disc(Disc { center: [48.0, 48.0], radius: 2.0, color: WHITE, shading: 0.0, softness: 1.0 }, depth);
        painting.paint(&mut canvas);
        (0..SIDE).filter(|&x| at(&canvas, x, 47)[0] > 0).count()
    };
    assert_eq!(width(0.0), 4);
    assert!(width(0.5) > 4 && width(2.0) > width(0.5) && width(-1.0) > width(1.0));
    assert!(width(1e6) <= 2 * (12 + 2));
}

#[test]
fn colors_and_textures_are_those_of_the_corners() {
    let corners = [[10.0, 80.0], [80.0, 80.0], [10.0, 10.0]];
    let colors = [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255]];
    let mut canvas = plain(0);
    canvas.triangle(&Triangle { corners, colors, depths: [0.0; 3], lit: false, texture_coordinates: [[0.0; 2]; 3] }, None);
    for ([x, y], channel) in [([11, 79], 0), ([78, 79], 1), ([11, 12], 2)] {
        let color = at(&canvas, x, y);
        // One pixel from the corner, the two other colors have about 1/70 of the weight each.
        assert!(color[channel] > 235 && color.iter().map(|&value| u32::from(value)).sum::<u32>() <= 257, "{color:?}");
    }

    let texture = Arc::new(Texture::new(2, vec![[200, 0, 0], [0, 200, 0], [0, 0, 200], [200; 3]]).expect("four texels"));
    let (mut painting, mut canvas) = (Painting::default(), plain(0));
    let (texture_coordinates, gray) = ([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], [128, 128, 128, 255]);
    let texture = painting.texture(texture);
    painting.triangle(
        Triangle { corners, colors: [gray; 3], depths: [0.0; 3], lit: false, texture_coordinates },
        Some(texture),
        0.0,
    );
    painting.paint(&mut canvas);
    for ([x, y], color) in [([14, 76], [0, 0, 100]), ([74, 79], [100, 100, 100]), ([11, 16], [100, 0, 0])] {
        assert_eq!(at(&canvas, x, y), color); // half as bright as the texel, whose edge is at the edge of the picture
    }
}

fn block(spacing: f32, depth: f32, painting: &mut Painting) {
    for (i, j) in (0..10_u8).flat_map(|i| (0..10_u8).map(move |j| (i, j))) {
        let center = [48.0 + spacing * (f32::from(i) - 4.5), 48.0 + spacing * (f32::from(j) - 4.5)];
        painting.drop(Drop { center, radius: Drop::REACH * spacing, depth, color: [40, 90, 200, 255] });
    }
}

/// A hundred drops on a square lattice have no holes inside. They cover at least their hundred squares, and at most a border of
/// 0.6 spacings more (the radius of an isolated drop).
#[test]
fn drops_flow_together_in_the_plane() {
    let (mut painting, mut canvas) = (Painting::default(), plain(0));
    painting.begin_liquid(0.0, sky(255), 0.0);
    block(6.0, 0.0, &mut painting);
    painting.paint(&mut canvas);
    let covered = canvas.pixels().iter().filter(|pixel| pixel[2] > 100).count() as f64;
    assert!((3600.0..(60.0 + 7.2_f64).powi(2)).contains(&covered), "{covered}");
    for (x, y) in (24..72).flat_map(|x| (24..72).map(move |y| (x, y))) {
        assert_eq!(at(&canvas, x, y), [40, 90, 200]);
    }
}

/// A flat layer of balls is smooth: its light varies by less than a tenth, although each single ball ranges from light to dark.
#[test]
fn balls_flow_together_into_a_smooth_surface_that_hides_what_is_behind() {
    let (mut painting, mut canvas) = (Painting::default(), plain(0));
    painting.begin_liquid(1.0, sky(255), 0.0);
    block(6.0, 0.0, &mut painting);
    let red = |x: f32| Disc { center: [x, 48.0], radius: 3.0, color: [255, 0, 0, 255], shading: 0.0, softness: 1.0 };
    painting.disc(red(40.0), 50.0);
    painting.disc(red(56.0), -50.0);
    painting.paint(&mut canvas);
    assert_eq!(at(&canvas, 56, 48), [255, 0, 0]);
    assert!(at(&canvas, 40, 48)[0] < 160 && at(&canvas, 40, 48)[2] > 60);
    let row: Vec<f64> = (30..66).map(|x| f64::from(at(&canvas, x, 60)[2])).collect();
    let mean = row.iter().sum::<f64>() / row.len() as f64;
    assert!(row.iter().all(|value| (value - mean).abs() < 0.1 * mean), "{row:?}");
}

/// A ball of drops reflects more of the sky where its surface turns away. At 24/28 of its radius the reflectance is 2.3 times
/// that of its middle; the filter of the front flattens it there.
#[test]
fn a_liquid_in_space_reflects_the_sky_at_its_rim() {
    let painted = |gray: u8| {
        let (mut painting, mut canvas) = (Painting::default(), plain(0));
        painting.begin_liquid(1.0, Sky { brightness: 4.0, ..sky(gray) }, 0.0);
        for index in 0..17_u16.pow(3) {
            let way = [index % 17, index / 17 % 17, index / 289].map(|step| 3.0 * (f32::from(step) - 8.0));
            if way.iter().map(|part| part * part).sum::<f32>() < 24.0 * 24.0 {
                let center = [48.0 + way[0], 48.0 + way[1]];
                painting.drop(Drop { center, radius: 4.0, depth: way[2], color: [40, 90, 200, 255] });
            }
        }
        painting.paint(&mut canvas);
        canvas
    };
    let (night, day) = (painted(0), painted(255));
    let more = |x: usize| i32::from(at(&day, x, 48)[0]) - i32::from(at(&night, x, 48)[0]);
    let rim = (60..SIDE).map(more).max().unwrap_or_default();
    assert!(more(48) > 0 && 4 * rim > 5 * more(48), "{} {rim}", more(48));
}

/// A single drop of clear water is spray: smaller than a drop inside, and white. Milk and drops inside keep their color.
#[test]
fn single_drops_of_a_clear_liquid_are_small_and_white() {
    let drop = |center: [f32; 2], opacity| Drop { center, radius: 8.0, depth: 0.0, color: [200, 40, 40, opacity] };
    let painted = |opacity: u8, crowd: bool| {
        let (mut painting, mut canvas) = (Painting::default(), plain(0));
        painting.begin_liquid(1.0, sky(0), 0.0);
        let around = if crowd { 4 } else { 0 };
        for (i, j) in (0..=around).flat_map(|i: u8| (0..=around).map(move |j: u8| (i, j))) {
            let [x, y] = [i, j].map(|index| 48.0 + 8.0 * (f32::from(index) - 0.5 * f32::from(around)));
            painting.drop(drop([x, y], opacity));
        }
        painting.paint(&mut canvas);
        canvas
    };
    let blueness = |opacity, crowd| {
        let color = at(&painted(opacity, crowd), 48, 48).map(f64::from);
        color[2] / color[0]
    };
    assert!(blueness(60, false) > 0.8, "{}", blueness(60, false));
    assert!(blueness(60, true) < 0.5 && blueness(255, false) < 0.5);
    let width = (0..SIDE).filter(|&x| at(&painted(255, false), x, 48)[0] > 30).count();
    assert!((6..14).contains(&width), "{width}"); // two radii of 8 would be 16
}

#[test]
fn only_a_liquid_that_glows_lights_its_surroundings() {
    let beside = |glow: f32| {
        let (mut painting, mut canvas) = (Painting::default(), plain(0));
        painting.begin_liquid(1.0, sky(0), glow);
        block(4.0, 0.0, &mut painting);
        painting.paint(&mut canvas);
        [80, 84, 88].map(|x| at(&canvas, x, 48)[2])
    };
    assert_eq!(beside(0.0), [0; 3]);
    let [near, middle, far] = beside(1.0);
    assert!(near > middle && middle > far && near > 20, "{:?}", beside(1.0));
}

#[test]
fn trails_join_the_times_of_each_thing_and_fade_with_age() {
    let past = [[0.0, 0.0], [0.0, 9.0], [10.0, 0.0], [10.0, 9.0], [20.0, 0.0], [20.0, 9.0]];
    let gaps = [false, false, true, false];
    let (widths, colors) = ([6.0, 3.0], [[200, 100, 50, 255]; 2]);
    let trails =
        Trails { past: &past, widths: &widths, colors: &colors, fade: Some(([0; 3], 0.9)), gaps: Some(&gaps), depths: None };
    let lines: Vec<Line> = trails.lines().map(|(line, _)| line).collect();
    assert_eq!(lines.len(), 3);
    assert_eq!((lines[0].from, lines[0].to, lines[0].width), ([0.0, 0.0], [10.0, 0.0], 2.0));
    assert_eq!((lines[2].from, lines[2].to, lines[2].width), ([10.0, 9.0], [20.0, 9.0], 2.0));
    assert_eq!(lines[0].color, [60, 30, 15, 255]); // 0.9 · 1/3 of the color
    assert_eq!(lines[2].color, [120, 60, 30, 255]);
}

proptest! {
    /// Segments too short to be seen are joined: the result begins and ends where the trail does, without holes.
    #[test]
    fn trails_have_no_holes(steps in prop::collection::vec([-4.0..4.0_f32, -4.0..4.0_f32], 1..300)) {
        let mut past = vec![[0.0, 0.0]];
        for [dx, dy] in steps {
            let [x, y] = past[past.len() - 1];
            past.push([x + dx, y + dy]);
        }
        let trails = Trails { past: &past, widths: &[2.0], colors: &[WHITE], fade: None, gaps: None, depths: None };
        let lines: Vec<Line> = trails.lines().map(|(line, _)| line).collect();
        prop_assert_eq!(lines[0].from, past[0]);
        prop_assert_eq!(lines[lines.len() - 1].to, past[past.len() - 1]);
        prop_assert!(lines.windows(2).all(|pair| pair[0].to == pair[1].from && pair[0].width < pair[1].width));
    }
}

/// A fading trail does not cover other shapes: on a dark ground no channel becomes darker, on a light ground none lighter.
#[test]
fn a_faint_trail_leaves_what_is_brighter_below_it() {
    let past = [[4.0, 16.0], [60.0, 16.0]];
    for (ground, below) in [([10, 12, 16], [200, 60, 220]), ([250, 250, 250], [60, 120, 20])] {
        let mut canvas = Canvas::new(64, 32, ground).expect("a valid size");
        canvas.polygon(&[[30.0, 0.0], [64.0, 0.0], [64.0, 32.0], [30.0, 32.0]], [below[0], below[1], below[2], 255]);
        let before = canvas.pixels().to_vec();
        let trails = Trails {
            past: &past,
            widths: &[6.0],
            colors: &[[120, 100, 110, 255]],
            fade: Some((ground, 0.5)),
            gaps: None,
            depths: None,
        };
        let mut painting = Painting::default();
        trails.lines().for_each(|(line, depth)| painting.trail(line, trails.mixing(), depth));
        painting.paint(&mut canvas);
        let light = ground[0] > 128;
        let changed = canvas.pixels().iter().zip(&before).filter(|(now, before)| now != before).count();
        assert!(changed > 50, "the trail is seen on the ground");
        for (now, before) in canvas.pixels().iter().zip(&before) {
            for (now, before) in now.iter().zip(before) {
                assert!(if light { now <= before } else { now >= before }, "{now} over {before} on {ground:?}");
            }
        }
    }
}
