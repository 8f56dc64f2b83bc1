//! Force of all short-range pair laws, with neighbor list, records and pair sums.
//!
//! Before the blocks accumulate, [`Pairs::prepare`] updates the neighbor lists. It writes the law's input of every particle into
//! records, and sums the law over the neighbors of each particle. Every pair is computed from both of its ends. Action and
//! reaction are equal bit by bit, because both use the same numbers with opposite signs.

use std::ops::Range;

use glam::{DMat3, DVec3};

use super::derivatives::{Derivatives, Directed, MatrixBlock, Motion, Push};
use super::springs;
use super::{About, Force, Rates, Reach, StateView, Validity, VelocityDependence};
use crate::error::Result;
use crate::history::{Archive, History};
use crate::ledger::{Class, Ledger};
use crate::math::{AXES, Coordinate, Real, Vector};
use crate::matter::{EnergySink, Properties};
use crate::neighbors::sums::{Pair, PairLaw, Records};
use crate::neighbors::{NeighborList, Neighbors};
use crate::parallel::{BlockedSlice, Executor};
use crate::scene::Scene;
use crate::simd::{LANES, Number, ParticleRecord};
use crate::stability::{Horizon, SpectralBound};

/// Parameters of a particle besides position and velocity, such as the radius.
pub type Attributes = [f64; 2];

/// Number of pair sums of a particle: the force along each axis [N], and the dissipated power of its pairs [W].
pub const SUMS: usize = AXES + 1;

/// A short-range pair interaction.
pub trait Interaction<V: Vector>: PairLaw<V, SUMS> + Send {
    /// Name in the plan and in the energy budget.
    const NAME: &'static str;
    /// Whether the two particles of each spring are excluded from the interaction.
    const SPARES_BONDED: bool = false;
    /// Whether the force has kinks as a function of the distance.
    const KINKS: bool = false;

    /// Cutoff radius [m].
    fn cutoff(&self) -> f64;

    /// Dependence on velocity.
    fn velocity(&self) -> VelocityDependence;

    /// Parameters of a particle: see [`attribute`].
    fn attributes(&self, properties: &Properties<V>, index: usize) -> Attributes;

    /// Potential energy of two particles with these attributes at a distance [J].
    fn potential(&self, attributes: [Attributes; 2], distance: f64) -> f64;

    /// Upper bounds of the stiffness [N/m] and the damping [N·s/m] of two such particles, longitudinal and transverse.
    fn stiffness(&self, attributes: [Attributes; 2], distance: f64) -> [Directed; 2];

    /// Force on the first of two such particles [N], with its derivatives. `separation` and `velocity` are its position and
    /// velocity relative to the second.
    fn response(&self, attributes: [Attributes; 2], separation: DVec3, velocity: DVec3) -> Response;

    /// Largest eigenvalues of the stiffness [N/m] and damping [N·s/m] matrices, summed over the pairs of each member, that are
    /// expected in the motion ahead. Independent of the number of pairs that interact now.
    fn expected(&self, _at: &StateView<'_, V>, members: &[u32]) -> Vec<[f64; 2]> {
        vec![[0.0; 2]; members.len()]
    }

    /// Adds further bounds on the time step.
    fn bound(&self, _at: &StateView<'_, V>, _members: &[u32], _bound: &mut SpectralBound) {}
}

/// Force on the first particle of a pair, with the symmetric parts of its derivatives.
#[derive(Debug, Clone, Copy)]
pub struct Response {
    /// Force [N].
    pub force: DVec3,
    /// Stiffness K along and across the separation [N/m].
    pub stiffness: Directed,
    /// Damping matrix C, positive semidefinite [N·s/m].
    pub damping: DMat3,
}

impl Response {
    /// Response of particles that do not interact.
    pub const NONE: Self = Self { force: DVec3::ZERO, stiffness: Directed { along: 0.0, across: 0.0 }, damping: DMat3::ZERO };
}

/// Upper bound of the largest eigenvalue of a symmetric matrix in `dimension` dimensions, from its trace and norm. Exact in two
/// dimensions. Source: H. Wolkowicz and G. P. H. Styan, Linear Algebra Appl. 29 (1980) 471, theorem 2.1.
fn largest(matrix: &DMat3, dimension: usize) -> f64 {
    let columns = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
    let number = dimension as f64;
    let (mut mean, mut square) = (0.0, 0.0);
    for axis in 0..dimension {
        mean += columns[axis][axis] / number;
        square += (0..dimension).map(|other| columns[axis][other] * columns[axis][other]).sum::<f64>() / number;
    }
    mean + ((number - 1.0) * (square - mean * mean).max(0.0)).sqrt()
}

/// Attribute 0 or 1 stored in a record.
#[inline(always)]
pub fn attribute<V: Vector, N: Copy>(record: &ParticleRecord<N>, which: usize) -> N {
    record[2 * V::DIMENSION + which]
}

/// Relative velocity vᵢ − vⱼ of a pair [m/s].
#[inline(always)]
pub fn relative_velocity<V: Vector, N: Number>(pair: &Pair<N>) -> [N; AXES] {
    let mut relative = [N::constant(0.0); AXES];
    for axis in 0..V::DIMENSION {
        relative[axis] = pair.own[V::DIMENSION + axis] - pair.other[V::DIMENSION + axis];
    }
    relative
}

/// Force of a pair law between near members.
pub struct Pairs<V: Vector, L> {
    law: L,
    /// Attributes of each member.
    attributes: Vec<Attributes>,
    neighbor_list: NeighborList,
    records: Records<V>,
    /// Pair sums by slot: force [N] and dissipated power [W].
    sums: Vec<[V::Scalar; SUMS]>,
}

impl<V: Vector, L: Interaction<V>> Pairs<V, L> {
    /// Force of a law between the `chosen` particles of a scene.
    ///
    /// # Errors
    /// If the periodic domain is too small for the cutoff.
    pub fn new(scene: &Scene, properties: &Properties<V>, chosen: &[bool], law: L) -> Result<Self> {
        let members: Vec<u32> = (0..properties.count() as u32).filter(|&index| chosen[index as usize]).collect();
        let attributes: Vec<Attributes> = members.iter().map(|&index| law.attributes(properties, index as usize)).collect();
        let sums = vec![[V::Scalar::ZERO; SUMS]; members.len()];
        let mut neighbor_list = NeighborList::new(scene, properties, members, law.cutoff())?;
        if L::SPARES_BONDED {
            let engine = properties.engine();
            let ends = springs::declared(scene)?.into_iter().map(|spring| spring.ends.map(|end| engine[end as usize]));
            neighbor_list = neighbor_list.excluding(ends);
        }
        let records = Records::new(neighbor_list.neighbors());
        Ok(Self { law, attributes, neighbor_list, records, sums })
    }

    /// Calls `take` with the two particles of every listed pair, their separation, and the response of the first.
    fn respond(&self, at: &Motion<'_>, mut take: impl FnMut([usize; 2], DVec3, Response)) {
        let (neighbors, members) = (self.neighbor_list.neighbors(), self.neighbor_list.members());
        let (order, support) = (neighbors.order(), neighbors.support());
        let encodings = neighbors.domain().lengths().map(|length| f64::encoding(length, support));
        for (slot, &one) in order.iter().enumerate() {
            for &other in neighbors.of(slot).iter().filter(|&&other| other as usize > slot) {
                let pair = [one as usize, order[other as usize] as usize];
                let [one, other] = pair.map(|member| members[member] as usize);
                let (a, b) = (at.position[one].to_array(), at.position[other].to_array());
                let separation =
                    DVec3::from_array(std::array::from_fn(|axis| f64::separation::<true, _>(a[axis], b[axis], encodings[axis])));
                let attributes = pair.map(|member| self.attributes[member]);
                take([one, other], separation, self.law.response(attributes, separation, at.velocity[one] - at.velocity[other]));
            }
        }
    }

    /// Calls `take` once for every pair within the cutoff, in a fixed order, with its members and the value of `each`. The
    /// arguments of `each` are the members and the separation vector [m]. Separate lists are built for a few slots at a time,
    /// because complete ones would take as much memory as the lists in use.
    ///
    /// # Errors
    /// If positions are too far from the origin for exact separations, or on an interrupt.
    fn for_each<T: Send>(
        &self,
        at: &StateView<'_, V>,
        each: impl Fn([usize; 2], DVec3) -> T + Sync,
        mut take: impl FnMut([usize; 2], T),
    ) -> Result<()> {
        let slot =
            |axis: usize| self.neighbor_list.members().iter().map(|&member| at.exact_position(axis, member as usize)).collect();
        let positions: [Vec<f64>; AXES] = std::array::from_fn(|axis| if axis < V::DIMENSION { slot(axis) } else { Vec::new() });
        let listed = self.neighbor_list.neighbors();
        let (count, domain) = (self.attributes.len(), listed.domain());
        let mut neighbors =
            Neighbors::new(count, V::DIMENSION, domain, self.law.cutoff(), 0.0)?.excluding(listed.excluded().clone());
        neighbors.arrange(positions.each_ref().map(Vec::as_slice), at.executor)?;
        let (order, encodings) = (neighbors.order(), domain.lengths().map(|length| f64::encoding(length, neighbors.support())));
        let mut buffers: Vec<_> = (0..BUFFERS).map(|_| (neighbors.listed(), Vec::new())).collect();
        let (mut start, mut stride) = (0, 1);
        while start < count {
            at.executor.check()?;
            at.executor.for_each_block(BlockedSlice::new(&mut buffers, 1), &|mine| {
                let first = (start + mine.start * stride).min(count);
                let (listed, pairs) = &mut mine.items[0];
                neighbors.list_slots(first..(first + stride).min(count), listed, at.executor);
                for (slot, list) in (first..).zip(listed.each()) {
                    let one = order[slot] as usize;
                    for &other in list.iter().filter(|&&other| other as usize > slot) {
                        let other = order[other as usize] as usize;
                        let mut separation = DVec3::ZERO;
                        for axis in 0..V::DIMENSION {
                            separation[axis] =
                                f64::separation::<true, _>(positions[axis][one], positions[axis][other], encodings[axis]);
                        }
                        pairs.push(([one, other], each([one, other], separation)));
                    }
                }
            });
            let taken: usize = buffers.iter().map(|(_, pairs)| pairs.len()).sum();
            buffers.iter_mut().flat_map(|(_, pairs)| pairs.drain(..)).for_each(|(pair, value)| take(pair, value));
            start += BUFFERS * stride;
            stride = if taken < BUFFERS * PAIRS { 2 * stride } else { (stride / 2).max(1) };
        }
        at.executor.check()
    }
}

/// Number of buffers, which several threads fill at a time, and target number of pairs in each.
const BUFFERS: usize = 16;
const PAIRS: usize = 2048;

impl<V: Vector, L: Interaction<V>> History for Pairs<V, L> {
    fn save(&mut self) {
        self.neighbor_list.save();
    }

    fn rollback(&mut self) {
        self.neighbor_list.rollback();
    }

    fn capture(&self, archive: &mut Archive) {
        self.neighbor_list.capture(archive);
    }

    fn restore(&mut self, archive: &mut Archive) -> Result<()> {
        self.neighbor_list.restore(archive)
    }
}

impl<V: Vector, L: Interaction<V>> Force<V> for Pairs<V, L> {
    fn about(&self) -> About {
        let own = std::mem::size_of_val(self.sums.as_slice()) + std::mem::size_of_val(self.attributes.as_slice());
        About {
            velocity: self.law.velocity(),
            kinks: L::KINKS,
            pairs: self.neighbor_list.pairs(),
            bytes: self.neighbor_list.bytes() + self.records.bytes() + own,
            layout: self.neighbor_list.layout(),
            ..About::new(L::NAME, Reach::Pairs)
        }
    }

    fn prepare(&mut self, at: &StateView<'_, V>, executor: &Executor) -> Result<()> {
        let Self { law, attributes, neighbor_list, records, sums } = self;
        neighbor_list.update(&|axis, index| at.exact_position(axis, index), executor)?;
        let members = neighbor_list.members();
        records.fill(neighbor_list.neighbors(), neighbor_list.positions(), executor, &|member, record| {
            let index = members[member] as usize;
            for axis in 0..V::DIMENSION {
                record[V::DIMENSION + axis] = at.velocity.axis(axis)[index];
            }
            for (slot, &attribute) in record[2 * V::DIMENSION..].iter_mut().zip(&attributes[member]) {
                *slot = V::Scalar::from_f64(attribute);
            }
        });
        records.sum(neighbor_list.neighbors(), *law, sums, executor);
        Ok(())
    }

    fn accumulate(&self, block: Range<usize>, _at: &StateView<'_, V>, rates: &mut Rates<'_, V>) {
        for (index, _, slot) in self.neighbor_list.in_block(block) {
            let sums = &self.sums[slot];
            for axis in 0..V::DIMENSION {
                rates.force.axes[axis][index] += sums[axis];
            }
            // Each particle accounts for half of the power of a pair.
            rates.power[EnergySink::Damping as usize][index % LANES] += 0.5 * sums[AXES].to_f64();
        }
    }

    fn energy(&self, at: &StateView<'_, V>, ledger: &mut Ledger) -> Result<()> {
        let mut energy = 0.0;
        let potential = |pair: [usize; 2], separation: DVec3| {
            self.law.potential(pair.map(|member| self.attributes[member]), separation.length())
        };
        self.for_each(at, potential, |_, potential| energy += potential)?;
        ledger.add(Class::Potential, L::NAME, energy);
        Ok(())
    }

    /// For a pair with the matrix A ≥ 0 and displacements u, w of its particles, (u − w)ᵀA(u − w) ≤ 2uᵀAu + 2wᵀAw. Counting each
    /// pair twice therefore bounds all frequencies by the largest of any single particle. The frequency of a particle is that of
    /// the direction with the largest sum over its pairs.
    fn bound(&self, at: &StateView<'_, V>, bound: &mut SpectralBound) -> Result<()> {
        let mut sums = vec![[DMat3::ZERO; 2]; self.attributes.len()];
        let matrices = |pair: [usize; 2], separation: DVec3| {
            let values = self.law.stiffness(pair.map(|member| self.attributes[member]), separation.length());
            values.map(|value| value.matrix(separation.normalize_or_zero()))
        };
        let added = self.for_each(at, matrices, |pair, matrices| {
            for member in pair {
                sums[member] = std::array::from_fn(|sum| sums[member][sum] + matrices[sum]);
            }
        });
        // The next step reports positions out of range.
        if added.is_err() {
            return Ok(());
        }
        let members = self.neighbor_list.members();
        let expected = self.law.expected(at, members);
        for ((&index, sums), expected) in members.iter().zip(sums).zip(expected) {
            let [stiffness, damping] = std::array::from_fn(|sum| 2.0 * largest(&sums[sum], V::DIMENSION).max(expected[sum]));
            bound.point(index as usize, L::NAME, stiffness, damping);
        }
        self.law.bound(at, members, bound);
        Ok(())
    }

    fn validity(&self, _at: &StateView<'_, V>, _horizon: Horizon) -> Validity {
        Validity::Now
    }

    fn derivatives(&mut self) -> Option<&mut dyn Derivatives> {
        Some(self)
    }
}

impl<V: Vector, L: Interaction<V>> Derivatives for Pairs<V, L> {
    fn arrange(&mut self, at: &Motion<'_>, executor: &Executor) -> Result<()> {
        self.neighbor_list.update(&|axis, index| at.position[index][axis], executor).map(|_| ())
    }

    fn forces(&self, at: &Motion<'_>, push: &mut dyn FnMut(Push)) {
        self.respond(at, |[one, other], _, Response { force, stiffness, .. }| {
            let stiffness = stiffness.largest();
            push(Push { particle: one, force, stiffness });
            push(Push { particle: other, force: -force, stiffness });
        });
    }

    fn blocks(&self, at: &Motion<'_>, [position, rate]: [f64; 2], add: &mut dyn FnMut(MatrixBlock)) {
        self.respond(at, |ends, separation, Response { stiffness, damping, .. }| {
            let direction = separation.normalize_or_zero();
            let [exact, definite] =
                [stiffness, stiffness.definite()].map(|stiffness| position * stiffness.matrix(direction) + rate * damping);
            if definite != DMat3::ZERO || exact != DMat3::ZERO {
                add(MatrixBlock { ends: ends.map(|end| end as u32), exact, definite });
            }
        });
    }
}
