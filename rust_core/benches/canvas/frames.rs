//! Benchmark of frames of 640×480 with 5000 discs: drawing and GIF encoding.

use criterion::{Criterion, criterion_group, criterion_main};
use physcore_canvas::{Canvas, Disc, Gif, Histogram, Line, Painting, Palette};

const SIZE: (usize, usize) = (640, 480);
const BACKGROUND: [u8; 3] = [16, 19, 24];

/// Draws discs that bounce in the picture, frame by frame, placed by a low-discrepancy sequence (golden and plastic ratios).
fn picture(canvas: &mut Canvas, frame: usize) {
    canvas.clear();
    for index in 0..5000_u16 {
        let seed = f32::from(index);
        let bounce = |start: f32, speed: f32, side: f32| {
            let path = (start * side + speed * frame as f32).rem_euclid(2.0 * side);
            path.min(2.0 * side - path)
        };
        let (u, v, w) = ((seed * 0.754_877_7).fract(), (seed * 0.569_840_3).fract(), (seed * 0.618_034).fract());
        let center = [bounce(u, 6.0 * (v - 0.5), 640.0), bounce(v, 6.0 * (w - 0.5), 480.0)];
        let color = [(60.0 + 190.0 * w) as u8, (80.0 + 150.0 * u) as u8, (250.0 - 180.0 * w) as u8, 255];
        canvas.disc(Disc { center, radius: 3.0, color, shading: 0.0, softness: 1.0 });
    }
}

fn palette() -> Palette {
    let mut histogram = Histogram::default();
    let mut canvas = Canvas::new(SIZE.0, SIZE.1, BACKGROUND).expect("a valid size");
    picture(&mut canvas, 0);
    histogram.observe(&canvas);
    Palette::new(&histogram, &[BACKGROUND], 255)
}

fn frames(criterion: &mut Criterion) {
    let mut canvas = Canvas::new(SIZE.0, SIZE.1, BACKGROUND).expect("a valid size");
    let pictures: Vec<Canvas> = (0..20)
        .map(|frame| {
            picture(&mut canvas, frame);
            canvas.clone()
        })
        .collect();
    criterion.bench_function("draw 5000 discs", |bencher| bencher.iter(|| picture(&mut canvas, 7)));
    criterion.bench_function("draw 20000 short lines", |bencher| {
        let mut painting = Painting::default();
        bencher.iter(|| {
            canvas.clear();
            for index in 0..20_000_u16 {
                let (x, y) = (f32::from(index % 200) * 3.2, f32::from(index / 200) * 4.8);
                let line = Line { from: [x, y], to: [x + 5.0, y + 3.0], width: 1.5, color: [200, 90, 40, 255], softness: 1.0 };
                painting.line(line, [0.0; 2]);
            }
            painting.paint(&mut canvas);
        });
    });
    let mut film = Gif::new(std::io::sink(), &canvas, palette()).expect("a sink takes all");
    let mut number = 0;
    criterion.bench_function("encode a frame", |bencher| {
        bencher.iter(|| {
            number = (number + 1) % pictures.len();
            film.frame(&pictures[number], 3).expect("a sink takes all");
        });
    });
}

criterion_group!(benches, frames);
criterion_main!(benches);
