//! Paths of bodies during a piece, and of two of them against each other.

use glam::DVec3;

use crate::collision;
use crate::contact::ContactPoint;
use crate::face::{FACES, SecondSide};
use crate::island::{BodyPair, Island};
use crate::mover::Mover;
use crate::pose::Pose;
use crate::shapes::SolidShape;

/// Path of a body during a piece: a parabola that begins with the velocity at the start, and a free rotation.
pub(crate) struct BodyPath<'a> {
    pub(super) start: &'a Mover,
    pub(super) end: &'a Mover,
    pub(super) length: f64,
}

impl BodyPath<'_> {
    /// Body after a time.
    pub fn mover(&self, time: f64) -> Mover {
        let mover = Mover { position: self.position(time), spin: self.end.spin, ..*self.start };
        Mover { orientation: mover.turned(time), ..mover }
    }

    fn position(&self, time: f64) -> DVec3 {
        self.start.position + time * (self.start.velocity + time * self.bend())
    }

    /// Half the acceleration [m/s²].
    fn bend(&self) -> DVec3 {
        (self.end.position - self.start.position - self.length * self.start.velocity) / (self.length * self.length)
    }

    fn velocity(&self, time: f64) -> DVec3 {
        self.start.velocity + 2.0 * time * self.bend()
    }

    /// Largest speed of surface points by rotation [m/s].
    fn turning(&self) -> f64 {
        self.end.angular_velocity().length() * self.end.arm
    }
}

/// Paths of two bodies, of which the second may be a face.
pub(super) struct PairPaths<'a> {
    one: &'a BodyPath<'a>,
    shape: &'a SolidShape,
    /// Path of the second body, or of the first corner of a face.
    other: &'a BodyPath<'a>,
    side: SecondSide<'a>,
    /// Corners beside a particle in faces, and the paths of all movers.
    beside: &'a [u32],
    paths: &'a [BodyPath<'a>],
    dimension: usize,
}

impl Island {
    /// Paths of a pair.
    pub(super) fn paths<'a>(&'a self, pair: &BodyPair, paths: &'a [BodyPath<'a>], shapes: &'a [SolidShape]) -> PairPaths<'a> {
        let [one, other] = pair.bodies;
        let shape = |body: usize| &shapes[self.surfaces[body].shape];
        let (first, side, beside) = if other < FACES {
            (other, SecondSide::Body(shape(other)), self.beside.of(other))
        } else {
            let face = &self.faces[other - FACES];
            (face.corners[0] as usize, SecondSide::Face(face), [].as_slice())
        };
        let (one, shape, other) = (&paths[one], shape(one), &paths[first]);
        PairPaths { one, shape, other, side, beside, paths, dimension: if self.planar { 2 } else { 3 } }
    }
}

impl PairPaths<'_> {
    /// Whether the second body is a face.
    fn has_face(&self) -> bool {
        matches!(self.side, SecondSide::Face(_))
    }

    /// Whether the second body is a face or a corner of some, so that the bodies may touch without a contact of this pair.
    pub fn may_hide(&self) -> bool {
        self.has_face() || !self.beside.is_empty()
    }

    /// Place of a mover after a time [m].
    fn position(&self, mover: u32, time: f64) -> DVec3 {
        self.paths[mover as usize].position(time)
    }

    /// Poses after a time.
    fn poses(&self, time: f64) -> [Pose; 2] {
        let second = match self.side {
            SecondSide::Body(_) => self.other.mover(time).pose(),
            SecondSide::Face(face) => face.pose(|corner| self.position(corner, time)),
        };
        [self.one.mover(time).pose(), second]
    }

    /// Velocity of the first against the second [m/s].
    pub fn velocity(&self, time: f64) -> DVec3 {
        self.one.velocity(time) - self.other.velocity(time)
    }

    /// Half the acceleration of the first against the second [m/s²].
    pub fn bend(&self) -> DVec3 {
        self.one.bend() - self.other.bend()
    }

    /// Largest speed of surface points against those of which these are the velocities, by rotation and as a face deforms [m/s].
    pub fn turning(&self) -> f64 {
        let second = match self.side {
            SecondSide::Body(_) => self.other.turning(),
            SecondSide::Face(face) => {
                let velocity = |corner: u32, time: f64| self.paths[corner as usize].velocity(time);
                let deforming = |corner: u32, time: f64| velocity(corner, time).distance(self.other.velocity(time));
                let of = |&corner: &u32| deforming(corner, 0.0).max(deforming(corner, self.other.length));
                face.corners[1..].iter().map(of).fold(0.0, f64::max)
            }
        };
        self.one.turning() + second
    }

    /// Replaces `points` by the contacts within a reach [m] after a time.
    pub fn contacts(&self, time: f64, reach: f64, points: &mut Vec<ContactPoint>) {
        let [one, other] = &self.poses(time);
        let net = (self.beside, |corner: u32| self.position(corner, time));
        self.side.contacts((self.shape, one), (other, net), (reach, self.dimension), points);
    }

    /// Replaces `found` by the distances of convex parts within a reach [m] after a time, with their normals.
    pub fn separations(&self, time: f64, reach: f64, found: &mut Vec<(f64, DVec3)>) {
        let [one, other] = &self.poses(time);
        match self.side {
            SecondSide::Body(shape) => {
                collision::separations((self.shape, one), (shape, other), reach, self.dimension, found);
            }
            SecondSide::Face(face) => {
                face.separations((self.shape, one), other, (reach, self.dimension), found);
            }
        }
    }

    /// Direction from the first to the second after a time, for points that coincide. From a body to a face there is none.
    pub fn direction(&self, time: f64) -> DVec3 {
        if self.has_face() {
            return DVec3::ZERO;
        }
        (self.other.position(time) - self.one.position(time)).try_normalize().unwrap_or(DVec3::X)
    }

    /// Gap of a contact after a time [m].
    pub fn gap(&self, point: &ContactPoint, time: f64, fallback: DVec3) -> f64 {
        let [one, other] = self.poses(time);
        point.at([&one, &other], fallback).gap
    }
}
