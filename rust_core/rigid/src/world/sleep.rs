//! Sleep: groups of bodies that have come to rest are held still, if asked for, until something disturbs them.
//!
//! A group consists of the bodies that near pairs, joints and springs connect. It falls asleep when its bodies have been
//! at rest for long enough, and contacts or joints hold each of them. It wakes at the start of a step in which
//! something that moves may touch one of its bodies: the boxes of the step meet. It also wakes where forces have changed.
//! Nothing therefore touches a body that sleeps. Steps see such bodies as fixed ones at rest.

use glam::DVec3;

use super::groups::Roots;
use super::members::StepMembers;
use super::{CenterMotion, RigidWorld};
use crate::island::Island;

/// Condition under which a body may fall asleep.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SleepRule {
    /// Speed of its fastest point below which the body is at rest [m/s]; 0 for a body that never sleeps.
    pub speed: f64,
    /// Time for which it has to be at rest [s].
    pub after: f64,
}

/// State of a body that may sleep.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BodyRest {
    /// Time for which the body has been slower than its limit [s].
    pub still: f64,
    /// First body of its group while it sleeps.
    pub group: Option<u32>,
    /// Acceleration [m/s²] and torque [N·m] by forces when it fell asleep.
    pub load: [DVec3; 2],
}

impl BodyRest {
    /// Length of `packed`.
    pub const NUMBERS: usize = 8;

    /// Whether an awake body has been at rest for so long that it may fall asleep.
    fn has_rested(&self, rule: &SleepRule) -> bool {
        self.group.is_none() && rule.speed > 0.0 && self.still >= rule.after
    }

    /// Numbers for files.
    pub fn packed(&self) -> [f64; Self::NUMBERS] {
        let [[x, y, z], [a, b, c]] = self.load.map(|vector| vector.to_array());
        [self.still, self.group.map_or(-1.0, f64::from), x, y, z, a, b, c]
    }

    /// State of which these are the numbers.
    pub fn unpacked(numbers: &[f64]) -> Self {
        let load = [2, 5].map(|first| DVec3::from_slice(&numbers[first..]));
        Self { still: numbers[0], group: (numbers[1] >= 0.0).then_some(numbers[1] as u32), load }
    }
}

impl RigidWorld {
    /// Lets bodies sleep by a rule for each.
    pub fn let_sleep(&mut self, rules: Vec<SleepRule>) {
        if rules.iter().any(|rule| rule.speed > 0.0) {
            self.state.rests = vec![BodyRest::default(); rules.len()];
            self.sleep = rules;
        }
    }

    /// Whether some bodies may sleep.
    pub fn may_sleep(&self) -> bool {
        !self.sleep.is_empty()
    }

    /// Number of bodies that may sleep.
    pub fn sleepers(&self) -> usize {
        self.sleep.iter().filter(|rule| rule.speed > 0.0).count()
    }

    /// Whether a body sleeps.
    #[inline]
    pub fn is_asleep(&self, body: usize) -> bool {
        self.state.rests.get(body).is_some_and(|rest| rest.group.is_some())
    }

    /// Wakes all bodies.
    pub fn wake_all(&mut self) {
        self.state.rests.fill(BodyRest::default());
    }

    /// Wakes the groups of these bodies; returns whether there are any.
    pub(super) fn wake(&mut self, bodies: &[usize]) -> bool {
        let mut woken: Vec<u32> = bodies.iter().filter_map(|&body| self.state.rests[body].group).collect();
        woken.sort_unstable();
        let rests = self.state.rests.iter_mut();
        let wakes = |rest: &&mut BodyRest| rest.group.is_some_and(|group| woken.binary_search(&group).is_ok());
        rests.filter(wakes).for_each(|rest| *rest = BodyRest::default());
        !woken.is_empty()
    }

    /// Wakes the groups on which forces have changed. The least change that does so brings a body from rest to its limit in the
    /// time after which it sleeps.
    pub(super) fn wake_loaded(&mut self, h: f64, bodies: &[CenterMotion]) {
        let is_loaded = |&body: &usize| {
            let (rest, motion, SleepRule { speed, after }) = (&self.state.rests[body], &bodies[body], self.sleep[body]);
            let change = [motion.acceleration(h) - rest.load[0], motion.torque - rest.load[1]];
            after * self.speed_of(body, change) > speed
        };
        let loaded: Vec<usize> = (0..bodies.len()).filter(|&body| self.is_asleep(body)).filter(is_loaded).collect();
        self.wake(&loaded);
    }

    /// Holds the bodies that sleep in a step.
    pub(super) fn hold_sleepers(&self, bodies: &mut [CenterMotion]) {
        for (_, motion) in bodies.iter_mut().enumerate().filter(|(body, _)| self.is_asleep(*body)) {
            (motion.drift, motion.velocity, motion.turning) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
        }
    }

    /// Keeps the loads of the contacts of bodies that sleep, for when they wake, and removes all others.
    pub(super) fn keep_loads_of_sleepers(&mut self) {
        let mut loads = std::mem::take(&mut self.state.loads);
        loads.retain(|((one, other, _), _)| [*one, *other].iter().any(|&name| self.is_asleep(name as usize)));
        self.state.loads = loads;
    }

    /// Accelerations and torques by forces at the end of a step of `h` seconds, after the second kick; empty if no body may sleep.
    pub(super) fn final_loads(&self, h: f64, bodies: &[CenterMotion]) -> Vec<[DVec3; 2]> {
        let of = |motion: &CenterMotion| [(motion.velocity - motion.drift) * (2.0 / h), motion.torque];
        if self.state.rests.is_empty() { Vec::new() } else { bodies.iter().map(of).collect() }
    }

    /// Ends a step of `h` seconds: stops the bodies that sleep, and lets groups fall asleep.
    pub(super) fn end_rests(&mut self, h: f64, (islands, loads): (&[Island], &[[DVec3; 2]]), bodies: &mut [CenterMotion]) {
        if self.state.rests.is_empty() {
            return;
        }
        for body in 0..bodies.len() {
            if self.is_asleep(body) {
                (bodies[body].velocity, self.state.turns[body].spin) = (DVec3::ZERO, DVec3::ZERO);
            } else if self.sleep[body].speed > 0.0 {
                let speed = self.speed_of(body, [bodies[body].velocity, self.state.turns[body].spin]);
                let rest = &mut self.state.rests[body];
                rest.still = if speed < self.sleep[body].speed { rest.still + h } else { 0.0 };
            }
        }
        if !self.state.rests.iter().zip(&self.sleep).any(|(rest, rule)| rest.has_rested(rule)) {
            return;
        }
        let groups = self.resting_groups(islands, loads, bodies);
        for (body, group) in groups.into_iter().enumerate() {
            let Some(group) = group else { continue };
            let (spin, motion) = (self.state.turns[body].spin, &mut bodies[body]);
            let turning = spin.dot(self.angular_velocity(body));
            self.state.slept += 0.5 * (motion.velocity.length_squared() / self.bodies[body].inverse_mass + turning);
            (motion.velocity, self.state.turns[body].spin) = (DVec3::ZERO, DVec3::ZERO);
            self.state.rests[body] = BodyRest { still: 0.0, group: Some(group), load: loads[body] };
        }
    }

    /// Group in which each body falls asleep, at the end of a step.
    fn resting_groups(&self, islands: &[Island], loads: &[[DVec3; 2]], bodies: &[CenterMotion]) -> Vec<Option<u32>> {
        let count = bodies.len();
        let mut roots = Roots::new(count);
        // Whether contacts or joints hold each body, and whether its group is with a particle, or with a fixed body that moves.
        let (mut held, mut stirred) = (vec![false; count], vec![false; count]);
        let mut link = |members: &mut dyn Iterator<Item = (usize, bool, [DVec3; 2])>| {
            let (mut first, mut stirs) = (None, false);
            for (member, is_fixed, motion) in members {
                if member < count && !is_fixed {
                    roots.join(*first.get_or_insert(member), member);
                } else {
                    stirs |= !is_fixed || motion != [DVec3::ZERO; 2];
                }
            }
            first.into_iter().for_each(|first| stirred[first] |= stirs);
        };
        for island in islands {
            let movers = island.members.iter().zip(&island.movers);
            link(&mut movers.map(|(&member, mover)| (member, mover.is_fixed(), [mover.velocity, mover.spin])));
            let pressed = island.contacts.iter().filter(|contact| contact.load.normal > 0.0).map(|contact| contact.bodies);
            let ends = pressed.chain(island.joints.iter().map(|joint| joint.bodies)).flatten();
            ends.filter_map(|end| island.members.get(end).copied())
                .filter(|&body| body < count)
                .for_each(|body| held[body] = true);
        }
        for ends in self.springs.pairs() {
            let of = |end: usize| {
                if end >= count {
                    return (end, false, [DVec3::ZERO; 2]);
                }
                (end, self.bodies[end].inverse_mass == 0.0, [bodies[end].velocity, self.state.turns[end].spin])
            };
            link(&mut ends.into_iter().flatten().map(of));
            ends.into_iter().flatten().filter(|&end| end < count).for_each(|body| held[body] = true);
        }
        let rests = |body: usize| {
            let has_rested = self.state.rests[body].has_rested(&self.sleep[body]);
            has_rested && (held[body] || loads[body] == [DVec3::ZERO; 2])
        };
        let mut is_awake = vec![false; count];
        (0..count).filter(|&body| stirred[body] || !rests(body)).for_each(|body| is_awake[roots.find(body)] = true);
        (0..count).map(|body| roots.find(body)).map(|root| (!is_awake[root]).then_some(root as u32)).collect()
    }

    /// Bound on the speed of the points of a body at a velocity and an angular momentum [m/s].
    fn speed_of(&self, body: usize, [velocity, spin]: [DVec3; 2]) -> f64 {
        let turning = self.bodies[body].inertia.inverse(&self.state.turns[body].orientation) * spin;
        velocity.length() + self.size(body) * turning.length()
    }
}

impl StepMembers<'_> {
    /// Bodies that sleep and that something may touch in the step: pairs have a member that moves.
    pub fn disturbed(&self, pairs: &[[u32; 2]]) -> Vec<usize> {
        pairs.iter().flatten().map(|&end| end as usize).filter(|&end| self.world.is_asleep(end)).collect()
    }
}
