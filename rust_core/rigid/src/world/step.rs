//! Steps of all bodies.

use glam::DVec3;
use physcore_base::parallel::{BlockedSlice, Executor};

use super::{CenterMotion, FreePoint, RigidWorld, Turn};
use crate::island::{Accuracy, Island, Meters};
use crate::mover::Mover;
use crate::pose::Pose;
use crate::rotation::Inertia;
use crate::surface::Surface;

impl RigidWorld {
    /// Moves bodies and particles through a step of `h` seconds, with their contacts and joints; returns which of them these
    /// have moved. If `predicts`, the velocities that are predicted for its end obey contacts and joints.
    pub fn drift(
        &mut self,
        (h, predicts): (f64, bool),
        bodies: &mut [CenterMotion],
        points: &[FreePoint],
        motions: &mut [CenterMotion],
        executor: &Executor,
    ) -> Vec<bool> {
        let count = self.bodies.len();
        let mut movers: Vec<Mover> = bodies.iter().enumerate().map(|(body, motion)| self.mover(body, motion, h)).collect();
        let mut surfaces: Vec<Surface> = self.bodies.iter().map(|solid| solid.surface).collect();
        for (point, motion) in points.iter().zip(&*motions) {
            movers.push(Mover {
                position: motion.position,
                velocity: motion.velocity,
                acceleration: motion.acceleration(h),
                inverse_mass: point.inverse_mass,
                ..Mover::wall(&Pose::WORLD)
            });
            surfaces.push(point.surface);
        }
        self.begin_springs(&mut movers, points);
        movers.extend(self.walls.iter().map(|wall| wall.mover));
        surfaces.extend(self.walls.iter().map(|wall| wall.surface));
        let pairs = self.pairs(&movers, &surfaces, count + points.len(), h);
        // Other end of joints to the world.
        movers.push(Mover::wall(&Pose::WORLD));
        surfaces.push(Surface { shape: 0, friction: None, restitution: 0.0 });
        self.islands = self.groups(&movers, &surfaces, &pairs, points);
        let (shapes, solver, predicts) = (&self.shapes, self.solver, predicts || self.has_damped_springs());
        executor.for_each_block(BlockedSlice::new(&mut self.islands, 1), &|block: BlockedSlice<'_, Island>| {
            for island in block.items {
                let sized = |mover: &&Mover| !mover.is_fixed() && mover.inertia != Inertia::NONE;
                let accuracy = Accuracy { iterations: solver.iterations, velocities: 1e-9, linearizations: 1, positions: 0.0 };
                let sweep = (solver.substeps, accuracy);
                if island.movers.iter().filter(sized).count() <= solver.sequential {
                    island.advance(shapes, h, sweep);
                } else {
                    island.sweep(shapes, h, sweep);
                }
                island.ahead.resize(island.movers.len(), [DVec3::ZERO; 2]);
                if predicts {
                    island.predict();
                }
            }
        });
        // Bodies without contacts and joints, and fixed ones.
        let mut alone = vec![true; movers.len()];
        for island in &self.islands {
            let members = island.members.iter().zip(&island.movers).zip(&island.ahead);
            members.filter(|((_, mover), _)| !mover.is_fixed()).for_each(|((&member, mover), ahead)| {
                alone[member] = false;
                movers[member] = *mover;
                movers[member].velocity += ahead[0] - 0.5 * (h - island.open) * mover.acceleration;
                movers[member].spin += ahead[1] - 0.5 * (h - island.open) * mover.torque;
            });
        }
        for (mover, _) in movers.iter_mut().zip(&alone).filter(|(_, alone)| **alone) {
            mover.kick(0.5 * h);
            mover.drift(h);
        }
        let mut moved: Vec<bool> = alone.iter().map(|alone| !alone).collect();
        self.springs.mark(&mut moved);
        for (index, mover) in movers.iter().enumerate().take(count) {
            self.state.turns[index] = Turn { orientation: mover.orientation, spin: mover.spin };
        }
        let (first, others) = movers.split_at(count);
        let all = bodies.iter_mut().zip(first).chain(motions.iter_mut().zip(others)).zip(&moved);
        for ((motion, mover), &moved) in all {
            let mut end = *mover;
            end.kick(0.5 * h);
            (motion.velocity, motion.turning) = (end.velocity, end.angular_velocity());
            if moved && !mover.is_fixed() {
                (motion.position, motion.drift) = (mover.position, mover.velocity);
            }
        }
        moved.truncate(count + points.len());
        moved
    }

    /// Ends a step of `h` seconds, given the motions of bodies and particles after the second kick. Changes their velocities;
    /// returns the energies of contacts and joints.
    pub fn finish(&mut self, h: f64, bodies: &mut [CenterMotion], others: &mut [CenterMotion], executor: &Executor) -> Meters {
        for ((motion, turn), solid) in bodies.iter().zip(&mut self.state.turns).zip(&self.bodies) {
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
        self.state.loads.clear();
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
        self.state.loads.sort_unstable_by_key(|(key, _)| *key);
        islands.iter_mut().for_each(Island::clear);
        self.spare.append(&mut islands);
        self.meter_springs(h, bodies, others);
        self.meters
    }
}
