//! Pixels of one frame.

#![expect(clippy::cast_possible_wrap, reason = "no side is longer than 65535 pixels")]

use std::borrow::Cow;

use crate::band::{Band, Rectangle};
use crate::color::{Ink, Rgb};
use crate::error::CanvasError;
use crate::eye::{Eye, OPEN};
use crate::ink::Mixing;
use crate::shapes::{Disc, Halo, Line, Triangle};
use crate::texture::Texture;

/// Picture in sRGB. Shapes are blended in the order of drawing and clipped to the picture.
#[derive(Clone, Debug)]
pub struct Canvas {
    width: usize,
    height: usize,
    /// Number of pixels along each side of a pixel of the picture returned by [`Canvas::reduced`].
    samples: usize,
    /// Pixels, row by row from the top. The fourth byte has no meaning.
    pixels: Vec<[u8; 4]>,
    backdrop: Vec<[u8; 4]>,
    /// Eye of a picture in space, and the depth of the surface that each pixel shows; empty without an eye.
    eye: Option<Eye>,
    depths: Vec<f32>,
    backdrop_depths: Vec<f32>,
    clip: Rectangle,
}

impl Canvas {
    /// Creates a canvas of one color. Its sides are from 1 to 65535 pixels.
    pub fn new(width: usize, height: usize, background: Rgb) -> Result<Self, CanvasError> {
        Self::supersampled(width, height, background, 1)
    }

    /// Creates a canvas that draws `samples` × `samples` pixels for each pixel of a picture of this size. Positions and lengths
    /// are given in pixels of that picture, which is [`Canvas::reduced`].
    pub fn supersampled(width: usize, height: usize, background: Rgb, samples: usize) -> Result<Self, CanvasError> {
        let (width, height) = (width.saturating_mul(samples), height.saturating_mul(samples));
        let sides = 1..=usize::from(u16::MAX);
        if !sides.contains(&width) || !sides.contains(&height) {
            return Err(CanvasError::Size { width, height });
        }
        let pixels = vec![[background[0], background[1], background[2], 0]; width * height];
        let clip = Rectangle { left: 0, top: 0, right: width as i32, bottom: height as i32 };
        let (depths, backdrop_depths) = (Vec::new(), Vec::new());
        Ok(Self { width, height, samples, backdrop: pixels.clone(), pixels, eye: None, depths, backdrop_depths, clip })
    }

    /// Width [pixels].
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height [pixels].
    pub fn height(&self) -> usize {
        self.height
    }

    /// Pixels, row by row from the top: red, green, blue, and a byte without meaning.
    pub fn pixels(&self) -> &[[u8; 4]] {
        &self.pixels
    }

    /// Number of pixels along each side of a pixel of the reduced picture.
    pub(crate) fn samples(&self) -> usize {
        self.samples
    }

    /// Reduced picture: each of its pixels is the mean of the samples drawn for it.
    pub fn reduced(&self) -> Cow<'_, Self> {
        if self.samples == 1 {
            return Cow::Borrowed(self);
        }
        let (width, height, count) =
            (self.width / self.samples, self.height / self.samples, (self.samples * self.samples) as u32);
        let mut pixels = Vec::with_capacity(width * height);
        let mut sums = vec![[0_u32; 4]; width];
        for rows in self.pixels.chunks_exact(self.width * self.samples) {
            sums.fill([0; 4]);
            for row in rows.chunks_exact(self.width) {
                for (sum, drawn) in sums.iter_mut().zip(row.chunks_exact(self.samples)) {
                    for pixel in drawn {
                        (0..4).for_each(|channel| sum[channel] += u32::from(pixel[channel]));
                    }
                }
            }
            pixels.extend(sums.iter().map(|sum| sum.map(|sum| ((sum + count / 2) / count) as u8)));
        }
        let clip = Rectangle { left: 0, top: 0, right: width as i32, bottom: height as i32 };
        let (depths, backdrop_depths, eye, backdrop) = (Vec::new(), Vec::new(), None, Vec::new());
        Cow::Owned(Self { width, height, samples: 1, pixels, backdrop, eye, depths, backdrop_depths, clip })
    }

    /// Makes the present picture the backdrop that [`Canvas::clear`] restores: static shapes are drawn only once.
    pub fn keep(&mut self) {
        self.backdrop.copy_from_slice(&self.pixels);
        self.backdrop_depths.clone_from(&self.depths);
    }

    /// Restores the backdrop: the picture kept last, or initially the background.
    pub fn clear(&mut self) {
        self.pixels.copy_from_slice(&self.backdrop);
        self.depths.clone_from(&self.backdrop_depths);
    }

    /// Sets the eye of all later drawing: from now on the depth of each pixel is recorded.
    pub fn look_from(&mut self, eye: Eye) {
        let times = self.samples as f32;
        self.eye = Some(Eye { scale: times * eye.scale, middle: eye.middle.map(|place| times * place), ..eye });
        self.depths.resize(self.pixels.len(), OPEN);
    }

    /// Eye of the picture, if any.
    pub(crate) fn eye(&self) -> Option<Eye> {
        self.eye
    }

    /// Sets the clip of all later drawing: columns `left..right`, rows `top..bottom` [pixels].
    pub fn clip(&mut self, left: usize, top: usize, right: usize, bottom: usize) {
        let [left, top, right, bottom] = [left, top, right, bottom].map(|edge| edge.saturating_mul(self.samples));
        let (right, bottom) = (right.min(self.width), bottom.min(self.height));
        let (left, top) = (left.min(right), top.min(bottom));
        self.clip = Rectangle { left: left as i32, top: top as i32, right: right as i32, bottom: bottom as i32 };
    }

    /// Draws a disc.
    pub fn disc(&mut self, disc: Disc) {
        let disc = disc.scaled(self.samples as f32);
        self.whole().disc(disc);
    }

    /// Draws a line.
    pub fn line(&mut self, line: Line) {
        let line = line.scaled(self.samples as f32);
        self.whole().line(line, Mixing::Over);
    }

    /// Draws a triangle, enlarged by half a pixel.
    pub fn triangle(&mut self, triangle: &Triangle, texture: Option<&Texture>) {
        let triangle = triangle.scaled(self.samples as f32);
        self.whole().triangle(&triangle, texture, None);
    }

    /// Draws a halo.
    pub fn halo(&mut self, halo: Halo) {
        let halo = halo.scaled(self.samples as f32);
        self.whole().halo(halo);
    }

    /// Copies a picture of `width` columns, row by row from the top, with its upper left corner at a pixel.
    pub fn picture(&mut self, picture: &[Rgb], width: usize, [left, top]: [i32; 2]) {
        let Rectangle { left: first, top: highest, right: last, bottom: lowest } = self.clip;
        let samples = self.samples as i32;
        for (row, colors) in (top..).zip(picture.chunks_exact(width.max(1))) {
            for row in (samples * row..samples * (row + 1)).filter(|row| (highest..lowest).contains(row)) {
                for (column, &[red, green, blue]) in (left..).zip(colors) {
                    for column in (samples * column..samples * (column + 1)).filter(|column| (first..last).contains(column)) {
                        self.pixels[row as usize * self.width + column as usize] = [red, green, blue, 0];
                    }
                }
            }
        }
    }

    /// Fills a convex polygon of either orientation.
    pub fn polygon(&mut self, corners: &[[f32; 2]], color: Ink) {
        let times = self.samples as f32;
        let corners: Vec<[f32; 2]> = corners.iter().map(|corner| corner.map(|place| times * place)).collect();
        self.whole().polygon(&corners, color);
    }

    /// Blends `color` into one pixel with a coverage of 0–1; no effect outside the clip.
    pub(crate) fn dot(&mut self, x: i32, y: i32, color: Ink, coverage: f32) {
        self.whole().dot(x, y, color, coverage);
    }

    /// Clip: first column and row, and one past the last column and row.
    pub(crate) fn clipped(&self) -> [usize; 4] {
        let Rectangle { left, top, right, bottom } = self.clip;
        [left, top, right, bottom].map(|edge| edge as usize)
    }

    /// Pixels of a row.
    pub(crate) fn row_mut(&mut self, row: usize) -> &mut [[u8; 4]] {
        &mut self.pixels[row * self.width..(row + 1) * self.width]
    }

    /// Pixels of a row and their depths, if any.
    pub(crate) fn row_with_depths(&mut self, row: usize) -> (&mut [[u8; 4]], &mut [f32]) {
        let range = row * self.width..(row + 1) * self.width;
        (&mut self.pixels[range.clone()], self.depths.get_mut(range).unwrap_or_default())
    }

    /// Depths of the backdrop.
    pub(crate) fn backdrop_depths(&self) -> &[f32] {
        &self.backdrop_depths
    }

    /// Band of all rows.
    fn whole(&mut self) -> Band<'_> {
        Band { pixels: &mut self.pixels, depths: &mut [], eye: None, width: self.width, top: 0, clip: self.clip }
    }

    /// Depths of all pixels.
    pub(crate) fn depths(&self) -> &[f32] {
        &self.depths
    }

    /// Divides the rows into at most `count` bands of about equal height.
    pub(crate) fn bands(&mut self, count: usize) -> impl Iterator<Item = Band<'_>> {
        let (width, clip, eye, height) = (self.width, self.clip, self.eye, self.height.div_ceil(count.max(1)));
        let mut depths = self.depths.chunks_mut(width * height);
        self.pixels.chunks_mut(width * height).enumerate().map(move |(index, pixels)| {
            let (top, bottom) = ((index * height) as i32, (index * height + pixels.len() / width) as i32);
            let clip = Rectangle { top: clip.top.max(top), bottom: clip.bottom.min(bottom), ..clip };
            Band { pixels, depths: depths.next().unwrap_or_default(), eye, width, top, clip }
        })
    }
}
