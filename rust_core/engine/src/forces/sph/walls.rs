//! Walls of a fluid, by mirror images.
//!
//! A particle near a wall interacts with the images of its neighbors, and its own, behind that wall: they complete its
//! support, so that density and pressure are as smooth there as inside. An image is never nearer than its original, so the
//! originals are all in the particle's neighbor list; those with near images are listed separately. In a corner there are
//! images of images. A curved wall is replaced by its tangent plane.

use std::cell::Cell;

use glam::DVec3;

use super::BLOCK;
use super::images::{Image, ImagePressure, Mirror, Mirrored, WallCondition};
use crate::boundaries::Wall;
use crate::forces::neighbor_list::NeighborList;
use crate::math::{AXES, Real, Vector};
use crate::neighbors::List;
use crate::neighbors::sums::{PairLaw, Records};
use crate::parallel::{BlockedSlice, Executor};
use crate::simd::Selection;

/// Maximum number of mirrors of a particle.
const CORNER: usize = 4;

/// A wall with its condition, no-slip or free-slip.
#[derive(Debug, Clone)]
pub struct Side {
    pub wall: Wall,
    pub no_slip: bool,
}

impl Side {
    /// The mirror of a particle at `x`: the tangent plane of the wall.
    fn mirror(&self, x: DVec3, no_slip: bool) -> Mirror {
        let (distance, normal) = self.wall.distance(x);
        Mirror { normal, distance, no_slip: self.no_slip && no_slip }
    }
}

/// Whether two walls with these normals form a corner, where images are mirrored again. Facing walls and continued walls do
/// not.
fn meet(one: &Mirror, other: &Mirror) -> bool {
    one.normal.dot(other.normal).abs() < 0.5
}

/// The walls of a fluid, and the lists of images behind them.
#[derive(Debug)]
pub struct Walls {
    sides: Vec<Side>,
    /// The images of each block of slots.
    images: Vec<BlockImages>,
    /// Force density on a particle [N/m^D] from each of its lists of images, in each block of slots.
    pushes: Vec<Vec<[f64; AXES]>>,
    /// Support radius of the kernel [m].
    reach: f64,
}

/// The images of the particles of one block.
#[derive(Debug)]
struct BlockImages {
    lists: Vec<ImageList>,
    /// Slots of the originals, list after list.
    originals: Selection,
    /// Separations from the candidates to the particle [m]: its neighbors, and itself.
    others: Vec<DVec3>,
}

/// The images of one particle by one wall, or by several in a corner.
#[derive(Debug, Clone, Copy)]
struct ImageList {
    slot: u32,
    /// The walls of the successive reflections.
    sides: [Option<u32>; AXES],
    /// End of its list of originals.
    end: usize,
}

impl Walls {
    /// The walls, for the particles of a neighbor list.
    pub fn new(sides: Vec<Side>, neighbor_list: &NeighborList) -> Self {
        let neighbors = neighbor_list.neighbors();
        let blocks = if sides.is_empty() { 0 } else { neighbors.count().div_ceil(BLOCK) };
        let block_images = || BlockImages { lists: Vec::new(), originals: neighbors.selection(), others: Vec::new() };
        let reach = neighbors.support() - neighbor_list.skin();
        let images = std::iter::repeat_with(block_images).take(blocks).collect();
        Self { sides, images, pushes: vec![Vec::new(); blocks], reach }
    }

    /// The walls with updated images, for another neighbor list.
    pub fn anew(&self, neighbor_list: &NeighborList, executor: &Executor) -> Self {
        let mut anew = Self::new(self.sides.clone(), neighbor_list);
        anew.update(neighbor_list, executor);
        anew
    }

    /// Lists the images within reach, or that may come within reach while the neighbor lists serve.
    pub fn update(&mut self, neighbor_list: &NeighborList, executor: &Executor) {
        let Self { sides, images, pushes, .. } = self;
        let count = neighbor_list.neighbors().count();
        executor.for_each_block((BlockedSlice::new(images, 1), BlockedSlice::new(pushes, 1)), &|(images, pushes)| {
            let block = images.start * BLOCK..((images.start + 1) * BLOCK).min(count);
            for (block_images, pushes) in images.items.iter_mut().zip(pushes.items) {
                block_images.update(block.clone(), sides, neighbor_list);
                pushes.resize(block_images.lists.len(), [0.0; AXES]);
            }
        });
    }

    /// Whether a point is farther than this from all walls, on their allowed side [m].
    pub fn admit(&self, x: DVec3, distance: f64) -> bool {
        self.sides.iter().all(|side| side.wall.distance(x).0 > distance)
    }

    /// The number of the nearest wall, its distance [m], and its normal.
    pub fn nearest(&self, x: DVec3) -> Option<(u32, f64, DVec3)> {
        let each = (0..).zip(&self.sides).map(|(number, side)| {
            let (distance, normal) = side.wall.distance(x);
            (number, distance, normal)
        });
        each.min_by(|one, other| one.1.total_cmp(&other.1))
    }

    /// Whether there are no walls.
    pub fn is_empty(&self) -> bool {
        self.sides.is_empty()
    }

    /// Memory [bytes].
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
        self.add_each(law, condition, lists, (sums, &mut nothing), &|(), _, _| (), executor);
    }

    /// The same for forces, and keeps that of each list of images.
    pub fn press<V: Vector, L: PairLaw<V, SUMS> + ImagePressure<V, SUMS>, const SUMS: usize>(
        &mut self,
        law: L,
        condition: &WallCondition,
        lists: (&NeighborList, &Records<V>),
        sums: &mut [[V::Scalar; SUMS]],
        executor: &Executor,
    ) {
        let mut pushes = std::mem::take(&mut self.pushes);
        pushes.iter_mut().for_each(|block| block.fill([0.0; AXES]));
        let keep = |block: &mut Vec<[f64; AXES]>, list: usize, more: &[V::Scalar; SUMS]| {
            for axis in 0..V::DIMENSION {
                block[list][axis] = more[axis].to_f64();
            }
        };
        self.add_each(law, condition, lists, (sums, &mut pushes), &keep, executor);
        self.pushes = pushes;
    }

    /// The forces that [`Walls::press`] kept, list by list: the slot of the particle, its force density [N/m^D], and the mirrors,
    /// each a wall's number with its normal.
    pub fn pushes(
        &self,
        neighbor_list: &NeighborList,
    ) -> impl Iterator<Item = (usize, DVec3, impl Iterator<Item = (u32, DVec3)>)> {
        let lists = self.images.iter().flat_map(|block| &block.lists);
        lists.zip(self.pushes.iter().flatten()).map(move |(list, &force)| {
            let x = neighbor_list.at(list.slot as usize);
            let mirrors = list.sides.into_iter().flatten();
            let normals = mirrors.map(move |side| (side, self.sides[side as usize].mirror(x, false).normal));
            (list.slot as usize, DVec3::from_array(force), normals)
        })
    }

    /// Adds the sums over the images, and shows each list's to `note`, with its number in the block.
    fn add_each<V: Vector, L: PairLaw<V, SUMS> + ImagePressure<V, SUMS>, N: Send, const SUMS: usize>(
        &self,
        law: L,
        condition: &WallCondition,
        (neighbor_list, records): (&NeighborList, &Records<V>),
        (sums, notes): (&mut [[V::Scalar; SUMS]], &mut [N]),
        note: &(impl Fn(&mut N, usize, &[V::Scalar; SUMS]) + Sync),
        executor: &Executor,
    ) {
        if self.is_empty() {
            return;
        }
        executor.for_each_block((BlockedSlice::new(sums, BLOCK), BlockedSlice::new(notes, 1)), &|(mine, notes)| {
            let BlockImages { lists, originals, .. } = &self.images[mine.start / BLOCK];
            let (mut start, current) = (0, Cell::new(0));
            let terms = lists.iter().enumerate().filter_map(|(number, &ImageList { slot, sides, end })| {
                let (slot, list) = (slot as usize, List { segment: originals, range: start..end });
                start = end;
                current.set(number);
                let x = neighbor_list.at(slot);
                let (mut image, mut farthest) = (Image::ITSELF, 0.0_f64);
                for &side in sides.iter().flatten() {
                    let mirror = self.sides[side as usize].mirror(x, condition.no_slip);
                    farthest = farthest.max(mirror.distance);
                    image.reflect(&mirror);
                }
                // An image is no nearer than its mirror.
                (farthest < self.reach).then(|| (slot, list, Mirrored::new(law, &image, condition)))
            });
            // Each list is summed before the next one is looked at.
            records.sum_few(terms, |slot, more| {
                note(&mut notes.items[0], current.get(), &more);
                mine.items[slot - mine.start].iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
            });
        });
    }
}

impl BlockImages {
    /// Lists the images of all slots of a block.
    fn update(&mut self, block: std::ops::Range<usize>, sides: &[Side], neighbor_list: &NeighborList) {
        self.lists.clear();
        self.originals.clear();
        let support = neighbor_list.neighbors().support();
        for slot in block {
            let x = neighbor_list.anchor(slot);
            // The mirrors of a particle near a curved wall rotate as it moves.
            let turn = |side: &Side| 2.0 * support * neighbor_list.skin() * side.wall.curvature(x, DVec3::ZERO).abs();
            let near = (0..).zip(sides).map(|(number, side)| (number, side.mirror(x, false), turn(side)));
            let mut near = near.filter(|(_, mirror, _)| mirror.distance < support);
            let mirrors: [_; CORNER] = std::array::from_fn(|_| near.next());
            let mirrors = || mirrors.iter().flatten().enumerate();
            if mirrors().next().is_some() {
                self.others.clear();
                self.others.extend(neighbor_list.neighbors().separation(slot).chain([DVec3::ZERO]));
            }
            for (first, one) in mirrors() {
                self.list_images(slot, &[one], neighbor_list);
                for (second, other) in mirrors().skip(first + 1).filter(|(_, other)| meet(&one.1, &other.1)) {
                    self.list_images(slot, &[one, other], neighbor_list);
                    let thirds = mirrors().skip(second + 1).map(|(_, third)| third);
                    for third in thirds.filter(|third| meet(&one.1, &third.1) && meet(&other.1, &third.1)) {
                        self.list_images(slot, &[one, other, third], neighbor_list);
                    }
                }
            }
        }
        self.originals.spare();
    }

    /// Lists the images of the particle at a slot by successive reflections in these mirrors.
    fn list_images(&mut self, slot: usize, mirrors: &[&(u32, Mirror, f64)], neighbor_list: &NeighborList) {
        let neighbors = neighbor_list.neighbors();
        let mut image = Image::ITSELF;
        mirrors.iter().for_each(|(_, mirror, _)| image.reflect(mirror));
        let reach = neighbors.support() + mirrors.iter().map(|(.., turn)| turn).sum::<f64>();
        let before = self.originals.len();
        for (&other, &separation) in neighbors.of(slot).iter().chain(&[slot as u32]).zip(&self.others) {
            self.originals.push(other, image.square(separation) <= reach * reach);
        }
        if self.originals.len() > before {
            let sides = std::array::from_fn(|mirror| mirrors.get(mirror).map(|(side, ..)| *side));
            self.lists.push(ImageList { slot: slot as u32, sides, end: self.originals.len() });
        }
    }
}
