//! Pairs that are near each other, kept from step to step.
//!
//! Pairs are those whose boxes overlap, which hold all of a member during a step. They are sought among pairs of fat boxes, found
//! anew as soon as a member leaves its own. The pairs of a step therefore do not depend on the steps before.

use physcore_base::parallel::{BlockedSlice, Executor};

use super::members::{SpeedBound, StepMembers};
use super::{CenterMotion, RigidWorld};
use crate::broad;
use crate::pose::Pose;
use crate::shapes::BoundingBox;

/// Margin of a fat box: part of the size, and number of steps at the present speed.
const PART: f64 = 0.1;
const STEPS: f64 = 4.0;
/// Number of steps in which a body may turn beyond the margin, from which on its box holds it in all orientations.
const TURNING: f64 = 32.0;

/// Bodies that one thread looks at at a time.
const BLOCK: usize = 512;

/// Bodies of a block in a step.
#[derive(Debug, Clone, Copy, Default)]
struct BlockReach {
    /// Largest speed of a surface point [m/s].
    fastest: f64,
    /// Least way that a body may take without leaving its fat box [m].
    least: f64,
    /// Whether no body leaves its fat box at its own speed.
    holds: bool,
}

/// Pairs of fat boxes.
#[derive(Debug, Default)]
pub(super) struct NearPairs {
    /// Particles and faces for which the boxes were made, by their indices.
    points: Vec<usize>,
    faces: Vec<usize>,
    boxes: Vec<BoundingBox>,
    pairs: Vec<[u32; 2]>,
    /// Size of the least body [m].
    least: f64,
    /// Whether each member moved or could disturb others when the boxes were made.
    moves: Vec<bool>,
    /// Whether a member is in a pair.
    is_paired: Vec<bool>,
    /// Bounds of the members in the present step: only of those in a pair.
    bounds: Vec<BoundingBox>,
    /// Upper bounds on the speeds of surface points in the present step [m/s].
    speeds: Vec<f64>,
    /// Largest of them when all were last compared.
    fastest: f64,
    /// Blocks of bodies in the present step.
    blocks: Vec<BlockReach>,
}

impl NearPairs {
    /// Pairs of members that may touch within a step, in ascending order, and whether some body may be thrown farther than its size.
    pub fn of_step(&mut self, members: &StepMembers) -> (Vec<[u32; 2]>, bool) {
        self.speeds.clear();
        self.speeds.extend((0..members.count()).map(|index| members.speed_bound(index)));
        let most = self.speeds.iter().copied().fold(0.0, f64::max);
        if !(self.pairs.is_empty() && self.holds(members, most)) {
            let mut fastest = 0.0_f64;
            for (index, &bound) in self.speeds.iter().enumerate() {
                if bound > fastest {
                    fastest = fastest.max(members.speed(index)[0]);
                }
            }
            if !self.holds(members, fastest) {
                self.renew(members, fastest);
            }
        }
        let overlap = |[one, other]: &&[u32; 2]| self.bounds[*one as usize].overlaps(&self.bounds[*other as usize]);
        (self.pairs.iter().filter(overlap).copied().collect(), members.h * most > self.least)
    }

    /// Whether no two boxes of a step overlap, in a world without particles: no fat boxes overlap, and hold what they held. If not
    /// so, [`NearPairs::of_step`] finds the pairs, if there are any.
    pub fn keep_apart(
        &mut self,
        world: &RigidWorld,
        h: f64,
        motion: &(impl Fn(usize) -> CenterMotion + Sync),
        executor: &Executor,
    ) -> bool {
        let (count, boxes, before) = (world.bodies.len(), &self.boxes, self.fastest);
        let walls_move = world.walls.iter().any(|wall| wall.mover.speed() > 0.0);
        if walls_move || !self.pairs.is_empty() || !self.points.is_empty() || boxes.len() != count + world.walls.len() {
            return false;
        }
        self.blocks.clear();
        self.blocks.resize(count.div_ceil(BLOCK), BlockReach::default());
        executor.for_each_block(BlockedSlice::new(&mut self.blocks, 1), &|blocks: BlockedSlice<'_, BlockReach>| {
            for (place, block) in blocks.items.iter_mut().enumerate() {
                let first = BLOCK * (blocks.start + place);
                *block = BlockReach { fastest: 0.0, least: f64::INFINITY, holds: true };
                let mut bounds = SpeedBound::new(world, first);
                for index in first..count.min(first + BLOCK) {
                    if !world.bodies.are_one(index, bounds.body) {
                        bounds = SpeedBound::new(world, index);
                    }
                    let motion = motion(index);
                    let speed = bounds.speed(&motion, world.state.turns[index].spin, h);
                    let mut margin = boxes[index].margin(&BoundingBox::around(motion.position, bounds.reach));
                    if margin < h * speed.max(before) {
                        let pose = Pose { position: motion.position, rotation: world.rotation(index) };
                        margin = boxes[index].margin(&world.shapes[world.bodies[index].surface.shape].bounds(&pose));
                    }
                    block.fastest = if speed > block.fastest { speed } else { block.fastest };
                    block.holds &= h * speed <= margin;
                    let least = if bounds.is_fixed { f64::INFINITY } else { margin };
                    block.least = if least < block.least { least } else { block.least };
                }
            }
        });
        self.fastest = self.blocks.iter().map(|block| block.fastest).fold(0.0, f64::max);
        let holds = |block: &BlockReach| block.holds && h * self.fastest <= block.least;
        self.blocks.iter().all(holds)
    }

    /// Bounds the members of pairs; returns whether all members are within their fat boxes.
    fn holds(&mut self, members: &StepMembers, fastest: f64) -> bool {
        let same = members.points.iter().map(|point| point.index).eq(self.points.iter().copied());
        let same = same && members.faces.iter().map(|face| face.index).eq(self.faces.iter().copied());
        if !same || self.boxes.len() != members.count() || !self.knows_sleepers(members) {
            return false;
        }
        for index in 0..members.count() {
            let reach = members.reach(index) + members.way(index, self.speeds[index], fastest);
            let is_within = self.boxes[index].contains(&BoundingBox::around(members.position(index), reach));
            if self.is_paired[index] || !is_within {
                self.bounds[index] = members.bounds(index).grown(members.way(index, members.speed(index)[0], fastest));
                if !is_within && !self.boxes[index].contains(&self.bounds[index]) {
                    return false;
                }
            }
        }
        true
    }

    /// Whether the same bodies sleep as when the boxes were made.
    fn knows_sleepers(&self, members: &StepMembers) -> bool {
        !members.world.may_sleep() || (0..members.count()).all(|index| members.moves(index) == self.moves[index])
    }

    /// Makes all boxes anew.
    fn renew(&mut self, members: &StepMembers, fastest: f64) {
        self.points.clear();
        self.points.extend(members.points.iter().map(|point| point.index));
        self.faces.clear();
        self.faces.extend(members.faces.iter().map(|face| face.index));
        let free = (0..members.bodies.len()).filter(|&index| !members.is_fixed(index));
        self.least = free.map(|index| members.reach(index)).fold(f64::INFINITY, f64::min);
        self.bounds.clear();
        self.boxes.clear();
        for index in 0..members.count() {
            let [speed, turning] = members.speed(index);
            let way = members.way(index, speed, fastest);
            let (bounds, reach) = (members.bounds(index), members.reach(index));
            self.bounds.push(bounds.grown(way));
            let slack = if members.is_fixed(index) { 0.0 } else { PART * reach };
            let turns = TURNING * members.h * turning > slack;
            let whole = if turns { BoundingBox::around(members.position(index), reach) } else { bounds };
            self.boxes.push(whole.grown(slack + (1.0 + STEPS) * way));
        }
        self.moves.clear();
        self.moves.extend((0..members.count()).map(|index| members.moves(index)));
        broad::pairs(&self.boxes, &self.moves, &mut self.pairs);
        self.pairs.retain(|[one, other]| members.can_meet(*one as usize, *other as usize));
        self.is_paired.clear();
        self.is_paired.resize(members.count(), false);
        self.pairs.iter().flatten().for_each(|&index| self.is_paired[index as usize] = true);
    }
}

#[cfg(test)]
impl crate::world::RigidWorld {
    /// Forgets the pairs of the last step.
    pub(crate) fn forget_pairs(&mut self) {
        self.near = NearPairs::default();
    }
}
