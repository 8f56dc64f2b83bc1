//! Colors, as bytes of sRGB.

/// Red, green and blue in sRGB, 0–255.
pub type Rgb = [u8; 3];

/// Ink, the color of a shape: red, green and blue in sRGB and opacity, 0–255.
pub type Ink = [u8; 4];
