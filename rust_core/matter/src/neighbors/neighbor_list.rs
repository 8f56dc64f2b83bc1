//! Neighbor list (Verlet list) of the members of a pair force, reused over several steps.
//!
//! Through rounding, the sums over lists depend on the positions at which the lists were built. These positions are therefore
//! captured in checkpoints and rolled back.

use std::ops::Range;

use glam::DVec3;

use super::{Domain, Neighbors, Reflections};
use crate::adjacency::Adjacency;
use crate::error::{Error, Result};
use crate::history::{Archive, History};
use crate::math::{AXES, Real, Vector};
use crate::matter::Properties;
use crate::parallel::{BlockedSlice, Executor};
use crate::scene::Scene;

/// Skin in units of the particle spacing. Lists of this length serve several steps and are not much longer than necessary.
const SKIN: f64 = 0.3;

/// Cell size of the estimate of the particle spacing, in units of the cutoff. The estimate counts particles per cell.
const SAMPLE: f64 = 4.0;

/// Particles per block of the copy of positions.
const BLOCK: usize = 1024;

/// Member number of particles that are not members.
const NOT_A_MEMBER: u32 = u32::MAX;

/// Positions of the members, with the lists of their neighbors.
#[derive(Debug)]
pub struct NeighborList {
    /// Particle indices of the members.
    members: Vec<u32>,
    /// Member number of each particle.
    member_of: Vec<u32>,
    neighbors: Neighbors,
    /// Exact positions relative to the origin, one array per axis [m].
    positions: [Vec<f64>; AXES],
    /// Positions at the last build, as of the start of the batch [m].
    saved: [Vec<f64>; AXES],
    /// Whether the lists were rebuilt since the start of the batch.
    renewed: bool,
    /// Whether the lists must be rebuilt from `saved` before use.
    rolled_back: bool,
    skin: f64,
}

impl NeighborList {
    /// Neighbor list of the `members` of a scene up to a cutoff [m]. Members are given by particle index. Those with larger
    /// indices are no particles.
    ///
    /// # Errors
    /// If the cutoff is out of range, the periodic domain is too small for it, or the precision of the run too coarse.
    pub fn new<V: Vector>(scene: &Scene, properties: &Properties<V>, members: Vec<u32>, cutoff: f64) -> Result<Self> {
        refuse_tiny::<V::Scalar>(cutoff)?;
        let domain = domain(scene, properties.origin);
        let skin = skin::<V>(&initial_positions(scene, properties, &members), &domain, cutoff);
        let columns = || std::array::from_fn(|axis| vec![0.0; if axis < V::DIMENSION { members.len() } else { 0 }]);
        let neighbors = Neighbors::new(members.len(), V::DIMENSION, &domain, cutoff, skin)?;
        let mut member_of = vec![NOT_A_MEMBER; properties.count()];
        let particles = members.iter().zip(0..).filter(|(index, _)| (**index as usize) < properties.count());
        particles.for_each(|(&index, member)| member_of[index as usize] = member);
        let (positions, saved) = (columns(), columns());
        Ok(Self { members, member_of, neighbors, positions, saved, renewed: false, rolled_back: false, skin })
    }

    /// Excludes pairs of particles from the lists. Pairs with non-members are ignored.
    #[must_use]
    #[inline]
    pub fn excluding(self, pairs: impl Iterator<Item = [u32; 2]>) -> Self {
        let numbers = pairs.map(|ends| ends.map(|end| self.member_of[end as usize]));
        let pairs = numbers.filter(|numbers| !numbers.contains(&NOT_A_MEMBER));
        let excluded = Adjacency::of_graph(self.members.len(), pairs);
        Self { neighbors: self.neighbors.excluding(excluded), ..self }
    }

    /// Updates positions and lists; returns whether the lists were rebuilt. `position` returns the position of a particle along
    /// an axis, relative to the origin [m].
    ///
    /// # Errors
    /// If positions are too far from the origin for exact separations, or the lists do not fit into memory.
    pub fn update(&mut self, position: &(impl Fn(usize, usize) -> f64 + Sync), executor: &Executor) -> Result<bool> {
        self.resume(executor)?;
        let (dimension, members) = (self.neighbors.dimension(), &self.members);
        for (axis, column) in self.positions.iter_mut().enumerate().take(dimension) {
            executor.for_each_block(BlockedSlice::new(column, BLOCK), &|mine| {
                let members = &members[mine.start..];
                mine.items.iter_mut().zip(members).for_each(|(to, &member)| *to = position(axis, member as usize));
            });
        }
        // The flag is set even on failure, because a failed update leaves no lists.
        let renewed = self.neighbors.update(self.positions.each_ref().map(Vec::as_slice), executor);
        self.renewed |= *renewed.as_ref().unwrap_or(&true);
        renewed
    }

    /// Copy of the neighbor list for other positions, with separate lists.
    ///
    /// # Errors
    /// As [`NeighborList::update`].
    pub fn anew(&self, position: &(impl Fn(usize, usize) -> f64 + Sync), executor: &Executor) -> Result<Self> {
        let Self { members, member_of, neighbors, positions, saved, skin, .. } = self;
        let (count, dimension, cutoff) = (neighbors.count(), neighbors.dimension(), neighbors.support() - skin);
        let mut anew = Self {
            members: members.clone(),
            member_of: member_of.clone(),
            neighbors: Neighbors::new(count, dimension, neighbors.domain(), cutoff, *skin)?
                .excluding(neighbors.excluded().clone()),
            positions: positions.clone(),
            saved: saved.clone(),
            renewed: false,
            rolled_back: false,
            skin: *skin,
        };
        anew.update(position, executor)?;
        Ok(anew)
    }

    /// Particle indices of the members.
    #[inline]
    pub fn members(&self) -> &[u32] {
        &self.members
    }

    /// The members in a block, each as index within the block, member number and slot.
    #[inline]
    pub fn in_block(&self, block: Range<usize>) -> impl Iterator<Item = (usize, usize, usize)> {
        let member_of = self.member_of[block.start..block.end.min(self.member_of.len())].iter().enumerate();
        let slots = self.neighbors.slots();
        let members = member_of.filter(|(_, member)| **member != NOT_A_MEMBER);
        members.map(|(index, &member)| (index, member as usize, slots[member as usize] as usize))
    }

    /// The neighbor lists.
    #[inline]
    pub fn neighbors(&self) -> &Neighbors {
        &self.neighbors
    }

    /// Skin: range of the lists beyond the cutoff [m].
    #[inline]
    pub fn skin(&self) -> f64 {
        self.skin
    }

    /// Positions of all members relative to the origin [m].
    #[inline]
    pub fn positions(&self) -> [&[f64]; AXES] {
        self.positions.each_ref().map(Vec::as_slice)
    }

    /// Position of the member at a slot relative to the origin [m].
    #[inline]
    pub fn at(&self, slot: usize) -> DVec3 {
        let member = self.neighbors.order()[slot] as usize;
        DVec3::from_array(self.positions().map(|axis| axis.get(member).copied().unwrap_or(0.0)))
    }

    /// Position of the member at a slot at the last build [m].
    #[inline]
    pub fn anchor(&self, slot: usize) -> DVec3 {
        self.neighbors.anchor(slot)
    }

    /// Lower bound of the distance of a point from the members of a block of the lists [m].
    #[inline]
    pub fn distance_to(&self, block: usize, point: DVec3) -> f64 {
        self.neighbors.bounds(block).distance(point.to_array()) - self.neighbors.largest_displacement()
    }

    /// Declares reflections of displacements, by position at the last build [m]. The lists then also serve reflected
    /// displacements.
    pub fn reflect(&mut self, reflections: &(impl Fn(DVec3) -> Reflections + Sync), executor: &Executor) {
        self.neighbors.reflect(&|point| reflections(DVec3::from_array(point)), executor);
    }

    /// Rebuilds the lists after a rollback; returns whether that was necessary.
    ///
    /// # Errors
    /// As [`NeighborList::update`].
    #[inline]
    pub fn resume(&mut self, executor: &Executor) -> Result<bool> {
        let rolled_back = self.rolled_back;
        if rolled_back {
            self.neighbors.restore(self.saved.each_ref().map(Vec::as_slice), executor)?;
            // After an interrupt within this batch, the lists and everything that depends on them must be rebuilt again.
            (self.renewed, self.rolled_back) = (true, executor.stopped());
        }
        Ok(rolled_back)
    }

    /// Number of listed neighbors, summed over all particles; an estimate before the first build.
    #[inline]
    pub fn pairs(&self) -> usize {
        let count = self.neighbors.count();
        let listed = (0..count).map(|slot| self.neighbors.of(slot).len()).sum();
        if listed == 0 { TYPICAL * count } else { listed }
    }

    /// Description in the plan.
    #[inline]
    pub fn layout(&self) -> String {
        let reach = self.neighbors.support() - self.skin;
        format!(
            "neighbors within {reach:.3e} m, from lists that reach {:.3e} m further and serve until neighbors have moved by that relative to each other",
            self.skin
        )
    }

    /// Memory [bytes].
    #[inline]
    pub fn bytes(&self) -> usize {
        let columns = self.positions.iter().chain(&self.saved).map(|column| std::mem::size_of_val(column.as_slice()));
        self.neighbors.bytes() + columns.sum::<usize>() + size_of::<u32>() * (self.members.len() + self.member_of.len())
    }
}

/// Saves the positions of the last build. After a rollback the lists are rebuilt on demand, because an interrupt must not wait
/// for them.
impl History for NeighborList {
    fn save(&mut self) {
        if self.renewed {
            for (axis, saved) in self.saved.iter_mut().enumerate() {
                saved.iter_mut().zip(self.neighbors.anchors(axis)).for_each(|(saved, anchor)| *saved = anchor);
            }
            self.renewed = false;
        }
    }

    fn rollback(&mut self) {
        self.rolled_back |= std::mem::take(&mut self.renewed);
    }

    fn capture(&self, archive: &mut Archive) {
        if self.rolled_back {
            archive.write(ANCHORS, self.saved.iter().flatten().copied());
        } else {
            archive.write(ANCHORS, (0..AXES).flat_map(|axis| self.neighbors.anchors(axis)));
        }
    }

    fn restore(&mut self, archive: &mut Archive) -> Result<()> {
        let numbers = archive.read_exactly(ANCHORS, self.saved.iter().map(Vec::len).sum())?;
        self.saved.iter_mut().flatten().zip(numbers).for_each(|(slot, &number)| *slot = number);
        (self.renewed, self.rolled_back) = (false, true);
        Ok(())
    }
}

/// Name of the positions of the last build in archives.
const ANCHORS: &str = "anchors";
/// Assumed number of neighbors per particle, which only sets the length of a batch of steps.
const TYPICAL: usize = 20;

/// Rejects cutoffs [m] that are too small for the precision of the run. The square of a cutoff must not underflow, down to the
/// smallest resolved distance.
fn refuse_tiny<T: Real>(cutoff: f64) -> Result<()> {
    let least = T::EPSILON * cutoff * cutoff;
    // Conversion to the precision of the run loses digits of subnormal and infinite numbers.
    if (T::from_f64(least).to_f64() - least).abs() <= T::EPSILON * least {
        return Ok(());
    }
    let found = format!("{} for forces that reach {cutoff:.3e} m", T::NAME);
    Err(Error::parameter("precision", "f64", found).with_hint("squares of such distances are out of its range"))
}

/// Domain of a scene, relative to an origin.
fn domain(scene: &Scene, origin: DVec3) -> Domain {
    let Some([lower, upper]) = scene.periodic else { return Domain::default() };
    let ends = |axis: usize| (lower[axis] - origin[axis], upper[axis] - origin[axis]);
    let is_periodic = |axis: usize| axis < scene.dimension && lower[axis].is_finite() && upper[axis].is_finite();
    Domain { period: std::array::from_fn(|axis| is_periodic(axis).then(|| ends(axis))) }
}

/// Initial positions of the members, relative to the origin [m].
fn initial_positions<V: Vector>(scene: &Scene, properties: &Properties<V>, members: &[u32]) -> Vec<DVec3> {
    let positions = scene.positions();
    let position = |&member: &u32| positions[properties.caller[member as usize] as usize] - properties.origin;
    members.iter().filter(|member| (**member as usize) < properties.count()).map(position).collect()
}

/// Skin for particles at these positions [m], from the mean volume per particle in occupied cells.
fn skin<V: Vector>(positions: &[DVec3], domain: &Domain, cutoff: f64) -> f64 {
    let cell = SAMPLE * cutoff;
    let mut cells: Vec<[i64; AXES]> =
        positions.iter().map(|position| (*position / cell).floor().to_array().map(|cell| cell as i64)).collect();
    cells.sort_unstable();
    cells.dedup();
    let space = cells.len() as f64 / positions.len().max(1) as f64;
    let distance = cell * libm::pow(space, 1.0 / V::DIMENSION as f64);
    let room = domain.lengths().iter().flatten().map(|length| 0.5 * length - cutoff).fold(f64::INFINITY, f64::min);
    (SKIN * distance).min(cutoff).min(0.999 * room).max(0.0)
}
