//! Products of vectors in the plane z = 0.

use glam::DVec3;

/// Products in the plane.
pub(crate) trait Planar {
    /// Component along z of the cross product.
    fn across(self, other: Self) -> f64;
    /// Vector turned clockwise by a right angle: along the outward normal of an edge that runs counterclockwise.
    fn outward(self) -> Self;
}

impl Planar for DVec3 {
    #[inline(always)]
    fn across(self, other: Self) -> f64 {
        self.x * other.y - self.y * other.x
    }

    #[inline(always)]
    fn outward(self) -> Self {
        Self::new(self.y, -self.x, 0.0)
    }
}
