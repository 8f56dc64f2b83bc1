//! Rotation of bodies that meet nothing and have no joint, side by side.

use glam::DVec3;
use physcore_base::parallel::{BlockedSlice, Executor};
use physcore_base::simd::{Isa, Kernel, LANES, dispatch_wide};

use super::{CenterMotion, RigidWorld, SolidBody, Turn};
use crate::splitting::FreeTurns;

/// Bodies that one thread turns at a time.
const BLOCK: usize = 64 * LANES;

impl RigidWorld {
    /// Turns the bodies that have not been moved through a step of `h` seconds.
    pub(super) fn turn_free(&mut self, h: f64, motions: &[CenterMotion], moved: &[bool], executor: &Executor) {
        let bodies = &self.bodies;
        executor.for_each_block(BlockedSlice::new(&mut self.state.turns, BLOCK), &|block: BlockedSlice<'_, Turn>| {
            let range = block.start..block.start + block.items.len();
            let (bodies, motions, moved) = (&bodies[range.clone()], &motions[range.clone()], &moved[range]);
            dispatch_wide(FreeTurning { turns: block.items, bodies, motions, moved, h });
        });
    }
}

/// Free rotation of a block of bodies.
struct FreeTurning<'a> {
    turns: &'a mut [Turn],
    bodies: &'a [SolidBody],
    motions: &'a [CenterMotion],
    moved: &'a [bool],
    h: f64,
}

impl Kernel for FreeTurning<'_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Isa>(mut self, _isa: I) {
        let mut lanes = FreeTurns::new();
        let (mut members, mut count) = ([0; LANES], 0);
        for index in (0..self.turns.len()).filter(|&index| !self.moved[index]) {
            let (body, turn, torque) = (&self.bodies[index], &mut self.turns[index], self.motions[index].torque);
            if body.inverse_mass == 0.0 {
                turn.orientation = turn.orientation.turned(self.h * turn.spin);
                continue;
            }
            if torque != DVec3::ZERO {
                turn.spin += 0.5 * self.h * torque;
            }
            if body.inertia.is_planar() {
                turn.orientation = body.inertia.turned(&turn.orientation, turn.spin, self.h);
                continue;
            }
            lanes.set(count, &body.inertia.free_turn(&turn.orientation, turn.spin, self.h));
            members[count] = index;
            count += 1;
            if count == LANES {
                self.turn(&mut lanes, &members);
                count = 0;
            }
        }
        self.turn(&mut lanes, &members[..count]);
    }
}

impl FreeTurning<'_> {
    /// Turns the bodies in the lanes.
    #[inline(always)]
    fn turn(&mut self, lanes: &mut FreeTurns, members: &[usize]) {
        lanes.turn();
        for (lane, &member) in members.iter().enumerate() {
            self.turns[member].orientation = self.bodies[member].inertia.orientation_of(lanes.orientation(lane));
        }
    }
}
