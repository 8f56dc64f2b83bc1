//! The pixels of one frame, and the shapes drawn on them.

use crate::color::{Ink, Rgb};
use crate::error::Error;
use crate::shapes::{Disc, Line, drawn_half_width, drawn_radius, ramp};

/// A picture in sRGB. Shapes are blended in the order in which they are drawn; whatever lies outside is cut off.
#[derive(Clone, Debug)]
pub struct Canvas {
    width: usize,
    height: usize,
    /// Row by row from the top; the fourth byte is not used, but makes a pixel one machine word.
    pixels: Vec<[u8; 4]>,
    backdrop: Vec<[u8; 4]>,
    clip: Rectangle,
}

/// Columns and rows from `left`, `top` up to, not including, `right`, `bottom`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Rectangle {
    left: usize,
    top: usize,
    right: usize,
    bottom: usize,
}

impl Canvas {
    /// A canvas of one color; its sides are from 1 to 65535 pixels.
    pub fn new(width: usize, height: usize, background: Rgb) -> Result<Self, Error> {
        let sides = 1..=usize::from(u16::MAX);
        if !sides.contains(&width) || !sides.contains(&height) {
            return Err(Error::Size { width, height });
        }
        let pixels = vec![[background[0], background[1], background[2], 255]; width * height];
        let clip = Rectangle { left: 0, top: 0, right: width, bottom: height };
        Ok(Self { width, height, backdrop: pixels.clone(), pixels, clip })
    }

    /// Width [pixels].
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height [pixels].
    pub fn height(&self) -> usize {
        self.height
    }

    /// The pixels, row by row from the top: red, green, blue and a byte without meaning.
    pub fn pixels(&self) -> &[[u8; 4]] {
        &self.pixels
    }

    /// Makes what is on the canvas now the picture that [`Canvas::clear`] goes back to: what does not move is drawn once.
    pub fn keep(&mut self) {
        self.backdrop.copy_from_slice(&self.pixels);
    }

    /// Goes back to the backdrop: what was kept last, at first the background.
    pub fn clear(&mut self) {
        self.pixels.copy_from_slice(&self.backdrop);
    }

    /// From now on only this part of the picture is drawn on: columns `left..right`, rows `top..bottom` [pixels].
    pub fn clip(&mut self, left: usize, top: usize, right: usize, bottom: usize) {
        let (right, bottom) = (right.min(self.width), bottom.min(self.height));
        self.clip = Rectangle { left: left.min(right), top: top.min(bottom), right, bottom };
    }

    /// Draws a disc.
    pub fn disc(&mut self, disc: Disc) {
        let (radius, opacity) = drawn_radius(disc.radius);
        let reach = radius + 0.5;
        let [x, y] = disc.center;
        let Some(area) = self.visible([x - reach, y - reach], [x + reach, y + reach]) else { return };
        let shade = (disc.shading > 0.0).then(|| Shade::new(disc.color, disc.shading, radius));
        let full = (opacity * f32::from(disc.color[3]) * 256.0 / 255.0).round();
        for row in area.top..area.bottom {
            let dy = row as f32 + 0.5 - y;
            let half = (reach * reach - dy * dy).max(0.0).sqrt();
            let columns = columns(area, x - half, x + half);
            let offset = columns.start as f32 + 0.5 - x;
            for (index, pixel) in self.pixels[row * self.width..][columns].iter_mut().enumerate() {
                let dx = offset + index as f32;
                let amount = (ramp((dx * dx + dy * dy).sqrt() - radius) * full) as u32;
                let color = shade.as_ref().map_or(disc.color, |shade| shade.at(dx, dy));
                blend(pixel, color, amount);
            }
        }
    }

    /// Draws a line.
    pub fn line(&mut self, line: Line) {
        let (half, opacity) = drawn_half_width(line.width);
        let reach = half + 0.5;
        let ([x0, y0], [x1, y1]) = (line.from, line.to);
        let low = [x0.min(x1) - reach, y0.min(y1) - reach];
        let high = [x0.max(x1) + reach, y0.max(y1) + reach];
        let Some(area) = self.visible(low, high) else { return };
        let (ux, uy) = (x1 - x0, y1 - y0);
        let length = (ux * ux + uy * uy).sqrt();
        let per_square = if length > 0.0 { 1.0 / (length * length) } else { 0.0 };
        // Along a row the band around the line is this wide; a level line's band is the whole row.
        let (slope, spread) = if uy == 0.0 { (0.0, f32::INFINITY) } else { (ux / uy, reach * length / uy.abs()) };
        let full = (opacity * f32::from(line.color[3]) * 256.0 / 255.0).round();
        for row in area.top..area.bottom {
            let dy = row as f32 + 0.5 - y0;
            let middle = x0 + dy * slope;
            // Beyond an end the cap reaches as far as the end itself does, which the sides of the box bound.
            let columns = columns(area, (middle - spread).max(low[0]), (middle + spread).min(high[0]));
            let offset = columns.start as f32 + 0.5 - x0;
            for (index, pixel) in self.pixels[row * self.width..][columns].iter_mut().enumerate() {
                let dx = offset + index as f32;
                let along = ((dx * ux + dy * uy) * per_square).clamp(0.0, 1.0);
                let (ex, ey) = (dx - along * ux, dy - along * uy);
                blend(pixel, line.color, (ramp((ex * ex + ey * ey).sqrt() - half) * full) as u32);
            }
        }
    }

    /// Fills a convex polygon, whose corners may go round either way.
    pub fn polygon(&mut self, corners: &[[f32; 2]], color: Ink) {
        let low = corners.iter().fold([f32::MAX; 2], |low, c| [low[0].min(c[0]), low[1].min(c[1])]);
        let high = corners.iter().fold([f32::MIN; 2], |high, c| [high[0].max(c[0]), high[1].max(c[1])]);
        let Some(area) = self.visible([low[0] - 0.5, low[1] - 0.5], [high[0] + 0.5, high[1] + 0.5]) else { return };
        let edges = edges(corners);
        let full = f32::from(color[3]) * 256.0 / 255.0;
        for row in area.top..area.bottom {
            for column in area.left..area.right {
                let (x, y) = (column as f32 + 0.5, row as f32 + 0.5);
                let distance = edges.iter().fold(f32::MIN, |most, [nx, ny, c]| most.max(nx * x + ny * y - c));
                blend(&mut self.pixels[row * self.width + column], color, (ramp(distance) * full) as u32);
            }
        }
    }

    /// Blends `color` into one pixel with a coverage of 0–255; outside the picture nothing happens.
    pub(crate) fn dot(&mut self, x: i64, y: i64, color: Ink, coverage: u8) {
        let (Ok(column), Ok(row)) = (usize::try_from(x), usize::try_from(y)) else { return };
        let Rectangle { left, top, right, bottom } = self.clip;
        if (left..right).contains(&column) && (top..bottom).contains(&row) {
            let amount = u32::from(coverage) * u32::from(color[3]) * 256 / (255 * 255);
            blend(&mut self.pixels[row * self.width + column], color, amount);
        }
    }

    /// The pixels whose centers lie between two corners and inside the clip; none for coordinates that are not numbers.
    fn visible(&self, low: [f32; 2], high: [f32; 2]) -> Option<Rectangle> {
        let Rectangle { left, top, right, bottom } = self.clip;
        let first = |least: f32, from: usize| ((least - 0.5).ceil().max(0.0) as usize).max(from);
        let last = |most: f32, to: usize| ((most + 0.5).floor().max(0.0) as usize).min(to);
        let area = Rectangle {
            left: first(low[0], left),
            top: first(low[1], top),
            right: last(high[0], right),
            bottom: last(high[1], bottom),
        };
        let finite = low.iter().chain(&high).all(|value| value.is_finite());
        (finite && area.left < area.right && area.top < area.bottom).then_some(area)
    }
}

/// The pixels of a row whose centers lie from `low` to `high`, within `area`.
#[inline(always)]
fn columns(area: Rectangle, low: f32, high: f32) -> std::ops::Range<usize> {
    let start = ((low - 0.5).ceil().max(0.0) as usize).max(area.left).min(area.right);
    let end = ((high + 0.5).floor().max(0.0) as usize).min(area.right).max(start);
    start..end
}

/// Mixes `amount`/256 of a color into a pixel.
#[inline(always)]
fn blend(pixel: &mut [u8; 4], color: Ink, amount: u32) {
    let keep = 256 - amount;
    for channel in 0..3 {
        pixel[channel] = ((u32::from(pixel[channel]) * keep + u32::from(color[channel]) * amount + 128) >> 8) as u8;
    }
}

/// Outward unit normals n and offsets c of a convex polygon's sides: outside is where n·x > c.
fn edges(corners: &[[f32; 2]]) -> Vec<[f32; 3]> {
    let count = corners.len() as f32;
    let middle = corners.iter().fold([0.0; 2], |sum, c| [sum[0] + c[0] / count, sum[1] + c[1] / count]);
    let ends = corners.iter().zip(corners.iter().cycle().skip(1));
    ends.filter_map(|(from, to)| {
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        let length = (dx * dx + dy * dy).sqrt();
        let inward = dy * (middle[0] - from[0]) - dx * (middle[1] - from[1]) > 0.0;
        let scale = if inward { -1.0 } else { 1.0 } / length;
        let (nx, ny) = (dy * scale, -dx * scale);
        (length > 0.0).then_some([nx, ny, nx * from[0] + ny * from[1]])
    })
    .collect()
}

/// Light on a ball: Lambert's cosine from a lamp above the viewer's left shoulder, and a soft highlight.
struct Shade {
    color: Ink,
    strength: f32,
    per_radius: f32,
}

impl Shade {
    /// Direction to the lamp: left, up, toward the viewer; a unit vector.
    const LAMP: [f32; 3] = [-0.408, -0.577, 0.707];

    fn new(color: Ink, strength: f32, radius: f32) -> Self {
        Self { color, strength, per_radius: 1.0 / radius }
    }

    #[inline(always)]
    fn at(&self, dx: f32, dy: f32) -> Ink {
        let (nx, ny) = (dx * self.per_radius, dy * self.per_radius);
        let nz = (1.0 - nx * nx - ny * ny).max(0.0).sqrt();
        let light = (nx * Self::LAMP[0] + ny * Self::LAMP[1] + nz * Self::LAMP[2]).max(0.0);
        let highlight = 46.0 * self.strength * (light * light * light * light).powi(4);
        let factor = 1.0 - self.strength * (1.0 - light);
        let channel = |value: u8| (f32::from(value) * factor + highlight).min(255.0) as u8;
        [channel(self.color[0]), channel(self.color[1]), channel(self.color[2]), self.color[3]]
    }
}
