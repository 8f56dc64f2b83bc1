//! The force that all laws between near particles share: who is near, what each reads of the other, and the sums.
//!
//! Before any block is asked, [`Pairs::prepare`] brings the lists of neighbors up to date, writes what the law reads of every
//! particle into records, and sums the law over the neighbors of each. Each particle sums its own forces, so every pair is
//! computed from both of its ends, and action and reaction are equal to the bit: both see the same numbers with opposite
//! signs.

use std::ops::Range;

use glam::DVec3;

use super::vicinity::Vicinity;
use super::{Force, Moment, Rates, Reach, VelocityDependence};
use crate::error::Result;
use crate::math::{AXES, Placed, Real, Vector};
use crate::matter::{Channel, Properties};
use crate::neighbors::Neighbors;
use crate::neighbors::sums::{Pair, PairLaw, Records};
use crate::parallel::Crew;
use crate::scene::Scene;
use crate::simd::{LANES, Number, Record};
use crate::stability::Bound;

/// The force on a particle along each axis, and the power that its pairs dissipate.
pub const SUMS: usize = AXES + 1;

/// What happens between two particles that are near.
pub trait Interaction<V: Vector>: PairLaw<V, SUMS> + Send {
    /// Its name in the plan and in the audit.
    const NAME: &'static str;

    /// The distance from which on nothing happens [m].
    fn cutoff(&self) -> f64;

    /// Whether it depends on velocity.
    fn velocity(&self) -> VelocityDependence;

    /// What it reads of a particle beside position and velocity: see [`attribute`].
    fn attribute(&self, properties: &Properties<V>, index: usize) -> f64;

    /// The energy of two particles with these attributes at a distance [J].
    fn potential(&self, attributes: [f64; 2], distance: f64) -> f64;

    /// The largest stiffness [N/m] and damping [N·s/m] of such a pair.
    fn stiffness(&self, attributes: [f64; 2], distance: f64) -> [f64; 2];

    /// The stiffness [N/m] and damping [N·s/m] that every particle must be expected to meet, counted like that of its pairs,
    /// however few touch it now.
    fn expected(&self, _at: &Moment<'_, V>, _members: &[u32]) -> [f64; 2] {
        [0.0; 2]
    }

    /// Adds what else bounds the time step.
    fn bound(&self, _at: &Moment<'_, V>, _members: &[u32], _bound: &mut Bound) {}
}

/// The attribute in a record.
#[inline(always)]
pub fn attribute<V: Vector, N: Copy>(record: &Record<N>) -> N {
    record[2 * V::DIMENSION]
}

/// The velocity of a particle relative to the other of a pair.
#[inline(always)]
pub fn relative_velocity<V: Vector, N: Number>(pair: &Pair<N>) -> [N; AXES] {
    let mut relative = [N::constant(0.0); AXES];
    for axis in 0..V::DIMENSION {
        relative[axis] = pair.own[V::DIMENSION + axis] - pair.other[V::DIMENSION + axis];
    }
    relative
}

/// A law between all pairs of some particles that are near each other.
pub struct Pairs<V: Vector, L> {
    law: L,
    /// What the law reads of each member.
    attributes: Vec<f64>,
    vicinity: Vicinity,
    records: Records<V>,
    /// What the law gives, in the order of places.
    sums: Vec<[V::Scalar; SUMS]>,
}

impl<V: Vector, L: Interaction<V>> Pairs<V, L> {
    /// A law between those particles of a scene that are `chosen`.
    ///
    /// # Errors
    /// If the periodic domain is too small for its cutoff.
    pub fn new(scene: &Scene, properties: &Properties<V>, chosen: &[bool], law: L) -> Result<Self> {
        let members: Vec<u32> = (0..properties.count() as u32).filter(|&index| chosen[index as usize]).collect();
        let attributes: Vec<f64> = members.iter().map(|&index| law.attribute(properties, index as usize)).collect();
        let sums = vec![[V::Scalar::ZERO; SUMS]; members.len()];
        let vicinity = Vicinity::new(scene, properties, members, law.cutoff())?;
        let records = Records::new(vicinity.neighbors());
        Ok(Self { law, attributes, vicinity, records, sums })
    }

    /// Calls `each` with the members of every pair that is near, once, and their distance [m].
    fn for_each(neighbors: &Neighbors, positions: &[Vec<f64>; AXES], mut each: impl FnMut([usize; 2], f64)) {
        let order = neighbors.order();
        let rulers = neighbors.domain().lengths().map(|length| f64::ruler(length, neighbors.support()));
        for place in 0..neighbors.count() {
            let one = order[place] as usize;
            for &other in neighbors.of(place).iter().filter(|&&other| other as usize > place) {
                let other = order[other as usize] as usize;
                let mut apart = DVec3::ZERO;
                for axis in 0..V::DIMENSION {
                    apart[axis] = f64::apart::<true, _>(positions[axis][one], positions[axis][other], rulers[axis]);
                }
                each([one, other], apart.length());
            }
        }
    }

    /// The lists that belong to a moment, whatever those in use are.
    fn around(&self, at: &Moment<'_, V>) -> Result<(Neighbors, [Vec<f64>; AXES])> {
        let place = |axis: usize| self.vicinity.members().iter().map(|&member| at.place(axis, member as usize)).collect();
        let positions = std::array::from_fn(|axis| if axis < V::DIMENSION { place(axis) } else { Vec::new() });
        let domain = self.vicinity.neighbors().domain();
        let mut neighbors = Neighbors::new(self.attributes.len(), V::DIMENSION, domain, self.law.cutoff(), 0.0)?;
        neighbors.update(positions.each_ref().map(Vec::as_slice), &Crew::alone())?;
        Ok((neighbors, positions))
    }
}

impl<V: Vector, L: Interaction<V>> Force<V> for Pairs<V, L> {
    fn name(&self) -> &'static str {
        L::NAME
    }

    fn reach(&self) -> Reach {
        Reach::Pairs
    }

    fn velocity(&self) -> VelocityDependence {
        self.law.velocity()
    }

    fn prepare(&mut self, at: &Moment<'_, V>, crew: &Crew) -> Result<()> {
        let Self { law, attributes, vicinity, records, sums } = self;
        vicinity.update(&|axis, index| at.place(axis, index), crew)?;
        let members = vicinity.members();
        records.fill(vicinity.neighbors(), vicinity.positions(), crew, &|member, record| {
            let index = members[member] as usize;
            for axis in 0..V::DIMENSION {
                record[V::DIMENSION + axis] = at.velocity.axis(axis)[index];
            }
            record[2 * V::DIMENSION] = V::Scalar::from_f64(attributes[member]);
        });
        records.sum(vicinity.neighbors(), *law, sums, crew);
        Ok(())
    }

    fn keep(&mut self) {
        self.vicinity.keep();
    }

    fn undo(&mut self) -> Result<()> {
        self.vicinity.undo().map(|_| ())
    }

    fn capture(&self) -> Vec<f64> {
        self.vicinity.capture()
    }

    fn restore(&mut self, numbers: &mut &[f64]) -> Result<()> {
        self.vicinity.restore(numbers)
    }

    fn accumulate(&self, block: Range<usize>, _at: &Moment<'_, V>, rates: &mut Rates<'_, V>) {
        for (index, _, place) in self.vicinity.in_block(block) {
            let sums = &self.sums[place];
            for axis in 0..V::DIMENSION {
                rates.force.axes[axis][index] += sums[axis];
            }
            // Of a pair's power each takes half.
            rates.power[Channel::Damping as usize][index % LANES] += 0.5 * sums[AXES].to_f64();
        }
    }

    fn potential(&self, _block: Range<usize>, _at: &Moment<'_, V>) -> f64 {
        0.0
    }

    fn potential_of_all(&self, at: &Moment<'_, V>) -> Result<f64> {
        let (neighbors, positions) = self.around(at)?;
        let mut energy = 0.0;
        Self::for_each(&neighbors, &positions, |pair, distance| {
            energy += self.law.potential(pair.map(|member| self.attributes[member]), distance);
        });
        Ok(energy)
    }

    /// The stiffness of a pair is added at both of its particles, and counts twice there: by Gershgorin's theorem on the rows
    /// of √M⁻¹ K √M⁻¹, as that of springs does for equal masses.
    fn bound(&self, at: &Moment<'_, V>, bound: &mut Bound) {
        // Positions that cannot be searched are reported by the step that meets them.
        let Ok((neighbors, positions)) = self.around(at) else { return };
        let mut rows = vec![[0.0; 2]; self.attributes.len()];
        Self::for_each(&neighbors, &positions, |pair, distance| {
            let values = self.law.stiffness(pair.map(|member| self.attributes[member]), distance);
            for member in pair {
                rows[member] = std::array::from_fn(|row| rows[member][row] + 2.0 * values[row]);
            }
        });
        let members = self.vicinity.members();
        let expected = self.law.expected(at, members);
        for (&index, row) in members.iter().zip(rows) {
            bound.point(index as usize, L::NAME, row[0].max(expected[0]), row[1].max(expected[1]));
        }
        self.law.bound(at, members, bound);
    }

    fn bound_varies(&self) -> bool {
        true
    }

    fn pairs(&self) -> usize {
        self.vicinity.pairs()
    }

    fn layout(&self) -> String {
        self.vicinity.layout()
    }

    fn bytes(&self) -> usize {
        self.vicinity.bytes()
            + self.records.bytes()
            + std::mem::size_of_val(self.sums.as_slice())
            + std::mem::size_of_val(self.attributes.as_slice())
    }
}
