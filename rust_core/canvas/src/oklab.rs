//! Perceptual color space Oklab, scaled so that neighboring grays of sRGB are about one unit apart.
//!
//! Only additions, multiplications, divisions and tables are used: the bits are equal on every machine.
//!
//! Source: B. Ottosson, "A perceptual color space for image processing" (2020).

use std::sync::LazyLock;

use crate::color::Rgb;

/// Lightness, 0–255, and two chromatic coordinates in the same unit.
pub(crate) type Lab = [f32; 3];

const SCALE: f32 = 255.0;

/// Responses of the three kinds of cones to each level of red, green and blue.
static CONES: LazyLock<[[[f32; 3]; 256]; 3]> = LazyLock::new(|| {
    const MATRIX: [[f32; 3]; 3] = [
        [0.412_221_47, 0.211_903_5, 0.088_302_46],
        [0.536_332_54, 0.680_699_5, 0.281_718_84],
        [0.051_445_994, 0.107_396_96, 0.629_978_7],
    ];
    MATRIX.map(|column| std::array::from_fn(|level| column.map(|part| part * linear(level as f32 / 255.0))))
});

/// Light of a channel of sRGB (IEC 61966-2-1).
fn linear(value: f32) -> f32 {
    if value <= 0.040_45 {
        return value / 12.92;
    }
    // x^2.4 = (x^12)^(1/5), by Newton's iteration for the fifth root.
    let base = f64::from((value + 0.055) / 1.055);
    let target = base.powi(12);
    let mut root = base * base;
    for _ in 0..40 {
        root -= (root - target / root.powi(4)) / 5.0;
    }
    root as f32
}

/// Converts a color.
#[inline]
pub(crate) fn lab([red, green, blue]: Rgb) -> Lab {
    let [reds, greens, blues] = &*CONES;
    let (red, green, blue) = (&reds[usize::from(red)], &greens[usize::from(green)], &blues[usize::from(blue)]);
    let [l, m, s] = std::array::from_fn(|kind| cube_root(red[kind] + green[kind] + blue[kind]));
    [
        SCALE * (0.210_454_26 * l + 0.793_617_8 * m - 0.004_072_047 * s),
        SCALE * (1.977_998_5 * l - 2.428_592_2 * m + 0.450_593_7 * s),
        SCALE * (0.025_904_037 * l + 0.782_771_77 * m - 0.808_675_77 * s),
    ]
}

/// Squared color difference.
#[inline(always)]
pub(crate) fn squared(p: Lab, q: Lab) -> f32 {
    let (x, y, z) = (p[0] - q[0], p[1] - q[1], p[2] - q[2]);
    x * x + y * y + z * z
}

/// Cube root of a number from 0 to 1, by two rounds of Halley's iteration from a third of the exponent.
#[inline(always)]
fn cube_root(value: f32) -> f32 {
    let value = value + 1e-12; // below the resolution; avoids 0/0
    let mut root = f32::from_bits((value.to_bits() as f32 * (1.0 / 3.0)) as u32 + 0x2A51_37A0);
    for _ in 0..2 {
        let cube = root * root * root;
        root *= (cube + value + value) / (cube + cube + value);
    }
    root
}

#[cfg(test)]
mod tests {
    use super::lab;

    /// Colors and their coordinates by Ottosson's program, to three digits; white is L = 1.
    #[test]
    fn known_colors_have_known_coordinates() {
        let known = [
            ([255, 255, 255], [1.0, 0.0, 0.0]),
            ([0, 0, 0], [0.0, 0.0, 0.0]),
            ([255, 0, 0], [0.628, 0.225, 0.126]),
            ([0, 255, 0], [0.866, -0.234, 0.179]),
            ([0, 0, 255], [0.452, -0.032, -0.312]),
        ];
        for (color, expected) in known {
            let [l, a, b] = lab(color);
            for (got, expected) in [l / 255.0, a / 255.0, b / 255.0].into_iter().zip(expected) {
                assert!((got - expected).abs() < 6e-4, "{color:?}: {got} instead of {expected}");
            }
        }
    }
}
