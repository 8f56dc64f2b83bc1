//! How much of each pixel a shape covers.
//!
//! Coverage is a ramp one pixel wide across the edge: clamp(½ − signed distance, 0, 1) at the pixel's center. Summed over a
//! plane of pixels (exactly, when averaged over the shape's sub-pixel offset) such a ramp gives
//!
//! - for a disc of radius r ≥ ½: ∫₀¹ π(r − ½ + t)² dt = π(r² + 1/12), so a disc is drawn with √(r² − 1/12): its area is then πr²;
//! - for a line of width w ≥ 1: w per unit length, as it should be.
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
pub(crate) fn drawn_radius(radius: f32) -> (f32, f32) {
    const TWELFTH: f32 = 1.0 / 12.0;
    let radius = radius.max(0.0);
    if radius * radius >= 0.25 + TWELFTH {
        ((radius * radius - TWELFTH).sqrt(), 1.0)
    } else {
        (0.5, radius * radius / (0.25 + TWELFTH))
    }
}

/// Half the width to draw with and the factor of opacity, so that a line covers its width however thin it is.
pub(crate) fn drawn_half_width(width: f32) -> (f32, f32) {
    let width = width.max(0.0); // and not a number becomes nothing
    (0.5 * width.max(1.0), width.min(1.0))
}
