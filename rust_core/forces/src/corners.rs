//! Forces on the corners of elements, such as faces or hinges: evaluated for each element, and summed for each particle.

use std::ops::Range;

use glam::DVec3;

use super::Rates;
use crate::adjacency::Adjacency;
use crate::error::Result;
use crate::math::Vector;
use crate::matter::EnergySink;
use crate::parallel::{BlockedSlice, Executor};
use crate::simd::LANES;

/// Elements per block of work.
const BLOCK: usize = 1024;

/// Forces of the last evaluation on the `N` corners of every element, and its power through `S` sinks.
#[derive(Debug)]
pub struct Corners<V: Vector, const N: usize, const S: usize> {
    /// Corners at each particle, as `N` times the element plus the corner.
    places: Adjacency,
    /// Forces on the corners [N].
    force: Vec<[V; N]>,
    /// Powers through the sinks [W].
    power: Vec<[f64; S]>,
}

impl<V: Vector, const N: usize, const S: usize> Corners<V, N, S> {
    /// Elements with these corners among `count` particles.
    #[inline]
    pub fn new(count: usize, elements: impl Iterator<Item = [u32; N]>) -> Self {
        let places: Vec<[u32; 2]> = elements.flatten().zip(0..).map(|(corner, place)| [corner, place]).collect();
        let elements = places.len() / N;
        Self { places: Adjacency::new(count, &places), force: vec![[V::default(); N]; elements], power: vec![[0.0; S]; elements] }
    }

    /// Evaluates the forces [N] and powers [W] of all elements.
    ///
    /// # Errors
    /// If the executor was asked to stop.
    pub fn evaluate(&mut self, executor: &Executor, of: impl Fn(usize) -> ([DVec3; N], [f64; S]) + Sync) -> Result<()> {
        let slots = (BlockedSlice::new(&mut self.force, BLOCK), BlockedSlice::new(&mut self.power, BLOCK));
        executor.for_each_block(slots, &|(force, power)| {
            for (element, (force, power)) in (force.start..).zip(force.items.iter_mut().zip(power.items)) {
                let (forces, powers) = of(element);
                (*force, *power) = (forces.map(V::narrow), powers);
            }
        });
        executor.check()
    }

    /// The elements of a particle, and the number of the corner that it is.
    #[inline]
    pub fn of(&self, particle: usize) -> impl Iterator<Item = (usize, usize)> {
        self.places.of(particle).iter().map(|&place| (place as usize / N, place as usize % N))
    }

    /// The particles of a block, without padding.
    #[inline]
    pub fn particles(&self, block: &Range<usize>) -> Range<usize> {
        block.start..block.end.min(self.places.count())
    }

    /// Adds the forces on the particles of a block. The power of an element counts at its first corner.
    pub fn accumulate(&self, block: &Range<usize>, sinks: [EnergySink; S], rates: &mut Rates<'_, V>) {
        for (lane, index) in self.particles(block).enumerate() {
            let mut sum = V::default();
            for (element, corner) in self.of(index) {
                sum += self.force[element][corner];
                for (sink, power) in sinks.iter().zip(self.power[element]) {
                    rates.power[*sink as usize][index % LANES] += if corner == 0 { power } else { 0.0 };
                }
            }
            rates.force.set(lane, rates.force.get(lane) + sum);
        }
    }

    /// Memory [bytes].
    #[inline]
    pub fn bytes(&self) -> usize {
        self.places.bytes() + size_of_val(self.force.as_slice()) + size_of_val(self.power.as_slice())
    }
}
