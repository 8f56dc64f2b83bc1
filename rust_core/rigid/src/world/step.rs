//! Steps of all bodies.

use glam::DVec3;
use physcore_base::parallel::{BlockedSlice, Executor};

use super::members::StepMembers;
use super::{CenterMotion, FreeParticles, RigidWorld, Turn};
use crate::island::{Accuracy, Island, Meters};
use crate::mover::Mover;
use crate::rotation::Inertia;
use crate::sweep_steps::SweepPieces;

impl RigidWorld {
    /// Moves bodies and particles with their faces through a step of `h` seconds, with their contacts and joints; returns which of them these
    /// have moved. If `predicts`, the velocities that are predicted for its end obey contacts and joints.
    pub fn drift(
        &mut self,
        (h, predicts): (f64, bool),
        bodies: &mut [CenterMotion],
        particles: FreeParticles,
        motions: &mut [CenterMotion],
        executor: &Executor,
    ) -> Vec<bool> {
        let FreeParticles { points, faces } = particles;
        self.wake_loaded(h, bodies);
        let (mut near, mut spare) = (std::mem::take(&mut self.near), std::mem::take(&mut self.spare));
        let pairs = loop {
            self.begin_springs(h, bodies, points, motions);
            let members = StepMembers { world: self, bodies, points, faces, motions, h };
            let pairs = members.pairs(&mut near);
            let disturbed = members.disturbed(&pairs);
            if !self.wake(&disturbed) {
                break pairs;
            }
        };
        self.hold_sleepers(bodies);
        let members = StepMembers { world: self, bodies, points, faces, motions, h };
        let islands = members.groups(&pairs, &mut spare);
        (self.near, self.spare, self.islands) = (near, spare, islands);
        let (shapes, solver, obeys) = (&self.shapes, self.solver, predicts || self.has_damped_springs());
        executor.for_each_block(BlockedSlice::new(&mut self.islands, 1), &|block: BlockedSlice<'_, Island>| {
            for island in block.items {
                let sized = |mover: &&Mover| !mover.is_fixed() && mover.inertia != Inertia::NONE;
                let accuracy = Accuracy { iterations: solver.iterations, velocities: 1e-9, linearizations: 1, positions: 0.0 };
                let (count, usual) = (solver.substeps, h / solver.substeps as f64);
                let pieces = SweepPieces { count, usual, accuracy };
                if island.movers.iter().filter(sized).count() <= solver.sequential {
                    island.advance(shapes, h, &pieces);
                } else {
                    island.take_sweeps(shapes, (h, h), &pieces);
                }
                island.ahead.resize(island.movers.len(), [DVec3::ZERO; 2]);
                if obeys {
                    island.predict();
                }
            }
        });
        let members = StepMembers { world: self, bodies, points, faces, motions, h };
        let mut moved: Vec<bool> = (0..members.free()).map(|member| self.is_asleep(member)).collect();
        let mut results = Vec::new();
        for island in &self.islands {
            let own = island.members.iter().zip(&island.movers).zip(&island.ahead);
            for ((&member, mover), ahead) in own.filter(|((_, mover), _)| !mover.is_fixed()) {
                let mut mover = *mover;
                mover.velocity += ahead[0] - 0.5 * (h - island.open) * mover.acceleration;
                mover.spin += ahead[1] - 0.5 * (h - island.open) * mover.torque;
                moved[member] = true;
                results.push((member, mover));
            }
        }
        for end in self.springs.pairs().flatten().flatten() {
            if !std::mem::replace(&mut moved[end], true) {
                let mut mover = members.mover(end);
                mover.kick(0.5 * h);
                mover.drift(h);
                results.push((end, mover));
            }
        }
        let count = self.bodies.len();
        for (index, mover) in results {
            if index < count {
                self.state.turns[index] = Turn { orientation: mover.orientation, spin: mover.spin };
            }
            let motion = if index < count { &mut bodies[index] } else { &mut motions[index - count] };
            if !mover.is_fixed() {
                (motion.position, motion.drift) = (mover.position, mover.velocity);
            }
            let mut end = mover;
            end.kick(0.5 * h);
            (motion.velocity, motion.turning) = (end.velocity, end.angular_velocity());
        }
        self.turn_free(h, bodies, &moved, executor);
        moved
    }

    /// Predicts the velocities at the end of a step of `h` seconds of the bodies that have not been moved.
    pub fn predict_free(&self, h: f64, bodies: &mut [CenterMotion], moved: &[bool]) {
        for (index, motion) in bodies.iter_mut().enumerate().filter(|(index, _)| !moved[*index]) {
            let mut end = self.mover(index, motion, h);
            end.velocity = motion.drift;
            end.kick(0.5 * h);
            (motion.velocity, motion.turning) = (end.velocity, end.angular_velocity());
        }
    }

    /// Ends a step of `h` seconds, given the motions of bodies and particles after the second kick. Changes their velocities;
    /// returns the energies of contacts and joints.
    pub fn finish(&mut self, h: f64, bodies: &mut [CenterMotion], others: &mut [CenterMotion], executor: &Executor) -> Meters {
        let loads = self.final_loads(h, bodies);
        for ((motion, turn), solid) in bodies.iter().zip(&mut self.state.turns).zip(self.bodies.iter()) {
            if motion.torque != DVec3::ZERO && solid.inverse_mass > 0.0 {
                turn.spin += 0.5 * h * motion.torque;
            }
        }
        self.end_springs(h, bodies, others);
        let count = self.bodies.len();
        let free = count + others.len();
        for island in &mut self.islands {
            let members = island.movers.iter_mut().zip(&island.members).zip(&island.ahead);
            for ((mover, &member), ahead) in members.filter(|((mover, _), _)| !mover.is_fixed()) {
                if member < count {
                    mover.velocity = bodies[member].velocity - ahead[0];
                    mover.spin = self.state.turns[member].spin - ahead[1];
                } else {
                    mover.velocity = others[member - count].velocity - ahead[0];
                }
            }
        }
        executor.for_each_block(BlockedSlice::new(&mut self.islands, 1), &|block: BlockedSlice<'_, Island>| {
            block.items.iter_mut().for_each(Island::end_piece);
        });
        self.meters = Meters::default();
        self.keep_loads_of_sleepers();
        let mut islands = std::mem::take(&mut self.islands);
        for island in &islands {
            for (mover, &member) in island.movers.iter().zip(&island.members).filter(|(mover, _)| !mover.is_fixed()) {
                if member < count {
                    bodies[member].velocity = mover.velocity;
                    self.state.turns[member].spin = mover.spin;
                } else if member < free {
                    others[member - count].velocity = mover.velocity;
                }
            }
            self.meters.dissipated += island.meters.dissipated;
            self.meters.work += island.meters.work;
            self.state.retaken += u64::from(island.meters.retaken);
            self.state.waits += u64::from(island.meters.waits);
            self.state.pushed += island.meters.pushed;
            let pressed = island.contacts.iter().filter(|contact| contact.load.normal > 0.0);
            self.state.loads.extend(pressed.map(|contact| (contact.key, contact.load)));
            for held in &island.joints {
                let joint = &mut self.state.joints[held.index];
                (joint.loads, joint.bounds) = (held.loads, held.bounds);
                joint.reaction = held.reaction.map(|impulse| impulse / h);
                if joint.reaction[0].length() > joint.joint.breaking_force {
                    (joint.broken, joint.reaction) = (true, [DVec3::ZERO; 2]);
                }
                if let Some((_, place)) = held.joint.freedom(held.bodies.map(|body| &island.movers[body])) {
                    joint.joint.last = place / joint.joint.unit();
                }
            }
        }
        // Contacts of a group stand in the order of its pairs.
        let pairs = self.state.loads.chunk_by_mut(|(one, _), (other, _)| (one.0, one.1) == (other.0, other.1));
        pairs.for_each(|pair| pair.sort_unstable_by_key(|(key, _)| *key));
        self.state.loads.sort_by_key(|(key, _)| *key);
        self.end_rests(h, (&islands, &loads), bodies);
        islands.iter_mut().for_each(Island::clear);
        self.spare.append(&mut islands);
        self.meter_springs(h, bodies, others);
        self.meters
    }
}
