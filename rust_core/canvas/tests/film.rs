//! What a film holds is what was drawn, read back by the `gif` crate, which shares no code with the writer.

use std::fs;
use std::io::Write;

use physcore_canvas::{Canvas, Disc, Gif, Histogram, NewFile, Palette};
use proptest::prelude::*;

const BACKGROUND: [u8; 3] = [16, 19, 24];

fn canvas(width: usize, height: usize) -> Canvas {
    Canvas::new(width, height, BACKGROUND).expect("a valid size")
}

fn film(frames: &[(Canvas, u16)], palette: &Palette) -> Vec<u8> {
    let mut gif = Gif::new(Vec::new(), &frames[0].0, palette.clone()).expect("a vector takes all");
    for (frame, delay) in frames {
        gif.frame(frame, *delay).expect("a vector takes all");
    }
    gif.finish().expect("a vector takes all")
}

/// The colors on the screen after each frame, as the format says that a viewer shall compose them, and the delays.
fn shown(bytes: &[u8]) -> (Vec<Vec<[u8; 3]>>, Vec<u16>) {
    let mut decoder = gif::DecodeOptions::new().read_info(bytes).expect("a valid header");
    let table: Vec<[u8; 3]> = decoder.global_palette().expect("one palette").chunks(3).map(|c| [c[0], c[1], c[2]]).collect();
    let width = usize::from(decoder.width());
    let mut screen = vec![[0; 3]; width * usize::from(decoder.height())];
    let (mut screens, mut delays) = (Vec::new(), Vec::new());
    while let Some(frame) = decoder.read_next_frame().expect("a valid frame") {
        assert_eq!(frame.dispose, gif::DisposalMethod::Keep);
        for (index, &number) in frame.buffer.iter().enumerate() {
            let (column, row) = (index % usize::from(frame.width), index / usize::from(frame.width));
            if frame.transparent != Some(number) {
                let place = (row + usize::from(frame.top)) * width + column + usize::from(frame.left);
                screen[place] = table[usize::from(number)];
            }
        }
        screens.push(screen.clone());
        delays.push(frame.delay);
    }
    (screens, delays)
}

/// The colors that the palette gives each pixel.
fn reduced(canvas: &Canvas, palette: &mut Palette) -> Vec<[u8; 3]> {
    let mut indices = Vec::new();
    palette.indices(canvas, &mut indices);
    indices.iter().map(|&index| palette.colors()[usize::from(index) - 1]).collect()
}

fn palette_of(frames: &[(Canvas, u16)]) -> Palette {
    let mut histogram = Histogram::default();
    for (frame, _) in frames {
        histogram.observe(frame);
    }
    Palette::new(&histogram, &[BACKGROUND])
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn a_film_shows_the_frames_that_were_drawn(
        width in 1..80_usize, height in 1..60_usize,
        discs in prop::collection::vec((0.0..80.0_f32, 0.0..60.0_f32, 0.3..30.0_f32, any::<[u8; 4]>()), 1..12),
    ) {
        let mut frame = canvas(width, height);
        let mut frames = vec![(frame.clone(), 3)];
        for (index, &(x, y, radius, color)) in discs.iter().enumerate() {
            if index % 3 == 2 {
                frame.clear();
            }
            frame.disc(Disc { center: [x, y], radius, color, shading: 0.5, softness: 1.0 });
            frames.push((frame.clone(), 3 + index as u16));
            frames.push((frame.clone(), 4)); // a picture that rests is a frame all the same
        }
        let mut palette = palette_of(&frames);
        let bytes = film(&frames, &palette);
        let (screens, delays) = shown(&bytes);
        prop_assert_eq!(screens.len(), frames.len());
        for ((screen, delay), (frame, asked)) in screens.iter().zip(delays).zip(&frames) {
            prop_assert_eq!(delay, *asked);
            prop_assert_eq!(screen, &reduced(frame, &mut palette));
        }
        prop_assert_eq!(bytes, film(&frames, &palette), "the same frames give the same bytes");
    }
}

/// Noise fills the dictionary of 4096 strings again and again; with every change of its width, off by one would show here.
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
    let mut palette = palette_of(&frames);
    assert!(palette.colors().len() > 240, "noise needs the whole table");
    let (screens, _) = shown(&film(&frames, &palette));
    assert!(screens.iter().zip(&frames).all(|(screen, (frame, _))| *screen == reduced(frame, &mut palette)));
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
    assert_eq!(reduced(&frames[0].0, &mut palette_of(&frames)), drawn);
}

#[test]
fn what_rests_costs_almost_nothing() {
    let mut frame = canvas(320, 240);
    (0..200_u8).for_each(|index| {
        let center = [f32::from(index) * 1.6, f32::from(index.wrapping_mul(83)) * 0.9];
        frame.disc(Disc { center, radius: 6.0, color: [index, 200, 90, 255], shading: 0.4, softness: 1.0 });
    });
    let palette = palette_of(&[(frame.clone(), 3)]);
    let length = |frames: &[(Canvas, u16)]| film(frames, &palette).len();
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
