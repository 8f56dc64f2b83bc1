//! Lists of the particles whose images behind walls are near a particle.

use std::ops::Range;

use glam::DVec3;

use super::images::{Image, Mirror};
use super::walls::FluidWall;
use crate::boundaries::Wall;
use crate::math::AXES;
use crate::neighbors::NeighborList;
use crate::simd::Selection;

/// Maximum number of mirrors of a particle.
const CORNER: usize = 4;

/// Images of the particles of one block.
#[derive(Debug)]
pub struct BlockImages {
    pub lists: Vec<ImageList>,
    /// Slots of the originals, list after list.
    pub originals: Selection,
    /// Separations [m] from the candidates, which are the neighbors and the particle itself, to the particle.
    pub others: Vec<DVec3>,
}

/// Images of one particle by one wall, or by several walls in a corner.
#[derive(Debug, Clone, Copy)]
pub struct ImageList {
    pub slot: u32,
    /// The walls of the successive reflections.
    pub sides: [Option<u32>; AXES],
    /// Ends of the ranges of originals: those with near images, and all.
    pub near: usize,
    pub end: usize,
}

/// Whether two walls with these normals form a corner, where images are mirrored again. Facing walls and continued walls do not.
fn meet(one: &Mirror, other: &Mirror) -> bool {
    one.normal.dot(other.normal).abs() < 0.5
}

impl BlockImages {
    /// Lists the images of all slots of a block.
    pub fn update(&mut self, block: Range<usize>, sides: &[FluidWall], neighbor_list: &NeighborList) {
        self.lists.clear();
        self.originals.clear();
        let (support, nearby) = (neighbor_list.neighbors().support(), neighbor_list.neighbors().near());
        for slot in block {
            let x = neighbor_list.anchor(slot);
            // Near a curved wall, the mirrors of a moving particle rotate; at an edge they rotate strongly. All of their images
            // count as near.
            let margins = |side: &FluidWall| {
                if let Wall::Plane { .. } = side.wall {
                    return [0.0; 2];
                }
                let turn = 2.0 * support * neighbor_list.skin() * side.wall.curvature(x, DVec3::ZERO).abs();
                [turn + support - nearby, turn]
            };
            let near = (0..).zip(sides).map(|(number, side)| (number, side.mirror(x, false), margins(side)));
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
    fn list_images(&mut self, slot: usize, mirrors: &[&(u32, Mirror, [f64; 2])], neighbor_list: &NeighborList) {
        let neighbors = neighbor_list.neighbors();
        let mut image = Image::ITSELF;
        mirrors.iter().for_each(|(_, mirror, _)| image.reflect(mirror));
        let margin = |of: usize| mirrors.iter().map(|(.., margins)| margins[of]).sum::<f64>();
        let reach = (neighbors.support() + margin(1)).powi(2);
        let near = (neighbors.near() + margin(0)).powi(2).min(reach);
        let itself = [slot as u32];
        let others = || neighbors.of(slot).iter().chain(&itself).zip(&self.others);
        let before = self.originals.len();
        others().for_each(|(&other, &separation)| self.originals.push(other, image.square(separation) <= near));
        let end = self.originals.len();
        for (&other, &separation) in others() {
            let square = image.square(separation);
            self.originals.push(other, near < square && square <= reach);
        }
        if self.originals.len() > before {
            let sides = std::array::from_fn(|mirror| mirrors.get(mirror).map(|(side, ..)| *side));
            self.lists.push(ImageList { slot: slot as u32, sides, near: end, end: self.originals.len() });
        }
    }
}
