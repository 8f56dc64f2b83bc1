//! Rigid bodies as a constraint of matter.
//!
//! A rigid body is a particle with an orientation: matter moves its center of mass as any particle, under all forces. This
//! constraint turns the bodies, and holds contacts and joints (crate `physcore-rigid`). Particles may meet the bodies.

mod anchors;
mod declaration;
mod faces;
mod fields;
mod history;
mod notes;
mod overlaps;
mod ties;

use glam::DVec3;
use physcore_rigid::mover::Mover;
use physcore_rigid::pose::Pose;
use physcore_rigid::world::{CenterMotion, FreeFace, FreeParticles, FreePoint, RigidState, RigidWorld, Turn, WORLD};

pub use overlaps::{RigidPose, overlaps};

use super::{Breakage, ConstrainedStep, Constraint, ConstraintProperties, ConstraintStage, DriftVelocity, ForcedState};
use crate::catalog::Space;
use crate::error::Result;
use crate::forces::StateView;
use crate::ledger::{Class, Ledger};
use crate::matter::{EnergySink, SolidMotion};
use crate::stability::{Horizon, SpectralBound};
use crate::systems::FieldInfo;
use faces::NetworkFaces;
use ties::TiedBody;

/// Largest accurate angle by which a body turns in a step [rad].
const LARGEST_ANGLE: f64 = 0.1;
/// Largest accurate part of the time in which a body falls through its own size.
const PART_OF_FALL: f64 = 0.05;
/// Name of the springs among joints in the budget and in the bound on the time step.
const JOINT_TERM: &str = "joints";

/// Rigid bodies with the particles that may meet them.
pub struct RigidBodies {
    world: RigidWorld,
    saved: RigidState,
    /// Particle of each body, in the caller's order.
    particles: Vec<u32>,
    /// Particles that may meet the bodies, with their indices in the engine's order.
    points: Vec<(u32, FreePoint)>,
    /// Faces between the points.
    faces: NetworkFaces,
    /// Whether a joint holds each point, so that it always takes part.
    joined: Vec<bool>,
    /// Bodies with the particles that are tied to them. Their motions are those of the common centers of mass.
    tied: Vec<TiedBody>,
    /// Positions [m] and velocities [m/s] of the bodies at the start of the present step.
    starts: Vec<[DVec3; 2]>,
    /// Positions of their particles then, relative to the origin [m].
    places: Vec<DVec3>,
    /// Whether no body may touch anything in the present step, or is joined.
    apart: bool,
    /// Motions of the bodies in the present step.
    motions: Vec<CenterMotion>,
    /// Motions of all points in the present step.
    others: Vec<CenterMotion>,
    /// Whether contacts, joints or springs have moved each body in the present step.
    moved: Vec<bool>,
    /// Points that take part in the present step, and the faces between them.
    near: Vec<usize>,
    near_faces: Vec<FreeFace>,
    order: u32,
    /// Index of the first particle of each body of the scene.
    firsts: Vec<usize>,
    /// Warning of overlaps at the start, empty without; None before they are sought.
    overlap: Option<String>,
    path: String,
}

impl RigidBodies {
    /// Chooses the points and faces that may meet a body within a step of `h` seconds, and the points of these faces. Their paths
    /// cross the box around all bodies.
    fn choose(&mut self, h: f64) {
        self.near.clear();
        self.near_faces.clear();
        if self.points.is_empty() {
            return;
        }
        let (lower, upper) = self.world.extent(&self.motions, h);
        let ways: Vec<f64> = self.others.iter().map(|motion| motion.way(h)).collect();
        let mut is_near = self.joined.clone();
        for (index, motion) in self.others.iter().enumerate() {
            let reach = DVec3::splat(ways[index] + self.world.reach(&self.points[index].1));
            is_near[index] |= (motion.position + reach).cmpge(lower).all() && (motion.position - reach).cmple(upper).all();
        }
        let faces = self.faces.near((lower, upper), |point| (self.others[point].position, ways[point]));
        self.near_faces.extend(faces);
        self.near_faces.iter().flat_map(|each| each.face.particles()).for_each(|point| is_near[point] = true);
        self.near.extend((0..self.points.len()).filter(|&point| is_near[point]));
        for each in &mut self.near_faces {
            each.face = each.face.map(|point| self.near.binary_search(&point).ok()).unwrap_or(each.face);
        }
    }

    /// Records positions and velocities of the bodies in the present state.
    fn record_starts<V: Space>(&mut self, step: &ConstrainedStep<'_, V>) {
        let start = |motion: CenterMotion| [motion.position, motion.velocity];
        self.starts.clear();
        self.starts.extend(self.particles.iter().map(|&particle| start(motion(step, particle as usize))));
        for tied in &mut self.tied {
            self.starts[tied.body] = start(tied.begin(step, &self.world.rotation(tied.body)));
        }
    }

    /// Particle of an end of a joint; None for the world.
    fn particle(&self, end: usize) -> Option<u32> {
        let point = |end: usize| self.points.binary_search_by_key(&end, |(_, point)| point.index).ok();
        match end {
            WORLD => None,
            end if end < self.particles.len() => Some(self.particles[end]),
            end => point(end - self.particles.len()).map(|point| self.points[point].0),
        }
    }

    /// End of a joint in a state.
    fn end<V: Space>(&self, at: &StateView<'_, V>, end: usize) -> Mover {
        let Some(particle) = self.particle(end).map(|particle| particle as usize) else { return Mover::wall(&Pose::WORLD) };
        let mut position = DVec3::ZERO;
        (0..V::DIMENSION).for_each(|axis| position[axis] = at.exact_position(axis, particle));
        let (position, velocity) = (at.properties.origin + position, at.velocity.get(particle).widen());
        if let Some(tied) = self.tied.iter().find(|tied| tied.body == end) {
            let offset = tied.offset(&self.world.rotation(end));
            let velocity = velocity - self.world.angular_velocity(end).cross(offset);
            self.world.mover(end, &CenterMotion::free(position - offset, velocity), 1.0)
        } else if end < self.particles.len() {
            self.world.mover(end, &CenterMotion::free(position, velocity), 1.0)
        } else {
            Mover { position, velocity, inverse_mass: at.properties.mass[particle].recip(), ..Mover::wall(&Pose::WORLD) }
        }
    }

    /// Motions of the bodies in the present state, as forces see them, with these angular velocities [rad/s].
    fn solid_motions(&self, angular_velocity: impl Fn(usize) -> DVec3) -> Vec<SolidMotion> {
        let of = |(body, &particle): (usize, &u32)| {
            let orientation = self.world.state.turns[body].orientation.quaternion;
            let angular_velocity = angular_velocity(body);
            SolidMotion { particle, orientation, angular_velocity, before: orientation, moved: DVec3::ZERO }
        };
        self.particles.iter().enumerate().map(of).collect()
    }
}

impl<V: Space> Constraint<V> for RigidBodies {
    fn about(&self) -> ConstraintProperties {
        ConstraintProperties {
            name: "rigid bodies",
            stages: vec![ConstraintStage { name: "rigid bodies", note: Some(self.stage_note()), last: true }],
            order: self.order,
            varies: true,
            exact: true,
            iterates: true,
            cost: 3000.0 * self.particles.len() as f64,
        }
    }

    fn bytes(&self) -> usize {
        let count = self.particles.len();
        self.world.bytes()
            + count * (size_of::<(CenterMotion, [DVec3; 2])>() + 2 * size_of::<Turn>())
            + self.points.len() * size_of::<(FreePoint, CenterMotion)>()
            + self.faces.bytes()
    }

    fn notes(&self) -> Vec<String> {
        self.warnings()
    }

    /// Places tied particles, and refuses bodies and particles that overlap at the start.
    fn initialize(&mut self, step: &mut ConstrainedStep<'_, V>) -> Result<()> {
        self.tied.iter().for_each(|tied| tied.initialize(step, &self.world));
        self.world.wake_all();
        if self.overlap.is_none() {
            self.record_starts(step);
            self.others.clear();
            self.others.extend(self.points.iter().map(|(particle, _)| motion(step, *particle as usize)));
            self.overlap = Some(self.start_overlap()?);
        }
        Ok(())
    }

    fn start(&mut self, step: &ConstrainedStep<'_, V>) {
        self.world.state.torques = step.torques();
    }

    fn solids(&self) -> Vec<SolidMotion> {
        self.solid_motions(|body| self.world.angular_velocity(body))
    }

    fn begin(&mut self, step: &ConstrainedStep<'_, V>) {
        self.record_starts(step);
        self.places.clear();
        if step.meets_solids() {
            self.places.extend(self.particles.iter().map(|&particle| step.matter.exact_position(particle as usize)));
        }
        self.others.clear();
        self.others.extend(self.points.iter().map(|(particle, _)| motion(step, *particle as usize)));
    }

    fn positions(&mut self, step: &mut ConstrainedStep<'_, V>) -> Result<bool> {
        let is_seen = step.meets_solids();
        let (starts, particles) = (&self.starts, &self.particles);
        let motion = |body: usize| {
            let [position, velocity] = starts[body];
            let drift = step.drift_velocity(particles[body] as usize);
            CenterMotion { drift, ..CenterMotion::free(position, velocity) }
        };
        let alone = !is_seen && self.tied.is_empty() && self.points.is_empty();
        self.apart = alone && self.world.turn_apart(step.h, &motion, step.executor);
        if self.apart {
            step.executor.check()?;
            return Ok(false);
        }
        self.motions.clear();
        let torques = self.world.state.torques.iter().enumerate();
        self.motions.extend(torques.map(|(body, &torque)| CenterMotion { torque, ..motion(body) }));
        for tied in &mut self.tied {
            tied.kick(step, &self.world.rotation(tied.body), &mut self.motions[tied.body]);
        }
        for (motion, (particle, _)) in self.others.iter_mut().zip(&self.points) {
            motion.drift = step.drift_velocity(*particle as usize);
        }
        self.choose(step.h);
        let before: Vec<Turn> = if is_seen { self.world.state.turns.clone() } else { Vec::new() };
        let points: Vec<FreePoint> = self.near.iter().map(|&index| self.points[index].1).collect();
        let mut others: Vec<CenterMotion> = self.near.iter().map(|&index| self.others[index]).collect();
        let needs_all = is_seen || !self.tied.is_empty();
        let predicts = step.predicts || needs_all;
        let particles = FreeParticles { points: &points, faces: &self.near_faces };
        let moved = self.world.drift((step.h, predicts), &mut self.motions, particles, &mut others, step.executor);
        if needs_all {
            self.world.predict_free(step.h, &mut self.motions, &moved);
        }
        step.executor.check()?;
        self.moved.clear();
        self.moved.extend(&moved[..self.particles.len()]);
        let bodies = self.particles.iter().zip(&self.motions).zip(&self.moved);
        let near = self.near.iter().map(|&index| &self.points[index].0);
        let points = near.zip(&others).zip(&moved[self.particles.len()..]);
        for ((&particle, motion), _) in bodies.chain(points).filter(|(_, moved)| **moved) {
            step.matter.set_exact_position(particle as usize, motion.position - step.properties.origin);
            step.matter.velocity.set(particle as usize, V::narrow(motion.velocity));
            if let DriftVelocity::Register(register) = step.drift {
                step.matter.registers[register].set(particle as usize, V::narrow(motion.drift));
            }
        }
        for tied in &self.tied {
            let motion = &mut self.motions[tied.body];
            if tied.is_fixed || !moved[tied.body] {
                motion.position += step.h * motion.drift;
            }
            tied.place(step, &self.world, motion);
        }
        if is_seen {
            let mut solids = self.solid_motions(|body| self.motions[body].turning);
            for ((solid, start), turn) in solids.iter_mut().zip(&self.places).zip(before) {
                solid.before = turn.orientation.quaternion;
                solid.moved = step.matter.exact_position(solid.particle as usize) - *start;
            }
            step.matter.solids = solids;
        }
        Ok(true)
    }

    fn velocities(&mut self, step: &mut ConstrainedStep<'_, V>) -> Result<()> {
        if self.apart {
            return Ok(());
        }
        let at = |particle: u32| motion(step, particle as usize);
        let is_seen = step.meets_solids();
        let mut turned = 0.0;
        if is_seen || !self.tied.is_empty() {
            turned = self.world.work_of_turning(step.h);
            self.world.state.torques = step.torques();
            turned += self.world.work_of_turning(step.h);
        }
        // Nothing else changes the velocities of the other bodies.
        let all = is_seen || !self.tied.is_empty() || self.world.has_springs() || self.world.may_sleep();
        self.moved.iter_mut().for_each(|moved| *moved |= all);
        let torques = self.world.state.torques.iter();
        let motions = self.motions.iter_mut().zip(&self.particles).zip(torques).zip(&self.moved);
        for (((motion, &particle), &torque), _) in motions.filter(|(_, moved)| **moved) {
            *motion = CenterMotion { torque, drift: motion.drift, ..at(particle) };
        }
        for tied in &mut self.tied {
            let torque = self.world.state.torques[tied.body];
            self.motions[tied.body] = tied.end(step, &self.world.rotation(tied.body), torque);
        }
        let mut others: Vec<CenterMotion> = self.near.iter().map(|&index| at(self.points[index].0)).collect();
        let mut meters = self.world.finish(step.h, &mut self.motions, &mut others, step.executor);
        step.executor.check()?;
        let near = self.near.iter().map(|&index| &self.points[index].0);
        let bodies = self.particles.iter().zip(&self.motions).zip(&self.moved).filter(|(_, moved)| **moved).map(|(body, _)| body);
        for (&particle, motion) in bodies.chain(near.zip(&others)) {
            step.matter.velocity.set(particle as usize, V::narrow(motion.velocity));
        }
        for tied in &self.tied {
            let mut forces = std::mem::take(&mut self.world.state.ties);
            meters.work += tied.release(step, &self.world, self.motions[tied.body].velocity, &mut forces);
            self.world.state.ties = forces;
        }
        if is_seen {
            step.matter.solids = Constraint::<V>::solids(self);
        }
        let tally = self.particles.first().map(|&particle| particle as usize / step.matter.block);
        if let Some(tally) = tally.map(|block| &mut step.matter.tallies[block]) {
            tally.add(EnergySink::Contact, meters.dissipated);
            tally.add(EnergySink::Damping, meters.damped);
            tally.add(EnergySink::Work, meters.work + turned);
        }
        Ok(())
    }

    /// Adds the springs, the rotation of the bodies, and their fall, to the bound on the time step.
    fn bound(&self, state: &ForcedState<'_, V>, bound: &mut SpectralBound) {
        let ahead = bound.horizon() == Horizon::Certified;
        for (end, [stiffness, damping]) in self.world.spring_rates(|end| self.end(state.at, end), ahead) {
            if let Some(particle) = self.particle(end) {
                let mass = state.at.properties.mass[particle as usize];
                bound.point(particle as usize, JOINT_TERM, mass * stiffness, mass * damping);
            }
        }
        let accelerations = (state.accelerations)();
        for (body, &particle) in self.particles.iter().enumerate() {
            let turning = self.world.angular_velocity(body).length();
            if turning > 0.0 {
                bound.accuracy("rigid bodies", LARGEST_ANGLE / turning);
            }
            let acceleration = accelerations[particle as usize].length();
            if acceleration > 0.0 {
                bound.accuracy("rigid bodies", PART_OF_FALL * (2.0 * self.world.size(body) / acceleration).sqrt());
            }
        }
    }

    fn energy(&self, at: &StateView<'_, V>, ledger: &mut Ledger) {
        let shared: f64 = self.tied.iter().map(|tied| tied.rotation(&self.world).0).sum();
        ledger.add(Class::Kinetic, "rotation", self.world.rotational_energy() - shared);
        if self.world.may_sleep() {
            ledger.add(Class::Dissipated, "sleep", self.world.state.slept);
        }
        if self.world.has_springs() {
            ledger.add(Class::Potential, JOINT_TERM, self.world.spring_energy(|end| self.end(at, end)));
            ledger.add(Class::Dissipated, "tearing", self.world.state.torn);
        }
    }

    fn spin(&self) -> DVec3 {
        let free = self.world.bodies.iter().zip(&self.world.state.turns).filter(|(body, _)| body.inverse_mass > 0.0);
        free.map(|(_, turn)| turn.spin).sum::<DVec3>() - self.tied.iter().map(|tied| tied.rotation(&self.world).1).sum::<DVec3>()
    }

    fn fields(&self) -> Vec<FieldInfo> {
        self.listed(V::DIMENSION)
    }

    fn read(&self, field: usize, _state: &ForcedState<'_, V>) -> Vec<f64> {
        self.values(&self.listed(V::DIMENSION)[field].name, V::DIMENSION)
    }

    fn adopt(&mut self, field: &str, values: &[f64]) {
        self.replace(field, values);
    }

    fn leave_out(&mut self, breakage: &Breakage) {
        self.faces.leave_out_broken(&breakage.broken);
    }
}

/// Motion of a particle in the present state.
#[inline(always)]
fn motion<V: Space>(step: &ConstrainedStep<'_, V>, particle: usize) -> CenterMotion {
    let position = step.properties.origin + step.matter.exact_position(particle);
    CenterMotion::free(position, step.matter.velocity.get(particle).widen())
}
