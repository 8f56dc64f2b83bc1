//! Visibility of color errors: an error on smooth shading is seen, an equal one in texture is hidden.
//!
//! The structural similarity (Z. Wang et al., 2004) of a picture falls by about e² / (2σ² + C₂) for an error of mean square e²
//! where the picture has the variance σ².

/// Side of a block of equal weight [pixels].
const BLOCK: usize = 4;
/// Constant C₂ = (0.03 · 255)² of the structural similarity.
const STABLE: f32 = 58.5;
/// Weight of an error in the strongest texture.
pub(crate) const LEAST: f32 = 0.25;

/// Variance of the brightness around each block of a frame.
#[derive(Clone, Debug, Default)]
pub(crate) struct Visibility {
    columns: usize,
    /// Sums of brightness and its square in each block, and number of pixels.
    sums: Vec<[u32; 3]>,
    variances: Vec<f32>,
}

impl Visibility {
    /// Computes the variances of a picture of `width` columns over windows of 3 × 3 blocks.
    pub(crate) fn look(&mut self, pixels: &[[u8; 4]], width: usize) {
        self.columns = width.div_ceil(BLOCK);
        self.sums.clear();
        for rows in pixels.chunks(BLOCK * width) {
            let first = self.sums.len();
            self.sums.resize(first + self.columns, [0; 3]);
            for row in rows.chunks_exact(width) {
                for (sum, part) in self.sums[first..].iter_mut().zip(row.chunks(BLOCK)) {
                    for &[red, green, blue, _] in part {
                        let bright = 2 * u32::from(red) + 5 * u32::from(green) + u32::from(blue);
                        *sum = [sum[0] + bright, sum[1] + bright * bright / 8, sum[2] + 1];
                    }
                }
            }
        }
        let (columns, rows) = (self.columns, self.sums.len() / self.columns);
        self.variances.clear();
        for row in 0..rows {
            for column in 0..columns {
                let mut total = [0; 3];
                for near in row.saturating_sub(1)..(row + 2).min(rows) {
                    for sum in &self.sums[near * columns..][column.saturating_sub(1)..(column + 2).min(columns)] {
                        (0..3).for_each(|part| total[part] += sum[part]);
                    }
                }
                let [mean, square, count] = total.map(|part| part as f32);
                self.variances.push(((square * 8.0 - mean * mean / count) / (64.0 * count)).max(0.0));
            }
        }
    }

    /// Variance of the brightness around a pixel [levels²].
    #[inline(always)]
    pub(crate) fn variance(&self, column: usize, row: usize) -> f32 {
        self.variances[row / BLOCK * self.columns + column / BLOCK]
    }

    /// Weight of a squared error at a pixel, from [`LEAST`] to 1.
    #[inline(always)]
    pub(crate) fn weight(&self, column: usize, row: usize) -> f32 {
        LEAST + (1.0 - LEAST) * STABLE / (STABLE + 2.0 * self.variance(column, row))
    }
}
