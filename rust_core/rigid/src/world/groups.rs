//! Groups of bodies that may touch or are joined.

use glam::DVec3;

use super::members::StepMembers;
use super::near::NearPairs;
use crate::face::FACES;
use crate::island::{BodyPair, HeldJoint, Island};

impl StepMembers<'_> {
    /// Pairs of members that may touch within the step. Bodies that are joined do not touch each other.
    pub fn pairs(&self, near: &mut NearPairs) -> Vec<[u32; 2]> {
        let (mut pairs, may_throw) = near.of_step(self);
        if may_throw {
            self.add_thrown(&mut pairs);
        }
        let whole = self.world.state.joints.iter().filter(|joint| !joint.broken && joint.joint.spring().is_none());
        let ends = whole.filter_map(|joint| {
            let [one, other] = [self.place(joint.ends[0])? as u32, self.place(joint.ends[1])? as u32];
            Some([one.min(other), one.max(other)])
        });
        let mut joined: Vec<[u32; 2]> = ends.collect();
        joined.sort_unstable();
        if !joined.is_empty() {
            let is_joined = |one: u32, other: u32| joined.binary_search(&[one, other]).is_ok();
            pairs.retain(|&[one, other]| match self.face(other as usize) {
                Some(face) => !self.corners(face).iter().any(|&corner| is_joined(one, corner as u32)),
                None => !is_joined(one, other),
            });
        }
        pairs
    }

    /// Groups of members that pairs and joints connect, in the order of their first members.
    pub fn groups(&self, pairs: &[[u32; 2]], spare: &mut Vec<Island>) -> Vec<Island> {
        let joints = self.joints();
        if pairs.is_empty() && joints.is_empty() {
            return Vec::new();
        }
        let count = self.count() + 1;
        let mut roots = self.roots(pairs);
        let free = |index: usize| !self.is_fixed(index);
        let links = pairs.iter().map(|pair| pair.map(|end| end as usize)).chain(joints.iter().map(|joint| joint.1));
        let mut islands: Vec<Island> = Vec::new();
        let mut number = vec![u32::MAX; count];
        for link in links {
            let end = if free(link[0]) { link[0] } else { link[1] };
            let root = roots.find(end);
            if number[root] == u32::MAX {
                number[root] = islands.len() as u32;
                islands.push(spare.pop().unwrap_or_else(|| Island::new(self.world.planar)));
            }
        }
        // The island of each free mover, and the places of movers in the island that is filled.
        let mut places: Vec<(u32, u32)> = vec![(u32::MAX, 0); count];
        let mut order: Vec<(u32, usize, bool)> = Vec::new();
        let of = |link: [usize; 2], roots: &mut Roots| {
            let end = if free(link[0]) { link[0] } else { link[1] };
            number[roots.find(end)]
        };
        for (index, pair) in pairs.iter().enumerate() {
            order.push((of(pair.map(|end| end as usize), &mut roots), index, false));
        }
        for (index, (_, ends)) in joints.iter().enumerate() {
            order.push((of(*ends, &mut roots), index, true));
        }
        order.sort_by_key(|&(island, index, joint)| (island, joint, index));
        for (which, index, joint) in order {
            let island = &mut islands[which as usize];
            let ends = if joint { joints[index].1 } else { pairs[index].map(|end| end as usize) };
            let mut place = |end: usize, island: &mut Island| {
                if places[end].0 != which {
                    places[end] = (which, island.movers.len() as u32);
                    island.movers.push(self.mover(end));
                    island.members.push(end);
                    island.surfaces.push(self.surface(end));
                }
                places[end].1
            };
            let local = ends.map(|end| {
                let Some(face) = self.face(end).filter(|_| !joint) else { return place(end, island) as usize };
                let face = face.face.map(|corner| Some(place(self.bodies.len() + corner, island)));
                island.faces.extend(face);
                FACES + island.faces.len() - 1
            });
            if joint {
                let world = &self.world.state.joints[joints[index].0];
                island.joints.push(HeldJoint {
                    index: joints[index].0,
                    bodies: local,
                    joint: world.joint,
                    loads: world.loads,
                    bounds: world.bounds,
                    held: [true; 2],
                    reaction: [DVec3::ZERO; 2],
                });
            } else {
                let size = self.size(ends[0]).min(self.size(ends[1]));
                let key = (self.name(ends[0]), self.name(ends[1]));
                let [one, other] = ends.map(|end| self.thickness(end));
                island.pairs.push(BodyPair { bodies: local, key, size, thickness: one.min(other), reach: 0.0, found: None });
            }
        }
        for island in &mut islands {
            island.link_faces();
            island.remember(&self.world.state.loads);
        }
        islands
    }

    /// Sets of members that pairs and joints connect.
    pub fn roots(&self, pairs: &[[u32; 2]]) -> Roots {
        let mut roots = Roots::new(self.count() + 1);
        let free = |index: usize| !self.is_fixed(index);
        let links = pairs.iter().map(|pair| pair.map(|end| end as usize)).chain(self.joints().into_iter().map(|joint| joint.1));
        links.filter(|&[one, other]| free(one) && free(other)).for_each(|[one, other]| roots.join(one, other));
        for [one, other] in pairs.iter().map(|pair| pair.map(|end| end as usize)) {
            let Some(face) = self.face(other) else { continue };
            let end = if free(other) { other } else { one };
            let particles = face.face.particles().map(|particle| self.bodies.len() + particle);
            particles.filter(|&particle| free(particle)).for_each(|particle| roots.join(end, particle));
        }
        roots
    }

    /// Joints with the indices of their ends among the members, but for those of bodies that sleep.
    fn joints(&self) -> Vec<(usize, [usize; 2])> {
        let joints = self.world.state.joints.iter().enumerate();
        let whole = joints.filter(|(_, joint)| !joint.broken && joint.joint.spring().is_none());
        let ends = whole.filter_map(|(index, joint)| Some((index, [self.place(joint.ends[0])?, self.place(joint.ends[1])?])));
        ends.filter(|(_, ends)| !ends.iter().any(|&end| self.world.is_asleep(end))).collect()
    }
}

/// Union–find forest.
pub(super) struct Roots {
    above: Vec<u32>,
}

impl Roots {
    /// Sets of one member each.
    pub fn new(count: usize) -> Self {
        Self { above: (0..count as u32).collect() }
    }

    /// Representative of a set, with path halving.
    pub fn find(&mut self, mut index: usize) -> usize {
        while self.above[index] as usize != index {
            self.above[index] = self.above[self.above[index] as usize];
            index = self.above[index] as usize;
        }
        index
    }

    /// Joins two sets.
    pub fn join(&mut self, one: usize, other: usize) {
        let (a, b) = (self.find(one), self.find(other));
        self.above[a.max(b)] = a.min(b) as u32;
    }
}
