//! Walls of a fluid, as mirrors.
//!
//! A particle near a wall meets the images of its neighbors, and its own, behind that wall: as many as the wall cuts off from
//! its support, so that density and pressure are as smooth there as inside. An image is never nearer than its original, so
//! the originals are all in the particle's list already; those whose images are near enough are listed once more. In a corner
//! there are images of images. A curved wall is met as its tangent plane.

use glam::DVec3;

use super::BLOCK;
use super::images::{Image, Mirror, Mirrored, Pressed, View};
use crate::boundaries::Wall;
use crate::forces::neighbor_list::NeighborList;
use crate::math::{AXES, Vector};
use crate::neighbors::List;
use crate::neighbors::sums::{PairLaw, Records};
use crate::parallel::{BlockedSlice, Executor};
use crate::simd::Selection;

/// The most walls that a particle looks into.
const CORNER: usize = 4;

/// A wall, and whether the fluid sticks to it.
#[derive(Debug, Clone)]
pub struct Side {
    pub wall: Wall,
    pub sticks: bool,
}

impl Side {
    /// The mirror that a particle at `x` looks into.
    fn mirror(&self, x: DVec3, sticks: bool) -> Mirror {
        let (distance, normal) = self.wall.distance(x);
        Mirror { normal, distance, sticks: self.sticks && sticks }
    }
}

/// Whether two walls with these normals meet in a corner, where images are mirrored again. Walls that face each other, or go
/// on as one, do not.
fn meet(one: &Mirror, other: &Mirror) -> bool {
    one.normal.dot(other.normal).abs() < 0.5
}

/// The walls of a fluid, and what is seen in them.
#[derive(Debug)]
pub struct Walls {
    sides: Vec<Side>,
    /// The views into walls from each block of slots.
    sights: Vec<Sight>,
    /// How far the kernel reaches [m].
    reach: f64,
}

/// The views of the particles of one block.
#[derive(Debug)]
struct Sight {
    looks: Vec<Look>,
    /// Whom they see, one after the other.
    seen: Selection,
    /// Where all whom the particle that looks could see are, from it: its neighbors, and itself.
    others: Vec<DVec3>,
}

/// The view of one particle into one wall, or into a corner by way of several.
#[derive(Debug, Clone, Copy)]
struct Look {
    slot: u32,
    /// These sides, one after the other.
    sides: [Option<u32>; AXES],
    /// Where the list of those seen ends.
    end: usize,
}

impl Walls {
    /// These walls, for the particles of a vicinity.
    pub fn new(sides: Vec<Side>, neighbor_list: &NeighborList) -> Self {
        let neighbors = neighbor_list.neighbors();
        let blocks = if sides.is_empty() { 0 } else { neighbors.count().div_ceil(BLOCK) };
        let sight = || Sight { looks: Vec::new(), seen: neighbors.selection(), others: Vec::new() };
        let reach = neighbors.support() - neighbor_list.skin();
        Self { sides, sights: std::iter::repeat_with(sight).take(blocks).collect(), reach }
    }

    /// The same walls, for the particles of another vicinity with lists.
    pub fn anew(&self, neighbor_list: &NeighborList, executor: &Executor) -> Self {
        let mut anew = Self::new(self.sides.clone(), neighbor_list);
        anew.survey(neighbor_list, executor);
        anew
    }

    /// Lists who is near whose image, or may come to be as long as the lists of neighbors serve.
    pub fn survey(&mut self, neighbor_list: &NeighborList, executor: &Executor) {
        let Self { sides, sights, .. } = self;
        let count = neighbor_list.neighbors().count();
        executor.for_each_block(BlockedSlice::new(sights, 1), &|mine| {
            let block = mine.start * BLOCK..((mine.start + 1) * BLOCK).min(count);
            mine.items.iter_mut().for_each(|sight| sight.survey(block.clone(), sides, neighbor_list));
        });
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.sides.is_empty()
    }

    /// The memory that they take [bytes].
    pub fn bytes(&self) -> usize {
        let views = |sight: &Sight| sight.looks.capacity() * size_of::<Look>() + sight.seen.bytes();
        std::mem::size_of_val(self.sides.as_slice()) + self.sights.iter().map(views).sum::<usize>()
    }

    /// Adds to a law's sums what it meets in the walls.
    pub fn add<V: Vector, L: PairLaw<V, SUMS> + Pressed<V, SUMS>, const SUMS: usize>(
        &self,
        law: L,
        view: &View,
        (neighbor_list, records): (&NeighborList, &Records<V>),
        sums: &mut [[V::Scalar; SUMS]],
        executor: &Executor,
    ) {
        if self.is_empty() {
            return;
        }
        executor.for_each_block(BlockedSlice::new(sums, BLOCK), &|mine| {
            let Sight { looks, seen, .. } = &self.sights[mine.start / BLOCK];
            let mut start = 0;
            let views = looks.iter().filter_map(|&Look { slot, sides, end }| {
                let (slot, list) = (slot as usize, List { segment: seen, range: start..end });
                start = end;
                let x = neighbor_list.at(slot);
                let (mut image, mut farthest) = (Image::ITSELF, 0.0_f64);
                for &side in sides.iter().flatten() {
                    let mirror = self.sides[side as usize].mirror(x, view.sticks);
                    farthest = farthest.max(mirror.distance);
                    image.reflect(&mirror);
                }
                // An image is behind its mirror.
                (farthest < self.reach).then(|| (slot, list, Mirrored::new(law, &image, view)))
            });
            records.sum_few(views, |slot, more| {
                mine.items[slot - mine.start].iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
            });
        });
    }
}

impl Sight {
    /// Looks into the walls from all slots of a block.
    fn survey(&mut self, block: std::ops::Range<usize>, sides: &[Side], neighbor_list: &NeighborList) {
        self.looks.clear();
        self.seen.clear();
        let support = neighbor_list.neighbors().support();
        for slot in block {
            let x = neighbor_list.anchor(slot);
            // The mirrors of a particle near a curved wall turn as it moves.
            let turn = |side: &Side| 2.0 * support * neighbor_list.skin() * side.wall.curvature(x).abs();
            let near = (0..).zip(sides).map(|(number, side)| (number, side.mirror(x, false), turn(side)));
            let mut near = near.filter(|(_, mirror, _)| mirror.distance < support);
            let mirrors: [_; CORNER] = std::array::from_fn(|_| near.next());
            let mirrors = || mirrors.iter().flatten().enumerate();
            if mirrors().next().is_some() {
                self.others.clear();
                self.others.extend(neighbor_list.neighbors().separation(slot).chain([DVec3::ZERO]));
            }
            for (first, one) in mirrors() {
                self.look(slot, &[one], neighbor_list);
                for (second, other) in mirrors().skip(first + 1).filter(|(_, other)| meet(&one.1, &other.1)) {
                    self.look(slot, &[one, other], neighbor_list);
                    let thirds = mirrors().skip(second + 1).map(|(_, third)| third);
                    for third in thirds.filter(|third| meet(&one.1, &third.1) && meet(&other.1, &third.1)) {
                        self.look(slot, &[one, other, third], neighbor_list);
                    }
                }
            }
        }
        self.seen.spare();
    }

    /// Lists whom the particle at a slot sees by way of these mirrors.
    fn look(&mut self, slot: usize, mirrors: &[&(u32, Mirror, f64)], neighbor_list: &NeighborList) {
        let neighbors = neighbor_list.neighbors();
        let mut image = Image::ITSELF;
        mirrors.iter().for_each(|(_, mirror, _)| image.reflect(mirror));
        let reach = neighbors.support() + mirrors.iter().map(|(.., turn)| turn).sum::<f64>();
        let before = self.seen.len();
        for (&other, &separation) in neighbors.of(slot).iter().chain(&[slot as u32]).zip(&self.others) {
            self.seen.push(other, image.square(separation) <= reach * reach);
        }
        if self.seen.len() > before {
            let sides = std::array::from_fn(|mirror| mirrors.get(mirror).map(|(side, ..)| *side));
            self.looks.push(Look { slot: slot as u32, sides, end: self.seen.len() });
        }
    }
}
