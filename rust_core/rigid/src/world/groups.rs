//! Groups of bodies that may touch or are joined.

use glam::DVec3;

use super::{FreePoint, RigidWorld, WORLD};
use crate::broad;
use crate::island::{BodyPair, HeldJoint, Island};
use crate::mover::Mover;
use crate::shapes::BoundingBox;
use crate::surface::Surface;

impl RigidWorld {
    /// Pairs of movers that may touch within a step.
    pub(super) fn pairs(&self, movers: &[Mover], surfaces: &[Surface], free: usize, h: f64) -> Vec<[u32; 2]> {
        let speed = |mover: &Mover| {
            mover.velocity.length() + mover.arm * mover.angular_velocity().length() + h * mover.acceleration.length()
        };
        let fastest = movers.iter().map(speed).fold(0.0, f64::max);
        let of = |(mover, surface): (&Mover, &Surface)| {
            let shape = &self.shapes[surface.shape];
            // An impact may pass the largest speed on to any body.
            let way = if mover.is_fixed() { h * speed(mover) } else { h * speed(mover).max(fastest.min(shape.reach() / h)) };
            shape.bounds(&mover.pose()).grown(way)
        };
        let bounds: Vec<BoundingBox> = movers.iter().zip(surfaces).map(of).collect();
        let moves: Vec<bool> = movers.iter().map(|mover| !mover.is_fixed()).collect();
        let mut pairs = Vec::new();
        broad::pairs(&bounds, &moves, &mut pairs);
        let bodies = self.bodies.len();
        let particle = |index: u32| (bodies..free).contains(&(index as usize));
        let wall = |index: u32| index as usize >= free;
        let mut joined: Vec<[u32; 2]> = self
            .state
            .joints
            .iter()
            .filter(|joint| !joint.broken && joint.joint.spring().is_none())
            .map(|joint| {
                let [one, other] = joint.ends.map(|end| end.min(u32::MAX as usize) as u32);
                [one.min(other), one.max(other)]
            })
            .collect();
        joined.sort_unstable();
        // Contacts resolve particles at walls. Bodies that are joined do not touch each other.
        pairs.retain(|pair| {
            let [one, other] = *pair;
            !(particle(one) && (particle(other) || wall(other))) && joined.binary_search(pair).is_err()
        });
        pairs
    }

    /// Groups of movers that pairs and joints connect, in the order of their first members.
    pub(super) fn groups(
        &mut self,
        movers: &[Mover],
        surfaces: &[Surface],
        pairs: &[[u32; 2]],
        points: &[FreePoint],
    ) -> Vec<Island> {
        let mut roots: Vec<u32> = (0..movers.len() as u32).collect();
        let free = |index: usize| !movers[index].is_fixed();
        let joints: Vec<(usize, [usize; 2])> = self.joints(movers.len(), points);
        let links = pairs.iter().map(|pair| pair.map(|end| end as usize)).chain(joints.iter().map(|joint| joint.1));
        for [one, other] in links.clone().filter(|&[one, other]| free(one) && free(other)) {
            let (a, b) = (root(&mut roots, one as u32), root(&mut roots, other as u32));
            roots[a.max(b) as usize] = a.min(b);
        }
        let mut islands: Vec<Island> = Vec::new();
        let mut spare = std::mem::take(&mut self.spare);
        let mut number = vec![u32::MAX; movers.len()];
        for link in links {
            let end = if free(link[0]) { link[0] } else { link[1] };
            let root = root(&mut roots, end as u32) as usize;
            if number[root] == u32::MAX {
                number[root] = islands.len() as u32;
                islands.push(spare.pop().unwrap_or_else(|| Island::new(self.planar)));
            }
        }
        // The island of each free mover, and the places of movers in the island that is filled.
        let bodies = self.bodies.len();
        let name = |index: usize| {
            if index < bodies {
                index as u32
            } else if index < bodies + points.len() {
                (bodies + points[index - bodies].index) as u32
            } else {
                u32::MAX - (movers.len() - index) as u32
            }
        };
        let mut places: Vec<(u32, u32)> = vec![(u32::MAX, 0); movers.len()];
        let mut order: Vec<(u32, usize, bool)> = Vec::new();
        let of = |link: [usize; 2], roots: &mut Vec<u32>| {
            let end = if free(link[0]) { link[0] } else { link[1] };
            number[root(roots, end as u32) as usize]
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
            let local = ends.map(|end| {
                if places[end].0 != which {
                    places[end] = (which, island.movers.len() as u32);
                    island.movers.push(movers[end]);
                    island.members.push(end);
                    island.surfaces.push(surfaces[end]);
                }
                places[end].1 as usize
            });
            if joint {
                let world = &self.state.joints[joints[index].0];
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
                let size = ends
                    .map(|end| self.shapes[surfaces[end].shape].reach())
                    .map(|reach| if reach > 0.0 { reach } else { f64::INFINITY });
                let size = size[0].min(size[1]);
                island.pairs.push(BodyPair { bodies: local, key: (name(ends[0]), name(ends[1])), size });
            }
        }
        self.spare = spare;
        islands.iter_mut().for_each(|island| island.remember(&self.state.loads));
        islands
    }

    /// Joints with the indices of their ends among the movers.
    fn joints(&self, movers: usize, points: &[FreePoint]) -> Vec<(usize, [usize; 2])> {
        let bodies = self.bodies.len();
        let place = |end: usize| {
            if end < bodies {
                Some(end)
            } else if end == WORLD {
                Some(movers - 1)
            } else {
                points.binary_search_by_key(&(end - bodies), |point| point.index).ok().map(|place| bodies + place)
            }
        };
        let joints = self.state.joints.iter().enumerate();
        let whole = joints.filter(|(_, joint)| !joint.broken && joint.joint.spring().is_none());
        whole.filter_map(|(index, joint)| Some((index, [place(joint.ends[0])?, place(joint.ends[1])?]))).collect()
    }
}

/// Representative of a set of a union–find forest, with path halving.
fn root(roots: &mut [u32], mut index: u32) -> u32 {
    while roots[index as usize] != index {
        let next = roots[roots[index as usize] as usize];
        roots[index as usize] = next;
        index = next;
    }
    index
}
