//! Texture images of surfaces.

use crate::color::Rgb;
use crate::error::CanvasError;

/// Picture in sRGB with bilinear interpolation.
#[derive(Clone, Debug)]
pub struct Texture {
    width: usize,
    texels: Vec<Rgb>,
}

impl Texture {
    /// Creates a texture from its pixels, row by row from the top.
    pub fn new(width: usize, texels: Vec<Rgb>) -> Result<Self, CanvasError> {
        let height = texels.len().checked_div(width).unwrap_or(0);
        if width == 0 || height == 0 || width * height != texels.len() {
            return Err(CanvasError::Size { width, height });
        }
        Ok(Self { width, texels })
    }

    /// Color at texture coordinates 0–1, to the right and up from the lower left corner; clamped to the edges.
    #[inline(always)]
    pub(crate) fn at(&self, [right, up]: [f32; 2]) -> [f32; 3] {
        let height = self.texels.len() / self.width;
        let (column, x) = texel_at(right, self.width);
        let (row, y) = texel_at(1.0 - up, height);
        let (next, below) = ((column + 1).min(self.width - 1), (row + 1).min(height - 1));
        let texel = |row: usize, column: usize| self.texels[row * self.width + column];
        let corners = [texel(row, column), texel(row, next), texel(below, column), texel(below, next)];
        let weights = [(1.0 - x) * (1.0 - y), x * (1.0 - y), (1.0 - x) * y, x * y];
        let mut color = [0.0; 3];
        for (corner, weight) in corners.iter().zip(weights) {
            for (sum, &channel) in color.iter_mut().zip(corner) {
                *sum += weight * f32::from(channel);
            }
        }
        color
    }
}

/// Texel whose center precedes a coordinate 0–1 of `count` texels, and the offset from it in texels.
fn texel_at(fraction: f32, count: usize) -> (usize, f32) {
    let position = (fraction * count as f32 - 0.5).clamp(0.0, (count - 1) as f32);
    let index = position as usize;
    (index, position - index as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn centers_of_texels_have_their_colors_and_between_them_is_the_mean() {
        let texture = Texture::new(2, vec![[0; 3], [200; 3], [100; 3], [40; 3]]).expect("four texels");
        assert_eq!(texture.at([0.25, 0.75]), [0.0; 3]); // the upper left
        assert_eq!(texture.at([0.75, 0.25]), [40.0; 3]);
        assert_eq!(texture.at([0.5, 0.75]), [100.0; 3]);
        assert_eq!(texture.at([0.25, 0.5]), [50.0; 3]);
        assert_eq!(texture.at([-3.0, 9.0]), [0.0; 3]);
        assert!(Texture::new(2, vec![[0; 3]; 3]).is_err());
        assert!(Texture::new(0, Vec::new()).is_err());
    }
}
