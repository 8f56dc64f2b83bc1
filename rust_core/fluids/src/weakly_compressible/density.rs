//! Density of the fluid, by the continuity equation over drifts or by summation.

use std::ops::Range;

use super::WeaklyCompressible;
use super::laws::RATES;
use super::solids::{frames, frames_between};
use crate::error::Result;
use crate::forces::{DensityScheme, Drift, Fields, FluidScheme, Mach, Readings};
use crate::math::{Real, Vector};
use crate::matter::{EnergySink, Power, Span, View};
use crate::parallel::{BlockedSlice, Executor};
use crate::particles::images::WallCondition;
use crate::particles::kernel::KernelShape;
use crate::particles::records::fill;
use crate::particles::{BLOCK, Gauges, OBSTACLE};
use crate::simd::LANES;

impl<V: Vector, K: KernelShape, const MIXED: bool> WeaklyCompressible<V, K, MIXED> {
    /// Updates density by summation, if that is the scheme.
    pub(super) fn sum_density(&mut self, velocity: &View<'_, V>, executor: &Executor) -> Result<()> {
        let Self { summation, neighbor_list, records, walls, materials, kind, mass, density, solids, .. } = self;
        let Some(summation) = summation else { return Ok(()) };
        let rest = |member: usize| [V::Scalar::from_f64(mass[member] / materials.rest_density(kind[member])), V::Scalar::ZERO];
        let velocity = solids.velocities(velocity);
        fill(records, (neighbor_list, kind), &velocity, &rest, executor);
        summation.count((neighbor_list, records), walls, (materials, kind), density, executor)
    }

    /// Advances the density by ρ ← ρ + h dρ/dt, with positions and velocities at the midpoint of the drift.
    fn carry_density(&mut self, drift: &Drift<'_, V>, executor: &Executor) -> Result<()> {
        self.solids.place(frames_between(drift));
        self.search(&|axis, index| drift.midpoint(axis, index), executor)?;
        let Self { fluids, kind, mass, density, diffused, neighbor_list, records, surface, shifting, .. } = self;
        let Self { continuity, rates, mirrored, walls, solids, .. } = self;
        let each = |member: usize| {
            let enthalpy = fluids.get(usize::from(kind[member])).map_or(0.0, |fluid| fluid.enthalpy(density[member]));
            [mass[member] / density[member], enthalpy].map(V::Scalar::from_f64)
        };
        let velocity = solids.velocities(&drift.velocity);
        fill(records, (neighbor_list, kind), &velocity, &each, executor);
        let neighbors = neighbor_list.neighbors();
        records.sum(neighbors, *continuity, rates, executor);
        let common = &fluids[0];
        let condition = WallCondition { weight: common.material.gravity / common.sound_speed.powi(2), no_slip: false };
        if !walls.is_empty() {
            mirrored.fill([V::Scalar::ZERO; RATES]);
        }
        walls.add(*continuity, &condition, (neighbor_list, records), mirrored, executor);
        if let Some(shifting) = shifting {
            shifting.update((neighbor_list, records), walls, drift.h, executor);
        }
        let slots = neighbors.slots();
        let columns = (
            BlockedSlice::new(density, BLOCK),
            (BlockedSlice::new(diffused, BLOCK), BlockedSlice::new(&mut surface.wall_factors, BLOCK)),
        );
        executor.for_each_block(columns, &|(densities, (losses, wall_factors))| {
            for (offset, (density, (lost, wall_factor))) in
                densities.items.iter_mut().zip(losses.items.iter_mut().zip(wall_factors.items)).enumerate()
            {
                let member = densities.start + offset;
                let Some(fluid) = fluids.get(usize::from(kind[member])) else { continue };
                let slot = slots[member] as usize;
                let [squeeze, diffusion, by_obstacles] = rates[slot].map(Real::to_f64);
                let [by_fluid, through_walls, by_solid] = mirrored.get(slot).map_or([0.0; RATES], |sums| sums.map(Real::to_f64));
                let by_walls = by_fluid + by_solid + by_obstacles;
                let evened = diffusion + through_walls;
                let change = drift.h * (*density * (squeeze + f64::from(wall_factor.drift()) * by_walls) + evened);
                // The work of diffusion against pressure is dissipated.
                let middle = *density + 0.5 * change;
                *lost = -drift.h * fluid.material.mass * fluid.pressure(middle) / (middle * middle) * evened;
                *density += change;
                wall_factor.drifted(*density < fluid.material.density, by_walls <= 0.0);
            }
        });
        Ok(())
    }
}

impl<V: Vector, K: KernelShape, const MIXED: bool> FluidScheme<V> for WeaklyCompressible<V, K, MIXED> {
    fn export(&self, fields: &mut Fields) {
        for (member, &index) in self.neighbor_list.members().iter().enumerate() {
            if let Some(fluid) = self.fluid(self.kind[member]) {
                fields.density[index as usize] = self.density[member];
                fields.pressure[index as usize] = fluid.pressure(self.density[member]);
            }
        }
    }

    fn import(&mut self, density: &[f64]) {
        for (member, &index) in self.neighbor_list.members().iter().enumerate() {
            if self.fluid(self.kind[member]).is_some() {
                self.density[member] = density[index as usize];
            }
        }
    }

    fn gauges(&self) -> Option<&Readings> {
        self.gauges.as_ref().map(Gauges::readings)
    }

    fn mach(&self, velocity: View<'_, V>) -> Option<Mach> {
        Some(self.speed(velocity))
    }

    fn density(&self) -> DensityScheme {
        if self.summation.is_some() {
            DensityScheme::Summation
        } else {
            DensityScheme::Continuity { shifts: self.shifting.is_some() }
        }
    }

    fn drift(&mut self, drift: &Drift<'_, V>, executor: &Executor) -> Result<()> {
        if self.summation.is_none() {
            return self.carry_density(drift, executor);
        }
        self.solids.place(frames(&drift.end));
        self.search(&|axis, index| drift.end.exact_position(axis, index), executor)?;
        self.sum_density(&drift.end.velocity, executor)
    }

    fn dissipated(&self, block: Range<usize>, energy: &mut Power) {
        for (index, member, _) in self.neighbor_list.in_block(block) {
            energy[EnergySink::Viscosity as usize][index % LANES] += self.diffused[member];
        }
    }

    fn shift(&self, block: Range<usize>, displacements: &mut Span<'_, V>) {
        let Some(shifting) = &self.shifting else { return };
        for (index, member, slot) in self.neighbor_list.in_block(block) {
            if self.kind[member] != OBSTACLE {
                displacements.set(index, displacements.get(index) + shifting.displacement(slot));
            }
        }
    }
}
