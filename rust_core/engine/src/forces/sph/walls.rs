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
use crate::forces::vicinity::Vicinity;
use crate::math::{AXES, Vector};
use crate::neighbors::List;
use crate::neighbors::sums::{PairLaw, Records};
use crate::parallel::{Chunks, Crew};
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
    /// The views into walls from each block of places.
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
    place: u32,
    /// These sides, one after the other.
    sides: [Option<u32>; AXES],
    /// Where the list of those seen ends.
    end: usize,
}

impl Walls {
    /// These walls, for the particles of a vicinity.
    pub fn new(sides: Vec<Side>, vicinity: &Vicinity) -> Self {
        let neighbors = vicinity.neighbors();
        let blocks = if sides.is_empty() { 0 } else { neighbors.count().div_ceil(BLOCK) };
        let sight = || Sight { looks: Vec::new(), seen: neighbors.selection(), others: Vec::new() };
        let reach = neighbors.support() - vicinity.skin();
        Self { sides, sights: std::iter::repeat_with(sight).take(blocks).collect(), reach }
    }

    /// The same walls, for the particles of another vicinity with lists.
    pub fn anew(&self, vicinity: &Vicinity, crew: &Crew) -> Self {
        let mut anew = Self::new(self.sides.clone(), vicinity);
        anew.survey(vicinity, crew);
        anew
    }

    /// Lists who is near whose image, or may come to be as long as the lists of neighbors serve.
    pub fn survey(&mut self, vicinity: &Vicinity, crew: &Crew) {
        let Self { sides, sights, .. } = self;
        let count = vicinity.neighbors().count();
        crew.sweep(Chunks::new(sights, 1), &|mine| {
            let block = mine.start * BLOCK..((mine.start + 1) * BLOCK).min(count);
            mine.items.iter_mut().for_each(|sight| sight.survey(block.clone(), sides, vicinity));
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
        (vicinity, records): (&Vicinity, &Records<V>),
        sums: &mut [[V::Scalar; SUMS]],
        crew: &Crew,
    ) {
        if self.is_empty() {
            return;
        }
        crew.sweep(Chunks::new(sums, BLOCK), &|mine| {
            let Sight { looks, seen, .. } = &self.sights[mine.start / BLOCK];
            let mut start = 0;
            let views = looks.iter().filter_map(|&Look { place, sides, end }| {
                let (place, list) = (place as usize, List { segment: seen, range: start..end });
                start = end;
                let x = vicinity.at(place);
                let (mut image, mut farthest) = (Image::ITSELF, 0.0_f64);
                for &side in sides.iter().flatten() {
                    let mirror = self.sides[side as usize].mirror(x, view.sticks);
                    farthest = farthest.max(mirror.distance);
                    image.reflect(&mirror);
                }
                // An image is behind its mirror.
                (farthest < self.reach).then(|| (place, list, Mirrored::new(law, &image, view)))
            });
            records.sum_few(views, |place, more| {
                mine.items[place - mine.start].iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
            });
        });
    }
}

impl Sight {
    /// Looks into the walls from all places of a block.
    fn survey(&mut self, block: std::ops::Range<usize>, sides: &[Side], vicinity: &Vicinity) {
        self.looks.clear();
        self.seen.clear();
        let support = vicinity.neighbors().support();
        for place in block {
            let x = vicinity.anchor(place);
            // The mirrors of a particle near a curved wall turn as it moves.
            let turn = |side: &Side| 2.0 * support * vicinity.skin() * side.wall.curvature(x).abs();
            let near = (0..).zip(sides).map(|(number, side)| (number, side.mirror(x, false), turn(side)));
            let mut near = near.filter(|(_, mirror, _)| mirror.distance < support);
            let mirrors: [_; CORNER] = std::array::from_fn(|_| near.next());
            let mirrors = || mirrors.iter().flatten().enumerate();
            if mirrors().next().is_some() {
                self.others.clear();
                self.others.extend(vicinity.neighbors().apart(place).chain([DVec3::ZERO]));
            }
            for (first, one) in mirrors() {
                self.look(place, &[one], vicinity);
                for (second, other) in mirrors().skip(first + 1).filter(|(_, other)| meet(&one.1, &other.1)) {
                    self.look(place, &[one, other], vicinity);
                    let thirds = mirrors().skip(second + 1).map(|(_, third)| third);
                    for third in thirds.filter(|third| meet(&one.1, &third.1) && meet(&other.1, &third.1)) {
                        self.look(place, &[one, other, third], vicinity);
                    }
                }
            }
        }
        self.seen.spare();
    }

    /// Lists whom the particle at a place sees by way of these mirrors.
    fn look(&mut self, place: usize, mirrors: &[&(u32, Mirror, f64)], vicinity: &Vicinity) {
        let neighbors = vicinity.neighbors();
        let mut image = Image::ITSELF;
        mirrors.iter().for_each(|(_, mirror, _)| image.reflect(mirror));
        let reach = neighbors.support() + mirrors.iter().map(|(.., turn)| turn).sum::<f64>();
        let before = self.seen.len();
        for (&other, &apart) in neighbors.of(place).iter().chain(&[place as u32]).zip(&self.others) {
            self.seen.push(other, image.square(apart) <= reach * reach);
        }
        if self.seen.len() > before {
            let sides = std::array::from_fn(|mirror| mirrors.get(mirror).map(|(side, ..)| *side));
            self.looks.push(Look { place: place as u32, sides, end: self.seen.len() });
        }
    }
}
