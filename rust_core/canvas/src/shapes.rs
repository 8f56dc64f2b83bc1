//! What can be drawn, and how much of each pixel it covers.
//!
//! Coverage is a ramp across the edge, clamp(½ − signed distance / softness, 0, 1) at the pixel's center; what is in focus has a
//! softness of one pixel. Summed over a plane of pixels (exactly, when averaged over the shape's sub-pixel offset) such a ramp of
//! softness s gives
//!
//! - for a disc of radius r ≥ s/2: ∫₀¹ π(r − s/2 + st)² dt = π(r² + s²/12), so a disc is drawn with √(r² − s²/12): its area is πr²;
//! - for a line of width w ≥ s: w per unit length, as it should be.
//!
//! Thinner shapes keep the smallest size and lose opacity instead, so that a picture's light does not depend on its resolution:
//! grains of sand far away grow faint, they do not flicker.

use crate::color::Ink;

/// A filled disc; `shading` above 0 makes it look like a ball lit from the upper left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// Center, x to the right and y down from the upper left corner of the picture [pixels].
    pub center: [f32; 2],
    /// Radius [pixels].
    pub radius: f32,
    /// What it is painted with.
    pub color: Ink,
    /// How much the light matters: 0 is flat, 1 is black on the far side.
    pub shading: f32,
    /// Over how many pixels its edge fades; 1 is sharp.
    pub softness: f32,
}

/// A straight line with round ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// One end, as [`Disc::center`] [pixels].
    pub from: [f32; 2],
    /// The other end [pixels].
    pub to: [f32; 2],
    /// Width [pixels].
    pub width: f32,
    /// What it is painted with.
    pub color: Ink,
    /// Over how many pixels its edge fades; 1 is sharp.
    pub softness: f32,
}

/// A part of a lit surface. It is painted half a pixel larger than it is, so that no seam shows where two of them meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    /// Corners, as [`Disc::center`] [pixels].
    pub corners: [[f32; 2]; 3],
    /// What each corner is painted with; in between, the mean by nearness. A texture is multiplied by it.
    pub colors: [Ink; 3],
    /// Where each corner lies on the texture, 0–1 to the right and up; without meaning if there is none.
    pub places: [[f32; 2]; 3],
}

/// Light around something that shines: it brightens what is behind it; or a shadow of its color, for light grounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Halo {
    /// Center, as [`Disc::center`] [pixels].
    pub center: [f32; 2],
    /// Where the light has faded away [pixels].
    pub radius: f32,
    /// The light at the center.
    pub color: Ink,
    /// Whether it takes away the light that its color lacks, instead of adding its own.
    pub shadow: bool,
}

impl Disc {
    /// The same disc seen out of focus: every point of it becomes a disc of this radius [pixels].
    #[must_use]
    pub fn blurred(self, confusion: f32) -> Self {
        let (radius, softness, share) = blurred(self.radius, confusion, 2);
        Self { radius, softness: softness.max(self.softness), color: faded(self.color, share), ..self }
    }
}

impl Line {
    /// The same line seen out of focus: every point of it becomes a disc of this radius [pixels].
    #[must_use]
    pub fn blurred(self, confusion: f32) -> Self {
        let (half, softness, share) = blurred(0.5 * self.width, confusion, 1);
        Self { width: 2.0 * half, softness: softness.max(self.softness), color: faded(self.color, share), ..self }
    }
}

/// Half the size, the softness and the part of the opacity of a shape that is blurred in so many directions: the light stays.
fn blurred(half: f32, confusion: f32, directions: i32) -> (f32, f32, f32) {
    let larger = half.max(confusion);
    (larger, 2.0 * half.min(confusion), if confusion > half { (half / confusion).powi(directions) } else { 1.0 })
}

fn faded([red, green, blue, alpha]: Ink, share: f32) -> Ink {
    [red, green, blue, (f32::from(alpha) * share + 0.5) as u8]
}

/// The ramp across an edge: 1 inside, 0 outside, one pixel wide.
#[inline(always)]
pub(crate) fn ramp(signed_distance: f32) -> f32 {
    let coverage = 0.5 - signed_distance;
    // Comparing, not `clamp`: these are one instruction each.
    let coverage = if coverage > 0.0 { coverage } else { 0.0 };
    if coverage < 1.0 { coverage } else { 1.0 }
}

/// The radius to draw with and the factor of opacity, so that a disc covers πr² pixels however small it is.
pub(crate) fn drawn_radius(radius: f32, softness: f32) -> (f32, f32) {
    const TWELFTH: f32 = 1.0 / 12.0;
    let (square, soft) = (radius.max(0.0) * radius.max(0.0), softness * softness);
    if square >= soft * (0.25 + TWELFTH) {
        ((square - soft * TWELFTH).sqrt(), 1.0)
    } else {
        (0.5 * softness, square / (soft * (0.25 + TWELFTH)))
    }
}

/// Half the width to draw with and the factor of opacity, so that a line covers its width however thin it is.
pub(crate) fn drawn_half_width(width: f32, softness: f32) -> (f32, f32) {
    let width = width.max(0.0); // and not a number becomes nothing
    (0.5 * width.max(softness), (width / softness).min(1.0))
}
