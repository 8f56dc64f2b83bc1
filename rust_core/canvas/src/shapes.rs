//! Shapes and their coverage of pixels.
//!
//! Coverage is a ramp across the edge, clamp(½ − signed distance / softness, 0, 1) at the center of the pixel. A shape in focus
//! has a softness of one pixel. The sum of a ramp of softness s over all pixels is as follows (exactly, if averaged over the
//! sub-pixel offset of the shape).
//!
//! - For a disc of radius r ≥ s/2: ∫₀¹ π(r − s/2 + st)² dt = π(r² + s²/12). A disc is therefore drawn with √(r² − s²/12): its
//!   area is πr².
//! - For a line of width w ≥ s: w per unit length, as required.
//!
//! Thinner shapes keep the smallest size and lose opacity instead. The light of a picture therefore does not depend on its
//! resolution: distant grains of sand grow faint and do not flicker.

use wide::f32x4;

use crate::color::Ink;

/// Filled disc. Positive `shading` shades it as a sphere lit from the upper left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// Center, x to the right and y down from the upper left corner of the picture [pixels].
    pub center: [f32; 2],
    /// Radius [pixels].
    pub radius: f32,
    /// Color and opacity.
    pub color: Ink,
    /// Contrast of the shading: 0 is flat, 1 is black on the far side.
    pub shading: f32,
    /// Width of the edge [pixels]; 1 is sharp.
    pub softness: f32,
}

/// Straight line with round ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// First end, as [`Disc::center`] [pixels].
    pub from: [f32; 2],
    /// Second end [pixels].
    pub to: [f32; 2],
    /// Width [pixels].
    pub width: f32,
    /// Color and opacity.
    pub color: Ink,
    /// Width of the edge [pixels]; 1 is sharp.
    pub softness: f32,
}

/// Triangle of a shaded surface, drawn half a pixel larger, so no seam shows between adjacent triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    /// Corners, as [`Disc::center`] [pixels].
    pub corners: [[f32; 2]; 3],
    /// Corner colors, interpolated by barycentric coordinates. A texture multiplies them.
    pub colors: [Ink; 3],
    /// Depths of the corners behind the focus.
    pub depths: [f32; 3],
    /// Whether the triangle is lit, and casts shadows in this light.
    pub lit: bool,
    /// Texture coordinates of the corners, 0–1 to the right and up; unused without a texture.
    pub texture_coordinates: [[f32; 2]; 3],
}

/// Glow that adds light to the background, or a shadow of its color for light backgrounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Halo {
    /// Center, as [`Disc::center`] [pixels].
    pub center: [f32; 2],
    /// Radius at which the light vanishes [pixels].
    pub radius: f32,
    /// Light at the center.
    pub color: Ink,
    /// Whether the halo subtracts the complement of its color instead of adding its color.
    pub shadow: bool,
}

impl Disc {
    /// Scales the disc to a picture with `times` as many pixels along each side.
    pub(crate) fn scaled(self, times: f32) -> Self {
        let (center, softness) = (self.center.map(|place| times * place), scaled_softness(self.softness, times));
        Self { center, radius: times * self.radius, softness, ..self }
    }

    /// Blurs the disc: a convolution with a circle of confusion of this radius [pixels].
    #[must_use]
    pub fn blurred(self, confusion: f32) -> Self {
        let (radius, softness, share) = blurred(self.radius, confusion, 2);
        Self { radius, softness: softness.max(self.softness), color: faded(self.color, share), ..self }
    }
}

impl Line {
    /// Scales the line to a picture with `times` as many pixels along each side.
    pub(crate) fn scaled(self, times: f32) -> Self {
        let [from, to] = [self.from, self.to].map(|end| end.map(|place| times * place));
        Self { from, to, width: times * self.width, softness: scaled_softness(self.softness, times), ..self }
    }

    /// Blurs the line: a convolution with a circle of confusion of this radius [pixels].
    #[must_use]
    pub fn blurred(self, confusion: f32) -> Self {
        let (half, softness, share) = blurred(0.5 * self.width, confusion, 1);
        Self { width: 2.0 * half, softness: softness.max(self.softness), color: faded(self.color, share), ..self }
    }
}

impl Triangle {
    /// Scales the triangle to a picture with `times` as many pixels along each side.
    pub(crate) fn scaled(self, times: f32) -> Self {
        Self { corners: self.corners.map(|corner| corner.map(|place| times * place)), ..self }
    }
}

impl Halo {
    /// Scales the halo to a picture with `times` as many pixels along each side.
    pub(crate) fn scaled(self, times: f32) -> Self {
        Self { center: self.center.map(|place| times * place), radius: times * self.radius, ..self }
    }
}

/// Scales a softness; a sharp edge remains one pixel wide.
fn scaled_softness(softness: f32, times: f32) -> f32 {
    if softness > 1.0 { times * softness } else { softness }
}

/// Half size, softness and opacity factor of a shape blurred in this number of directions. Total light is conserved.
fn blurred(half: f32, confusion: f32, directions: i32) -> (f32, f32, f32) {
    let larger = half.max(confusion);
    (larger, 2.0 * half.min(confusion), if confusion > half { (half / confusion).powi(directions) } else { 1.0 })
}

fn faded([red, green, blue, alpha]: Ink, share: f32) -> Ink {
    [red, green, blue, (f32::from(alpha) * share + 0.5) as u8]
}

/// Ramp across an edge: 1 inside, 0 outside, one pixel wide.
#[inline(always)]
pub(crate) fn ramp(signed_distance: f32) -> f32 {
    let coverage = 0.5 - signed_distance;
    // Comparisons instead of `clamp`: these are one instruction each.
    let coverage = if coverage > 0.0 { coverage } else { 0.0 };
    if coverage < 1.0 { coverage } else { 1.0 }
}

/// Evaluates [`ramp`] for several distances.
#[inline(always)]
pub(crate) fn ramps(signed_distances: f32x4) -> f32x4 {
    (0.5 - signed_distances).fast_max(f32x4::ZERO).fast_min(f32x4::ONE)
}

/// Drawn radius and opacity factor for which a disc covers πr² pixels, however small.
pub(crate) fn drawn_radius(radius: f32, softness: f32) -> (f32, f32) {
    const TWELFTH: f32 = 1.0 / 12.0;
    let (square, soft) = (radius.max(0.0) * radius.max(0.0), softness * softness);
    if square >= soft * (0.25 + TWELFTH) {
        ((square - soft * TWELFTH).sqrt(), 1.0)
    } else {
        (0.5 * softness, square / (soft * (0.25 + TWELFTH)))
    }
}

/// Drawn half width and opacity factor for which a line covers its width, however thin.
pub(crate) fn drawn_half_width(width: f32, softness: f32) -> (f32, f32) {
    let width = width.max(0.0); // NaN becomes 0
    (0.5 * width.max(softness), (width / softness).min(1.0))
}
