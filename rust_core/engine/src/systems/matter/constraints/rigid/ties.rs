//! Particles tied to bodies.
//!
//! A body and the particles tied to it move as one rigid body about their common center of mass. The world of rigid bodies knows
//! this one alone. Matter kicks the center of the body and each particle by their own forces. The common center has their mean
//! velocity by mass, and the torque is the sum of the moments of their kicks. After the drift, and after the last kick, each
//! gets the place and the velocity of its part. Momentum and angular momentum are therefore kept to rounding, for any number
//! of particles. The force of a tie is what the change of momentum of its particle lacks.

use glam::{DMat3, DVec3};
use physcore_rigid::world::{CenterMotion, RigidWorld};

use super::{ConstrainedStep, DriftVelocity, motion};
use crate::catalog::Space;

/// Error of a place relative to the coordinates, below which a particle keeps its position.
const PLACED: f64 = 1e-12;

/// Center of a body, or particle that is tied to it.
#[derive(Debug, Clone)]
pub struct TiedPart {
    pub particle: usize,
    /// Mass [kg].
    pub mass: f64,
    /// Place about the common center, in the frame of the body [m].
    pub place: DVec3,
    /// Velocity at the start of the step [m/s], and accelerations by forces at its start and end [m/s²].
    start: DVec3,
    accelerations: [DVec3; 2],
}

impl TiedPart {
    /// Part at a place.
    pub fn new(particle: usize, mass: f64, place: DVec3) -> Self {
        Self { particle, mass, place, start: DVec3::ZERO, accelerations: [DVec3::ZERO; 2] }
    }
}

/// Body with particles that are tied to it.
#[derive(Debug, Clone)]
pub struct TiedBody {
    /// Index of the body.
    pub body: usize,
    /// Whether the body is fixed; then the common center is its own.
    pub is_fixed: bool,
    /// Center of the body, then the particles.
    pub parts: Vec<TiedPart>,
    /// Row of each particle among the ties of the scene.
    pub rows: Vec<usize>,
}

impl TiedBody {
    /// Mean of vectors of the parts by mass; for a fixed body the vector of its center.
    fn mean(&self, of: impl Fn(&TiedPart) -> DVec3) -> DVec3 {
        if self.is_fixed {
            return of(&self.parts[0]);
        }
        let mass: f64 = self.parts.iter().map(|part| part.mass).sum();
        self.parts.iter().map(|part| part.mass * of(part)).sum::<DVec3>() / mass
    }

    /// Torque about the common center of accelerations of the parts [N·m]; 0 for a fixed body.
    fn torque(&self, rotation: &DMat3, of: impl Fn(&TiedPart) -> DVec3) -> DVec3 {
        if self.is_fixed {
            return DVec3::ZERO;
        }
        self.parts.iter().map(|part| (*rotation * part.place).cross(part.mass * of(part))).sum()
    }

    /// Offset of the center of the body from the common center [m].
    pub fn offset(&self, rotation: &DMat3) -> DVec3 {
        *rotation * self.parts[0].place
    }

    /// Motion of the common center in the present state.
    fn motion<V: Space>(&self, step: &ConstrainedStep<'_, V>, rotation: &DMat3) -> CenterMotion {
        let velocity = self.mean(|part| step.matter.velocity.get(part.particle).widen());
        CenterMotion::free(motion(step, self.parts[0].particle).position - self.offset(rotation), velocity)
    }

    /// Places the particles of an initial state on the body, with the velocities of their places.
    pub fn initialize<V: Space>(&self, step: &mut ConstrainedStep<'_, V>, world: &RigidWorld) {
        let (center, rotation) = (motion(step, self.parts[0].particle), world.rotation(self.body));
        for part in &self.parts[1..] {
            let arm = rotation * (part.place - self.parts[0].place);
            let (place, present) = (center.position + arm, motion(step, part.particle).position);
            if place.distance(present) > PLACED * (place.length() + arm.length()) {
                step.matter.set_exact_position(part.particle, place - step.properties.origin);
            }
            let velocity = center.velocity + world.angular_velocity(self.body).cross(arm);
            step.matter.velocity.set(part.particle, V::narrow(velocity));
        }
    }

    /// Motion of the common center at the start of a step.
    pub fn begin<V: Space>(&mut self, step: &ConstrainedStep<'_, V>, rotation: &DMat3) -> CenterMotion {
        self.parts.iter_mut().for_each(|part| part.start = step.matter.velocity.get(part.particle).widen());
        self.motion(step, rotation)
    }

    /// Adds the first kick to a motion of the common center.
    pub fn kick<V: Space>(&mut self, step: &ConstrainedStep<'_, V>, rotation: &DMat3, motion: &mut CenterMotion) {
        for part in &mut self.parts {
            part.accelerations[0] = (step.drift_velocity(part.particle) - part.start) * (2.0 / step.h);
        }
        motion.drift = self.mean(|part| step.drift_velocity(part.particle));
        motion.torque += self.torque(rotation, |part| part.accelerations[0]);
    }

    /// Places the parts after the drift, given the motion of the common center, with the velocities predicted for the end.
    pub fn place<V: Space>(&self, step: &mut ConstrainedStep<'_, V>, world: &RigidWorld, motion: &CenterMotion) {
        let rotation = world.rotation(self.body);
        for part in &self.parts {
            let arm = rotation * part.place;
            step.matter.set_exact_position(part.particle, motion.position + arm - step.properties.origin);
            let predicted = motion.velocity + motion.turning.cross(arm);
            step.matter.velocity.set(part.particle, V::narrow(predicted));
            if let DriftVelocity::Register(register) = step.drift {
                let from = predicted - 0.5 * step.h * part.accelerations[0];
                step.matter.registers[register].set(part.particle, V::narrow(from));
            }
        }
    }

    /// Motion of the common center after the last kick, with the torque on it besides that on the body.
    pub fn end<V: Space>(&mut self, step: &ConstrainedStep<'_, V>, rotation: &DMat3, torque: DVec3) -> CenterMotion {
        for part in &mut self.parts {
            let kick = step.matter.velocity.get(part.particle).widen() - step.drift_velocity(part.particle);
            part.accelerations[1] = kick * (2.0 / step.h);
        }
        let torque = torque + self.torque(rotation, |part| part.accelerations[1]);
        CenterMotion { torque, ..self.motion(step, rotation) }
    }

    /// Sets the velocities of the parts at the end of a step, given that of the common center. Writes the mean forces of the
    /// particles on the body [N]; returns the work of a fixed body on them [J].
    pub fn release<V: Space>(
        &self,
        step: &mut ConstrainedStep<'_, V>,
        world: &RigidWorld,
        velocity: DVec3,
        forces: &mut [DVec3],
    ) -> f64 {
        let (rotation, turning) = (world.rotation(self.body), world.angular_velocity(self.body));
        let mut work = 0.0;
        for (place, part) in self.parts.iter().enumerate() {
            let end = velocity + turning.cross(rotation * part.place);
            step.matter.velocity.set(part.particle, V::narrow(end));
            if place > 0 {
                let [first, last] = part.accelerations;
                let impulse = part.mass * (end - part.start - 0.5 * step.h * (first + last));
                forces[self.rows[place - 1]] = -impulse / step.h;
                work += 0.5 * impulse.dot(part.start + end);
            }
        }
        if self.is_fixed { work } else { 0.0 }
    }

    /// Energy of the rotation of the parts about the common center [J], and its angular momentum [kg·m²/s]; matter has both too.
    pub fn rotation(&self, world: &RigidWorld) -> (f64, DVec3) {
        let (rotation, turning) = (world.rotation(self.body), world.angular_velocity(self.body));
        let mut sums = (0.0, DVec3::ZERO);
        for part in self.parts.iter().filter(|_| !self.is_fixed) {
            let arm = rotation * part.place;
            let velocity = turning.cross(arm);
            sums.0 += 0.5 * part.mass * velocity.length_squared();
            sums.1 += arm.cross(part.mass * velocity);
        }
        sums
    }

    /// Torque of the force of a particle about the center of the body [N·m].
    pub fn torques(&self, world: &RigidWorld, forces: &[DVec3]) -> impl Iterator<Item = (usize, DVec3)> {
        let rotation = world.rotation(self.body);
        let arm = move |part: &TiedPart| rotation * (part.place - self.parts[0].place);
        self.rows.iter().zip(&self.parts[1..]).map(move |(&row, part)| (row, arm(part).cross(forces[row])))
    }
}
