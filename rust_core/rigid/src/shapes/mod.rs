//! Shapes of rigid bodies: convex parts about the center of mass, in the frame of the body.

use glam::DVec3;
use physcore_base::error::{Error, Result};
use physcore_base::scene::Item;

use crate::pose::Pose;

mod bounds;
mod declared;
mod hull;
mod mass;
mod mesh;
mod outline;
mod part;
mod parts;
mod patches;
mod plane;
mod samples;
mod skin;
mod terrain;
mod tree;
mod walls;

pub use bounds::BoundingBox;
pub use mass::MassProperties;
pub(crate) use part::{Part, side_of};
pub(crate) use parts::ConvexParts;
pub use patches::SurfacePatch;
use plane::Planar;
pub use samples::{ShapeSamples, VolumeSample};
pub(crate) use terrain::GroundProfile;
pub use walls::{WallShape, walls};

/// Shape of a body in its frame.
#[derive(Debug, Clone, PartialEq)]
pub struct SolidShape {
    pub(crate) form: ShapeForm,
    /// Number of features, by which points of contact are told apart.
    pub(crate) features: u32,
    reach: f64,
    thickness: f64,
}

/// Kind of a shape.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum ShapeForm {
    /// Union of convex parts.
    ConvexParts(ConvexParts),
    /// All points below the plane through the origin with this unit normal.
    HalfSpace(DVec3),
    /// All points beyond a sphere of this radius about the origin [m].
    Hollow(f64),
    /// All points below a height field.
    GroundProfile(GroundProfile),
}

impl SolidShape {
    /// Shape of a record, moved so that its center of mass is the origin, and its mass properties as declared.
    ///
    /// # Errors
    /// If there is no shape of that kind in this dimension, or one of its parameters is not acceptable.
    pub fn declared(item: &Item, dimension: usize) -> Result<(Self, MassProperties)> {
        let (parts, mass) = declared::parts(item, dimension)?;
        if !mass.is_proper(dimension) {
            let found = format!("a size of {} and an inertia of {}", mass.size, mass.inertia.z_axis.z);
            return Err(Error::parameter(&item.path, "a shape whose size and inertia are finite and above 0", found));
        }
        let shift = Pose { position: -mass.center, ..Pose::WORLD };
        let is_centered = mass.center == DVec3::ZERO;
        Ok((Self::of(parts.into_iter().map(|part| if is_centered { part } else { part.moved(&shift) })), mass))
    }

    /// Disc or ball about the origin; a particle for a radius of 0 [m].
    pub fn round(radius: f64) -> Self {
        Self::of(std::iter::once(Part::round(DVec3::ZERO, radius)))
    }

    /// Half-space below the plane through the origin with this unit normal. Only for fixed bodies.
    pub fn half_space(normal: DVec3) -> Self {
        Self { form: ShapeForm::HalfSpace(normal), features: 1, reach: f64::INFINITY, thickness: f64::INFINITY }
    }

    /// Outside of a sphere about the origin. Only for fixed bodies.
    pub fn hollow(radius: f64) -> Self {
        Self { form: ShapeForm::Hollow(radius), features: 1, reach: f64::INFINITY, thickness: f64::INFINITY }
    }

    /// Ground below a height field. Only for fixed bodies.
    pub(crate) fn terrain(terrain: GroundProfile) -> Self {
        let features = terrain.features();
        Self { form: ShapeForm::GroundProfile(terrain), features, reach: f64::INFINITY, thickness: f64::INFINITY }
    }

    /// Union of convex parts.
    pub(crate) fn of(parts: impl IntoIterator<Item = Part>) -> Self {
        let mut features = 0;
        let parts: Vec<Part> = parts
            .into_iter()
            .map(|mut part| {
                part.first = features;
                features += part.features();
                part
            })
            .collect();
        let farthest = |part: &Part| part.vertices.iter().map(|vertex| vertex.length()).fold(0.0, f64::max) + part.radius;
        let reach = parts.iter().map(farthest).fold(0.0, f64::max);
        let thickness = parts.iter().map(|part| part.inner + part.radius).fold(f64::INFINITY, f64::min);
        Self { form: ShapeForm::ConvexParts(ConvexParts::new(parts)), features, reach, thickness }
    }

    /// Shape with its parts moved by a vector in the frame of the body [m]. Ground stays where it is.
    #[must_use]
    pub fn moved(&self, shift: DVec3) -> Self {
        let ShapeForm::ConvexParts(parts) = &self.form else { return self.clone() };
        let pose = Pose { position: shift, ..Pose::WORLD };
        Self::of(parts.all.iter().map(|part| part.clone().moved(&pose)))
    }

    /// Largest distance of a point of the surface from the origin [m]; infinite for a half-space.
    pub fn reach(&self) -> f64 {
        self.reach
    }

    /// Radius of a ball that each convex part contains [m]; infinite for ground.
    pub fn thickness(&self) -> f64 {
        self.thickness
    }

    /// Whether the shape is a disc or a ball about the origin, which turning does not change.
    pub fn is_round(&self) -> bool {
        matches!(&self.form, ShapeForm::ConvexParts(parts) if matches!(parts.all[..], [Part { ref vertices, .. }] if vertices[..] == [DVec3::ZERO]))
    }

    /// Calls `visit` with the convex parts whose boxes overlap another, in the frame of the body; a half-space and a hollow have
    /// none.
    pub(crate) fn near(&self, bounds: &BoundingBox, visit: &mut dyn FnMut(&Part)) {
        match &self.form {
            ShapeForm::ConvexParts(parts) => parts.near(bounds, visit),
            ShapeForm::GroundProfile(terrain) => terrain.near(bounds, visit),
            ShapeForm::HalfSpace(_) | ShapeForm::Hollow(_) => {}
        }
    }

    /// Part of a shape that consists of one alone.
    #[inline]
    pub(crate) fn single(&self) -> Option<&Part> {
        if let ShapeForm::ConvexParts(parts) = &self.form { parts.single() } else { None }
    }

    /// Whether the parts of the shape are triangles of the surface of a mesh.
    pub fn is_surface(&self) -> bool {
        matches!(&self.form, ShapeForm::ConvexParts(parts) if parts.all.iter().any(|part| part.leaf_corners().is_some()))
    }

    /// Whether a point in the frame of the body is within a mesh.
    pub(crate) fn encloses(&self, point: DVec3) -> bool {
        matches!(&self.form, ShapeForm::ConvexParts(parts) if parts.enclose(point))
    }

    /// Whether the shape is a half-space or a hollow, without parts.
    #[inline]
    pub(crate) fn is_ground(&self) -> bool {
        matches!(self.form, ShapeForm::HalfSpace(_) | ShapeForm::Hollow(_))
    }

    /// Box along the axes around the shape at a pose.
    pub fn bounds(&self, pose: &Pose) -> BoundingBox {
        match &self.form {
            ShapeForm::ConvexParts(parts) => parts.bounds(pose),
            ShapeForm::HalfSpace(normal) => half_space_bounds(pose.rotation * *normal, pose.position),
            ShapeForm::Hollow(_) => BoundingBox::EVERYWHERE,
            ShapeForm::GroundProfile(terrain) => terrain.bounds().moved(pose),
        }
    }
}

/// Box around a half-space, infinite except above a plane along the axes.
fn half_space_bounds(normal: DVec3, point: DVec3) -> BoundingBox {
    let mut bounds = BoundingBox::EVERYWHERE;
    for axis in 0..3 {
        let is_along = (0..3).all(|other| other == axis || normal[other] == 0.0);
        if is_along && normal[axis] > 0.0 {
            bounds.upper[axis] = point[axis];
        } else if is_along && normal[axis] < 0.0 {
            bounds.lower[axis] = point[axis];
        }
    }
    bounds
}
