//! Tests of films: frames read back by the `gif` crate, which shares no code with the writer, equal the drawn frames.

use std::fs;
use std::io::Write;

use physcore_canvas::{Background, Canvas, CanvasError, Disc, Gif, Halo, Histogram, NewFile, Palette};
use proptest::prelude::*;

const BACKGROUND: [u8; 3] = [16, 19, 24];

fn canvas(width: usize, height: usize) -> Canvas {
    Canvas::new(width, height, BACKGROUND).expect("a valid size")
}

fn film(frames: &[(Canvas, u16)], palette: &Palette, tolerance: f32) -> Vec<u8> {
    let mut gif = Gif::new(Vec::new(), &frames[0].0, palette.clone()).expect("a vector takes all");
    gif.tolerate(tolerance);
    for (frame, delay) in frames {
        gif.frame(frame, *delay).expect("a vector takes all");
    }
    gif.finish().expect("a vector takes all")
}

/// Encodes a film on a separate thread.
fn film_in_background(frames: &[(Canvas, u16)], palette: &Palette, tolerance: f32) -> Vec<u8> {
    let gif = Gif::new(Vec::new(), &frames[0].0, palette.clone()).expect("a vector takes all");
    let mut background = Background::new(gif).expect("a thread");
    background.tolerate(tolerance).expect("a running thread");
    for (frame, delay) in frames {
        background.frame(frame, *delay).expect("a vector takes all");
    }
    let written = background.written().expect("a vector takes all");
    let bytes = background.finish().expect("a vector takes all");
    assert_eq!(written + 1, bytes.len() as u64, "all but the trailer");
    bytes
}

/// Colors on the screen after each frame, composed as the format prescribes for viewers, and the delays.
fn shown(bytes: &[u8]) -> (Vec<Vec<[u8; 3]>>, Vec<u16>) {
    let mut decoder = gif::DecodeOptions::new().read_info(bytes).expect("a valid header");
    let common = decoder.global_palette().expect("a palette of the film").to_vec();
    let width = usize::from(decoder.width());
    let mut screen = vec![[0; 3]; width * usize::from(decoder.height())];
    let (mut screens, mut delays) = (Vec::new(), Vec::new());
    while let Some(frame) = decoder.read_next_frame().expect("a valid frame") {
        assert_eq!(frame.dispose, gif::DisposalMethod::Keep);
        let (table, _) = frame.palette.as_ref().unwrap_or(&common).as_chunks::<3>();
        for (index, &number) in frame.buffer.iter().enumerate() {
            let (column, row) = (index % usize::from(frame.width), index / usize::from(frame.width));
            if frame.transparent != Some(number) {
                let pixel = (row + usize::from(frame.top)) * width + column + usize::from(frame.left);
                screen[pixel] = table[usize::from(number)];
            }
        }
        screens.push(screen.clone());
        delays.push(frame.delay);
    }
    (screens, delays)
}

fn palette_of(frames: &[(Canvas, u16)]) -> Palette {
    palette_with(frames, 255)
}

fn palette_with(frames: &[(Canvas, u16)], most: u8) -> Palette {
    let mut histogram = Histogram::default();
    for (frame, _) in frames {
        histogram.observe(frame);
    }
    Palette::new(&histogram, &[BACKGROUND], most)
}

/// Colors that a film of one picture shows.
fn reduced(canvas: &Canvas, palette: &Palette) -> Vec<[u8; 3]> {
    shown(&film(&[(canvas.clone(), 3)], palette, 0.0)).0.swap_remove(0)
}

fn colors(canvas: &Canvas) -> Vec<[u8; 3]> {
    canvas.pixels().iter().map(|&[red, green, blue, _]| [red, green, blue]).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// However long the film and large the tolerance: no frame is lost, what rests does not flicker, and the ground is clean.
    #[test]
    fn a_film_shows_the_frames_that_were_drawn(
        width in 1..80_usize, height in 1..60_usize, tolerance in prop_oneof![Just(0.0_f32), 0.1..8.0_f32],
        discs in prop::collection::vec((0.0..80.0_f32, 0.0..60.0_f32, 0.3..30.0_f32, any::<[u8; 4]>()), 1..12),
        most in 2..=255_u8,
    ) {
        let mut frame = canvas(width, height);
        let mut frames = vec![(frame.clone(), 3)];
        for (index, &(x, y, radius, color)) in discs.iter().enumerate() {
            if index % 3 == 2 {
                frame.clear();
            }
            frame.disc(Disc { center: [x, y], radius, color, shading: 0.5, softness: 1.0 });
            frames.push((frame.clone(), 3 + index as u16));
            frames.push((frame.clone(), 4)); // an unchanged picture is a frame too
        }
        let palette = palette_with(&frames, most);
        prop_assert!(palette.colors().len() <= usize::from(most));
        let bytes = film(&frames, &palette, tolerance);
        let (screens, delays) = shown(&bytes);
        prop_assert_eq!(screens.len(), frames.len());
        for ((screen, delay), (frame, asked)) in screens.iter().zip(delays).zip(&frames) {
            prop_assert_eq!(delay, *asked);
            for (shown, drawn) in screen.iter().zip(colors(frame)) {
                prop_assert!(drawn != BACKGROUND || *shown == BACKGROUND, "the ground is clean");
            }
        }
        for (screens, pair) in screens.windows(2).zip(frames.windows(2)) {
            let drawn = colors(&pair[0].0).into_iter().zip(colors(&pair[1].0));
            for ((p, q), (before, now)) in screens[0].iter().zip(&screens[1]).zip(drawn) {
                prop_assert!(p == q || before != now, "what rests does not flicker");
            }
        }
        prop_assert_eq!(&bytes, &film(&frames, &palette, tolerance), "the same frames give the same bytes");
        prop_assert_eq!(&bytes, &film_in_background(&frames, &palette, tolerance), "on any thread");
    }
}

/// Draws a row of pixels in these colors.
fn mosaic(colors: &[[u8; 3]]) -> Canvas {
    let mut frame = canvas(colors.len(), 1);
    for (&[red, green, blue], x) in colors.iter().zip(0_u16..) {
        let (left, right) = (f32::from(x), f32::from(x) + 1.0);
        frame.polygon(&[[left, 0.0], [right, 0.0], [right, 1.0], [left, 1.0]], [red, green, blue, 255]);
    }
    frame
}

/// Mean square error of a channel of a film of one picture.
fn mean_square_error(picture: &[[u8; 3]], shown: &[[u8; 3]]) -> f64 {
    let channels = picture.as_flattened().iter().zip(shown.as_flattened());
    channels.map(|(&drawn, &shown)| f64::from(drawn.abs_diff(shown)).powi(2)).sum::<f64>() / (3 * picture.len()) as f64
}

/// 2^k colors represent 256 / 2^k = L levels each with the mean square (L² − 1) / 12, and 1/4 for rounding, if the parts are equal.
/// They are equal in lightness, whose slope over the levels varies by a factor of two about the mean: four for the squares.
#[test]
fn a_gray_ramp_is_as_good_as_equal_steps() {
    let ramp: Vec<[u8; 3]> = (0..=255).map(|level| [level; 3]).collect();
    for parts in [8, 16, 32] {
        let levels = 256.0 / f64::from(parts);
        let frame = mosaic(&ramp);
        let got = mean_square_error(&ramp, &reduced(&frame, &palette_with(&[(frame.clone(), 3)], parts + 1)));
        let expected = 4.0 * (levels * levels - 1.0) / 12.0 + 0.25;
        assert!(got <= expected, "{parts} colors: {got} > {expected}");
    }
}

/// Two pictures of 240 colors that share none: each has its palette. With one for both, every second color would be missing.
#[test]
fn a_palette_is_renewed_where_that_pays() {
    let picture =
        |shift: u8| -> Vec<[u8; 3]> { (0..9600_u32).map(|n| [(n % 240) as u8, shift, 255 - (n % 240) as u8]).collect() };
    let pictures = [picture(10), picture(200)];
    let frames = pictures.clone().map(|picture| (mosaic(&picture), 3));
    let (screens, _) = shown(&film(&frames, &palette_with(&frames[..1], 255), 1.0));
    for (picture, screen) in pictures.iter().zip(&screens) {
        let error = mean_square_error(picture, screen);
        assert!(error < 4.0, "{error}");
    }
}

/// A flat color that is drawn is on the screen exactly, in the first frame and where it appears later, among a thousand others.
#[test]
fn flat_colors_are_exact() {
    let (first, second) = ([228, 87, 46, 255], [61, 142, 203, 255]);
    let scene = |index: u16, colors: &[[u8; 4]]| {
        let mut frame = canvas(160, 120);
        (0..160_u16).for_each(|x| {
            let ([left, right], level) = ([f32::from(x), f32::from(x) + 1.0], (x + 8 * index) as u8);
            frame.polygon(&[[left, 0.0], [right, 0.0], [right, 60.0], [left, 60.0]], [level, 255 - level, level / 2, 255]);
        });
        for (&color, place) in colors.iter().zip([40.0, 110.0]) {
            frame.polygon(&[[place, 20.0], [place + 30.0, 20.0], [place + 30.0, 80.0], [place, 80.0]], color);
        }
        (frame, 3)
    };
    let frames: Vec<_> = (0..6).map(|index| scene(index, &[first, second][..if index < 3 { 1 } else { 2 }])).collect();
    for tolerance in [0.0, 1.0, 4.0] {
        let (screens, _) = shown(&film(&frames, &palette_with(&frames[..1], 255), tolerance));
        for (screen, (frame, _)) in screens.iter().zip(&frames) {
            for (&shown, drawn) in screen.iter().zip(colors(frame)) {
                assert!(drawn != first[..3] && drawn != second[..3] || shown == drawn, "{tolerance}: {shown:?}");
            }
        }
    }
}

#[test]
fn fewer_colors_make_a_smaller_table() {
    let many: Vec<[u8; 3]> =
        (0..1000_u32).map(|n| n.wrapping_mul(0x9E37_79B1).to_be_bytes()).map(|[r, g, b, _]| [r, g, b]).collect();
    let frames = [(mosaic(&many), 3)];
    for (most, entries) in [(2, 4), (3, 4), (31, 32), (32, 64), (255, 256)] {
        let bytes = film(&frames, &palette_with(&frames, most), 0.0);
        let decoder = gif::DecodeOptions::new().read_info(&bytes[..]).expect("a valid header");
        let table = decoder.global_palette().expect("one palette");
        assert_eq!(table.len(), 3 * entries, "{most} colors and the transparent one");
    }
}

/// A moving ramp: its colors differ little from those of the previous frame.
#[test]
fn a_tolerant_film_is_smaller() {
    let ramp = |shift: u32| mosaic(&(0..4000_u32).map(|x| [((x + shift) % 500 / 2) as u8, 90, 40]).collect::<Vec<_>>());
    let frames: Vec<(Canvas, u16)> = (0..12).map(|frame| (ramp(frame), 3)).collect();
    let palette = palette_of(&frames);
    let [exact, tolerant] = [0.0, 2.0].map(|tolerance| film(&frames, &palette, tolerance).len());
    assert!(4 * tolerant < 3 * exact, "{tolerant} of {exact}");
}

/// Writer that accepts this number of bytes and then fails.
struct Full(usize);

impl Write for Full {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0 = self.0.checked_sub(bytes.len()).ok_or(std::io::ErrorKind::StorageFull)?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_full_disk_is_reported_from_the_other_thread_too() {
    let frame = mosaic(&[[1, 2, 3], [200, 100, 50]]);
    let palette = palette_of(&[(frame.clone(), 3)]);
    let gif = || Gif::new(Full(100), &frame, palette.clone()).expect("room for the header");
    let mut film = Background::new(gif()).expect("a thread");
    let failure = (0..100).find_map(|_| film.frame(&frame, 3).err()).expect("a full disk");
    assert!(matches!(failure, CanvasError::Write(cause) if cause.kind() == std::io::ErrorKind::StorageFull));
    assert!(film.frame(&frame, 3).is_err() && film.written().is_err(), "a failed film takes no more");
    assert!(film.finish().is_err());

    let mut last = Background::new(gif()).expect("a thread");
    (0..3).for_each(|_| last.frame(&frame, 3).expect("handed over before the disk is full"));
    assert!(last.written().is_err() || last.finish().is_err(), "no failure is lost at the end");
}

/// Noise fills the dictionary of 4096 strings repeatedly; an off-by-one error at a change of the code width would show here.
#[test]
fn noise_survives() {
    let mut state = 1_u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223); // Knuth's linear congruential generator
        (state >> 24) as u8
    };
    let mut frames = Vec::new();
    for _ in 0..4 {
        let mut frame = canvas(97, 61);
        for (x, y) in (0..97_u8).flat_map(|x| (0..61_u8).map(move |y| (x, y))) {
            let color = [next(), 30, next(), 255];
            let (x, y) = (f32::from(x), f32::from(y));
            frame.polygon(&[[x, y], [x + 1.0, y], [x + 1.0, y + 1.0], [x, y + 1.0]], color);
        }
        frames.push((frame, 2));
    }
    let palette = palette_of(&frames);
    assert!(palette.colors().len() > 240, "noise needs the whole table");
    let (screens, _) = shown(&film(&frames, &palette, 0.0));
    for (screen, (frame, _)) in screens.iter().zip(&frames) {
        // 254 squares in a plane of 256 × 256 levels have a side of 16 levels, and the mean square 16² / 12 in two of three channels.
        // Equal squares in Oklab are unequal ones in sRGB, by a factor of up to four.
        let error = mean_square_error(&colors(frame), screen);
        assert!(error < 4.0 * 16.0 * 16.0 / 12.0 * 2.0 / 3.0, "{error}");
    }
}

#[test]
fn a_picture_of_few_colors_keeps_each_exactly() {
    let mut frame = canvas(40, 20);
    for step in 0..20_u8 {
        let x = f32::from(step) * 2.0;
        frame.polygon(&[[x, 0.0], [x + 2.0, 0.0], [x + 2.0, 20.0], [x, 20.0]], [step * 9, 255 - step * 12, 77, 255]);
    }
    let drawn: Vec<[u8; 3]> = frame.pixels().iter().map(|p| [p[0], p[1], p[2]]).collect();
    let frames = [(frame, 5)];
    assert_eq!(reduced(&frames[0].0, &palette_of(&frames)), drawn);
}

#[test]
fn what_rests_costs_almost_nothing() {
    let mut frame = canvas(320, 240);
    (0..200_u8).for_each(|index| {
        let center = [f32::from(index) * 1.6, f32::from(index.wrapping_mul(83)) * 0.9];
        frame.disc(Disc { center, radius: 6.0, color: [index, 200, 90, 255], shading: 0.4, softness: 1.0 });
    });
    let palette = palette_of(&[(frame.clone(), 3)]);
    let length = |frames: &[(Canvas, u16)]| film(frames, &palette, 0.0).len();
    let once = length(&[(frame.clone(), 3)]);
    // Per frame: 8 bytes of graphic control, 10 of image descriptor, 3 around the data, and "clear, one pixel, end" in 27 bits.
    assert_eq!(length(&vec![(frame, 3); 11]), once + 10 * (8 + 10 + 3 + 4));
}

#[test]
fn frames_of_another_size_are_refused() {
    let first = canvas(20, 10);
    let mut gif = Gif::new(Vec::new(), &first, palette_of(&[(first.clone(), 3)])).expect("a vector takes all");
    assert!(gif.frame(&canvas(10, 20), 3).is_err());
}

#[test]
fn a_file_is_the_new_one_whole_or_the_old_one() {
    let folder = std::env::temp_dir().join(format!("physcore-canvas-{}", std::process::id()));
    fs::create_dir_all(&folder).expect("a temporary folder");
    let path = folder.join("film.gif");
    let entries = || fs::read_dir(&folder).expect("the folder").count();
    fs::write(&path, "old").expect("a file");

    let mut abandoned = NewFile::create(&path).expect("a file");
    abandoned.write_all(b"half of the ne").expect("space");
    assert_eq!(entries(), 2, "the temporary file stands beside its target");
    drop(abandoned);
    assert_eq!((fs::read(&path).expect("the file"), entries()), (b"old".to_vec(), 1));

    let mut finished = NewFile::create(&path).expect("a file");
    finished.write_all(b"new").expect("space");
    finished.commit().expect("a renamed file");
    assert_eq!((fs::read(&path).expect("the file"), entries()), (b"new".to_vec(), 1));

    assert!(NewFile::create(&folder).is_err(), "a folder is not a file");
    assert!(NewFile::create(&folder.join("none/film.gif")).is_err());
    fs::remove_dir_all(&folder).expect("an empty folder");
}

/// Draws a halo in the middle of a picture.
fn glowing(color: [u8; 3], shadow: bool) -> Canvas {
    let mut picture = Canvas::new(512, 512, if shadow { [250; 3] } else { BACKGROUND }).expect("a valid size");
    picture.halo(Halo { center: [256.0, 256.0], radius: 250.0, color: [color[0], color[1], color[2], 160], shadow });
    picture
}

/// Sum of the squared differences of mean colors over 8 × 8 pixels from those of a picture.
fn unevenness(picture: &Canvas, colors: &[[u8; 3]]) -> f64 {
    let width = picture.width();
    let mut sums = vec![[0.0; 3]; (width / 8) * (picture.height() / 8)];
    for (index, (drawn, shown)) in picture.pixels().iter().zip(colors).enumerate() {
        let square = &mut sums[index / width / 8 * (width / 8) + index % width / 8];
        (0..3).for_each(|channel| square[channel] += f64::from(shown[channel]) - f64::from(drawn[channel]));
    }
    sums.iter().flatten().map(|sum| (sum / 64.0) * (sum / 64.0)).sum()
}

/// With few colors, the mean errors of a gradient are less than half of those with nearest colors: no rings appear. (The means are
/// off where the palette ends, at the center, beyond which no color is available for mixing.)
#[test]
fn gradients_are_dithered_where_steps_would_be_seen() {
    for (color, shadow) in [([255, 190, 60], false), ([60, 160, 255], false), ([220, 90, 40], true)] {
        let picture = glowing(color, shadow);
        let mut histogram = Histogram::default();
        histogram.observe(&picture);
        let ground = colors(&picture)[0];
        let palette = Palette::new(&histogram, &[ground], 12);
        let nearest: Vec<[u8; 3]> = colors(&picture)
            .iter()
            .map(|pixel| {
                let away = |entry: &&[u8; 3]| (0..3).map(|c| i32::from(entry[c].abs_diff(pixel[c])).pow(2)).sum::<i32>();
                *palette.colors().iter().min_by_key(away).expect("a color")
            })
            .collect();
        let dithered = reduced(&picture, &palette);
        let (before, after) = (unevenness(&picture, &nearest), unevenness(&picture, &dithered));
        assert!(after < before / 4.0, "{color:?}: {after} after {before}");
    }
}

/// A color is included if none is within 24 levels in each channel, up to the 8 of a cell. The palette then contains it, and a
/// similar color changes nothing.
#[test]
fn included_colors_are_in_the_palette() {
    let mut picture = canvas(64, 64);
    let ball = Disc { center: [32.0, 32.0], radius: 25.0, color: [122, 63, 208, 255], shading: 0.8, softness: 1.0 };
    picture.disc(ball);
    let mut histogram = Histogram::default();
    histogram.observe(&picture);
    let plain = Palette::new(&histogram, &[BACKGROUND], 255);
    histogram.include(&[[124, 60, 210]]);
    assert_eq!(Palette::new(&histogram, &[BACKGROUND], 255).colors(), plain.colors());
    histogram.include(&[[255, 140, 26]]);
    for most in [255, 16] {
        let palette = Palette::new(&histogram, &[BACKGROUND], most);
        let away = |color: &[u8; 3]| (0..3).map(|c| u32::from(color[c].abs_diff([255, 140, 26][c])).pow(2)).sum::<u32>();
        assert!(palette.colors().iter().map(away).min().expect("a color") < 100, "{most}");
    }
}
