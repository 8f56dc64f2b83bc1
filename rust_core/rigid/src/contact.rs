//! Points of contact: the gap between two bodies as a function of their poses.

use glam::DVec3;

use crate::pose::Pose;

/// Direction of the normal of a contact, from the first body to the second.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Normal {
    /// Normal of a face of the first body, in its frame.
    First(DVec3),
    /// Normal of a face of the second body, in its frame; it points from the first body to the second.
    Second(DVec3),
    /// From the point of the first body to the point of the second.
    Points,
    /// From the point of the second body to the point of the first, where one of the bodies is hollow. The radius of a hollow
    /// sphere counts as negative.
    Hollow,
    /// From a line through the point of the first body, in its frame, to the point of the second.
    FirstLine(DVec3),
    /// From the point of the first body to a line through the point of the second, in its frame.
    SecondLine(DVec3),
    /// Cross product of two edges, in the frames of their bodies; oriented from the first body to the second.
    Edges(DVec3, DVec3),
}

/// Point of contact between two bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactPoint {
    /// Points of the cores, each in the frame of its body [m]. A core is a shape without its rounding radius.
    pub points: [DVec3; 2],
    /// Rounding radii of the two bodies [m].
    pub radii: [f64; 2],
    /// Direction of the normal.
    pub normal: Normal,
    /// Identity of the features that touch, the same from step to step; unique in a pair of bodies.
    pub feature: u32,
}

/// Contact at given poses.
#[derive(Debug, Clone, Copy)]
pub struct Touch {
    /// Distance between the surfaces along the normal [m]; negative if they overlap.
    pub gap: f64,
    /// Unit normal, from the first body to the second.
    pub normal: DVec3,
    /// Point halfway between the surfaces [m].
    pub point: DVec3,
}

impl ContactPoint {
    /// Contact at the poses of the two bodies. Points that coincide have the normal `fallback`.
    #[inline]
    pub fn at(&self, [first, second]: [&Pose; 2], fallback: DVec3) -> Touch {
        let [one, other] = [first.point(self.points[0]), second.point(self.points[1])];
        let way = other - one;
        let normal = match self.normal {
            Normal::First(normal) => first.rotation * normal,
            Normal::Second(normal) => second.rotation * normal,
            Normal::Points => way.try_normalize().unwrap_or(fallback),
            Normal::Hollow => (-way).try_normalize().unwrap_or(fallback),
            Normal::FirstLine(line) => (way.reject_from_normalized(first.rotation * line)).try_normalize().unwrap_or(fallback),
            Normal::SecondLine(line) => (way.reject_from_normalized(second.rotation * line)).try_normalize().unwrap_or(fallback),
            Normal::Edges(a, b) => {
                let across = (first.rotation * a).cross(second.rotation * b).try_normalize().unwrap_or(fallback);
                // Edges that turn past each other keep the side of the last normal.
                if across.dot(fallback) < 0.0 { -across } else { across }
            }
        };
        let [r1, r2] = self.radii;
        let gap = way.dot(normal) - r1 - r2;
        // Halfway between the surfaces: from the point of a sharp body, or of the smaller rounding, which is exact.
        let point = match self.normal {
            Normal::First(_) | Normal::FirstLine(_) => other - (r2 + 0.5 * gap) * normal,
            Normal::Second(_) | Normal::SecondLine(_) => one + (r1 + 0.5 * gap) * normal,
            _ => 0.5 * ((one + r1 * normal) + (other - r2 * normal)),
        };
        Touch { gap, normal, point }
    }
}
