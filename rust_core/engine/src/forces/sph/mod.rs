//! Weakly compressible fluids: smoothed particle hydrodynamics.
//!
//! Density is a field of its own, which changes with the motion. A step of kick–drift–kick has two sums over neighbors: in
//! the middle of the drift density is advanced by the motion ([`Force::drift`]), and at its end the pressures push
//! ([`Force::prepare`]). Density and velocity so take turns like position and velocity, and the step may be as long as that
//! of a leapfrog: 2/ω for the fastest sound wave, twice as long as where both rates are taken at one moment.
//!
//! [`laws`] holds the sums, [`kernel`] what they weigh with, [`images`] the walls, [`start`] what the scene leaves open.

use std::ops::Range;

use super::vicinity::Vicinity;
use super::{Drift, Fields, Force, Moment, Rates, Reach, VelocityDependence};
use crate::error::{Error, Result};
use crate::math::{Real, Vector};
use crate::matter::{Channel, Properties};
use crate::neighbors::sums::Records;
use crate::parallel::{Chunks, Crew};
use crate::scene::Scene;
use crate::simd::LANES;
use crate::stability::Bound;

mod images;
mod kernel;
mod laws;
mod start;

use images::{View, Walls};
use kernel::{CubicSpline, Kernel, Shape, Wave, WendlandC2, WendlandC4};
use laws::{Continuity, FORCES, LIFT, Momentum, VISCOUS};
use start::Material;

/// Places in a block of the passes over single particles.
const BLOCK: usize = 1024;

/// Stands for the slot of a particle that is no fluid.
const NOBODY: u32 = u32::MAX;

/// The fluid of a scene.
///
/// # Errors
/// If its parameters make no sense together, or there is no kernel of that name.
pub fn fluid<V: Vector>(scene: &Scene, properties: &Properties<V>) -> Result<Option<Box<dyn Force<V>>>> {
    let Some(body) = scene.bodies.iter().position(|body| body.fluid.is_some()) else { return Ok(None) };
    let name = scene.bodies[body].fluid.as_ref().map_or("", |fluid| fluid.kernel.as_str());
    match name {
        "WendlandC2" => Ok(Some(Box::new(Fluid::<V, WendlandC2>::new(scene, properties)?))),
        "WendlandC4" => Ok(Some(Box::new(Fluid::<V, WendlandC4>::new(scene, properties)?))),
        "CubicSpline" => Ok(Some(Box::new(Fluid::<V, CubicSpline>::new(scene, properties)?))),
        other => Err(Error::parameter(format!("bodies[{body}].kernel"), "WendlandC2, WendlandC4 or CubicSpline", other)),
    }
}

/// All fluid particles of a scene.
struct Fluid<V: Vector, K> {
    material: Material,
    /// The fluid particles, by their index.
    members: Vec<u32>,
    /// The member that each particle is.
    slots: Vec<u32>,
    /// Density ρ of each member [kg/m³].
    density: Vec<f64>,
    /// The power that diffusion takes from each [W].
    diffused: Vec<f64>,
    /// Density when the chunk began.
    kept: Vec<f64>,
    vicinity: Vicinity,
    records: Records<V>,
    continuity: Continuity<V::Scalar, K>,
    momentum: Momentum<V::Scalar, K>,
    /// What [`Continuity`] gives, in the order of places.
    rates: Vec<[V::Scalar; 2]>,
    /// What [`Momentum`] gives, likewise.
    forces: Vec<[V::Scalar; FORCES]>,
    walls: Walls,
    /// The waves that the kernel carries, for unit smoothing length.
    waves: Vec<Wave>,
}

impl<V: Vector, K: Shape<V::Scalar> + Shape<f64>> Fluid<V, K> {
    fn new(scene: &Scene, properties: &Properties<V>) -> Result<Self> {
        let material = Material::of(scene)?;
        let is_fluid = |index: &u32| scene.bodies[properties.body[*index as usize] as usize].fluid.is_some();
        let members: Vec<u32> = (0..properties.count() as u32).filter(is_fluid).collect();
        let mut slots = vec![NOBODY; properties.count()];
        members.iter().zip(0..).for_each(|(&index, slot)| slots[index as usize] = slot);
        let h = material.smoothing_length;
        let vicinity = Vicinity::new(scene, properties, &members, 2.0 * h)?;
        let walls = Walls::new(start::walls(scene, properties.origin)?, 2.0 * h);
        let number = V::Scalar::from_f64;
        let gravity = material.gravity.to_array();
        let kernel = Kernel::new(h, material.spacing, V::DIMENSION);
        let continuity = Continuity {
            kernel,
            diffusion: number(material.diffusion()),
            stratification: gravity.map(|g| number(material.density * g / material.sound_speed.powi(2))),
        };
        let momentum = Momentum {
            kernel,
            artificial: number(material.artificial()),
            laminar: number(2.0 * material.viscosity),
            softening: number(0.01 * h * h),
        };
        let density = start::densities(scene, properties, &members, &material);
        Ok(Self {
            kept: density.clone(),
            diffused: vec![0.0; members.len()],
            records: Records::new(vicinity.neighbors()),
            rates: vec![[V::Scalar::ZERO; 2]; members.len()],
            forces: vec![[V::Scalar::ZERO; FORCES]; members.len()],
            waves: kernel::waves::<K>(V::DIMENSION),
            material,
            members,
            slots,
            density,
            vicinity,
            continuity,
            momentum,
            walls,
        })
    }

    /// Brings lists up to date, and with them who is near a wall.
    fn search(&mut self, place: &(impl Fn(usize, usize) -> f64 + Sync), crew: &Crew) -> Result<()> {
        if self.vicinity.update(place, &self.members, crew)? {
            self.walls.survey(&self.vicinity);
        }
        Ok(())
    }
}

impl<V: Vector, K: Shape<V::Scalar> + Shape<f64>> Force<V> for Fluid<V, K> {
    fn name(&self) -> &'static str {
        "fluid"
    }

    fn reach(&self) -> Reach {
        Reach::Pairs
    }

    fn velocity(&self) -> VelocityDependence {
        VelocityDependence::Dissipative
    }

    fn has_field(&self) -> bool {
        true
    }

    /// ρ ← ρ + h dρ/dt, in the middle of the way and at the velocity of the way.
    fn drift(&mut self, drift: &Drift<'_, V>, crew: &Crew) -> Result<()> {
        self.search(&|axis, index| drift.middle(axis, index), crew)?;
        let Self { members, density, diffused, vicinity, records, continuity, rates, material, walls, .. } = self;
        let neighbors = vicinity.neighbors();
        records.fill(neighbors, vicinity.positions(), crew, &|member, record| {
            let index = members[member] as usize;
            for axis in 0..V::DIMENSION {
                record[V::DIMENSION + axis] = drift.velocity.axis(axis)[index];
            }
            record[2 * V::DIMENSION] = V::Scalar::from_f64(material.mass / density[member]);
            record[2 * V::DIMENSION + 1] = V::Scalar::from_f64(material.enthalpy(density[member]));
        });
        records.sum(neighbors, *continuity, rates, crew);
        let view = View { weight: material.density / material.sound_speed.powi(2) * material.gravity, sticks: false };
        walls.add(*continuity, &view, (vicinity, records), rates, crew);
        let places = vicinity.neighbors().places();
        crew.sweep((Chunks::new(density, BLOCK), Chunks::new(diffused, BLOCK)), &|(densities, powers)| {
            let places = &places[densities.start..];
            for ((density, power), &place) in densities.items.iter_mut().zip(powers.items).zip(places) {
                let [squeeze, diffusion] = rates[place as usize].map(Real::to_f64);
                let change = drift.h * (*density * squeeze + diffusion);
                // What diffusion moves against pressure is gone at once.
                let middle = *density + 0.5 * change;
                *power = -material.mass * material.pressure(middle) / (middle * middle) * diffusion;
                *density += change;
            }
        });
        Ok(())
    }

    fn prepare(&mut self, at: &Moment<'_, V>, crew: &Crew) -> Result<()> {
        self.search(&|axis, index| at.place(axis, index), crew)?;
        let Self { members, density, vicinity, records, momentum, forces, material, walls, .. } = self;
        let neighbors = vicinity.neighbors();
        records.fill(neighbors, vicinity.positions(), crew, &|member, record| {
            let index = members[member] as usize;
            for axis in 0..V::DIMENSION {
                record[V::DIMENSION + axis] = at.velocity.axis(axis)[index];
            }
            record[2 * V::DIMENSION] = V::Scalar::from_f64(material.mass / density[member]);
            record[2 * V::DIMENSION + 1] = V::Scalar::from_f64(material.pressure(density[member]));
        });
        records.sum(neighbors, *momentum, forces, crew);
        let view = View { weight: material.density * material.gravity, sticks: true };
        walls.add(*momentum, &view, (vicinity, records), forces, crew);
        Ok(())
    }

    fn keep(&mut self) {
        self.vicinity.keep();
        self.kept.copy_from_slice(&self.density);
    }

    fn undo(&mut self) -> Result<()> {
        self.density.copy_from_slice(&self.kept);
        self.vicinity.undo()?;
        self.walls.survey(&self.vicinity);
        Ok(())
    }

    fn capture(&self) -> Vec<f64> {
        [self.density.clone(), self.vicinity.capture()].concat()
    }

    fn restore(&mut self, numbers: &mut &[f64]) -> Result<()> {
        super::vicinity::take(numbers, &mut self.density)?;
        self.vicinity.restore(numbers)?;
        self.walls.survey(&self.vicinity);
        Ok(())
    }

    fn accumulate(&self, block: Range<usize>, _at: &Moment<'_, V>, rates: &mut Rates<'_, V>) {
        let places = self.vicinity.neighbors().places();
        for (index, &slot) in self.slots[block.start..block.end.min(self.slots.len())].iter().enumerate() {
            if slot == NOBODY {
                continue;
            }
            let (density, place) = (self.density[slot as usize], places[slot as usize] as usize);
            let (volume, force) = (self.material.mass / density, &self.forces[place]);
            for axis in 0..V::DIMENSION {
                rates.force.axes[axis][index] += V::Scalar::from_f64(volume) * force[axis];
            }
            // Of a pair's power each takes half.
            let viscous = 0.5 * volume * force[VISCOUS].to_f64();
            rates.power[Channel::Viscosity as usize][index % LANES] += viscous + self.diffused[slot as usize];
            rates.power[Channel::Work as usize][index % LANES] += volume * force[LIFT].to_f64();
        }
    }

    fn has_potential(&self) -> bool {
        false
    }

    fn potential(&self, _block: Range<usize>, _at: &Moment<'_, V>) -> f64 {
        0.0
    }

    fn internal(&self) -> f64 {
        self.density.iter().map(|&density| self.material.mass * self.material.energy(density)).sum()
    }

    /// Of all waves that the kernel carries, the one with the shortest step: for kick–drift–kick with the force at the predicted
    /// velocity that is 2/(γ + √(γ² + ω²)), where diffusion counts with half its rate.
    fn bound(&self, at: &Moment<'_, V>, bound: &mut Bound) {
        let (material, h) = (&self.material, self.material.smoothing_length);
        let densest = self.density.iter().copied().fold(material.density, f64::max);
        let scaled = |wave: &Wave| {
            let viscous = (material.artificial() * wave.squeeze + 2.0 * material.viscosity * wave.decay) / material.density;
            let decay = (viscous + 0.5 * material.diffusion() * wave.decay) / (h * h);
            (material.sound_at(densest) * wave.frequency / h, decay)
        };
        let haste = |&(frequency, decay): &(f64, f64)| decay + decay.hypot(frequency);
        let binding = self.waves.iter().map(scaled).max_by(|one, other| haste(one).total_cmp(&haste(other)));
        let (frequency, decay) = binding.unwrap_or_default();
        for &index in &self.members {
            let mass = at.properties.mass[index as usize];
            bound.point(index as usize, "sound", mass * frequency * frequency, 0.0);
            bound.point(index as usize, "viscosity", 0.0, mass * decay);
        }
        let strongest = self.forces.iter().map(|force| force[..V::DIMENSION].iter().map(|f| f.to_f64().powi(2)).sum::<f64>());
        let acceleration = strongest.fold(0.0, f64::max).sqrt() / self.material.density;
        bound.accuracy("acceleration", (self.material.smoothing_length / acceleration).sqrt());
    }

    fn bound_varies(&self) -> bool {
        true
    }

    fn show(&self, fields: &mut Fields) {
        for (&index, &density) in self.members.iter().zip(&self.density) {
            fields.density[index as usize] = density;
            fields.pressure[index as usize] = self.material.pressure(density);
        }
    }

    fn pairs(&self) -> usize {
        2 * self.vicinity.pairs()
    }

    fn layout(&self) -> String {
        format!("sound at {:.4} m/s; {}", self.material.sound_speed, self.vicinity.layout())
    }

    fn bytes(&self) -> usize {
        let own = std::mem::size_of_val(self.rates.as_slice()) + std::mem::size_of_val(self.forces.as_slice());
        let numbers = 3 * size_of::<f64>() * self.density.len();
        let indices = size_of::<u32>() * (self.members.len() + self.slots.len());
        self.vicinity.bytes() + self.records.bytes() + self.walls.bytes() + own + numbers + indices
    }
}
