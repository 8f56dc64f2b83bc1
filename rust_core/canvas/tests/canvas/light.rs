//! Tests of light and ground: shadows fall where an object blocks the lamp, and nowhere else; ground is where its plane is seen.

use physcore_canvas::{Canvas, Disc, Eye, Ground, Light, Line, Painting, Triangle};

const SIDE: usize = 200;
const GRAY: u8 = 200;
/// Lamp direction straight above, in a picture whose vertical axis is up.
const ABOVE: [f32; 3] = [0.0, 1.0, 0.0];

/// Draws an orthographic view, 50 pixels per unit, of a floor at the height −1, seen from 45 degrees above.
fn floor(grid: Option<([u8; 3], f32, f32)>) -> Canvas {
    let mut canvas = Canvas::new(SIDE, SIDE, [10; 3]).expect("a valid size");
    canvas.look_from(Eye { scale: 50.0, middle: [100.0, 100.0], distance: f32::INFINITY });
    let half = 0.5_f32.sqrt();
    // The vertical axis of the scene is tilted toward the eye.
    let normal = [0.0, half, half];
    let center = normal.map(|component| -component);
    canvas.ground(&Ground { normal, center, size: 100.0, color: [GRAY; 3], grid, along: [1.0, 0.0, 0.0], part: None });
    canvas.keep();
    canvas
}

fn lit(balls: &[([f32; 2], f32, f32)], lamp: [f32; 3]) -> Canvas {
    let (mut painting, mut canvas) = (Painting::default(), floor(None));
    painting.light(Light { lamp, shadow: 0.5, occlusion: 0.0, reach: 8.0 });
    for &(center, radius, depth) in balls {
        painting.disc(Disc { center, radius, color: [255, 0, 0, 255], shading: 0.5, softness: 1.0 }, depth);
    }
    painting.paint(&mut canvas);
    canvas
}

fn gray(canvas: &Canvas, x: usize, y: usize) -> u8 {
    canvas.pixels()[y * SIDE + x][0]
}

/// Along the floor's normal n, the foot of the center c of a ball is c − ((c + n)·n) n. For the focus it is −n, seen 50·√½ = 35
/// pixels below the middle of the picture. The dither of the floor is at most 1.5 levels.
#[test]
fn a_ball_has_its_shadow_at_its_foot_and_nowhere_else() {
    let half = 0.5_f32.sqrt();
    let canvas = lit(&[([100.0, 100.0], 15.0, 0.0)], [0.0, half, half]);
    let foot = gray(&canvas, 100, 135);
    assert!((0.45..0.65).contains(&(f32::from(foot) / f32::from(GRAY))), "{foot}");
    for (x, y) in [(20, 135), (180, 135), (100, 190), (30, 60)] {
        assert!(gray(&canvas, x, y) >= GRAY - 2, "{x}, {y}");
    }
}

/// The floor is the plane y' = −1 along its normal; a lamp along the floor from the left has an incidence cosine of 0.
#[test]
fn no_shadow_falls_on_what_the_lamp_does_not_reach() {
    let canvas = lit(&[([100.0, 100.0], 15.0, 0.0)], [-1.0, 0.0, 0.0]);
    let beside = |pixel: &usize| (pixel % SIDE).abs_diff(100).pow(2) + (pixel / SIDE).abs_diff(100).pow(2) > 17 * 17;
    assert!((0..SIDE * SIDE).filter(beside).all(|pixel| canvas.pixels()[pixel][1] >= GRAY - 3));
}

/// Where two sides of a body meet, the side with its center in a pixel keeps half of it or more, whichever is drawn first. An
/// edge between many sides therefore does not alternate.
#[test]
fn an_edge_lies_where_its_sides_meet_in_either_order() {
    let picture = |first: usize| {
        let mut canvas = Canvas::new(SIDE, SIDE, [10; 3]).expect("a valid size");
        canvas.look_from(Eye { scale: 50.0, middle: [100.0, 100.0], distance: f32::INFINITY });
        let mut painting = Painting::default();
        for (index, corner) in [[60.0, 20.0], [140.0, 180.0]].into_iter().enumerate() {
            let triangle = Triangle {
                corners: [[40.0, 110.0], [160.0, 90.0], corner],
                colors: [[[255, 0][index], 0, 0, 255]; 3],
                depths: [0.0, 0.0, 1.0],
                lit: true,
                texture_coordinates: [[0.0; 2]; 3],
            };
            painting.triangle(triangle, None, if index == first { 0.1 } else { 0.0 });
        }
        painting.paint(&mut canvas);
        canvas
    };
    let (one, other) = (picture(0), picture(1));
    for x in 60..140 {
        for y in 90..110 {
            let (here, there) = (gray(&one, x, y), gray(&other, x, y));
            assert!(here.abs_diff(there) <= 128, "{x}, {y}: {here} and {there}");
            let above = 110.0 - (x as f32 + 0.5 - 40.0) / 6.0 - (y as f32 + 0.5);
            if above.abs() > 0.1 {
                assert_eq!((here >= 127, there >= 127), (above > 0.0, above > 0.0), "{x}, {y}: {here} and {there}");
            }
        }
    }
}

/// Nothing is above a plane, even one made of thin triangles.
#[test]
fn a_wall_of_thin_triangles_takes_no_light_from_itself() {
    for slope in [0.0_f32, 0.01, 0.04] {
        let mut canvas = Canvas::new(SIDE, SIDE, [10; 3]).expect("a valid size");
        canvas.look_from(Eye { scale: 50.0, middle: [100.0, 100.0], distance: f32::INFINITY });
        let mut painting = Painting::default();
        painting.light(Light { lamp: ABOVE, shadow: 0.0, occlusion: 0.8, reach: 10.0 });
        let node = |column: u8, row: f32| [40.0 + 1.3 * f32::from(column) + 0.1 * row, 30.0 + 140.0 * row];
        let depth = |[x, y]: [f32; 2]| slope * (x - y);
        for column in 0..90 {
            let [a, b, c, d] = [(0, 0.0), (1, 0.0), (0, 1.0), (1, 1.0)].map(|(right, row)| node(column + right, row));
            for corners in [[a, c, d], [a, d, b]] {
                let depths = corners.map(depth);
                let colors = [[GRAY, 0, 0, 255]; 3];
                let triangle = Triangle { corners, colors, depths, lit: true, texture_coordinates: [[0.0; 2]; 3] };
                painting.triangle(triangle, None, depths.iter().sum::<f32>() / 3.0);
            }
        }
        painting.paint(&mut canvas);
        for x in 45..150 {
            for y in 35..165 {
                assert!(gray(&canvas, x, y) >= GRAY - 1, "{slope}, {x}, {y}: {}", gray(&canvas, x, y));
            }
        }
    }
}

/// A straight rod is convex: no part of it is above another part, however it is composed.
#[test]
fn a_rod_of_several_lines_takes_no_light_from_itself() {
    for slope in [-0.015_f32, 0.0, 0.004, 0.015] {
        let mut canvas = Canvas::new(SIDE, SIDE, [10; 3]).expect("a valid size");
        canvas.look_from(Eye { scale: 50.0, middle: [100.0, 100.0], distance: f32::INFINITY });
        let mut painting = Painting::default();
        painting.light(Light { lamp: ABOVE, shadow: 0.0, occlusion: 0.8, reach: 10.0 });
        let (place, depth) = (|x: f32| [x, 80.0 + 0.2 * x], |x: f32| slope * (x - 100.0));
        for part in 0..14_u8 {
            let (low, high) = (30.0 + 10.0 * f32::from(part), 40.0 + 10.0 * f32::from(part));
            let line = Line { from: place(low), to: place(high), width: 16.0, color: [GRAY, 0, 0, 255], softness: 1.0 };
            painting.line(line, [depth(low), depth(high)]);
        }
        painting.paint(&mut canvas);
        for x in 40..160 {
            for away in -4..=4 {
                let y = (place(x as f32)[1] as i32 + away) as usize;
                assert!(gray(&canvas, x, y) >= GRAY - 1, "{slope}, {x}, {y}: {}", gray(&canvas, x, y));
            }
        }
    }
}

#[test]
fn a_place_among_others_gets_less_light_from_around() {
    let crowd: Vec<([f32; 2], f32, f32)> =
        (0..81).map(|index| ([60.0 + 10.0 * (index % 9) as f32, 60.0 + 10.0 * (index / 9) as f32], 5.0, 0.0)).collect();
    let total = |occlusion: f32| -> u32 {
        let (mut painting, mut canvas) = (Painting::default(), floor(None));
        painting.light(Light { lamp: ABOVE, shadow: 0.0, occlusion, reach: 10.0 });
        for &(center, radius, depth) in &crowd {
            painting.disc(Disc { center, radius, color: [255, 0, 0, 255], shading: 0.5, softness: 1.0 }, depth);
        }
        painting.paint(&mut canvas);
        canvas.pixels().iter().map(|pixel| u32::from(pixel[0])).sum()
    };
    assert!(total(0.8) < total(0.4) && total(0.4) < total(0.0));
    // Far from the crowd, no light is lost.
    let (mut painting, mut canvas) = (Painting::default(), floor(None));
    painting.light(Light { lamp: ABOVE, shadow: 0.0, occlusion: 0.8, reach: 10.0 });
    painting.disc(Disc { center: [100.0, 100.0], radius: 5.0, color: [255; 4], shading: 0.5, softness: 1.0 }, 0.0);
    painting.paint(&mut canvas);
    assert_eq!(gray(&canvas, 20, 20), gray(&floor(None), 20, 20));
}

/// Colors that represent values are exact: an unshaded disc receives no light.
#[test]
fn what_is_not_shaded_is_not_lit() {
    let (mut painting, mut canvas) = (Painting::default(), floor(None));
    painting.light(Light { lamp: ABOVE, shadow: 0.9, occlusion: 0.9, reach: 10.0 });
    painting.disc(Disc { center: [100.0, 100.0], radius: 20.0, color: [77, 0, 0, 255], shading: 0.0, softness: 1.0 }, 0.5);
    painting.disc(Disc { center: [100.0, 80.0], radius: 9.0, color: [255; 4], shading: 0.5, softness: 1.0 }, 0.0);
    painting.paint(&mut canvas);
    assert_eq!(gray(&canvas, 100, 110), 77);
}

/// Lines a unit apart along x are 50 pixels apart; across them the floor is tilted by 45 degrees, which gives 35 pixels.
#[test]
fn the_grid_has_its_pitch_in_perspective() {
    let canvas = floor(Some(([0; 3], 1.0, 1.0)));
    let dark = |pixels: Vec<u8>| pixels.into_iter().filter(|&pixel| pixel < GRAY / 2).count();
    let row: Vec<u8> = (0..SIDE).map(|x| gray(&canvas, x, 150)).collect();
    let column: Vec<u8> = (0..SIDE).map(|y| gray(&canvas, 125, y)).collect();
    assert!((3..=10).contains(&dark(row)) && (4..=12).contains(&dark(column)));
}

#[test]
fn threads_and_bad_numbers_do_not_show() {
    let nan = lit(&[([f32::NAN, 4.0], 3.0, 0.0), ([50.0, 50.0], f32::INFINITY, 0.0), ([60.0, 60.0], 4.0, f32::NAN)], ABOVE);
    assert_eq!(nan.pixels().len(), SIDE * SIDE);
    let balls: Vec<([f32; 2], f32, f32)> =
        (0..1500).map(|index| ([(index * 37 % 200) as f32, (index * 91 % 200) as f32], 3.0, (index % 7) as f32 * 0.1)).collect();
    let (one, other) = (lit(&balls, ABOVE), lit(&balls, ABOVE));
    assert!(one.pixels() == other.pixels());
}

/// Draws an orthographic view of a wall that faces the eye, from −1 to 1 along both axes, two lengths behind the focus.
fn wall(normal: [f32; 3]) -> Canvas {
    let mut canvas = Canvas::new(SIDE, SIDE, [10; 3]).expect("a valid size");
    canvas.look_from(Eye { scale: 50.0, middle: [100.0, 100.0], distance: f32::INFINITY });
    let part = Some(([[50.0, 50.0], [150.0, 50.0], [150.0, 150.0], [50.0, 150.0]], 1.0));
    let (center, color) = ([0.0, 0.0, -2.0], [GRAY; 3]);
    canvas.ground(&Ground { normal, center, size: 1.0, color, grid: None, along: [1.0, 0.0, 0.0], part });
    canvas.keep();
    canvas
}

/// A wall lies between its corners and is seen from its front. The lamp is 45 degrees to the left. A ball two lengths in front of
/// the wall therefore casts its shadow two lengths, 100 pixels, to its right.
#[test]
fn a_wall_is_between_its_corners_and_takes_shadows() {
    let half = 0.5_f32.sqrt();
    assert!(wall([0.0, 0.0, -1.0]).pixels().iter().all(|pixel| pixel[0] == 10));
    let bare = wall([0.0, 0.0, 1.0]);
    for (x, y, seen) in [(60, 60, GRAY), (140, 140, GRAY), (40, 100, 10), (100, 160, 10)] {
        assert!(gray(&bare, x, y).abs_diff(seen) <= 2, "{x}, {y}: {}", gray(&bare, x, y));
    }
    let (mut painting, mut canvas) = (Painting::default(), bare);
    painting.light(Light { lamp: [-half, 0.0, half], shadow: 0.5, occlusion: 0.0, reach: 8.0 });
    painting.disc(Disc { center: [20.0, 100.0], radius: 12.0, color: [255, 0, 0, 255], shading: 0.5, softness: 1.0 }, 0.0);
    painting.paint(&mut canvas);
    let shadow = f32::from(gray(&canvas, 120, 100)) / f32::from(GRAY);
    assert!((0.45..0.65).contains(&shadow), "{shadow}");
    for (x, y) in [(75, 100), (120, 65), (120, 135)] {
        assert!(gray(&canvas, x, y) >= GRAY - 2, "{x}, {y}");
    }
}

/// Two walls that meet take no light from each other, wherever other objects are: otherwise the corner would be dark only near
/// these.
#[test]
fn what_stands_still_is_not_darker_where_something_is_near() {
    let half = 0.5_f32.sqrt();
    let draw = |ball: bool| {
        let mut canvas = Canvas::new(SIDE, SIDE, [10; 3]).expect("a valid size");
        canvas.look_from(Eye { scale: 50.0, middle: [100.0, 100.0], distance: f32::INFINITY });
        for (side, left, right) in [(1.0, 50.0, 100.0), (-1.0, 100.0, 150.0)] {
            let part = Some(([[left, 50.0], [right, 50.0], [right, 150.0], [left, 150.0]], 1.0));
            let (normal, center) = ([side * half, 0.0, half], [0.0, 0.0, -2.0]);
            let (color, along) = ([GRAY; 3], [0.0, 1.0, 0.0]);
            canvas.ground(&Ground { normal, center, size: 1.0, color, grid: None, along, part });
        }
        canvas.keep();
        let mut painting = Painting::default();
        painting.light(Light { lamp: [0.0, 0.0, 1.0], shadow: 0.0, occlusion: 0.8, reach: 12.0 });
        let center = if ball { [100.0, 70.0] } else { [100.0, 10.0] };
        painting.disc(Disc { center, radius: 6.0, color: [255, 0, 0, 255], shading: 0.5, softness: 1.0 }, 1.9);
        painting.paint(&mut canvas);
        canvas
    };
    let (near, far) = (draw(true), draw(false));
    for row in 95..140 {
        assert_eq!(gray(&near, 99, row), gray(&far, 99, row), "{row}");
    }
    let darker = (77..82).map(|row| gray(&far, 99, row) - gray(&near, 99, row)).max();
    assert!(darker > Some(5), "{darker:?}");
}
