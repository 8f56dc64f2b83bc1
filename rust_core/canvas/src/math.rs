//! Vectors in space.

pub(crate) type CanvasVector = [f32; 3];

#[inline(always)]
pub(crate) fn dot(one: CanvasVector, other: CanvasVector) -> f32 {
    one[0] * other[0] + one[1] * other[1] + one[2] * other[2]
}

#[inline(always)]
pub(crate) fn cross(one: CanvasVector, other: CanvasVector) -> CanvasVector {
    [one[1] * other[2] - one[2] * other[1], one[2] * other[0] - one[0] * other[2], one[0] * other[1] - one[1] * other[0]]
}

#[inline(always)]
pub(crate) fn minus(one: CanvasVector, other: CanvasVector) -> CanvasVector {
    [one[0] - other[0], one[1] - other[1], one[2] - other[2]]
}

/// Adds a multiple of another vector to a vector.
#[inline(always)]
pub(crate) fn plus(one: CanvasVector, factor: f32, other: CanvasVector) -> CanvasVector {
    [one[0] + factor * other[0], one[1] + factor * other[1], one[2] + factor * other[2]]
}

/// Unit vector in a direction; for a zero vector, the unit vector toward the eye.
#[inline(always)]
pub(crate) fn unit(vector: CanvasVector) -> CanvasVector {
    let square = dot(vector, vector);
    if square > 0.0 {
        let scale = 1.0 / square.sqrt();
        vector.map(|component| component * scale)
    } else {
        [0.0, 0.0, 1.0]
    }
}

/// Two unit vectors perpendicular to a direction and to each other.
pub(crate) fn across(direction: CanvasVector) -> [CanvasVector; 2] {
    let helper = if direction[0].abs() < 0.7 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let first = unit(cross(direction, helper));
    [first, cross(direction, first)]
}

/// Threshold of an ordered dither at a pixel, between 0 and 1: each of 64 values once in 8 × 8 pixels.
///
/// Source: B. Bayer, "An optimum method for two-level rendition of continuous-tone pictures" (1973).
#[inline(always)]
pub(crate) fn threshold(column: u32, row: u32) -> f32 {
    let mut index = 0;
    for bit in 0..3 {
        let (right, down) = ((column >> bit) & 1, (row >> bit) & 1);
        index = 4 * index + 2 * (right ^ down) + down;
    }
    (index as f32 + 0.5) / 64.0
}
