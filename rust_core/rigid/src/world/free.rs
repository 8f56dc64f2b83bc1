//! Rotation of bodies that meet nothing and have no joint, side by side.

use glam::DVec3;
use physcore_base::parallel::{BlockedSlice, Executor};
use physcore_base::simd::{Isa, Kernel, LANES, dispatch_wide};

use super::{CenterMotion, RigidWorld, SolidBodies, Turn};
use crate::splitting::{Quaternion, TurnQueue};

/// Bodies that one thread turns at a time.
const BLOCK: usize = 64 * LANES;

impl RigidWorld {
    /// Turns all bodies through a step of `h` seconds, if none of them may touch anything, is joined or may sleep. Returns
    /// whether. `motion` gives the motions at the start of the step, which has no torques.
    pub fn turn_apart(&mut self, h: f64, motion: &(impl Fn(usize) -> CenterMotion + Sync), executor: &Executor) -> bool {
        let mut near = std::mem::take(&mut self.near);
        let apart = self.state.joints.is_empty() && !self.may_sleep() && near.keep_apart(self, h, motion, executor);
        self.near = near;
        if apart {
            self.state.loads.clear();
            self.turn_free(h, &[], &[], executor);
        }
        apart
    }

    /// Turns the bodies that have not been moved through a step of `h` seconds. Without `moved` these are all, without motions
    /// there are no torques.
    pub(super) fn turn_free(&mut self, h: f64, motions: &[CenterMotion], moved: &[bool], executor: &Executor) {
        let bodies = &self.bodies;
        executor.for_each_block(BlockedSlice::new(&mut self.state.turns, BLOCK), &|block: BlockedSlice<'_, Turn>| {
            dispatch_wide(FreeTurning { first: block.start, turns: block.items, bodies, motions, moved, h });
        });
    }
}

/// Free rotation of a block of bodies.
struct FreeTurning<'a> {
    first: usize,
    turns: &'a mut [Turn],
    bodies: &'a SolidBodies,
    motions: &'a [CenterMotion],
    moved: &'a [bool],
    h: f64,
}

impl Kernel for FreeTurning<'_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Isa>(mut self, _isa: I) {
        // The bodies in the lanes, and those of which each lane has the moments of inertia.
        let (mut queue, mut alike) = (TurnQueue::new(), [usize::MAX; LANES]);
        for place in 0..self.turns.len() {
            let (index, turn) = (self.first + place, &mut self.turns[place]);
            if self.moved.get(index) == Some(&true) {
                continue;
            }
            let body = &self.bodies[index];
            if body.inverse_mass == 0.0 {
                turn.orientation = turn.orientation.turned(self.h * turn.spin);
                continue;
            }
            if let Some(torque) = self.motions.get(index).map(|motion| motion.torque).filter(|&torque| torque != DVec3::ZERO) {
                turn.spin += 0.5 * self.h * torque;
            }
            if body.inertia.is_planar() {
                turn.orientation = body.inertia.turned(&turn.orientation, turn.spin, self.h);
                continue;
            }
            let lane = queue.count;
            if alike[lane] != usize::MAX && self.bodies.are_one(alike[lane], index) {
                let (orientation, spin) = body.inertia.free_state(&turn.orientation, turn.spin);
                queue.lanes.set_state(lane, orientation, spin);
            } else {
                queue.lanes.set(lane, &body.inertia.free_turn(&turn.orientation, turn.spin, self.h));
                alike[lane] = index;
            }
            queue.push(place, |place, orientation| self.take(place, orientation));
        }
        queue.finish(|place, orientation| self.take(place, orientation));
    }
}

impl FreeTurning<'_> {
    /// Takes the orientation of a body of the block.
    #[inline(always)]
    fn take(&mut self, place: usize, orientation: Quaternion) {
        self.turns[place].orientation = self.bodies[self.first + place].inertia.orientation_of(orientation);
    }
}
