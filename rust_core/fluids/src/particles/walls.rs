//! Walls of a fluid, by mirror images.
//!
//! A particle near a wall interacts with the images of its neighbors and of itself behind that wall. The images complete its
//! support, so that density and pressure are as smooth there as inside. An image is never nearer than its original, so that the
//! originals are all in the particle's neighbor list. Originals with near images are listed separately. In a corner there are
//! images of images. A curved wall is replaced by its tangent plane.

use std::cell::Cell;

use glam::DVec3;

use super::BLOCK;
use super::image_lists::{BlockImages, ImageList};
use super::images::{Image, ImagePressure, Mirror, Mirrored, Reflection, WallCondition};
use crate::boundaries::Wall;
use crate::error::Result;
use crate::math::{AXES, Vector};
use crate::neighbors::NeighborList;
use crate::neighbors::sums::{PairLaw, Records};
use crate::neighbors::{List, Reflections};
use crate::parallel::{BlockedSlice, Executor};

/// A wall with its condition, no-slip or free-slip.
#[derive(Debug, Clone)]
pub struct FluidWall {
    pub wall: Wall,
    pub no_slip: bool,
}

impl FluidWall {
    /// Reflections in the wall. A plane along the axes has its own reflections, because its normal is the same everywhere.
    fn reflections(&self) -> Reflections {
        match self.wall {
            Wall::Plane { normal, .. } if normal.abs().max_element() == 1.0 => {
                Reflections { axes: normal.to_array().map(|along| along != 0.0), any: false }
            }
            _ => Reflections { axes: [false; AXES], any: true },
        }
    }

    /// Mirror of a particle at `x`: the tangent plane of the wall.
    pub fn mirror(&self, x: DVec3, no_slip: bool) -> Mirror {
        let (distance, normal) = self.wall.distance(x);
        Mirror { normal, distance, no_slip: self.no_slip && no_slip }
    }
}

/// The walls of a fluid, and the lists of images behind them.
#[derive(Debug)]
pub struct FluidWalls {
    sides: Vec<FluidWall>,
    /// Images of each block of slots.
    images: Vec<BlockImages>,
    /// Support radius of the kernel [m].
    reach: f64,
}

impl FluidWalls {
    /// Walls for the particles of a neighbor list.
    #[inline]
    pub fn new(sides: Vec<FluidWall>, neighbor_list: &NeighborList) -> Self {
        let neighbors = neighbor_list.neighbors();
        let blocks = if sides.is_empty() { 0 } else { neighbors.count().div_ceil(BLOCK) };
        let block_images = || BlockImages { lists: Vec::new(), originals: neighbors.selection(), others: Vec::new() };
        let reach = neighbors.support() - neighbor_list.skin();
        let images = std::iter::repeat_with(block_images).take(blocks).collect();
        Self { sides, images, reach }
    }

    /// Copy of the walls with updated images, for another neighbor list.
    #[inline]
    pub fn anew(&self, neighbor_list: &NeighborList, executor: &Executor) -> Self {
        let mut anew = Self::new(self.sides.clone(), neighbor_list);
        anew.update(neighbor_list, executor);
        anew
    }

    /// Updates neighbor lists and lists of images; returns whether the former were rebuilt.
    /// Function `position` returns the position of a particle along an axis, relative to the origin [m].
    ///
    /// # Errors
    /// As [`NeighborList::update`].
    pub fn search(
        &mut self,
        neighbor_list: &mut NeighborList,
        position: &(impl Fn(usize, usize) -> f64 + Sync),
        executor: &Executor,
    ) -> Result<bool> {
        let resumed = neighbor_list.resume(executor)?;
        if resumed {
            self.declare(neighbor_list, executor);
        }
        let renewed = neighbor_list.update(position, executor)?;
        if renewed {
            self.declare(neighbor_list, executor);
        }
        if resumed || renewed {
            self.update(neighbor_list, executor);
        }
        Ok(renewed)
    }

    /// Lists the images within reach, and those that may come within reach before the next build of the neighbor lists.
    fn update(&mut self, neighbor_list: &NeighborList, executor: &Executor) {
        let Self { sides, images, .. } = self;
        let count = neighbor_list.neighbors().count();
        executor.for_each_block(BlockedSlice::new(images, 1), &|images| {
            let block = images.start * BLOCK..((images.start + 1) * BLOCK).min(count);
            for block_images in images.items {
                block_images.update(block.clone(), sides, neighbor_list);
            }
        });
    }

    /// Declares the reflections in walls to a rebuilt neighbor list.
    fn declare(&self, neighbor_list: &mut NeighborList, executor: &Executor) {
        if self.is_empty() {
            return;
        }
        let near = neighbor_list.neighbors().support() + neighbor_list.neighbors().largest_displacement();
        let reflections = |x: DVec3| {
            let sides = self.sides.iter().filter(|side| side.wall.distance(x).0 < near);
            sides.map(FluidWall::reflections).fold(Reflections::default(), Reflections::with)
        };
        neighbor_list.reflect(&reflections, executor);
    }

    /// Whether a point is farther than `distance` [m] from all walls, on their allowed side.
    #[inline]
    pub fn admit(&self, x: DVec3, distance: f64) -> bool {
        self.sides.iter().all(|side| side.wall.distance(x).0 > distance)
    }

    /// Number of the nearest wall, its distance [m], and its normal.
    #[inline]
    pub fn nearest(&self, x: DVec3) -> Option<(u32, f64, DVec3)> {
        let each = (0..).zip(&self.sides).map(|(number, side)| {
            let (distance, normal) = side.wall.distance(x);
            (number, distance, normal)
        });
        each.min_by(|one, other| one.1.total_cmp(&other.1))
    }

    /// Whether there are no walls.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.sides.is_empty()
    }

    /// Memory [bytes].
    #[inline]
    pub fn bytes(&self) -> usize {
        let bytes =
            |block_images: &BlockImages| block_images.lists.capacity() * size_of::<ImageList>() + block_images.originals.bytes();
        std::mem::size_of_val(self.sides.as_slice()) + self.images.iter().map(bytes).sum::<usize>()
    }

    /// Adds the sums of a pair law over the images.
    pub fn add<V: Vector, L: PairLaw<V, SUMS> + ImagePressure<V, SUMS>, const SUMS: usize>(
        &self,
        law: L,
        condition: &WallCondition,
        lists: (&NeighborList, &Records<V>),
        sums: &mut [[V::Scalar; SUMS]],
        executor: &Executor,
    ) {
        let mut nothing = vec![(); self.images.len()];
        self.add_noting(law, condition, lists, sums, (BlockedSlice::new(&mut nothing, 1), &|_, _, _| ()), executor);
    }

    /// Adds the sums of a pair law over the images. The sums of each list of images are also passed to `note`, with the items of
    /// `notes` for its block of slots.
    pub fn add_noting<V: Vector, L: PairLaw<V, SUMS> + ImagePressure<V, SUMS>, N: Send, const SUMS: usize>(
        &self,
        law: L,
        condition: &WallCondition,
        (neighbor_list, records): (&NeighborList, &Records<V>),
        sums: &mut [[V::Scalar; SUMS]],
        (notes, note): (BlockedSlice<'_, N>, &(impl Fn(&mut [N], &Mirrors, &[V::Scalar; SUMS]) + Sync)),
        executor: &Executor,
    ) {
        if self.is_empty() {
            return;
        }
        executor.for_each_block((BlockedSlice::new(sums, BLOCK), notes), &|(mine, notes)| {
            let BlockImages { lists, originals, .. } = &self.images[mine.start / BLOCK];
            let (mut start, current) = (0, Cell::new(Mirrors::NONE));
            let terms = lists.iter().filter_map(|&ImageList { slot, sides, near, end }| {
                let slot = slot as usize;
                let nearest = if neighbor_list.neighbors().needs_far(slot) { end } else { near };
                let list = List { segment: originals, range: start..nearest };
                start = end;
                let x = neighbor_list.at(slot);
                let (mut image, mut farthest) = (Image::ITSELF, 0.0_f64);
                let mut mirrors = Mirrors { slot, x, ..Mirrors::NONE };
                for &side in sides.iter().flatten() {
                    let mirror = self.sides[side as usize].mirror(x, condition.no_slip);
                    farthest = farthest.max(mirror.distance);
                    mirrors.walls[mirrors.count] = (side, mirror.normal);
                    mirrors.count += 1;
                    image.reflect(&mirror);
                }
                current.set(mirrors);
                // An image is no nearer than its mirror.
                (farthest < self.reach).then(|| (slot, list, Reflection::new(&image, condition)))
            });
            // Each list is summed before the iterator advances to the next one.
            let mirrored = |reflection: &Reflection<V::Scalar>| Mirrored::new(law, reflection);
            records.sum_few(terms, mirrored, |slot, more| {
                note(notes.items, &current.get(), &more);
                mine.items[slot - mine.start].iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
            });
        });
    }
}

/// Mirrors of a list of images.
#[derive(Debug, Clone, Copy)]
pub struct Mirrors {
    /// Slot of the particle, and its position [m].
    pub slot: usize,
    pub x: DVec3,
    /// Number and normal of the wall of each reflection.
    walls: [(u32, DVec3); AXES],
    count: usize,
}

impl Mirrors {
    const NONE: Self = Self { slot: 0, x: DVec3::ZERO, walls: [(0, DVec3::ZERO); AXES], count: 0 };

    /// Number and normal of the wall of each reflection.
    #[inline]
    pub fn walls(&self) -> &[(u32, DVec3)] {
        &self.walls[..self.count]
    }
}
