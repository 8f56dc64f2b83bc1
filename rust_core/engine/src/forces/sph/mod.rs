//! Weakly compressible fluids: smoothed particle hydrodynamics.
//!
//! Density is a field of its own, which changes with the motion. A step of kick–drift–kick has two sums over neighbors: in
//! the middle of the drift density is advanced by the motion ([`Force::drift`]), and at its end the pressures push
//! ([`Force::prepare`]). Density and velocity so take turns like position and velocity, and the step may be as long as that
//! of a leapfrog: 2/ω for the fastest sound wave, twice as long as where both rates are taken at one moment.
//!
//! Where density is counted from places ([`summation`]) both sums are at the end.
//!
//! [`laws`] holds the sums, [`kernel`] what they weigh with, [`walls`] their images behind walls; [`start`] finds what the scene
//! leaves open, and [`assembly`] puts the parts together. Particles that gather in strands can be spread again: [`shifting`].

use std::ops::Range;

use super::vicinity::Vicinity;
use super::{Drift, Fields, Flow, Force, Moment, Rates, Reach, VelocityDependence};
use crate::error::{Error, Result};
use crate::math::{Real, Vector};
use crate::matter::{self, Channel, Properties, Span};
use crate::neighbors::sums::Records;
use crate::parallel::{Chunks, Crew};
use crate::scene::Scene;
use crate::simd::LANES;
use crate::stability::Bound;

mod assembly;
mod images;
mod kernel;
mod laws;
mod shifting;
mod start;
mod summation;
mod walls;

use images::View;
use kernel::{CubicSpline, Shape, Wave, WendlandC2, WendlandC4};
use laws::{Continuity, Extrapolation, FORCES, LIFT, Momentum, OBSTACLE, VISCOUS};
use shifting::Shifting;
use start::Kinds;
use summation::Summation;
use walls::Walls;

/// Places in a block of the passes over single particles.
const BLOCK: usize = 1024;

/// The fluids of a scene, and the obstacles that they meet.
///
/// # Errors
/// If their parameters make no sense together, or there is no kernel of that name.
pub fn fluid<V: Vector>(scene: &Scene, properties: &Properties<V>) -> Result<Option<Box<dyn Force<V>>>> {
    let Some(body) = scene.bodies.iter().position(|body| body.fluid.is_some()) else { return Ok(None) };
    let kinds = Kinds::of(scene)?;
    match scene.bodies[body].fluid.as_ref().map_or("", |fluid| fluid.kernel.as_str()) {
        "WendlandC2" if !kinds.are_mixed() => with::<V, WendlandC2, false>(scene, properties, kinds),
        "WendlandC2" => with::<V, WendlandC2, true>(scene, properties, kinds),
        // The other kernels are not worth compiling twice.
        "WendlandC4" => with::<V, WendlandC4, true>(scene, properties, kinds),
        "CubicSpline" => with::<V, CubicSpline, true>(scene, properties, kinds),
        other => Err(Error::parameter(format!("bodies[{body}].kernel"), "WendlandC2, WendlandC4 or CubicSpline", other)),
    }
}

fn with<V: Vector, K, const MIXED: bool>(
    scene: &Scene,
    properties: &Properties<V>,
    kinds: Kinds,
) -> Result<Option<Box<dyn Force<V>>>>
where
    K: Shape<V::Scalar> + Shape<f64>,
{
    Ok(Some(Box::new(Fluids::<V, K, MIXED>::new(scene, properties, kinds)?)))
}

/// Writes what the laws read of every particle: velocity, and the volume and content that `each` gives for a member.
fn fill<V: Vector>(
    records: &mut Records<V>,
    (vicinity, kind): (&Vicinity, &[u8]),
    velocity: &matter::View<'_, V>,
    each: &(impl Fn(usize) -> [f64; 2] + Sync),
    crew: &Crew,
) {
    let members = vicinity.members();
    records.fill(vicinity.neighbors(), vicinity.positions(), crew, &|member, record| {
        let index = members[member] as usize;
        for axis in 0..V::DIMENSION {
            record[V::DIMENSION + axis] = velocity.axis(axis)[index];
        }
        let [volume, content] = each(member);
        record[2 * V::DIMENSION] = V::Scalar::from_f64(volume).tagged(kind[member]);
        record[2 * V::DIMENSION + 1] = V::Scalar::from_f64(content);
    });
}

/// All particles of fluids, and of the obstacles that they meet.
struct Fluids<V: Vector, K, const MIXED: bool> {
    kinds: Kinds,
    /// The kind of each member.
    kind: Vec<u8>,
    /// Mass of each member [kg]; of an obstacle, that of the fluid in its place.
    mass: Vec<f64>,
    /// Density ρ of each member [kg/m³].
    density: Vec<f64>,
    /// The power that diffusion takes from each [W].
    diffused: Vec<f64>,
    /// Density when the chunk began.
    kept: Vec<f64>,
    /// The members that are obstacles.
    obstacles: Vec<u32>,
    /// What [`Extrapolation`] gives for them.
    met: Vec<[V::Scalar; 2]>,
    vicinity: Vicinity,
    records: Records<V>,
    continuity: Continuity<V::Scalar, K, MIXED>,
    momentum: Momentum<V::Scalar, K, MIXED>,
    extrapolation: Extrapolation<V::Scalar, K>,
    /// Where density is counted instead of carried along.
    summation: Option<Summation<V, K>>,
    /// Where particles are moved to where there is room.
    shifting: Option<Shifting<V, K>>,
    /// What [`Continuity`] gives, in the order of places.
    rates: Vec<[V::Scalar; 2]>,
    /// What [`Momentum`] gives, likewise.
    forces: Vec<[V::Scalar; FORCES]>,
    walls: Walls,
    /// The waves that the kernel carries, for unit smoothing length.
    waves: Vec<Wave>,
}

impl<V: Vector, K: Shape<V::Scalar> + Shape<f64>, const MIXED: bool> Fluids<V, K, MIXED> {
    /// Presses on the obstacles, in the records, what the fluid around them does.
    fn press_obstacles(&mut self, crew: &Crew) {
        let Self { obstacles, met, vicinity, records, extrapolation, .. } = self;
        let (neighbors, before) = (vicinity.neighbors(), &*records);
        crew.sweep(Chunks::new(met, BLOCK), &|mine| {
            for (met, &obstacle) in mine.items.iter_mut().zip(&obstacles[mine.start..]) {
                let place = neighbors.places()[obstacle as usize] as usize;
                *met = before.sum_at(neighbors.list(place), extrapolation, place);
            }
        });
        for (&obstacle, &[pressed, weight]) in obstacles.iter().zip(&*met) {
            // A fluid does not pull, and is not pulled.
            let pressure = if weight > V::Scalar::ZERO && pressed > V::Scalar::ZERO { pressed / weight } else { V::Scalar::ZERO };
            records.write(neighbors.places()[obstacle as usize] as usize, |words| words[V::DIMENSION + 1] = pressure);
        }
    }

    /// The volume of a member [m^D]: that at rest where density is counted.
    fn volume(&self, member: usize) -> f64 {
        let counted = self.summation.is_some();
        self.mass[member] / if counted { self.kinds.rest_density(self.kind[member]) } else { self.density[member] }
    }

    /// Brings lists up to date, and with them who is near a wall.
    fn search(&mut self, place: &(impl Fn(usize, usize) -> f64 + Sync), crew: &Crew) -> Result<()> {
        if self.vicinity.update(place, crew)? {
            self.walls.survey(&self.vicinity, crew);
        }
        Ok(())
    }
}

impl<V: Vector, K: Shape<V::Scalar> + Shape<f64>, const MIXED: bool> Force<V> for Fluids<V, K, MIXED> {
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
        if self.summation.is_some() {
            return Ok(());
        }
        self.search(&|axis, index| drift.middle(axis, index), crew)?;
        let Self { kinds, kind, mass, density, diffused, vicinity, records, continuity, rates, walls, shifting, .. } = self;
        let each = |member: usize| {
            let enthalpy = kinds.fluid(kind[member]).map_or(0.0, |fluid| fluid.enthalpy(density[member]));
            [mass[member] / density[member], enthalpy]
        };
        fill(records, (vicinity, kind), &drift.velocity, &each, crew);
        let neighbors = vicinity.neighbors();
        records.sum(neighbors, *continuity, rates, crew);
        let common = kinds.first();
        let view = View { weight: common.gravity / common.sound_speed.powi(2), sticks: false };
        walls.add(*continuity, &view, (vicinity, records), rates, crew);
        if let Some(shifting) = shifting {
            shifting.survey((vicinity, records), walls, drift.h, crew);
        }
        let places = neighbors.places();
        crew.sweep((Chunks::new(density, BLOCK), Chunks::new(diffused, BLOCK)), &|(densities, powers)| {
            for (offset, (density, power)) in densities.items.iter_mut().zip(powers.items).enumerate() {
                let member = densities.start + offset;
                let Some(fluid) = kinds.fluid(kind[member]) else { continue };
                let [squeeze, diffusion] = rates[places[member] as usize].map(Real::to_f64);
                let change = drift.h * (*density * squeeze + diffusion);
                // What diffusion moves against pressure is gone at once.
                let middle = *density + 0.5 * change;
                *power = -fluid.mass * fluid.pressure(middle) / (middle * middle) * diffusion;
                *density += change;
            }
        });
        Ok(())
    }

    fn displaces(&self) -> bool {
        self.shifting.is_some()
    }

    fn displace(&self, block: Range<usize>, ways: &mut Span<'_, V>) {
        let Some(shifting) = &self.shifting else { return };
        for (index, member, place) in self.vicinity.in_block(block) {
            if self.kind[member] != OBSTACLE {
                ways.set(index, ways.get(index) + shifting.displacement(place));
            }
        }
    }

    fn prepare(&mut self, at: &Moment<'_, V>, crew: &Crew) -> Result<()> {
        self.search(&|axis, index| at.place(axis, index), crew)?;
        let Self { summation, vicinity, records, walls, kinds, kind, mass, density, .. } = self;
        if let Some(summation) = summation {
            let rest = |member: usize| [mass[member] / kinds.rest_density(kind[member]), 0.0];
            fill(records, (vicinity, kind), &at.velocity, &rest, crew);
            summation.count((vicinity, records), walls, (kinds, kind), density, crew)?;
        }
        let counted = summation.is_some();
        let each = |member: usize| {
            let (density, rest) = (density[member], kinds.rest_density(kind[member]));
            let pressure = kinds.fluid(kind[member]).map_or(0.0, |fluid| fluid.pressure(density));
            if counted { [mass[member] / rest, pressure * (rest / density).powi(2)] } else { [mass[member] / density, pressure] }
        };
        fill(records, (vicinity, kind), &at.velocity, &each, crew);
        self.press_obstacles(crew);
        let Self { kinds, vicinity, records, momentum, forces, walls, .. } = self;
        records.sum(vicinity.neighbors(), *momentum, forces, crew);
        let view = View { weight: kinds.first().gravity, sticks: true };
        walls.add(*momentum, &view, (vicinity, records), forces, crew);
        Ok(())
    }

    fn keep(&mut self) {
        self.vicinity.keep();
        self.kept.copy_from_slice(&self.density);
    }

    fn undo(&mut self) -> Result<()> {
        self.density.copy_from_slice(&self.kept);
        if self.vicinity.undo()? {
            self.walls.survey(&self.vicinity, &Crew::alone());
        }
        Ok(())
    }

    fn capture(&self) -> Vec<f64> {
        [self.density.clone(), self.vicinity.capture()].concat()
    }

    fn restore(&mut self, numbers: &mut &[f64]) -> Result<()> {
        super::vicinity::take(numbers, &mut self.density)?;
        self.vicinity.restore(numbers)?;
        self.walls.survey(&self.vicinity, &Crew::alone());
        Ok(())
    }

    fn accumulate(&self, block: Range<usize>, _at: &Moment<'_, V>, rates: &mut Rates<'_, V>) {
        for (index, member, place) in self.vicinity.in_block(block) {
            let (volume, force) = (self.volume(member), &self.forces[place]);
            for axis in 0..V::DIMENSION {
                rates.force.axes[axis][index] += V::Scalar::from_f64(volume) * force[axis];
            }
            // Of a pair's power each takes half.
            let viscous = 0.5 * volume * force[VISCOUS].to_f64();
            rates.power[Channel::Viscosity as usize][index % LANES] += viscous + self.diffused[member];
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
        let energy = |member: usize| {
            let fluid = self.kinds.fluid(self.kind[member]);
            fluid.map_or(0.0, |fluid| fluid.mass * fluid.energy(self.density[member]))
        };
        (0..self.kind.len()).map(energy).sum()
    }

    fn flow(&self, velocity: matter::View<'_, V>) -> Option<Flow> {
        let sound = self.kinds.first().sound_speed;
        let square = |index: u32| (0..V::DIMENSION).map(|axis| velocity.axis(axis)[index as usize].to_f64().powi(2)).sum::<f64>();
        let (mut fast, mut all) = (0.0, 0.0);
        for (&index, _) in self.vicinity.members().iter().zip(&self.kind).filter(|(_, kind)| **kind != OBSTACLE) {
            all += 1.0;
            fast += if square(index) > (Flow::FAST * sound).powi(2) { 1.0 } else { 0.0 };
        }
        Some(Flow { fast: fast / all, sound })
    }

    /// Of all waves that the kernel carries, the one with the shortest step: for kick–drift–kick with the force at the predicted
    /// velocity that is 2/(γ + √(γ² + ω²)), where diffusion counts with half its rate. An obstacle is pushed with the force on
    /// the fluid in its place.
    fn bound(&self, _at: &Moment<'_, V>, bound: &mut Bound) {
        let h = self.kinds.first().smoothing_length;
        let bounds: Vec<(f64, f64, f64)> = self
            .kinds
            .materials
            .iter()
            .zip(0..)
            .map(|(fluid, kind)| {
                let densities = self.density.iter().zip(&self.kind).filter(|(_, other)| **other == kind);
                let densest = densities.map(|(density, _)| *density).fold(fluid.density, f64::max);
                let scaled = |wave: &Wave| {
                    let viscous = (fluid.artificial() * wave.squeeze + 2.0 * fluid.viscosity * wave.decay) / fluid.density;
                    let decay = (viscous + 0.5 * fluid.diffusion() * wave.decay) / (h * h);
                    (fluid.sound_at(densest) * wave.frequency / h, decay)
                };
                let haste = |&(frequency, decay): &(f64, f64)| decay + decay.hypot(frequency);
                let binding = self.waves.iter().map(scaled).max_by(|one, other| haste(one).total_cmp(&haste(other)));
                let (frequency, decay) = binding.unwrap_or_default();
                (frequency * frequency, decay, fluid.density)
            })
            .collect();
        let heaviest = |one: &&(f64, f64, f64), other: &&(f64, f64, f64)| (one.0 * one.2).total_cmp(&(other.0 * other.2));
        let pressing = bounds.iter().max_by(heaviest).copied().unwrap_or_default();
        for (member, &index) in self.vicinity.members().iter().enumerate() {
            let (stiffness, damping, density) = bounds.get(usize::from(self.kind[member])).copied().unwrap_or(pressing);
            let mass = self.mass[member] / self.density[member] * density;
            bound.point(index as usize, "sound", mass * stiffness, 0.0);
            bound.point(index as usize, "viscosity", 0.0, mass * damping);
        }
        let push = |force: &[V::Scalar; FORCES]| force[..V::DIMENSION].iter().map(|f| f.to_f64().powi(2)).sum::<f64>();
        let strongest = self.forces.iter().map(push).fold(0.0, f64::max).sqrt();
        let lightest = self.kinds.materials.iter().map(|fluid| fluid.density).fold(f64::INFINITY, f64::min);
        // What has diverged has no scale left.
        if strongest.is_finite() {
            bound.accuracy("acceleration", (h * lightest / strongest).sqrt());
        }
    }

    fn bound_varies(&self) -> bool {
        true
    }

    fn show(&self, fields: &mut Fields) {
        for (member, &index) in self.vicinity.members().iter().enumerate() {
            if let Some(fluid) = self.kinds.fluid(self.kind[member]) {
                fields.density[index as usize] = self.density[member];
                fields.pressure[index as usize] = fluid.pressure(self.density[member]);
            }
        }
    }

    fn pairs(&self) -> usize {
        2 * self.vicinity.pairs()
    }

    fn layout(&self) -> String {
        let shifts =
            self.shifting.as_ref().map_or_else(String::new, |shifting| format!("shifted by A = {}; ", shifting.coefficient()));
        format!("sound at {:.4} m/s; {shifts}{}", self.kinds.first().sound_speed, self.vicinity.layout())
    }

    fn bytes(&self) -> usize {
        let own = std::mem::size_of_val(self.rates.as_slice()) + std::mem::size_of_val(self.forces.as_slice());
        let numbers = 4 * size_of::<f64>() * self.density.len();
        let indices = size_of::<u32>() * self.obstacles.len() + self.kind.len();
        let counts = self.summation.as_ref().map_or(0, Summation::bytes);
        let shifts = self.shifting.as_ref().map_or(0, Shifting::bytes);
        counts + shifts + self.vicinity.bytes() + self.records.bytes() + self.walls.bytes() + own + numbers + indices
    }
}
