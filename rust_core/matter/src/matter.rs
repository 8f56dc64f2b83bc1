//! The state of all particles, in fixed blocks.

use std::ops::Range;

use glam::{DQuat, DVec3};

pub use crate::columns::{Columns, Span, View};
use crate::error::Result;
use crate::history::{Archive, TALLIES};
pub use crate::integrators::REGISTERS;
use crate::math::{Real, Vector};
use crate::parallel::Split;
use crate::simd::{LANES, padded};
pub use crate::tally::{EnergySink, EnergyTally, Power, SINKS};

/// The constant properties of particles.
#[derive(Debug, Clone)]
pub struct Properties<V: Vector> {
    /// 1/m [1/kg], 0 for a fixed particle; padded with zeros to whole groups of lanes.
    pub inverse_mass: Vec<V::Scalar>,
    /// Mass m [kg] in the precision of the forces, 0 for a fixed particle; padded with zeros.
    pub inertia: Vec<V::Scalar>,
    /// Mass m [kg], infinite for a fixed particle.
    pub mass: Vec<f64>,
    /// Charge [C].
    pub charge: Vec<f64>,
    /// Radius [m].
    pub radius: Vec<f64>,
    /// Body of each particle.
    pub body: Vec<u32>,
    /// Index of each particle in the caller's order.
    pub caller: Vec<u32>,
    /// Origin of the positions [m]; the third component is 0 in 2D.
    pub origin: DVec3,
}

impl<V: Vector> Properties<V> {
    /// Properties of particles with these masses [kg], infinite where fixed, in the caller's order. All belong to one body
    /// about the origin, without charge or radius.
    pub fn new(mass: Vec<f64>) -> Self {
        let column = |value: &dyn Fn(f64) -> f64| {
            let mut column: Vec<V::Scalar> = mass.iter().map(|&mass| V::Scalar::from_f64(value(mass))).collect();
            column.resize(padded(mass.len()), V::Scalar::ZERO);
            column
        };
        let count = mass.len();
        Self {
            inverse_mass: column(&|mass| 1.0 / mass),
            inertia: column(&|mass| if mass.is_finite() { mass.min(V::Scalar::MAX) } else { 0.0 }),
            mass,
            charge: vec![0.0; count],
            radius: vec![0.0; count],
            body: vec![0; count],
            caller: (0..count as u32).collect(),
            origin: DVec3::ZERO,
        }
    }

    /// Index in the engine's order of each particle of the caller's order.
    #[inline]
    pub fn engine(&self) -> Vec<u32> {
        let mut engine = vec![0; self.caller.len()];
        self.caller.iter().zip(0..).for_each(|(&caller, index)| engine[caller as usize] = index);
        engine
    }

    /// Converts positions [m] from the caller's order to the engine's order, relative to the origin.
    #[inline]
    pub fn relative(&self, positions: &[DVec3]) -> Vec<DVec3> {
        self.caller.iter().map(|&caller| positions[caller as usize] - self.origin).collect()
    }

    /// Number of particles.
    #[inline]
    pub fn count(&self) -> usize {
        self.mass.len()
    }

    /// Whether a particle has a prescribed velocity.
    #[inline]
    pub fn is_fixed(&self, index: usize) -> bool {
        self.mass[index].is_infinite()
    }
}

/// Motion of a rigid body, whose center of mass is a particle, as forces see it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SolidMotion {
    /// Index of the particle in the engine's order.
    pub particle: u32,
    /// Rotation from the body's frame to the world's.
    pub orientation: DQuat,
    /// Orientation at the start of the last drift.
    pub before: DQuat,
    /// Displacement of the center of mass in the last drift [m].
    pub moved: DVec3,
    /// Angular velocity in the world's axes [rad/s].
    pub angular_velocity: DVec3,
}

/// The state of all particles.
#[derive(Debug, Clone)]
pub struct Matter<V: Vector> {
    /// Positions relative to the origin [m].
    pub position: Columns<V>,
    /// Velocities [m/s].
    pub velocity: Columns<V>,
    /// Registers of the integrator, persistent or between its stages.
    pub registers: Vec<Columns<V>>,
    /// Low-order part of the positions [m]: exact = position + residual. For forces that need separations beyond the
    /// precision of the state; else empty.
    pub residual: Columns<V>,
    /// Rotations of the rigid bodies, in the caller's order, as forces see them. The constraint of rigid bodies holds the state.
    pub solids: Vec<SolidMotion>,
    /// Energy dissipated and supplied, one tally per block.
    pub tallies: Vec<EnergyTally>,
    /// The number of particles in a block.
    pub block: usize,
}

/// Exact position [m]: a position plus its residual, if there is one.
fn exact<V: Vector>(position: V, residual: Option<V>) -> DVec3 {
    position.widen() + residual.map_or(DVec3::ZERO, V::widen)
}

/// Splits a position [m] into its rounded value and the residual.
fn parts<V: Vector>(exact: DVec3) -> (V, V) {
    let position = V::narrow(exact);
    (position, V::narrow(exact - position.widen()))
}

impl<V: Vector> Matter<V> {
    /// Matter at rest at the origin.
    #[inline]
    pub fn zeros(count: usize, registers: usize, block: usize) -> Self {
        Self {
            position: Columns::zeros(count),
            velocity: Columns::zeros(count),
            registers: vec![Columns::zeros(count); registers],
            residual: Columns::zeros(0),
            solids: Vec::new(),
            tallies: vec![EnergyTally::ZERO; count.div_ceil(block)],
            block,
        }
    }

    /// Number of particles.
    #[inline]
    pub fn count(&self) -> usize {
        self.position.count()
    }

    /// Copies the state of `other`, which has the same shape.
    #[inline]
    pub fn copy_from(&mut self, other: &Self) {
        self.position.copy_from(&other.position);
        self.velocity.copy_from(&other.velocity);
        for (mine, theirs) in self.registers.iter_mut().zip(&other.registers) {
            mine.copy_from(theirs);
        }
        self.residual.copy_from(&other.residual);
        self.solids.clone_from(&other.solids);
        self.tallies.copy_from_slice(&other.tallies);
    }

    /// Writes positions, velocities, the first registers and the tallies to an archive.
    pub fn capture(&self, registers: usize, archive: &mut Archive) {
        self.position.capture("positions", archive);
        self.velocity.capture("velocities", archive);
        self.residual.capture("residuals", archive);
        let registers = self.registers.iter().take(registers).enumerate();
        registers.for_each(|(index, columns)| columns.capture(&format!("registers[{index}]"), archive));
        let tallies = self.tallies.iter().flat_map(|tally| tally.energy.iter().chain(&tally.last));
        archive.write(TALLIES, tallies.flatten().copied());
    }

    /// Reads the data of [`Matter::capture`].
    ///
    /// # Errors
    /// If an array is missing or of another size.
    pub fn restore(&mut self, registers: usize, archive: &mut Archive) -> Result<()> {
        self.position.restore("positions", archive)?;
        self.velocity.restore("velocities", archive)?;
        self.residual.restore("residuals", archive)?;
        let mut registers = self.registers.iter_mut().take(registers).enumerate();
        registers.try_for_each(|(index, columns)| columns.restore(&format!("registers[{index}]"), archive))?;
        let numbers = archive.read_exactly(TALLIES, 2 * SINKS * LANES * self.tallies.len())?;
        let slots = self.tallies.iter_mut().flat_map(|tally| tally.energy.iter_mut().chain(&mut tally.last));
        slots.flatten().zip(numbers).for_each(|(slot, &number)| *slot = number);
        Ok(())
    }

    /// Exact position of a particle relative to the origin [m].
    #[inline(always)]
    pub fn exact_position(&self, index: usize) -> DVec3 {
        exact(self.position.get(index), (self.residual.count() > 0).then(|| self.residual.get(index)))
    }

    /// Sets the position of a particle relative to the origin [m], as exactly as the state can hold it.
    #[inline]
    pub fn set_exact_position(&mut self, index: usize, exact: DVec3) {
        let (position, residual) = parts(exact);
        self.position.set(index, position);
        if self.residual.count() > 0 {
            self.residual.set(index, residual);
        }
    }

    /// Energy through one sink so far [J], summed block by block.
    #[inline]
    pub fn tallied(&self, sink: EnergySink) -> f64 {
        self.tallies.iter().map(|tally| tally.total(sink)).sum()
    }

    /// Tallies the energies that contacts of particles, given by their indices, dissipate in a step [J]. A sum below 0 is an error
    /// of the step: it is left to the drift. `driven` says whether fixed particles may supply it.
    pub fn lose_in_contacts(&mut self, losses: &[(usize, f64)], driven: bool) {
        if driven || losses.iter().map(|(_, lost)| lost).sum::<f64>() > 0.0 {
            losses.iter().for_each(|&(index, lost)| self.tallies[index / self.block].add(EnergySink::Contact, lost));
        }
    }

    /// Memory [bytes].
    #[inline]
    pub fn bytes(&self) -> usize {
        let registers: usize = self.registers.iter().map(Columns::bytes).sum();
        self.position.bytes()
            + self.velocity.bytes()
            + registers
            + self.residual.bytes()
            + size_of_val(self.solids.as_slice())
            + std::mem::size_of_val(self.tallies.as_slice())
    }

    /// All blocks, mutable.
    pub fn blocks(&mut self) -> Blocks<'_, V> {
        let mut registers = self.registers.iter_mut();
        Blocks {
            start: 0,
            count: self.position.count(),
            size: self.block,
            position: self.position.span(),
            velocity: self.velocity.span(),
            registers: std::array::from_fn(|_| registers.next().map_or_else(Span::empty, Columns::span)),
            residual: self.residual.span(),
            tallies: &mut self.tallies,
        }
    }
}

/// Consecutive mutable blocks of matter.
#[derive(Debug)]
pub struct Blocks<'a, V: Vector> {
    /// Index of the first particle.
    pub start: usize,
    /// Number of particles, without the padding.
    pub count: usize,
    size: usize,
    /// Positions relative to the origin [m].
    pub position: Span<'a, V>,
    /// Velocities [m/s].
    pub velocity: Span<'a, V>,
    /// Registers of the integrator.
    pub registers: [Span<'a, V>; REGISTERS],
    /// Low-order part of the positions [m]; empty if unused.
    pub residual: Span<'a, V>,
    /// One tally per block.
    pub tallies: &'a mut [EnergyTally],
}

impl<'a, V: Vector> Blocks<'a, V> {
    /// One block of `count` particles that begins at `start`.
    #[inline]
    pub fn new(
        start: usize,
        count: usize,
        position: Span<'a, V>,
        velocity: Span<'a, V>,
        registers: [Span<'a, V>; REGISTERS],
        tallies: &'a mut [EnergyTally],
    ) -> Self {
        Self { start, count, size: position.len(), position, velocity, registers, residual: Span::empty(), tallies }
    }

    /// Exact position of a particle of these blocks, relative to the origin [m].
    #[inline]
    pub fn exact_position(&self, lane: usize) -> DVec3 {
        exact(self.position.get(lane), (!self.residual.is_empty()).then(|| self.residual.get(lane)))
    }

    /// Sets the position of a particle of these blocks relative to the origin [m], as exactly as the state can hold it.
    #[inline]
    pub fn set_exact_position(&mut self, lane: usize, exact: DVec3) {
        let (position, residual) = parts(exact);
        self.position.set(lane, position);
        if !self.residual.is_empty() {
            self.residual.set(lane, residual);
        }
    }

    /// Range of the particles' indices, padding included.
    #[inline(always)]
    pub fn range(&self) -> Range<usize> {
        self.start..self.start + self.position.len()
    }
}

impl<V: Vector> Split for Blocks<'_, V> {
    fn blocks(&self) -> usize {
        self.tallies.len()
    }

    fn split_at(self, blocks: usize) -> (Self, Self) {
        let length = (blocks * self.size).min(self.position.len());
        let count = length.min(self.count);
        let (position, other_position) = self.position.split_at(length);
        let (velocity, other_velocity) = self.velocity.split_at(length);
        let (residual, other_residual) = self.residual.split_at(length);
        let (tallies, other_tallies) = self.tallies.split_at_mut(blocks);
        let mut others: [Span<'_, V>; REGISTERS] = std::array::from_fn(|_| Span::empty());
        let registers = {
            let mut other = others.iter_mut();
            self.registers.map(|span| {
                let (first, rest) = span.split_at(length);
                if let Some(slot) = other.next() {
                    *slot = rest;
                }
                first
            })
        };
        let first = Self { start: self.start, count, size: self.size, position, velocity, registers, residual, tallies };
        let rest = Self {
            start: self.start + length,
            count: self.count - count,
            size: self.size,
            position: other_position,
            velocity: other_velocity,
            registers: others,
            residual: other_residual,
            tallies: other_tallies,
        };
        (first, rest)
    }
}
