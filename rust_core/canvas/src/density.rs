//! Density of very many points as light: counted in pixels, smoothed, and exposed by the tone curve of a film.

use crate::canvas::Canvas;
use crate::color::Rgb;

/// Mapping of a density to colors.
#[derive(Clone, Copy, Debug)]
pub struct Exposure<'a> {
    /// Colors from the darkest to the brightest.
    pub table: &'a [Rgb],
    /// Exposure: light at the density of a typical point; 1 is a normal exposure.
    pub strength: f32,
    /// Standard deviation of the light of a point [pixels].
    pub spread: f32,
}

/// Light at a typical point, as input of the tone curve.
const TYPICAL: f32 = 0.5;
/// Tone above which a color is opaque.
const OPAQUE: f32 = 0.3;
/// Gamma exponent of displays.
const DISPLAY: f32 = 2.2;

/// Tone, 0 to 1, of an amount of light: dark parts keep their contrast, and bright parts do not saturate.
///
/// Source: K. Narkowicz, "ACES filmic tone mapping curve" (2016), a fit to the curve of the Academy Color Encoding System.
fn tone(light: f32) -> f32 {
    let curve = light * (2.51 * light + 0.03) / (light * (2.43 * light + 0.59) + 0.14);
    curve.clamp(0.0, 1.0).powf(1.0 / DISPLAY)
}

/// Light on a rectangle of pixels.
struct Film {
    width: usize,
    height: usize,
    light: Vec<f32>,
}

impl Film {
    /// Adds a point with some light, distributed over the four nearest pixels.
    fn add(&mut self, [x, y]: [f32; 2], light: f32) {
        let (x, y) = (x - 0.5, y - 0.5);
        // Negated, so NaN is outside.
        if !(x > -1.0 && y > -1.0 && x < self.width as f32 && y < self.height as f32) {
            return;
        }
        let (column, row) = (x.floor(), y.floor());
        let (right, down) = (x - column, y - row);
        for (rows, vertical) in [(0, 1.0 - down), (1, down)] {
            for (columns, horizontal) in [(0, 1.0 - right), (1, right)] {
                let (column, row) = (column as i64 + columns, row as i64 + rows);
                if column >= 0 && row >= 0 && (column as usize) < self.width && (row as usize) < self.height {
                    self.light[row as usize * self.width + column as usize] += vertical * horizontal * light;
                }
            }
        }
    }

    /// Spreads the light of each pixel by a Gaussian.
    fn smooth(&mut self, spread: f32) {
        let reach = (3.0 * spread).ceil() as usize;
        let weights: Vec<f32> = (0..=reach).map(|away| (-0.5 * (away as f32 / spread).powi(2)).exp()).collect();
        let sum = weights[0] + 2.0 * weights[1..].iter().sum::<f32>();
        let (width, mut spread) = (self.width, vec![0.0; self.light.len()]);
        for (row, out) in self.light.chunks_exact(width).zip(spread.chunks_exact_mut(width)) {
            for (away, weight) in weights.iter().map(|weight| weight / sum).enumerate().filter(|(away, _)| *away < width) {
                out[away..].iter_mut().zip(row).for_each(|(out, light)| *out += weight * light);
                if away > 0 {
                    out.iter_mut().zip(&row[away..]).for_each(|(out, light)| *out += weight * light);
                }
            }
        }
        self.light.fill(0.0);
        for row in 0..self.height {
            let out = &mut self.light[row * width..(row + 1) * width];
            for (away, weight) in weights.iter().map(|weight| weight / sum).enumerate() {
                let sources = [row.checked_sub(away), (away > 0 && row + away < self.height).then_some(row + away)];
                for source in sources.into_iter().flatten() {
                    let light = &spread[source * width..(source + 1) * width];
                    out.iter_mut().zip(light).for_each(|(out, light)| *out += weight * light);
                }
            }
        }
    }

    /// Density at a typical point: the mean density over all points.
    fn typical(&self) -> f32 {
        let (sum, squares) = self
            .light
            .iter()
            .fold((0.0_f64, 0.0), |(sum, squares), &light| (sum + f64::from(light), squares + f64::from(light * light)));
        if sum > 0.0 { (squares / sum) as f32 } else { 1.0 }
    }
}

impl Canvas {
    /// Draws the density of points [pixels] over the present picture, within the clip.
    pub fn density(&mut self, points: &[[f32; 2]], exposure: &Exposure<'_>) {
        let [left, top, right, bottom] = self.clipped();
        if left >= right || top >= bottom || exposure.table.is_empty() {
            return;
        }
        let (width, height) = (right - left, bottom - top);
        let mut film = Film { width, height, light: vec![0.0; width * height] };
        let times = self.samples() as f32;
        points.iter().for_each(|&[x, y]| film.add([times * x - left as f32, times * y - top as f32], 1.0));
        film.smooth((times * exposure.spread).max(0.1));
        let scale = TYPICAL * exposure.strength / film.typical();
        for (row, light) in film.light.chunks_exact(width).enumerate() {
            for (pixel, &light) in self.row_mut(top + row)[left..right].iter_mut().zip(light).filter(|(_, light)| **light > 0.0) {
                let tone = tone(scale * light);
                let color = exposure.table[((tone * exposure.table.len() as f32) as usize).min(exposure.table.len() - 1)];
                let share = (tone / OPAQUE).min(1.0);
                for channel in 0..3 {
                    let behind = f32::from(pixel[channel]);
                    pixel[channel] = (behind + (f32::from(color[channel]) - behind) * share + 0.5) as u8;
                }
            }
        }
    }
}

impl Canvas {
    /// Adds the light of points [pixels] of these colors to the present picture, within the clip. On a light background
    /// (`shadow`) they absorb it instead. Each channel has its own tone, so that bright light is white.
    pub fn starlight(&mut self, points: &[[f32; 2]], colors: &[Rgb], strength: f32, spread: f32, shadow: bool) {
        let [left, top, right, bottom] = self.clipped();
        if left >= right || top >= bottom {
            return;
        }
        let (width, height, times) = (right - left, bottom - top, self.samples() as f32);
        let films = [0, 1, 2].map(|channel| {
            let mut film = Film { width, height, light: vec![0.0; width * height] };
            for (&[x, y], color) in points.iter().zip(colors) {
                let value = if shadow { 255 - color[channel] } else { color[channel] };
                film.add([times * x - left as f32, times * y - top as f32], (f32::from(value) / 255.0).powf(DISPLAY));
            }
            film.smooth((times * spread).max(0.1));
            film
        });
        let mut sum = Film { width, height, light: vec![0.0; width * height] };
        for (index, light) in sum.light.iter_mut().enumerate() {
            *light = films.iter().map(|film| film.light[index]).sum::<f32>() / 3.0;
        }
        let scale = TYPICAL * strength / sum.typical();
        for row in 0..height {
            for (column, pixel) in self.row_mut(top + row)[left..right].iter_mut().enumerate() {
                for (channel, film) in films.iter().enumerate() {
                    let tone = tone(scale * film.light[row * width + column]);
                    let (behind, full) = (f32::from(pixel[channel]), if shadow { 0.0 } else { 255.0 });
                    pixel[channel] = (behind + (full - behind) * tone + 0.5) as u8;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHITE: [Rgb; 2] = [[0; 3], [255; 3]];

    #[test]
    fn all_light_of_a_point_inside_is_kept_and_points_outside_or_nowhere_add_none() {
        let mut film = Film { width: 20, height: 16, light: vec![0.0; 320] };
        film.add([8.3, 7.9], 1.0);
        film.smooth(1.0);
        assert!((film.light.iter().sum::<f32>() - 1.0).abs() < 1e-5);
        let brightest = (0..320).max_by(|&one, &other| film.light[one].total_cmp(&film.light[other])).unwrap();
        assert_eq!((brightest % 20, brightest / 20), (8, 7));
        for outside in [[-5.0, 3.0], [f32::NAN, 3.0], [f32::INFINITY, 3.0], [3.0, 99.0]] {
            film.add(outside, 1.0);
        }
        assert!((film.light.iter().sum::<f32>() - 1.0).abs() < 1e-5);
    }

    #[test]
    fn starlight_has_its_color_where_it_is_faint_and_is_white_where_it_is_bright() {
        let warm = [[255, 128, 64]; 5000];
        let draw = |points: &[[f32; 2]], ground: u8| {
            let mut canvas = Canvas::new(64, 64, [ground; 3]).unwrap();
            canvas.starlight(points, &warm, 1.0, 2.0, ground > 128);
            canvas
        };
        // 4000 points in the middle, and a thousandth of them alone: the typical point is in the middle.
        let mut points = vec![[32.5, 32.5]; 4000];
        points.extend([[10.5, 10.5]; 200]);
        let canvas = draw(&points, 0);
        let [middle, alone, nothing] = [(32, 32), (10, 10), (54, 10)].map(|(x, y)| canvas.pixels()[y * 64 + x]);
        assert!(alone[0] > alone[1] && alone[1] > alone[2] && alone[0] > 2 * alone[2]);
        assert!(middle[0] >= alone[0] && f32::from(middle[2]) / f32::from(middle[0]) > f32::from(alone[2]) / f32::from(alone[0]));
        assert_eq!(nothing[..3], [0; 3]);
        // On white the same light is a shadow of this color.
        let canvas = draw(&points, 255);
        let [alone, nothing] = [(10, 10), (54, 10)].map(|(x, y)| canvas.pixels()[y * 64 + x]);
        assert!(alone[0] > alone[1] && alone[1] > alone[2] && nothing[..3] == [255; 3]);
    }

    #[test]
    fn tones_rise_with_the_light_up_to_white() {
        let tones: Vec<f32> = (0..1000).map(|index| tone(0.01 * index as f32)).collect();
        assert!(tones.windows(2).all(|pair| pair[0] <= pair[1]) && tones[0] == 0.0 && tones[999] > 0.99);
        assert!(tone(0.01) > 0.05 && tone(TYPICAL) < 0.9);
    }

    #[test]
    fn the_clip_holds_and_more_points_of_the_same_kind_change_nothing() {
        let exposure = Exposure { table: &WHITE, strength: 1.0, spread: 1.0 };
        let points: Vec<[f32; 2]> = (0..400).map(|index| [0.5 + (index % 20) as f32, 0.5 + (index / 20) as f32]).collect();
        let draw = |points: &[[f32; 2]]| {
            let mut canvas = Canvas::new(20, 20, [0; 3]).unwrap();
            canvas.clip(5, 0, 20, 20);
            canvas.density(points, &exposure);
            canvas
        };
        let once = draw(&points);
        assert!((0..20).all(|row| once.pixels()[row * 20 + 4][0] == 0 && once.pixels()[row * 20 + 12][0] > 100));
        let thrice: Vec<[f32; 2]> = points.iter().flat_map(|&point| [point; 3]).collect();
        let difference = |(one, other): (&[u8; 4], &[u8; 4])| one[0].abs_diff(other[0]);
        assert!(once.pixels().iter().zip(draw(&thrice).pixels()).map(difference).all(|difference| difference <= 1));
    }
}
