//! Sky that smooth water reflects: a gradient from the horizon to the zenith.

use crate::color::Rgb;
use crate::math::{dot, plus};

/// Sky above a picture in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sky {
    /// Color at the horizon.
    pub horizon: Rgb,
    /// Color at the zenith.
    pub zenith: Rgb,
    /// Unit vector to the zenith: right, up, toward the eye.
    pub up: [f32; 3],
    /// Brightness of the sky, relative to white in the picture.
    pub brightness: f32,
}

/// Reflectance of water at normal incidence.
const WATER: f32 = 0.02;
/// Maximum share of the reflection in a color. Waves smaller than a pixel keep it below one.
const MOST: f32 = 0.85;

impl Sky {
    /// Mixes the reflected sky into the color of a surface.
    ///
    /// - `normal`, `toward`: unit normal, and unit vector to the eye.
    /// - `share`: factor of the reflection.
    #[inline(always)]
    pub fn reflected(&self, color: [f32; 3], normal: [f32; 3], toward: [f32; 3], share: f32) -> [f32; 3] {
        let cosine = dot(normal, toward).clamp(0.0, 1.0);
        let bounced = plus(toward.map(|component| -component), 2.0 * cosine, normal);
        let mirrored = share * (self.brightness * reflectance(cosine)).min(MOST);
        let sky = self.color(bounced);
        std::array::from_fn(|channel| color[channel] + (sky[channel] - color[channel]) * mirrored)
    }

    /// Color in a direction. Rays below the horizon meet water, which reflects the sky on the other side of the horizon.
    fn color(&self, direction: [f32; 3]) -> [f32; 3] {
        let share = dot(direction, self.up).abs().min(1.0).sqrt();
        std::array::from_fn(|channel| {
            let (low, high) = (f32::from(self.horizon[channel]), f32::from(self.zenith[channel]));
            low + share * (high - low)
        })
    }
}

/// Share of light that water reflects, from the cosine of the angle of incidence.
///
/// Source: C. Schlick, "An inexpensive BRDF model for physically-based rendering" (1994).
fn reflectance(cosine: f32) -> f32 {
    WATER + (1.0 - WATER) * (1.0 - cosine).powi(5)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SKY: Sky = Sky { horizon: [200, 100, 0], zenith: [0, 100, 200], up: [0.0, 1.0, 0.0], brightness: 1.0 };

    /// Water of index n = 4/3 reflects ((n − 1)/(n + 1))² = 0.0204 at normal incidence, and everything at grazing incidence. At
    /// 60° Fresnel's equations give 0.0595; Schlick's approximation is low by a fifth there.
    #[test]
    fn water_reflects_as_fresnel_says() {
        assert!((reflectance(1.0) - 1.0 / 49.0).abs() < 5e-4);
        assert!((reflectance(0.0) - 1.0).abs() < 1e-6);
        assert!((reflectance(0.5) / 0.0595 - 1.0).abs() < 0.2);
    }

    /// A level surface seen from 30° above reflects the sky at 30°; seen from above, the zenith.
    #[test]
    fn a_mirror_shows_the_sky_on_the_other_side() {
        let (up, toward) = ([0.0, 1.0, 0.0], [0.0, 0.5, 0.75_f32.sqrt()]);
        let bright = Sky { brightness: 1e3, ..SKY };
        let shown = |normal, toward| bright.reflected([0.0; 3], normal, toward, 1.0);
        let low = shown(up, toward);
        let share = 0.5_f32.sqrt();
        assert!((low[0] - MOST * 200.0 * (1.0 - share)).abs() < 1e-3 && (low[2] - MOST * 200.0 * share).abs() < 1e-3, "{low:?}");
        assert!((shown(up, up)[2] - MOST * 200.0).abs() < 1e-3);
        // Nothing is reflected without a share, and more at flatter angles.
        assert_eq!(SKY.reflected([7.0; 3], up, toward, 0.0), [7.0; 3]);
        let green = |height: f32| SKY.reflected([0.0; 3], up, [0.0, height, (1.0 - height * height).sqrt()], 1.0)[1];
        assert!(green(0.1) > green(0.3) && green(0.3) > green(0.8));
    }
}
