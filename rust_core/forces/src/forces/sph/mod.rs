//! Weakly compressible fluids: smoothed particle hydrodynamics.
//!
//! Density is a state variable. A step of drifts and kicks has a pair sum for each. The continuity equation advances density in
//! the middle of a drift ([`DensityEvolution::drift`]). Pressure forces act at each kick ([`Force::prepare`]). Density and
//! velocity alternate like position and velocity. A kick–drift–kick step may therefore be as long as that of a leapfrog: 2/ω for
//! the fastest sound wave, twice the limit for simultaneous rates.
//!
//! For density by summation ([`summation`]) both sums are evaluated at the kick, with any integrator.
//!
//! The pair laws are in [`laws`], the smoothing kernels in [`kernel`], and the mirror images behind walls in [`walls`]. The
//! detection of free surfaces is in [`surface`], and surface tension in [`tension`]. Particle shifting ([`shifting`]) restores
//! even particle distributions. Gauges ([`gauges`]) measure pressures and the forces on walls. The parameters of the scene are
//! completed in [`start`], and the force is constructed in [`assembly`].

use std::ops::Range;

use glam::DVec3;

use super::neighbor_list::NeighborList;
use super::{
    About, DensityEvolution, DensityScheme, Drift, Fields, Force, Mach, Rates, Reach, StateView, Validity, VelocityDependence,
};
use crate::error::Result;
use crate::history::{Archive, History};
use crate::ledger::{Class, Ledger};
use crate::math::{Real, Vector};
use crate::matter::{self, EnergySink, Power, Properties, Span};
use crate::neighbors::sums::Records;
use crate::parallel::{BlockedSlice, Executor};
use crate::scene::{self, Scene};
use crate::simd::LANES;
use crate::stability::{Horizon, SpectralBound};

mod assembly;
mod gauges;
mod images;
mod kernel;
mod laws;
mod limits;
mod shifting;
mod start;
mod summation;
mod surface;
mod tension;
mod walls;

pub use gauges::Gauges;
use gauges::SurroundingFluid;
use images::WallCondition;
use kernel::{FluidWave, KernelShape, OtherShape, WendlandC2};
use laws::{Continuity, Extrapolation, FORCES, Momentum, OBSTACLE, RATES, SOLID, VISCOUS};
use shifting::Shifting;
pub use start::KIND;
use start::Materials;
use summation::Summation;
use surface::FreeSurface;
use tension::Tension;
use walls::{FluidWalls, Mirrors};

/// Slots in a block of the passes over single particles.
const BLOCK: usize = 1024;

/// Force of the fluids of a scene and their obstacles.
///
/// # Errors
/// If their parameters are inconsistent, or there is no kernel of that name.
pub fn fluid<V: Vector>(scene: &Scene, properties: &Properties<V>, executor: &Executor) -> Result<Option<Box<dyn Force<V>>>> {
    let Some((_, fluid)) = start::fluids(scene).next() else { return Ok(None) };
    let materials = Materials::of(scene)?;
    let kernel = start::method(fluid)?.record("kernel")?;
    match kernel.kind.as_str() {
        "WendlandC2" if !materials.are_mixed() => with::<V, _, false>(WendlandC2, scene, properties, materials, executor),
        "WendlandC2" => with::<V, _, true>(WendlandC2, scene, properties, materials, executor),
        "WendlandC4" => with::<V, _, true>(OtherShape::WendlandC4, scene, properties, materials, executor),
        "CubicSpline" => with::<V, _, true>(OtherShape::CubicSpline, scene, properties, materials, executor),
        _ => Err(scene::unknown(kernel, "WendlandC2, WendlandC4 or CubicSpline")),
    }
}

/// Whether a scene has a fluid.
#[inline]
pub fn is_in(scene: &Scene) -> bool {
    start::fluids(scene).next().is_some()
}

fn with<V: Vector, K, const MIXED: bool>(
    shape: K,
    scene: &Scene,
    properties: &Properties<V>,
    materials: Materials,
    executor: &Executor,
) -> Result<Option<Box<dyn Force<V>>>>
where
    K: KernelShape,
{
    Ok(Some(Box::new(Fluids::<V, K, MIXED>::new(shape, scene, properties, materials, executor)?)))
}

/// Writes the records of the pair laws: the velocity, and the volume and second word returned by `each` for a member.
fn fill<V: Vector>(
    records: &mut Records<V>,
    (neighbor_list, kind): (&NeighborList, &[u8]),
    velocity: &matter::View<'_, V>,
    each: &(impl Fn(usize) -> [V::Scalar; 2] + Sync),
    executor: &Executor,
) {
    let members = neighbor_list.members();
    records.fill(neighbor_list.neighbors(), neighbor_list.positions(), executor, &|member, record| {
        let index = members[member] as usize;
        for axis in 0..V::DIMENSION {
            record[V::DIMENSION + axis] = velocity.axis(axis)[index];
        }
        let [volume, content] = each(member);
        record[2 * V::DIMENSION] = volume.tagged(kind[member]);
        record[2 * V::DIMENSION + 1] = content;
    });
}

/// Force on the particles of all fluids and obstacles.
struct Fluids<V: Vector, K, const MIXED: bool> {
    materials: Materials,
    /// Material of each member.
    kind: Vec<u8>,
    /// Mass m of each member [kg]; for an obstacle, the mass of the fluid in its volume.
    mass: Vec<f64>,
    /// Density ρ of each member [kg/m³].
    density: Vec<f64>,
    /// Energy dissipated by diffusion in the last drift, of each member [J].
    diffused: Vec<f64>,
    /// Density at the start of the batch [kg/m³].
    saved_density: Vec<f64>,
    /// The members that are obstacles.
    obstacles: Vec<u32>,
    /// Sums of [`Extrapolation`] for each obstacle particle.
    extrapolated: Vec<[V::Scalar; 2]>,
    neighbor_list: NeighborList,
    records: Records<V>,
    continuity: Continuity<V::Scalar, K, MIXED>,
    momentum: Momentum<V::Scalar, K, MIXED>,
    extrapolation: Extrapolation<V::Scalar, K>,
    /// Density by summation, if that is the scheme.
    summation: Option<Summation<V, K>>,
    /// Surface tension, if a fluid has it.
    tension: Option<Tension<V, K, MIXED>>,
    /// Particle shifting, if enabled.
    shifting: Option<Shifting<V, K>>,
    /// Sums of [`Continuity`] by slot: over particles, and over their images if there are walls.
    rates: Vec<[V::Scalar; RATES]>,
    mirrored: Vec<[V::Scalar; RATES]>,
    /// Sums of [`Momentum`] by slot: force and power densities.
    forces: Vec<[V::Scalar; FORCES]>,
    walls: FluidWalls,
    /// Gauges, if there are any.
    gauges: Option<Gauges>,
    surface: FreeSurface<V, K>,
    /// Waves resolved by the kernel, for unit smoothing length.
    waves: Vec<FluidWave>,
    /// Largest force density [N/m^D] if the present sums are not those of the state, and its value at the start of the batch.
    strongest: Option<f64>,
    saved_strongest: f64,
}

impl<V: Vector, K: KernelShape, const MIXED: bool> Fluids<V, K, MIXED> {
    /// Writes the pressure extrapolated from the fluid to the records of obstacles.
    fn extrapolate_pressure(&mut self, executor: &Executor) {
        let Self { obstacles, extrapolated, neighbor_list, records, extrapolation, .. } = self;
        let (neighbors, before) = (neighbor_list.neighbors(), &*records);
        executor.for_each_block(BlockedSlice::new(extrapolated, BLOCK), &|mine| {
            let end = mine.start + mine.items.len();
            let mut extrapolated = mine.items.iter_mut();
            let slots = obstacles[mine.start..end].iter().map(|&obstacle| neighbors.slots()[obstacle as usize] as usize);
            let few = slots.map(|slot| (slot, neighbors.list(slot), ()));
            before.sum_few(
                few,
                |()| *extrapolation,
                |_, sums| extrapolated.next().into_iter().for_each(|extrapolated| *extrapolated = sums),
            );
        });
        for (&obstacle, &[pressed, weight]) in obstacles.iter().zip(&*extrapolated) {
            // Negative pressures are cut off, because obstacles exert no suction.
            let pressure = if weight > V::Scalar::ZERO && pressed > V::Scalar::ZERO { pressed / weight } else { V::Scalar::ZERO };
            records.write(neighbors.slots()[obstacle as usize] as usize, |words| words[V::DIMENSION + 1] = pressure);
        }
    }

    /// Volume V of a member [m^D]; for density by summation, its rest volume.
    fn volume(&self, member: usize) -> f64 {
        let summed = self.summation.is_some();
        self.mass[member] / if summed { self.materials.rest_density(self.kind[member]) } else { self.density[member] }
    }

    /// Updates density by summation, if that is the scheme.
    fn sum_density(&mut self, velocity: &matter::View<'_, V>, executor: &Executor) -> Result<()> {
        let Self { summation, neighbor_list, records, walls, materials, kind, mass, density, .. } = self;
        let Some(summation) = summation else { return Ok(()) };
        let rest = |member: usize| [V::Scalar::from_f64(mass[member] / materials.rest_density(kind[member])), V::Scalar::ZERO];
        fill(records, (neighbor_list, kind), velocity, &rest, executor);
        summation.count((neighbor_list, records), walls, (materials, kind), density, executor)
    }

    /// Rest volume V₀ of a member [m^D].
    fn rest_volume(&self, member: usize) -> f64 {
        self.mass[member] / self.materials.rest_density(self.kind[member])
    }

    /// Updates the neighbor lists, and with them the lists of images.
    fn search(&mut self, position: &(impl Fn(usize, usize) -> f64 + Sync), executor: &Executor) -> Result<()> {
        let resumed = self.neighbor_list.resume(executor)?;
        if resumed {
            self.walls.declare(&mut self.neighbor_list, executor);
        }
        let renewed = self.neighbor_list.update(position, executor)?;
        if renewed {
            self.walls.declare(&mut self.neighbor_list, executor);
        }
        if resumed || renewed {
            self.walls.update(&self.neighbor_list, executor);
        }
        self.surface.is_stale |= renewed;
        Ok(())
    }

    /// Energy of surface tension [J]. Separate lists are used, because the last sums are not always those of the state.
    fn tension_energy(&self, tension: &Tension<V, K, MIXED>, at: &StateView<'_, V>) -> Result<f64> {
        let executor = at.executor;
        let neighbor_list = self.neighbor_list.anew(&|axis, index| at.exact_position(axis, index), executor)?;
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
        let pressure =
            |member: usize| self.materials.fluid(self.kind[member]).map_or(0.0, |fluid| fluid.pressure(self.density[member]));
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

    /// Memory [bytes].
    fn bytes(&self) -> usize {
        let rates = std::mem::size_of_val(self.rates.as_slice()) + std::mem::size_of_val(self.mirrored.as_slice());
        let own = rates + std::mem::size_of_val(self.forces.as_slice());
        let numbers = 4 * size_of::<f64>() * self.density.len();
        let indices = size_of::<u32>() * self.obstacles.len() + self.kind.len();
        let counts = self.summation.as_ref().map_or(0, Summation::bytes);
        let pulls = self.tension.as_ref().map_or(0, Tension::bytes) + self.shifting.as_ref().map_or(0, Shifting::bytes);
        let parts = self.neighbor_list.bytes() + self.records.bytes() + self.walls.bytes() + self.surface.bytes();
        counts + pulls + parts + own + numbers + indices + self.gauges.as_ref().map_or(0, Gauges::bytes)
    }
}

impl<V: Vector, K: KernelShape, const MIXED: bool> History for Fluids<V, K, MIXED> {
    fn save(&mut self) {
        self.neighbor_list.save();
        self.saved_density.copy_from_slice(&self.density);
        self.surface.save();
        self.gauges.iter_mut().for_each(History::save);
        self.saved_strongest = self.strongest();
    }

    fn rollback(&mut self) {
        self.density.copy_from_slice(&self.saved_density);
        self.surface.rollback();
        self.gauges.iter_mut().for_each(History::rollback);
        self.strongest = Some(self.saved_strongest);
        self.neighbor_list.rollback();
    }

    fn capture(&self, archive: &mut Archive) {
        archive.write("densities", self.density.iter().copied());
        archive.write("strongest", [self.strongest()]);
        archive.within("surface", |archive| self.surface.capture(archive));
        self.gauges.iter().for_each(|gauges| archive.within("gauges", |archive| gauges.capture(archive)));
        self.neighbor_list.capture(archive);
    }

    fn restore(&mut self, archive: &mut Archive) -> Result<()> {
        archive.read_into("densities", &mut self.density)?;
        self.strongest = Some(archive.read_number("strongest")?);
        archive.within("surface", |archive| self.surface.restore(archive))?;
        self.gauges.iter_mut().try_for_each(|gauges| archive.within("gauges", |archive| gauges.restore(archive)))?;
        self.neighbor_list.restore(archive)
    }
}

impl<V: Vector, K: KernelShape, const MIXED: bool> DensityEvolution<V> for Fluids<V, K, MIXED> {
    fn scheme(&self) -> DensityScheme {
        if self.summation.is_some() { DensityScheme::Summation } else { DensityScheme::Continuity }
    }

    fn sum(&mut self, at: &StateView<'_, V>, executor: &Executor) -> Result<()> {
        if self.summation.is_none() {
            return Ok(());
        }
        self.search(&|axis, index| at.exact_position(axis, index), executor)?;
        self.sum_density(&at.velocity, executor)
    }

    /// Advances the density by ρ ← ρ + h dρ/dt, with positions and velocities at the midpoint of the drift.
    fn drift(&mut self, drift: &Drift<'_, V>, executor: &Executor) -> Result<()> {
        self.search(&|axis, index| drift.midpoint(axis, index), executor)?;
        let Self { materials, kind, mass, density, diffused, neighbor_list, records, surface, shifting, .. } = self;
        let Self { continuity, rates, mirrored, walls, .. } = self;
        let each = |member: usize| {
            let enthalpy = materials.fluid(kind[member]).map_or(0.0, |fluid| fluid.enthalpy(density[member]));
            [mass[member] / density[member], enthalpy].map(V::Scalar::from_f64)
        };
        fill(records, (neighbor_list, kind), &drift.velocity, &each, executor);
        let neighbors = neighbor_list.neighbors();
        records.sum(neighbors, *continuity, rates, executor);
        let common = materials.first();
        let condition = WallCondition { weight: common.gravity / common.sound_speed.powi(2), no_slip: false };
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
                let Some(fluid) = materials.fluid(kind[member]) else { continue };
                let slot = slots[member] as usize;
                let [squeeze, diffusion, by_obstacles] = rates[slot].map(Real::to_f64);
                let [by_fluid, through_walls, by_solid] = mirrored.get(slot).map_or([0.0; RATES], |sums| sums.map(Real::to_f64));
                let by_walls = by_fluid + by_solid + by_obstacles;
                let evened = diffusion + through_walls;
                let change = drift.h * (*density * (squeeze + f64::from(wall_factor.drift()) * by_walls) + evened);
                // The work of diffusion against pressure is dissipated.
                let middle = *density + 0.5 * change;
                *lost = -drift.h * fluid.mass * fluid.pressure(middle) / (middle * middle) * evened;
                *density += change;
                wall_factor.drifted(*density < fluid.density, by_walls <= 0.0);
            }
        });
        Ok(())
    }

    fn dissipated(&self, block: Range<usize>, energy: &mut Power) {
        for (index, member, _) in self.neighbor_list.in_block(block) {
            energy[EnergySink::Viscosity as usize][index % LANES] += self.diffused[member];
        }
    }

    fn shifts(&self) -> bool {
        self.shifting.is_some()
    }

    fn shift(&self, block: Range<usize>, displacements: &mut Span<'_, V>) {
        let Some(shifting) = &self.shifting else { return };
        for (index, member, slot) in self.neighbor_list.in_block(block) {
            if self.kind[member] != OBSTACLE {
                displacements.set(index, displacements.get(index) + shifting.displacement(slot));
            }
        }
    }

    fn mach(&self, velocity: matter::View<'_, V>) -> Mach {
        self.speed(velocity)
    }

    fn gauges(&self) -> Option<&Gauges> {
        self.gauges.as_ref()
    }

    fn export(&self, fields: &mut Fields) {
        for (member, &index) in self.neighbor_list.members().iter().enumerate() {
            if let Some(fluid) = self.materials.fluid(self.kind[member]) {
                fields.density[index as usize] = self.density[member];
                fields.pressure[index as usize] = fluid.pressure(self.density[member]);
            }
        }
    }
}

impl<V: Vector, K: KernelShape, const MIXED: bool> Force<V> for Fluids<V, K, MIXED> {
    /// Volumes and enthalpies are those at the beginning of the drift, so that continuity is of order 1.
    fn about(&self) -> About {
        let viscous = self.materials.fluids.iter().any(|fluid| fluid.artificial() > 0.0 || fluid.viscosity > 0.0);
        let continuity = self.scheme() == DensityScheme::Continuity;
        let shifts =
            self.shifting.as_ref().map_or_else(String::new, |shifting| format!("shifted by A = {}; ", shifting.coefficient()));
        About {
            velocity: if viscous || continuity { VelocityDependence::Dissipative } else { VelocityDependence::None },
            order: if continuity { 1 } else { u32::MAX },
            potential: self.tension.as_ref().map(|_| "surface tension"),
            pairs: 2 * self.neighbor_list.pairs(),
            bytes: self.bytes(),
            layout: format!("sound at {:.4} m/s; {shifts}{}", self.materials.first().sound_speed, self.neighbor_list.layout()),
            remarks: self.materials.remarks.clone(),
            ..About::new("fluid", Reach::Pairs)
        }
    }

    fn prepare(&mut self, at: &StateView<'_, V>, executor: &Executor) -> Result<()> {
        self.search(&|axis, index| at.exact_position(axis, index), executor)?;
        self.sum_density(&at.velocity, executor)?;
        let Self {
            summation, tension, surface, walls, neighbor_list, records, materials, kind, mass, density, obstacles, ..
        } = self;
        if let Some(tension) = tension {
            let rest = |member: usize| mass[member] / materials.rest_density(kind[member]);
            tension.update((neighbor_list, records), walls, kind, &rest, executor);
        }
        let summed = summation.is_some();
        let meets_obstacles = !obstacles.is_empty();
        let each = |member: usize| {
            let (density, rest) = (density[member], materials.rest_density(kind[member]));
            let pressure = materials.fluid(kind[member]).map_or(0.0, |fluid| fluid.pressure(density));
            let both = if summed {
                [mass[member] / rest, pressure * (rest / density).powi(2)]
            } else {
                [mass[member] / density, pressure]
            };
            let [volume, pressure] = both.map(V::Scalar::from_f64);
            [volume, if meets_obstacles { pressure.tagged(surface.wall_factors[member].tag()) } else { pressure }]
        };
        fill(records, (neighbor_list, kind), &at.velocity, &each, executor);
        if surface.is_stale {
            surface.update((neighbor_list, records), walls, (materials, kind), density, executor);
        }
        self.extrapolate_pressure(executor);
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
        Ok(())
    }

    fn accumulate(&self, block: Range<usize>, _at: &StateView<'_, V>, rates: &mut Rates<'_, V>) {
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

    fn energy(&self, at: &StateView<'_, V>, ledger: &mut Ledger) -> Result<()> {
        if let Some(tension) = &self.tension {
            ledger.add(Class::Potential, "surface tension", self.tension_energy(tension, at)?);
        }
        let energy = |member: usize| {
            let fluid = self.materials.fluid(self.kind[member]);
            fluid.map_or(0.0, |fluid| fluid.mass * fluid.energy(self.density[member]))
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

    fn density(&self) -> Option<&dyn DensityEvolution<V>> {
        Some(self)
    }

    fn density_mut(&mut self) -> Option<&mut dyn DensityEvolution<V>> {
        Some(self)
    }
}

/// Force density from sums of [`Momentum`] [N/m^D].
fn force_density<V: Vector>(sums: &[V::Scalar; FORCES]) -> DVec3 {
    V::from_axes(|axis| sums[axis]).widen()
}
