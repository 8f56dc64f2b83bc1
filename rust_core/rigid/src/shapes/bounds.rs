//! Boxes along the axes.

use glam::DVec3;

use crate::pose::Pose;

/// Box along the axes; infinite where a body is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundingBox {
    /// Corner with the smallest coordinates [m].
    pub lower: DVec3,
    /// Corner with the largest coordinates [m].
    pub upper: DVec3,
}

impl BoundingBox {
    /// Whole space.
    pub const EVERYWHERE: Self = Self { lower: DVec3::NEG_INFINITY, upper: DVec3::INFINITY };
    /// Box without points, the start of a union.
    pub const NOWHERE: Self = Self { lower: DVec3::INFINITY, upper: DVec3::NEG_INFINITY };

    /// Box of half the edge length `reach` [m] about a point.
    #[inline]
    pub fn around(center: DVec3, reach: f64) -> Self {
        Self { lower: center - reach, upper: center + reach }
    }

    /// Smallest box that contains both.
    #[inline]
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self { lower: self.lower.min(other.lower), upper: self.upper.max(other.upper) }
    }

    /// Box around this one at a pose. An infinite one is infinite along all axes that its infinite edges have a part along.
    #[must_use]
    pub fn moved(&self, pose: &Pose) -> Self {
        let mut moved = Self { lower: pose.position, upper: pose.position };
        for axis in 0..3 {
            for (along, column) in [pose.rotation.x_axis, pose.rotation.y_axis, pose.rotation.z_axis].into_iter().enumerate() {
                // An infinite end times zero is no number.
                if column[axis] != 0.0 {
                    let ends = [self.lower[along] * column[axis], self.upper[along] * column[axis]];
                    moved.lower[axis] += ends[0].min(ends[1]);
                    moved.upper[axis] += ends[0].max(ends[1]);
                }
            }
        }
        moved
    }

    /// Box with a margin on all sides [m].
    #[inline]
    #[must_use]
    pub fn grown(self, margin: f64) -> Self {
        Self { lower: self.lower - margin, upper: self.upper + margin }
    }

    /// Whether the boxes have a point in common; boxes that touch have.
    #[inline]
    pub fn overlaps(&self, other: &Self) -> bool {
        self.lower.cmple(other.upper).all() && other.lower.cmple(self.upper).all()
    }

    /// Whether another box is within this one.
    #[inline]
    pub fn contains(&self, other: &Self) -> bool {
        self.lower.cmple(other.lower).all() && other.upper.cmple(self.upper).all()
    }

    /// Least distance of the faces of another box from those of this one, which contains it [m]; negative if not.
    #[inline(always)]
    pub fn margin(&self, other: &Self) -> f64 {
        (other.lower - self.lower).min(self.upper - other.upper).min_element()
    }

    /// Whether all coordinates are finite.
    #[inline]
    pub fn is_finite(&self) -> bool {
        self.lower.is_finite() && self.upper.is_finite()
    }
}
