//! Springs between bodies, as forces in the steps of the world.
//!
//! A step is velocity Verlet. The forces at its start act until its end. There half of them gives way to half of those at the
//! end. Damping there acts on velocities that are predicted with the springs at the start. Springs join no groups.

use glam::DVec3;

use super::members::StepMembers;
use super::{CenterMotion, FreePoint, RigidWorld};
use crate::joints::{DampedSpring, Joint, SpringForce};
use crate::mover::Mover;
use crate::pose::Pose;

/// Spring that acts in the present step.
#[derive(Debug, Clone, Copy)]
pub(super) struct ActingSpring {
    /// Index among the joints.
    joint: usize,
    /// Indices of the ends among the movers; None at the world.
    ends: [Option<usize>; 2],
    /// Force at the start of the step.
    start: SpringForce,
}

/// Springs of the present step.
#[derive(Debug, Default)]
pub(super) struct SpringStep {
    acting: Vec<ActingSpring>,
    /// Acceleration [m/s²] and torque [N·m] by the springs at the start, of each body and particle.
    loads: Vec<[DVec3; 2]>,
    /// Inverse masses of the particles [1/kg].
    inverse_masses: Vec<f64>,
}

impl SpringStep {
    /// Whether no spring acts.
    pub fn is_empty(&self) -> bool {
        self.acting.is_empty()
    }

    /// Bodies and particles at the ends of each spring; None at the world.
    pub fn pairs(&self) -> impl Iterator<Item = [Option<usize>; 2]> {
        self.acting.iter().map(|spring| spring.ends)
    }

    /// Acceleration and torque of a body or particle by the springs; None if no spring acts on any.
    pub fn load(&self, index: usize) -> Option<[DVec3; 2]> {
        self.loads.get(index).copied()
    }
}

/// Ends of a spring in a state.
fn ends_in(ends: [Option<usize>; 2], movers: &[Mover]) -> [Mover; 2] {
    ends.map(|end| end.map_or_else(|| Mover::wall(&Pose::WORLD), |end| movers[end]))
}

impl RigidWorld {
    /// Springs that are whole, with their indices among the joints.
    fn whole_springs(&self) -> impl Iterator<Item = (usize, [usize; 2], &Joint, DampedSpring)> {
        let whole = self.state.joints.iter().enumerate().filter(|(_, joint)| !joint.broken);
        whole.filter_map(|(index, each)| each.joint.spring().map(|spring| (index, each.ends, &each.joint, spring)))
    }

    /// Springs that act in a step, with their forces at its start.
    pub(super) fn begin_springs(&mut self, h: f64, bodies: &[CenterMotion], points: &[FreePoint], motions: &[CenterMotion]) {
        let members = StepMembers { world: self, bodies, points, faces: &[], motions, h };
        let mut step = SpringStep::default();
        for (index, ends, joint, spring) in self.whole_springs() {
            let [Some(one), Some(other)] = ends.map(|end| members.place(end)) else { continue };
            if self.is_asleep(one) || self.is_asleep(other) {
                continue;
            }
            let [first, second] = [one, other].map(|end| members.unsprung(end));
            let start = joint.spring_force(spring, [&first, &second]);
            let ends = [one, other].map(|end| (end < members.free()).then_some(end));
            if step.is_empty() {
                step.loads.resize(members.free(), [DVec3::ZERO; 2]);
                step.inverse_masses.extend(points.iter().map(|point| point.inverse_mass));
            }
            for (side, mover) in [&first, &second].into_iter().enumerate() {
                let Some(end) = ends[side] else { continue };
                step.loads[end][0] += mover.inverse_mass * start.on(side);
                step.loads[end][1] += start.arms[side].cross(start.on(side));
            }
            step.acting.push(ActingSpring { joint: index, ends, start });
        }
        self.springs = step;
    }

    /// Adds the second half of the forces of the springs, at the end of a step of `h` seconds.
    pub(super) fn end_springs(&mut self, h: f64, bodies: &mut [CenterMotion], others: &mut [CenterMotion]) {
        if self.springs.is_empty() {
            return;
        }
        let count = self.bodies.len();
        let mut movers = self.movers_of(bodies, others);
        for (mover, load) in movers.iter_mut().zip(&self.springs.loads).filter(|(mover, _)| !mover.is_fixed()) {
            mover.velocity += 0.5 * h * load[0];
            mover.spin += 0.5 * h * load[1];
        }
        for spring in &self.springs.acting {
            let each = &mut self.state.joints[spring.joint];
            let Some(law) = each.joint.spring() else { continue };
            let [first, second] = ends_in(spring.ends, &movers);
            let end = each.joint.spring_force(law, [&first, &second]);
            each.reaction = [0.5 * (spring.start.force + end.force), DVec3::ZERO];
            for (side, index) in spring.ends.iter().enumerate().filter_map(|(side, index)| index.map(|index| (side, index))) {
                if movers[index].is_fixed() {
                    continue;
                }
                let (force, torque) = (end.on(side), end.arms[side].cross(end.on(side)));
                let motion = if index < count { &mut bodies[index] } else { &mut others[index - count] };
                motion.velocity += 0.5 * h * movers[index].inverse_mass * force;
                if index < count {
                    self.state.turns[index].spin += 0.5 * h * torque;
                }
            }
        }
    }

    /// Meters the energies of the springs at the end of a step of `h` seconds, and breaks those that are pulled too much.
    pub(super) fn meter_springs(&mut self, h: f64, bodies: &[CenterMotion], others: &[CenterMotion]) {
        if self.springs.is_empty() {
            return;
        }
        let movers = self.movers_of(bodies, others);
        for ActingSpring { joint, ends, start } in &self.springs.acting {
            let each = &mut self.state.joints[*joint];
            let Some(law) = each.joint.spring() else { continue };
            let [first, second] = ends_in(*ends, &movers);
            let end = each.joint.spring_force(law, [&first, &second]);
            self.meters.damped += 0.5 * h * (start.loss + end.loss);
            self.meters.work += 0.5 * h * (start.supply + end.supply);
            if each.reaction[0].length() > each.joint.breaking_force {
                (each.broken, each.reaction) = (true, [DVec3::ZERO; 2]);
                self.state.torn += end.energy;
            }
        }
    }

    /// Bodies and particles in a state.
    fn movers_of(&self, bodies: &[CenterMotion], others: &[CenterMotion]) -> Vec<Mover> {
        let own = bodies.iter().enumerate().map(|(body, motion)| self.mover(body, motion, 1.0));
        let particle = |(motion, &inverse_mass): (&CenterMotion, &f64)| Mover {
            position: motion.position,
            velocity: motion.velocity,
            inverse_mass,
            ..Mover::wall(&Pose::WORLD)
        };
        own.chain(others.iter().zip(&self.springs.inverse_masses).map(particle)).collect()
    }

    /// Whether the forces of springs depend on velocities.
    pub(super) fn has_damped_springs(&self) -> bool {
        self.whole_springs().any(|(.., spring)| spring.damping > 0.0)
    }

    /// Whether there are springs.
    pub fn has_springs(&self) -> bool {
        self.state.joints.iter().any(|joint| joint.joint.spring().is_some())
    }

    /// Potential energy of all springs [J], with the bodies and particles at their ends.
    pub fn spring_energy(&self, mover: impl Fn(usize) -> Mover) -> f64 {
        let of = |(_, ends, joint, spring): (usize, [usize; 2], &Joint, DampedSpring)| {
            let [first, second] = ends.map(&mover);
            joint.spring_force(spring, [&first, &second]).energy
        };
        self.whole_springs().map(of).sum()
    }

    /// Bounds on the squares of the angular frequencies [1/s²] and on the decay rates [1/s] of the ends of springs. They hold
    /// for the present directions of the springs, or for all directions `ahead`.
    ///
    /// The ends move by a and b, and k (a + b)² ≤ k (1 + t) a² + k (1 + 1/t) b². For bodies with many springs t is 1. For one
    /// spring it is the ratio of the effective masses, which is exact.
    pub fn spring_rates(&self, mover: impl Fn(usize) -> Mover, ahead: bool) -> Vec<(usize, [f64; 2])> {
        let mut rates: Vec<(usize, [[f64; 2]; 2])> = Vec::new();
        for (_, ends, joint, spring) in self.whole_springs() {
            let [first, second] = ends.map(&mover);
            let both = joint.spring_rates(spring, [&first, &second], ahead);
            for side in [0, 1] {
                let (own, other) = (&both[side], &both[1 - side]);
                if own.shared[0] == 0.0 && own.shared[1] == 0.0 {
                    continue;
                }
                let alone = other.shared == [0.0; 2];
                let equal = own.shared.map(|rate| if alone { rate } else { 2.0 * rate });
                let weighted = [0, 1].map(|kind| own.shared[kind] + other.shared[kind]);
                let [mut equal, mut weighted] = [equal, weighted];
                equal[0] += own.own;
                weighted[0] += own.own;
                rates.push((ends[side], [equal, weighted]));
            }
        }
        rates.sort_by_key(|(end, _)| *end);
        let mut sums: Vec<(usize, [[f64; 2]; 2])> = Vec::new();
        for (end, terms) in rates {
            match sums.last_mut().filter(|(last, _)| *last == end) {
                Some((_, sum)) => (0..4).for_each(|place| sum[place / 2][place % 2] += terms[place / 2][place % 2]),
                None => sums.push((end, terms)),
            }
        }
        let largest = |choice: usize, kind: usize| sums.iter().map(|(_, sum)| sum[choice][kind]).fold(0.0, f64::max);
        let better = [0, 1].map(|kind| usize::from(largest(1, kind) < largest(0, kind)));
        sums.iter().map(|(end, sum)| (*end, [0, 1].map(|kind| sum[better[kind]][kind]))).collect()
    }
}
