//! All rigid bodies of a scene with their orientations, contacts and joints.
//!
//! Matter moves the centers of mass. A step has two parts here. After the first kick, [`RigidWorld::drift`] finds groups
//! of bodies that may touch or are joined, and moves these. After the second kick, [`RigidWorld::finish`] ends the last piece
//! of each. Groups are independent of each other, so that the bits are the same for any number of threads.

mod bodies;
mod free;
mod groups;
mod members;
mod near;
mod overlaps;
mod sleep;
mod springs;
mod state;
mod step;
mod thrown;

use glam::{DMat3, DVec3};

use crate::face::NetFace;
use crate::island::{ContactKey, Island, Meters};
use crate::mover::Mover;
use crate::rotation::Orientation;
use crate::rows::ContactImpulse;
use crate::shapes::SolidShape;
use crate::surface::Surface;

pub use bodies::{SolidBodies, SolidBody};
use near::NearPairs;
pub use overlaps::Overlap;
pub use sleep::{BodyRest, SleepRule};
use springs::SpringStep;
pub use state::{RigidState, Turn, WorldJoint};

/// Fixed shape that bounds the bodies.
#[derive(Debug, Clone, Copy)]
pub struct FixedSolid {
    /// Surface with its shape.
    pub surface: Surface,
    /// Pose, and velocities if it moves.
    pub mover: Mover,
}

/// Particle that may meet bodies.
#[derive(Debug, Clone, Copy)]
pub struct FreePoint {
    /// Index among all particles.
    pub index: usize,
    /// Surface; its shape is a ball or disc.
    pub surface: Surface,
    /// Inverse mass [1/kg]; 0 for a fixed particle.
    pub inverse_mass: f64,
}

/// Face of a network that may meet bodies.
#[derive(Debug, Clone, Copy)]
pub struct FreeFace {
    /// Index among all faces.
    pub index: usize,
    /// Face between particles, by their places among those of the step.
    pub face: NetFace<usize>,
}

/// Particles of a step, and the faces between them.
#[derive(Debug, Clone, Copy, Default)]
pub struct FreeParticles<'a> {
    /// Particles, in the order of their indices.
    pub points: &'a [FreePoint],
    /// Faces, in the order of their indices.
    pub faces: &'a [FreeFace],
}

/// Motion of a center of mass or a particle in a step.
#[derive(Debug, Clone, Copy)]
pub struct CenterMotion {
    /// Position at the start of the step [m]; then at its end.
    pub position: DVec3,
    /// Velocity at the start of the step [m/s]; then that predicted for its end, with the forces at the start.
    pub velocity: DVec3,
    /// Velocity of the drift, after the kick of half a step [m/s]; then that from which the second kick leads to the end.
    pub drift: DVec3,
    /// Angular velocity predicted for the end of the step [rad/s].
    pub turning: DVec3,
    /// Torque of the forces at the start of the step, then at its end [N·m].
    pub torque: DVec3,
}

impl CenterMotion {
    /// Motion without forces.
    pub fn free(position: DVec3, velocity: DVec3) -> Self {
        Self { position, velocity, drift: velocity, turning: DVec3::ZERO, torque: DVec3::ZERO }
    }

    /// Bound on the way in a step of `h` seconds [m].
    pub fn way(&self, h: f64) -> f64 {
        h * self.velocity.length() + h * (self.drift - self.velocity).length()
    }

    /// Mean acceleration in a step of `h` seconds [m/s²].
    #[inline]
    pub(crate) fn acceleration(&self, h: f64) -> DVec3 {
        let change = self.drift - self.velocity;
        if change == DVec3::ZERO { change } else { change * (2.0 / h) }
    }
}

/// Numerics of contacts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactSolver {
    /// Pieces of a step of a large group.
    pub substeps: usize,
    /// Iterations of each of its solves.
    pub iterations: usize,
    /// Number of bodies of the largest group whose impacts are taken at their times.
    pub sequential: usize,
}

impl Default for ContactSolver {
    fn default() -> Self {
        Self { substeps: 4, iterations: 2, sequential: 32 }
    }
}

/// End of a joint at a point of the world.
pub const WORLD: usize = usize::MAX;

/// Rigid bodies of a scene.
#[derive(Debug, Default)]
pub struct RigidWorld {
    /// Whether the bodies move in the plane.
    pub planar: bool,
    /// Shapes of all surfaces.
    pub shapes: Vec<SolidShape>,
    /// Constant properties of the bodies.
    pub bodies: SolidBodies,
    /// Fixed shapes that bound the bodies.
    pub walls: Vec<FixedSolid>,
    /// Paths of the bodies in the scene.
    pub names: Vec<String>,
    /// Paths of the walls in the scene.
    pub wall_names: Vec<String>,
    /// Numerics of contacts.
    pub solver: ContactSolver,
    /// When each body may fall asleep; empty if none does.
    sleep: Vec<SleepRule>,
    /// State that persists from step to step.
    pub state: RigidState,
    /// Pairs that are near each other.
    near: NearPairs,
    /// Groups of the present step, and cleared ones.
    islands: Vec<Island>,
    spare: Vec<Island>,
    /// Springs of the present step.
    springs: SpringStep,
    /// Energies of the present step [J].
    meters: Meters,
}

impl RigidWorld {
    /// Empty world, in the plane or in space.
    pub fn new(planar: bool) -> Self {
        Self { planar, ..Self::default() }
    }

    /// Rotational energy of all bodies [J].
    pub fn rotational_energy(&self) -> f64 {
        let of = |(body, turn): (&SolidBody, &Turn)| 0.5 * turn.spin.dot(body.inertia.inverse(&turn.orientation) * turn.spin);
        let free = self.bodies.iter().zip(&self.state.turns).filter(|(body, _)| body.inverse_mass > 0.0);
        free.map(of).sum()
    }

    /// Angular velocity of a body [rad/s].
    pub fn angular_velocity(&self, body: usize) -> DVec3 {
        let (solid, turn) = (&self.bodies[body], &self.state.turns[body]);
        if solid.inverse_mass == 0.0 { turn.spin } else { solid.inertia.inverse(&turn.orientation) * turn.spin }
    }

    /// Rotation of a body from its frame to the world's.
    pub fn rotation(&self, body: usize) -> DMat3 {
        self.state.turns[body].orientation.matrix()
    }

    /// Work of fixed bodies that turn, against the present torques of the forces during half a step of `h` seconds [J].
    pub fn work_of_turning(&self, h: f64) -> f64 {
        let each = self.bodies.iter().zip(&self.state.turns).zip(&self.state.torques);
        let fixed = each.filter(|((body, _), _)| body.inverse_mass == 0.0);
        fixed.map(|((_, turn), torque)| -0.5 * h * torque.dot(turn.spin)).sum()
    }

    /// Sets the orientation and the angular velocity [rad/s] of a body.
    pub fn turn(&mut self, body: usize, orientation: Orientation, turning: DVec3) {
        let solid = &self.bodies[body];
        let spin = if solid.inverse_mass == 0.0 { turning } else { solid.inertia.spin(&orientation, turning) };
        self.state.turns[body] = Turn { orientation, spin };
    }

    /// Largest distance of a surface point of a body from its center [m].
    pub fn size(&self, body: usize) -> f64 {
        self.shapes[self.bodies[body].surface.shape].reach()
    }

    /// Radius of a particle [m].
    pub fn reach(&self, point: &FreePoint) -> f64 {
        self.shapes[point.surface.shape].reach()
    }

    /// Whether there are two bodies, or a body and a wall, that may touch.
    pub fn can_touch(&self) -> bool {
        let free = self.bodies.iter().filter(|body| body.inverse_mass > 0.0).count();
        free > 0 && (self.bodies.len() > 1 || !self.walls.is_empty())
    }

    /// Whether some joint has a limit or a motor.
    pub fn has_bounded_joints(&self) -> bool {
        self.state.joints.iter().any(|joint| joint.joint.is_bounded())
    }

    /// Box that holds all bodies during a step of `h` seconds [m].
    pub fn extent(&self, motions: &[CenterMotion], h: f64) -> (DVec3, DVec3) {
        let mut extent = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for (body, motion) in motions.iter().enumerate() {
            let reach = DVec3::splat(self.size(body) + motion.way(h));
            extent = (extent.0.min(motion.position - reach), extent.1.max(motion.position + reach));
        }
        extent
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        let joints = self.state.joints.len() * size_of::<WorldJoint>();
        self.bodies.bytes()
            + self.bodies.len() * (2 * size_of::<Turn>() + size_of::<Mover>())
            + size_of_val(self.walls.as_slice())
            + 2 * (joints + self.state.loads.len() * size_of::<(ContactKey, ContactImpulse)>())
            + self.shapes.len() * size_of::<SolidShape>()
    }

    /// Mover of a body in a step of `h` seconds.
    pub fn mover(&self, body: usize, motion: &CenterMotion, h: f64) -> Mover {
        let (solid, turn) = (&self.bodies[body], &self.state.turns[body]);
        let shape = &self.shapes[solid.surface.shape];
        Mover {
            position: motion.position,
            velocity: motion.velocity,
            orientation: turn.orientation,
            spin: turn.spin,
            acceleration: motion.acceleration(h),
            torque: motion.torque,
            inverse_mass: solid.inverse_mass,
            inertia: solid.inertia,
            arm: if shape.is_round() { 0.0 } else { shape.reach() },
        }
    }
}
