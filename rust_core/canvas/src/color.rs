//! Colors: sRGB bytes outside, Oklab where two colors are compared.

/// Red, green and blue in sRGB, 0–255.
pub type Rgb = [u8; 3];

/// Red, green and blue in sRGB and opacity, 0–255: what a shape is painted with.
pub type Ink = [u8; 4];

/// Lightness and two opponent axes, in which equal distances look about equally different.
///
/// Source: Björn Ottosson, "A perceptual color space for image processing" (2020).
pub(crate) type Oklab = [f32; 3];

pub(crate) fn oklab([red, green, blue]: Rgb) -> Oklab {
    let [r, g, b] = [linear(red), linear(green), linear(blue)];
    let l = (0.412_221_46 * r + 0.536_332_55 * g + 0.051_445_995 * b).cbrt();
    let m = (0.211_903_5 * r + 0.680_699_5 * g + 0.107_396_96 * b).cbrt();
    let s = (0.088_302_46 * r + 0.281_718_85 * g + 0.629_978_7 * b).cbrt();
    [
        0.210_454_26 * l + 0.793_617_8 * m - 0.004_072_047 * s,
        1.977_998_5 * l - 2.428_592_2 * m + 0.450_593_7 * s,
        0.025_904_037 * l + 0.782_771_77 * m - 0.808_675_77 * s,
    ]
}

pub(crate) fn srgb([lightness, a, b]: Oklab) -> Rgb {
    let l = (lightness + 0.396_337_78 * a + 0.215_803_76 * b).powi(3);
    let m = (lightness - 0.105_561_346 * a - 0.063_854_17 * b).powi(3);
    let s = (lightness - 0.089_484_18 * a - 1.291_485_5 * b).powi(3);
    [
        encoded(4.076_741_7 * l - 3.307_711_6 * m + 0.230_969_94 * s),
        encoded(-1.268_438 * l + 2.609_757_4 * m - 0.341_319_4 * s),
        encoded(-0.004_196_086_3 * l - 0.703_418_6 * m + 1.707_614_7 * s),
    ]
}

/// The transfer function of sRGB (IEC 61966-2-1): a byte to light, 0–1.
fn linear(byte: u8) -> f32 {
    let value = f32::from(byte) / 255.0;
    if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

fn encoded(light: f32) -> u8 {
    let value = if light <= 0.003_130_8 { 12.92 * light } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 };
    (value.clamp(0.0, 1.0) * 255.0).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_gray_and_many_colors_come_back_from_oklab() {
        // The matrices above are each other's inverse to about 1e-6, far less than half a step of 1/255.
        for step in 0..=255_u8 {
            for color in [[step, step, step], [step, 255 - step, step / 2], [255 - step, step / 3, step]] {
                assert_eq!(srgb(oklab(color)), color);
            }
        }
    }
}
