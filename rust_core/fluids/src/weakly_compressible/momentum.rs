//! Forces of the fluid: pressure, viscosity and surface tension, with their energies.

use std::ops::Range;

use glam::DVec3;

use super::WeaklyCompressible;
use super::laws::{FORCES, SOLID, VISCOUS};
use super::solids::frames;
use crate::error::Result;
use crate::forces::{About, FluidScheme, Force, Rates, Reach, StateView, Validity, VelocityDependence};
use crate::ledger::{Class, Ledger};
use crate::math::{Real, Vector};
use crate::matter::EnergySink;
use crate::neighbors::sums::Records;
use crate::parallel::Executor;
use crate::particles::images::WallCondition;
use crate::particles::kernel::KernelShape;
use crate::particles::probes::SurroundingFluid;
use crate::particles::records::fill;
use crate::particles::tension::Tension;
use crate::particles::walls::Mirrors;
use crate::particles::{Gauges, OBSTACLE};
use crate::simd::LANES;
use crate::stability::{Horizon, SpectralBound};

impl<V: Vector, K: KernelShape, const MIXED: bool> Force<V> for WeaklyCompressible<V, K, MIXED> {
    /// Volumes and enthalpies are those at the beginning of the drift, so that continuity is of order 1.
    fn about(&self) -> About {
        let viscous = self.fluids.iter().any(|fluid| fluid.artificial() > 0.0 || fluid.material.viscosity > 0.0);
        let continuity = self.density().is_carried();
        let shifts =
            self.shifting.as_ref().map_or_else(String::new, |shifting| format!("shifted by A = {}; ", shifting.coefficient()));
        About {
            velocity: if viscous || continuity { VelocityDependence::Dissipative } else { VelocityDependence::None },
            order: if continuity { 1 } else { u32::MAX },
            potential: self.tension.as_ref().map(|_| "surface tension"),
            pairs: 2 * self.neighbor_list.pairs(),
            bytes: self.bytes(),
            layout: format!("sound at {:.4} m/s; {shifts}{}", self.fluids[0].sound_speed, self.neighbor_list.layout()),
            remarks: self.remarks.clone(),
            ..About::new("fluid", Reach::Pairs)
        }
    }

    fn prepare(&mut self, at: &StateView<'_, V>, executor: &Executor) -> Result<()> {
        self.solids.place(frames(at));
        self.search(&|axis, index| at.exact_position(axis, index), executor)?;
        self.sum_density(&at.velocity, executor)?;
        let Self { summation, tension, surface, walls, neighbor_list, records, obstacles, .. } = self;
        let Self { materials, fluids, kind, mass, density, solids, .. } = self;
        if let Some(tension) = tension {
            let rest = |member: usize| mass[member] / materials.rest_density(kind[member]);
            tension.update((neighbor_list, records), walls, kind, &rest, executor);
        }
        let summed = summation.is_some();
        let meets_obstacles = !obstacles.is_empty();
        let each = |member: usize| {
            let (density, rest) = (density[member], materials.rest_density(kind[member]));
            let pressure = fluids.get(usize::from(kind[member])).map_or(0.0, |fluid| fluid.pressure(density));
            let both = if summed {
                [mass[member] / rest, pressure * (rest / density).powi(2)]
            } else {
                [mass[member] / density, pressure]
            };
            let [volume, pressure] = both.map(V::Scalar::from_f64);
            [volume, if meets_obstacles { pressure.tagged(surface.wall_factors[member].tag()) } else { pressure }]
        };
        fill(records, (neighbor_list, kind), &solids.velocities(&at.velocity), &each, executor);
        if surface.is_stale {
            surface.update((neighbor_list, records), walls, (fluids, kind), density, executor);
        }
        obstacles.extrapolate_pressure(neighbor_list, records, executor);
        let Self { surface, neighbor_list, records, momentum, forces, walls, .. } = self;
        let neighbors = neighbor_list.neighbors();
        records.sum(neighbors, *momentum, forces, executor);
        if !walls.is_empty() {
            for (wall_factor, &slot) in
                surface.wall_factors.iter().zip(neighbors.slots()).filter(|(wall_factor, _)| wall_factor.kick() < 1.0)
            {
                records.write(slot as usize, |words| words[V::DIMENSION + 1] *= V::Scalar::from_f64(wall_factor.kick().into()));
            }
        }
        self.strongest = None;
        self.press(at.time, executor);
        self.load_solids();
        Ok(())
    }

    fn accumulate(&self, block: Range<usize>, _at: &StateView<'_, V>, rates: &mut Rates<'_, V>) {
        self.accumulate_solids(&block, rates);
        for (index, member, slot) in self.neighbor_list.in_block(block) {
            let (volume, force) = (self.volume(member), &self.forces[slot]);
            for axis in 0..V::DIMENSION {
                rates.force.axes[axis][index] += V::Scalar::from_f64(volume) * force[axis];
            }
            if let Some(tension) = &self.tension {
                let volume = V::Scalar::from_f64(self.rest_volume(member));
                for (axis, &force) in tension.force(slot)[..V::DIMENSION].iter().enumerate() {
                    rates.force.axes[axis][index] += volume * force;
                }
            }
            // Each particle accounts for half of the power of a pair.
            rates.power[EnergySink::Viscosity as usize][index % LANES] -= 0.5 * volume * force[VISCOUS].to_f64();
            rates.power[EnergySink::Contact as usize][index % LANES] += volume * force[SOLID].to_f64();
        }
    }

    fn meets_solids(&self) -> bool {
        self.solids.count() > 0
    }

    fn torques(&self, torques: &mut [DVec3]) {
        self.solids.add_torques(torques);
    }

    fn energy(&self, at: &StateView<'_, V>, ledger: &mut Ledger) -> Result<()> {
        if let Some(tension) = &self.tension {
            ledger.add(Class::Potential, "surface tension", self.tension_energy(tension, at)?);
        }
        let energy = |member: usize| {
            let fluid = self.fluid(self.kind[member]);
            fluid.map_or(0.0, |fluid| fluid.material.mass * fluid.energy(self.density[member]))
        };
        ledger.add(Class::Internal, "fluid", (0..self.kind.len()).map(energy).sum());
        Ok(())
    }

    fn bound(&self, _at: &StateView<'_, V>, bound: &mut SpectralBound) -> Result<()> {
        self.limit(bound);
        Ok(())
    }

    fn validity(&self, _at: &StateView<'_, V>, _horizon: Horizon) -> Validity {
        Validity::Now
    }

    fn fluid(&self) -> Option<&dyn FluidScheme<V>> {
        Some(self)
    }

    fn fluid_mut(&mut self) -> Option<&mut dyn FluidScheme<V>> {
        Some(self)
    }
}

/// Force density from sums of [`Momentum`] [N/m^D].
pub(super) fn force_density<V: Vector>(sums: &[V::Scalar; FORCES]) -> DVec3 {
    V::from_axes(|axis| sums[axis]).widen()
}

impl<V: Vector, K: KernelShape, const MIXED: bool> WeaklyCompressible<V, K, MIXED> {
    /// Energy of surface tension [J]. Separate lists are used, because the last sums are not always those of the state.
    fn tension_energy(&self, tension: &Tension<V, K, MIXED>, at: &StateView<'_, V>) -> Result<f64> {
        let executor = at.executor;
        let samples = self.solids.positions(frames(at));
        let position = |axis: usize, index: usize| {
            self.solids.sample(index).map_or_else(|| at.exact_position(axis, index), |sample| samples[sample][axis])
        };
        let neighbor_list = self.neighbor_list.anew(&position, executor)?;
        let (walls, mut records) = (self.walls.anew(&neighbor_list, executor), Records::new(neighbor_list.neighbors()));
        Ok(tension.energy((&neighbor_list, &mut records), &walls, &self.kind, &|member| self.rest_volume(member), executor))
    }

    /// Adds the forces from walls, and reads the gauges.
    fn press(&mut self, time: f64, executor: &Executor) {
        let Some(mut gauges) = self.gauges.take() else { return };
        gauges.begin(time);
        let slots = self.neighbor_list.neighbors().slots();
        let force = |member: usize| force_density::<V>(&self.forces[slots[member] as usize]);
        gauges.sum_obstacles(&|member| self.volume(member) * force(member), executor);
        self.add_walls(&mut gauges, executor);
        let pressure = |member: usize| self.fluid(self.kind[member]).map_or(0.0, |fluid| fluid.pressure(self.density[member]));
        let flow = SurroundingFluid {
            neighbor_list: &self.neighbor_list,
            materials: &self.materials,
            kind: &self.kind,
            state: |member: usize| (self.volume(member), pressure(member)),
        };
        gauges.read(self.momentum.kernel.shape, &flow, executor);
        self.gauges = Some(gauges);
    }

    /// Adds the forces from walls, and the opposite forces of fluid particles on walls to the gauges.
    fn add_walls(&mut self, gauges: &mut Gauges, executor: &Executor) {
        let mut forces = std::mem::take(&mut self.forces);
        let condition = WallCondition { weight: self.materials.first().gravity, no_slip: true };
        let (numbers, instruments) = gauges.on_walls();
        let order = self.neighbor_list.neighbors().order();
        let note = |numbers: &mut [f64], mirrors: &Mirrors, more: &[V::Scalar; FORCES]| {
            let member = order[mirrors.slot] as usize;
            // Forces of fluid images on an obstacle are not forces of the fluid on the wall.
            if self.kind[member] != OBSTACLE {
                instruments.add(self.momentum.kernel.shape, numbers, mirrors, -self.volume(member) * force_density::<V>(more));
            }
        };
        let lists = (&self.neighbor_list, &self.records);
        self.walls.add_noting(self.momentum.untagged(), &condition, lists, &mut forces, (numbers, &note), executor);
        self.forces = forces;
    }
}
