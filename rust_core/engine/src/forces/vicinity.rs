//! Who is near whom among the members of a pair force, from step to step.
//!
//! The sums over lists depend on when the lists were made, by rounding. So the positions that they were made from are part of
//! what a checkpoint holds, and of what is undone.

use std::ops::Range;

use glam::DVec3;

use crate::error::{Error, Result};
use crate::math::{AXES, Real, Vector};
use crate::matter::Properties;
use crate::neighbors::{Domain, Neighbors};
use crate::parallel::{Chunks, Crew};
use crate::scene::Scene;

/// The skin in units of the distance between particles. A list then lives some steps, and is not much longer than need be.
const SKIN: f64 = 0.3;

/// The cells in which particles are counted to find that distance, in units of the cutoff.
const SAMPLE: f64 = 4.0;

/// Particles whose positions are copied at a time.
const BLOCK: usize = 1024;

/// Stands for the slot of a particle that is no member.
const NOBODY: u32 = u32::MAX;

/// The positions of some particles, and lists of their neighbors.
#[derive(Debug)]
pub struct Vicinity {
    /// These particles, by their index.
    members: Vec<u32>,
    /// The member that each particle is.
    slots: Vec<u32>,
    neighbors: Neighbors,
    /// Exact positions relative to the origin, one array per axis [m].
    positions: [Vec<f64>; AXES],
    /// What the lists were made from when the chunk began.
    kept: [Vec<f64>; AXES],
    /// Whether they have been made anew since.
    renewed: bool,
    /// Whether those of then are to be made again before anything else.
    undone: bool,
    skin: f64,
}

impl Vicinity {
    /// The vicinity up to a cutoff [m] of the `members` of a scene, which are given by their index.
    ///
    /// # Errors
    /// If the cutoff makes no sense, the periodic domain is too small for it, or the precision of the run too coarse.
    pub fn new<V: Vector>(scene: &Scene, properties: &Properties<V>, members: Vec<u32>, cutoff: f64) -> Result<Self> {
        refuse_tiny::<V::Scalar>(cutoff)?;
        let domain = domain(scene, properties.origin);
        let skin = skin::<V>(&places(scene, properties, &members), &domain, cutoff);
        let columns = || std::array::from_fn(|axis| vec![0.0; if axis < V::DIMENSION { members.len() } else { 0 }]);
        let neighbors = Neighbors::new(members.len(), V::DIMENSION, &domain, cutoff, skin)?;
        let mut slots = vec![NOBODY; properties.count()];
        members.iter().zip(0..).for_each(|(&index, slot)| slots[index as usize] = slot);
        let (positions, kept) = (columns(), columns());
        Ok(Self { members, slots, neighbors, positions, kept, renewed: false, undone: false, skin })
    }

    /// Brings positions and lists up to date, and says whether the lists are new. `place` gives the position of a particle along
    /// an axis, relative to the origin [m].
    ///
    /// # Errors
    /// If positions are too far away to tell distances, or the lists do not fit into memory.
    pub fn update(&mut self, place: &(impl Fn(usize, usize) -> f64 + Sync), crew: &Crew) -> Result<bool> {
        self.resume(crew)?;
        let (dimension, members) = (self.neighbors.dimension(), &self.members);
        for (axis, column) in self.positions.iter_mut().enumerate().take(dimension) {
            crew.sweep(Chunks::new(column, BLOCK), &|mine| {
                let members = &members[mine.start..];
                mine.items.iter_mut().zip(members).for_each(|(to, &member)| *to = place(axis, member as usize));
            });
        }
        // Said beforehand, because a failure leaves no lists behind.
        let renewed = self.neighbors.update(self.positions.each_ref().map(Vec::as_slice), crew);
        self.renewed |= *renewed.as_ref().unwrap_or(&true);
        renewed
    }

    /// The same members at another moment, with lists of their own.
    ///
    /// # Errors
    /// As [`Vicinity::update`].
    pub fn anew(&self, place: &(impl Fn(usize, usize) -> f64 + Sync), crew: &Crew) -> Result<Self> {
        let Self { members, slots, neighbors, positions, kept, skin, .. } = self;
        let (count, dimension, cutoff) = (neighbors.count(), neighbors.dimension(), neighbors.support() - skin);
        let mut anew = Self {
            members: members.clone(),
            slots: slots.clone(),
            neighbors: Neighbors::new(count, dimension, neighbors.domain(), cutoff, *skin)?,
            positions: positions.clone(),
            kept: kept.clone(),
            renewed: false,
            undone: false,
            skin: *skin,
        };
        anew.update(place, crew)?;
        Ok(anew)
    }

    /// The members, by their index.
    pub fn members(&self) -> &[u32] {
        &self.members
    }

    /// The members in a block: their number in it, which member each is, and its place.
    pub fn in_block(&self, block: Range<usize>) -> impl Iterator<Item = (usize, usize, usize)> {
        let slots = self.slots[block.start..block.end.min(self.slots.len())].iter().enumerate();
        let places = self.neighbors.places();
        let members = slots.filter(|(_, slot)| **slot != NOBODY);
        members.map(|(index, &slot)| (index, slot as usize, places[slot as usize] as usize))
    }

    /// The lists.
    pub fn neighbors(&self) -> &Neighbors {
        &self.neighbors
    }

    /// How much further than the cutoff the lists reach [m].
    pub fn skin(&self) -> f64 {
        self.skin
    }

    /// The positions of all members relative to the origin [m].
    pub fn positions(&self) -> [&[f64]; AXES] {
        self.positions.each_ref().map(Vec::as_slice)
    }

    /// The position of the member at a place relative to the origin [m].
    pub fn at(&self, place: usize) -> DVec3 {
        self.vector(self.positions(), place)
    }

    /// Where that member was when the lists were made [m].
    pub fn anchor(&self, place: usize) -> DVec3 {
        self.vector(self.neighbors.anchors(), place)
    }

    fn vector(&self, columns: [&[f64]; AXES], place: usize) -> DVec3 {
        let member = self.neighbors.order()[place] as usize;
        DVec3::from_array(columns.map(|axis| axis.get(member).copied().unwrap_or(0.0)))
    }

    /// Remembers what the lists were made from.
    pub fn keep(&mut self) {
        if self.renewed {
            self.kept.iter_mut().zip(self.neighbors.anchors()).for_each(|(kept, anchors)| kept.copy_from_slice(anchors));
            self.renewed = false;
        }
    }

    /// Goes back to the lists that were last kept. They are made when they are needed: whoever interrupts a step has not the
    /// time.
    pub fn undo(&mut self) {
        self.undone |= std::mem::take(&mut self.renewed);
    }

    /// Makes the lists that were gone back to, and says whether there were others.
    ///
    /// # Errors
    /// As [`Vicinity::update`].
    pub fn resume(&mut self, crew: &Crew) -> Result<bool> {
        let undone = self.undone;
        if undone {
            self.neighbors.restore(self.kept.each_ref().map(Vec::as_slice), crew)?;
            // Whoever is stopped before the end of this chunk makes them once more, and what hangs on them.
            (self.renewed, self.undone) = (true, crew.stopped());
        }
        Ok(undone)
    }

    /// What the lists were made from [m].
    pub fn capture(&self) -> Vec<f64> {
        if self.undone { self.kept.concat() } else { self.neighbors.anchors().concat() }
    }

    /// Goes back to the lists that were captured; takes its part from the front of `numbers`.
    pub fn restore(&mut self, numbers: &mut &[f64]) -> Result<()> {
        self.kept.iter_mut().try_for_each(|column| take(numbers, column))?;
        (self.renewed, self.undone) = (false, true);
        Ok(())
    }

    /// How many neighbors are listed, of all particles together; a guess while there are no lists.
    pub fn pairs(&self) -> usize {
        let count = self.neighbors.count();
        let listed = (0..count).map(|place| self.neighbors.of(place).len()).sum();
        if listed == 0 { TYPICAL * count } else { listed }
    }

    /// How the plan describes it.
    pub fn layout(&self) -> String {
        let reach = self.neighbors.support() - self.skin;
        format!(
            "neighbors within {reach:.3e} m, from lists that reach {:.3e} m further and serve until somebody has moved by half of that",
            self.skin
        )
    }

    /// The memory that it takes [bytes].
    pub fn bytes(&self) -> usize {
        let columns = self.positions.iter().chain(&self.kept).map(|column| std::mem::size_of_val(column.as_slice()));
        self.neighbors.bytes() + columns.sum::<usize>() + size_of::<u32>() * (self.members.len() + self.slots.len())
    }
}

/// The number of neighbors that a particle is taken to have where that only decides how long a chunk of steps is.
const TYPICAL: usize = 20;

/// Fills a column from the front of captured numbers.
///
/// # Errors
/// If there are too few.
pub fn take(numbers: &mut &[f64], column: &mut [f64]) -> Result<()> {
    let foreign = || Error::State("it does not belong to this scene".to_owned());
    let (mine, rest) = numbers.split_at_checked(column.len()).ok_or_else(foreign)?;
    column.copy_from_slice(mine);
    *numbers = rest;
    Ok(())
}

/// Refuses cutoffs [m] of which the precision of the run cannot hold the square, down to the distances that it tells apart.
fn refuse_tiny<T: Real>(cutoff: f64) -> Result<()> {
    let least = T::EPSILON * cutoff * cutoff;
    // Where numbers are no longer normal, or infinite, they lose digits.
    if (T::from_f64(least).to_f64() - least).abs() <= T::EPSILON * least {
        return Ok(());
    }
    let found = format!("{} for forces that reach {cutoff:.3e} m", T::NAME);
    Err(Error::parameter("precision", "f64", found).with_hint("squares of such distances are out of its range"))
}

/// The space of a scene, relative to an origin.
fn domain(scene: &Scene, origin: DVec3) -> Domain {
    let Some([lower, upper]) = scene.periodic else { return Domain::default() };
    let ends = |axis: usize| (lower[axis] - origin[axis], upper[axis] - origin[axis]);
    let is_periodic = |axis: usize| axis < scene.dimension && lower[axis].is_finite() && upper[axis].is_finite();
    Domain { period: std::array::from_fn(|axis| is_periodic(axis).then(|| ends(axis))) }
}

/// Where the members are at the start, relative to the origin [m].
fn places<V: Vector>(scene: &Scene, properties: &Properties<V>, members: &[u32]) -> Vec<DVec3> {
    let positions = scene.positions();
    let place = |&member: &u32| positions[properties.caller[member as usize] as usize] - properties.origin;
    members.iter().map(place).collect()
}

/// The skin for particles at these places, from the space that there is for each where they are: in wide cells that hold any.
fn skin<V: Vector>(places: &[DVec3], domain: &Domain, cutoff: f64) -> f64 {
    let cell = SAMPLE * cutoff;
    let mut cells: Vec<[i64; AXES]> = places.iter().map(|place| (*place / cell).floor().as_i64vec3().to_array()).collect();
    cells.sort_unstable();
    cells.dedup();
    let space = cells.len() as f64 / places.len().max(1) as f64;
    let distance = cell * libm::pow(space, 1.0 / V::DIMENSION as f64);
    let room = domain.lengths().iter().flatten().map(|length| 0.5 * length - cutoff).fold(f64::INFINITY, f64::min);
    (SKIN * distance).min(cutoff).min(0.999 * room).max(0.0)
}
