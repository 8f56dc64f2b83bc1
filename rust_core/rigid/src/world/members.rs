//! Bodies, particles, walls and faces of a step, by one index: bodies, then particles, walls, faces, and the world.

use glam::DVec3;

use super::{CenterMotion, FreeFace, FreePoint, RigidWorld, WORLD};
use crate::mover::Mover;
use crate::pose::Pose;
use crate::rotation::{Inertia, Orientation};
use crate::shapes::BoundingBox;
use crate::surface::Surface;

/// Upper bound on the speed of surface points of equal bodies, without their orientations.
#[derive(Debug, Clone, Copy)]
pub(super) struct SpeedBound {
    /// One of the bodies.
    pub body: usize,
    /// Largest distance of a surface point from the center [m].
    pub reach: f64,
    /// Whether impulses leave the bodies as they are.
    pub is_fixed: bool,
    /// Largest distance of a surface point that turning moves [m].
    arm: f64,
    /// Largest angular velocity over the angular momentum [1/(kg·m²)]; 1 of fixed bodies, which have the former.
    inverse: f64,
}

impl SpeedBound {
    /// Bound for the bodies that are stored as this one.
    pub fn new(world: &RigidWorld, body: usize) -> Self {
        let solid = &world.bodies[body];
        let shape = &world.shapes[solid.surface.shape];
        let (reach, is_fixed) = (shape.reach(), solid.inverse_mass == 0.0);
        let arm = if shape.is_round() { 0.0 } else { reach };
        let inverse = if is_fixed { 1.0 } else { solid.inertia.largest_inverse() };
        Self { body, reach, is_fixed, arm, inverse }
    }

    /// Speed within a step of `h` seconds, without springs [m/s].
    #[inline(always)]
    pub fn speed(&self, motion: &CenterMotion, spin: DVec3, h: f64) -> f64 {
        let forced = if self.is_fixed { 0.0 } else { h * motion.acceleration(h).length() };
        motion.velocity.length() + self.arm * (self.inverse * spin.length()) + forced
    }
}

/// Bodies, particles, walls and faces of a step of `h` seconds.
#[derive(Clone, Copy)]
pub(super) struct StepMembers<'a> {
    pub world: &'a RigidWorld,
    pub bodies: &'a [CenterMotion],
    pub points: &'a [FreePoint],
    pub faces: &'a [FreeFace],
    pub motions: &'a [CenterMotion],
    pub h: f64,
}

impl StepMembers<'_> {
    /// Number of bodies and particles.
    pub fn free(&self) -> usize {
        self.bodies.len() + self.points.len()
    }

    /// Number of all but the world.
    pub fn count(&self) -> usize {
        self.walls() + self.faces.len()
    }

    /// Number of bodies, particles and walls.
    fn walls(&self) -> usize {
        self.free() + self.world.walls.len()
    }

    /// Face at an index; None for others.
    pub fn face(&self, index: usize) -> Option<&FreeFace> {
        index.checked_sub(self.walls()).and_then(|face| self.faces.get(face))
    }

    /// Corners of a face as members.
    pub fn corners(&self, face: &FreeFace) -> [usize; 3] {
        face.face.corners.map(|corner| self.bodies.len() + corner)
    }

    /// Index of an end of a joint; None for a particle that takes no part.
    pub fn place(&self, end: usize) -> Option<usize> {
        let bodies = self.bodies.len();
        match end {
            WORLD => Some(self.count()),
            end if end < bodies => Some(end),
            end => self.points.binary_search_by_key(&(end - bodies), |point| point.index).ok().map(|place| bodies + place),
        }
    }

    /// Number of a member that is the same in all steps.
    pub fn name(&self, index: usize) -> u32 {
        let bodies = self.bodies.len();
        if index < bodies {
            index as u32
        } else if index < self.free() {
            (bodies + self.points[index - bodies].index) as u32
        } else if let Some(face) = self.face(index) {
            u32::MAX - (self.world.walls.len() + 2 + face.index) as u32
        } else {
            u32::MAX - (self.walls() + 1 - index) as u32
        }
    }

    /// Whether impulses leave a member as it is. Nothing touches a body that sleeps.
    pub fn is_fixed(&self, index: usize) -> bool {
        if index < self.bodies.len() {
            self.world.bodies[index].inverse_mass == 0.0 || self.world.is_asleep(index)
        } else if let Some(face) = self.face(index) {
            self.corners(face).iter().all(|&corner| self.is_fixed(corner))
        } else {
            index >= self.free() || self.points[index - self.bodies.len()].inverse_mass == 0.0
        }
    }

    /// Whether a member moves in the step, or may disturb bodies that sleep.
    pub fn moves(&self, index: usize) -> bool {
        !self.is_fixed(index) || (self.world.may_sleep() && !self.world.is_asleep(index) && self.speed(index)[0] > 0.0)
    }

    /// Whether two members may touch: contacts resolve particles at walls. Concave meshes meet particles, and not the faces between
    /// them, whose triangles would cut those of the mesh.
    pub fn can_meet(&self, one: usize, other: usize) -> bool {
        let meets =
            |body: usize, face: usize| self.face(face).is_none() || !self.world.shapes[self.surface(body).shape].is_surface();
        if !meets(one, other) || !meets(other, one) {
            return false;
        }
        let is_free = |&index: &usize| !self.is_fixed(index) || self.world.is_asleep(index);
        one.min(other) < self.bodies.len() && [one, other].iter().any(is_free)
    }

    /// Surface of a member.
    pub fn surface(&self, index: usize) -> Surface {
        if index < self.bodies.len() {
            self.world.bodies[index].surface
        } else if index < self.free() {
            self.points[index - self.bodies.len()].surface
        } else {
            let wall = self.world.walls.get(index - self.free());
            wall.map_or(Surface { shape: 0, friction: None, restitution: 0.0 }, |wall| wall.surface)
        }
    }

    /// Member without the forces of springs.
    pub fn unsprung(&self, index: usize) -> Mover {
        if index < self.bodies.len() {
            self.world.mover(index, &self.bodies[index], self.h)
        } else if index < self.free() {
            let place = index - self.bodies.len();
            let motion = &self.motions[place];
            Mover {
                position: motion.position,
                velocity: motion.velocity,
                acceleration: motion.acceleration(self.h),
                inverse_mass: self.points[place].inverse_mass,
                ..Mover::wall(&Pose::WORLD)
            }
        } else {
            self.world.walls.get(index - self.free()).map_or_else(|| Mover::wall(&Pose::WORLD), |wall| wall.mover)
        }
    }

    /// Member.
    pub fn mover(&self, index: usize) -> Mover {
        let mut mover = self.unsprung(index);
        if let Some([acceleration, torque]) = self.world.springs.load(index).filter(|_| !mover.is_fixed()) {
            mover.acceleration += acceleration;
            mover.torque += torque;
        }
        mover
    }

    /// Position [m]; of a face, that of its first corner.
    pub fn position(&self, index: usize) -> DVec3 {
        if let Some(face) = self.face(index) {
            return self.position(self.corners(face)[0]);
        }
        if index < self.bodies.len() {
            self.bodies[index].position
        } else if index < self.free() {
            self.motions[index - self.bodies.len()].position
        } else {
            self.world.walls[index - self.free()].mover.position
        }
    }

    /// Largest distance of a surface point from the center [m].
    pub fn reach(&self, index: usize) -> f64 {
        if let Some(face) = self.face(index) {
            let corners = self.corners(face).map(|corner| self.position(corner));
            return face.face.radius + corners.iter().map(|corner| corner.distance(corners[0])).fold(0.0, f64::max);
        }
        self.world.shapes[self.surface(index).shape].reach()
    }

    /// Size of a member [m], its largest distance of a surface point from the center; infinite for a particle or a face.
    pub fn size(&self, index: usize) -> f64 {
        let reach = if self.face(index).is_some() { 0.0 } else { self.reach(index) };
        if reach > 0.0 { reach } else { f64::INFINITY }
    }

    /// Thickness of a member [m]; infinite for a particle or a face.
    pub fn thickness(&self, index: usize) -> f64 {
        if self.face(index).is_some() {
            return f64::INFINITY;
        }
        let shape = &self.world.shapes[self.surface(index).shape];
        if shape.reach() > 0.0 { shape.thickness() } else { f64::INFINITY }
    }

    /// Box around a member.
    pub fn bounds(&self, index: usize) -> BoundingBox {
        if let Some(face) = self.face(index) {
            let corners = self.corners(face).map(|corner| BoundingBox::around(self.position(corner), face.face.radius));
            return corners.into_iter().fold(BoundingBox::NOWHERE, BoundingBox::union);
        }
        self.world.shapes[self.surface(index).shape].bounds(&self.pose(index))
    }

    /// Acceleration by forces [m/s²].
    fn acceleration(&self, index: usize) -> DVec3 {
        let motion = if index < self.bodies.len() { &self.bodies[index] } else { &self.motions[index - self.bodies.len()] };
        motion.acceleration(self.h) + self.world.springs.load(index).map_or(DVec3::ZERO, |load| load[0])
    }

    /// Bounds on the speed of surface points of a member within the step [m/s]: the whole, and that of turning.
    pub fn speed(&self, index: usize) -> [f64; 2] {
        self.speed_at(index, Inertia::rate)
    }

    /// Upper bound on the speed, without the orientation of the body.
    #[inline]
    pub fn speed_bound(&self, index: usize) -> f64 {
        self.speed_at(index, |inertia, _, spin| inertia.largest_inverse() * spin.length())[0]
    }

    /// Speed of surface points, given the angular velocity of a body.
    #[inline(always)]
    fn speed_at(&self, index: usize, rate: impl Fn(&Inertia, &Orientation, DVec3) -> f64) -> [f64; 2] {
        if index >= self.free() {
            if let Some(face) = self.face(index) {
                return [self.corners(face).map(|corner| self.speed_bound(corner)).into_iter().fold(0.0, f64::max), 0.0];
            }
            let Mover { velocity, spin, arm, .. } = self.world.walls[index - self.free()].mover;
            let turning = arm * spin.length();
            return [velocity.length() + turning, turning];
        }
        let forced = self.h * if self.is_fixed(index) { 0.0 } else { self.acceleration(index).length() };
        if index >= self.bodies.len() {
            return [self.motions[index - self.bodies.len()].velocity.length() + forced, 0.0];
        }
        let (bound, turn) = (SpeedBound::new(self.world, index), &self.world.state.turns[index]);
        let rate = || rate(&self.world.bodies[index].inertia, &turn.orientation, turn.spin);
        let turning = bound.arm * if bound.is_fixed { turn.spin.length() } else { rate() };
        [self.bodies[index].velocity.length() + turning + forced, turning]
    }

    /// Way of a member of a speed within the step [m]: an impact may pass the largest speed on to any body.
    #[inline]
    pub fn way(&self, index: usize, speed: f64, fastest: f64) -> f64 {
        self.h * if self.is_fixed(index) { speed } else { speed.max(fastest.min(self.reach(index) / self.h)) }
    }

    /// Speed of the rim of a round body, which friction may pass on to its center [m/s]; 0 of others.
    pub fn rim_speed(&self, index: usize) -> f64 {
        if index >= self.bodies.len() || self.is_fixed(index) || !self.world.shapes[self.surface(index).shape].is_round() {
            return 0.0;
        }
        let turn = &self.world.state.turns[index];
        self.reach(index) * self.world.bodies[index].inertia.rate(&turn.orientation, turn.spin)
    }

    /// Pose.
    pub fn pose(&self, index: usize) -> Pose {
        if index < self.bodies.len() {
            Pose { position: self.bodies[index].position, rotation: self.world.rotation(index) }
        } else {
            self.unsprung(index).pose()
        }
    }
}
