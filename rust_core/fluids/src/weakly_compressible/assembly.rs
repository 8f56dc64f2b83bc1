//! Construction of a scene's fluids: pair laws from the materials, initial densities and volumes from the positions.

use super::WeaklyCompressible;
use super::equation_of_state::CompressibleFluid;
use super::laws::{Continuity, FORCES, Momentum, PairCoefficients, RATES};
use super::parameters::{Choice, FluidParameters, SHIFTING};
use super::shifting::Shifting;
use super::summation::Summation;
use super::surface::{SurfaceEffects, WallFactor};
use crate::error::{Error, Result};
use crate::forces::fluid::fluids;
use crate::math::{Real, Vector};
use crate::matter::Properties;
use crate::neighbors::NeighborList;
use crate::neighbors::sums::Records;
use crate::parallel::Executor;
use crate::particles::kernel::{KernelShape, SmoothingKernel};
use crate::particles::material::pairs;
use crate::particles::obstacles::Obstacles;
use crate::particles::solids::Solids;
use crate::particles::tension::Tension;
use crate::particles::walls::FluidWalls;
use crate::particles::{Gauges, KINDS, OBSTACLE, start, waves};
use crate::scene::Scene;

impl<V: Vector, K: KernelShape, const MIXED: bool> WeaklyCompressible<V, K, MIXED> {
    /// Fluids of a scene with these materials.
    pub fn new(
        shape: K,
        scene: &Scene,
        properties: &Properties<V>,
        parameters: FluidParameters,
        executor: &Executor,
    ) -> Result<Self> {
        let FluidParameters { materials, fluids, summation, shifting, mut remarks } = parameters;
        let kind_of = |index: u32| materials.of_body[properties.body[index as usize] as usize];
        let solids = Solids::declared(scene, properties, &materials)?;
        let mut members: Vec<u32> = (0..properties.count() as u32).filter(|&index| kind_of(index).is_some()).collect();
        let mut kind: Vec<u8> = members.iter().filter_map(|&index| kind_of(index)).collect();
        members.extend((0..solids.count()).map(|sample| (properties.count() + sample) as u32));
        kind.resize(members.len(), OBSTACLE);
        let common = materials.first();
        let h = common.smoothing_length;
        let neighbor_list = NeighborList::new(scene, properties, members, 2.0 * h)?;
        let walls = FluidWalls::new(start::walls(scene, properties.origin)?, &neighbor_list);
        let kernel = SmoothingKernel::<V::Scalar, K>::new(shape, h, common.spacing, V::DIMENSION);
        if !kernel.steepness.is_finite() {
            let found = format!("{} for a smoothing length of {h:.3e} m", V::Scalar::NAME);
            return Err(Error::parameter("precision", "f64", found).with_hint("the kernel is steeper than it can hold"));
        }
        let continuity = continuity(kernel, &fluids, materials.rest_densities());
        let momentum = momentum(kernel, &fluids, materials.rest_densities(), V::DIMENSION);
        let obstacles = Obstacles::new(kernel, &materials, &kind);
        remarks.extend(solids.remarks.iter().cloned());
        let waves = waves::waves(shape, V::DIMENSION);
        let measures = !(walls.is_empty() && obstacles.is_empty() && scene.probes.is_empty());
        let body = |obstacle: u32| {
            let index = neighbor_list.members()[obstacle as usize] as usize;
            let particle = solids.sample(index).map_or(index, |sample| solids.owner(sample) as usize);
            properties.body[particle] as usize
        };
        let bodies = || obstacles.members().iter().map(|&obstacle| (body(obstacle), obstacle)).collect();
        let mut scheme = Self {
            mass: kind.iter().map(|&kind| materials.fluid(kind).unwrap_or(common).mass).collect(),
            density: Vec::new(),
            saved_density: Vec::new(),
            diffused: vec![0.0; kind.len()],
            records: Records::new(neighbor_list.neighbors()),
            rates: vec![[V::Scalar::ZERO; RATES]; kind.len()],
            mirrored: vec![[V::Scalar::ZERO; RATES]; if walls.is_empty() { 0 } else { kind.len() }],
            forces: vec![[V::Scalar::ZERO; FORCES]; kind.len()],
            surface: SurfaceEffects::new(kernel, common, waves, kind.len()),
            tension: Tension::new(kernel, waves, &materials, kind.len()),
            waves,
            strongest: None,
            saved_strongest: 0.0,
            summation: summation.then(|| Summation::new(kernel, &materials, kind.len())),
            shifting: None,
            gauges: measures
                .then(|| Gauges::new(shape, scene, properties.origin, &walls, 2.0 * h, (bodies(), kind.len())))
                .transpose()?,
            materials,
            fluids,
            remarks,
            kind,
            obstacles,
            solids,
            neighbor_list,
            continuity,
            momentum,
            walls,
        };
        scheme.fill_space(scene, properties, executor)?;
        let is_closed = scheme.is_closed(scene, properties, executor)?;
        scheme.choose_shifting(scene, shifting, is_closed);
        scheme.choose_viscosity(is_closed);
        Ok(scheme)
    }

    /// Enables shifting if it is requested, or if the choice is automatic and shifting is safe. It is safe without a free
    /// surface. It is also safe for a fluid alone: shifts then lift nothing, and no wall deflects a surface that is not shifted.
    fn choose_shifting(&mut self, scene: &Scene, choice: Choice, is_closed: bool) {
        let coefficient = match choice {
            Choice::Given(coefficient) => coefficient,
            Choice::Auto if is_closed || is_alone(scene) => SHIFTING,
            Choice::Auto => 0.0,
        };
        if coefficient > 0.0 {
            self.shifting = Some(Shifting::new(self.continuity.kernel, &self.fluids[0], coefficient, self.kind.len()));
        }
    }

    /// Sets the viscous force along v where the flow is the same, which is in a single fluid without a free surface.
    fn choose_viscosity(&mut self, is_closed: bool) {
        if is_closed && !self.materials.are_mixed() {
            let momentum = &mut self.momentum;
            momentum.shear = V::Scalar::from_f64(2.0 * self.materials.first().viscosity);
            let each = momentum.coefficients.iter_mut().chain([&mut momentum.for_particle]);
            each.for_each(|coefficients| coefficients.laminar = [V::Scalar::ZERO; KINDS]);
        }
    }

    /// Whether the fluid has no free surface initially.
    fn is_closed(&mut self, scene: &Scene, properties: &Properties<V>, executor: &Executor) -> Result<bool> {
        let at = properties.relative(&scene.positions());
        self.search(&|axis, index| at[index][axis], executor)?;
        executor.check()?;
        let Self { neighbor_list, records, surface, walls, fluids, kind, mass, density, .. } = self;
        records.fill(neighbor_list.neighbors(), neighbor_list.positions(), executor, &|member, record| {
            record[2 * V::DIMENSION] = V::Scalar::from_f64(mass[member] / density[member]).tagged(kind[member]);
        });
        surface.update((neighbor_list, records), walls, (fluids, kind), density, executor);
        Ok(surface.is_closed())
    }

    /// Sets the hydrostatic density of every fluid particle, and the mass of the fluid in every obstacle particle.
    fn fill_space(&mut self, scene: &Scene, properties: &Properties<V>, executor: &Executor) -> Result<()> {
        let at = properties.relative(&scene.positions());
        let members: Vec<usize> = self.neighbor_list.members().iter().map(|&index| index as usize).collect();
        let common = self.materials.first();
        let down = common.gravity.normalize_or_zero();
        let fluid_of = |member: usize| self.fluid(self.kind[member]);
        let fluid: Vec<usize> = (0..members.len()).filter(|&member| fluid_of(member).is_some()).collect();
        let heads: Vec<(f64, f64)> = fluid
            .iter()
            .map(|&member| (at[members[member]].dot(down), fluid_of(member).map_or(0.0, |of| of.material.density)))
            .collect();
        let pressures = start::pressures(&heads, common.spacing, common.gravity.length());
        let mut density = vec![common.density; members.len()];
        for (&member, pressure) in fluid.iter().zip(pressures) {
            density[member] = fluid_of(member).map_or(common.density, |of| of.density_under(pressure));
        }
        self.saved_density.clone_from(&density);
        self.density = density;
        if self.obstacles.is_empty() {
            return Ok(());
        }
        self.search(&|axis, index| at[index][axis], executor)?;
        executor.check()?;
        let samples = members.len() - self.solids.count();
        let masses = self.obstacles.masses(&self.neighbor_list, &self.kind, samples, self.materials.first());
        self.obstacles.members().iter().zip(masses).for_each(|(&obstacle, mass)| self.mass[obstacle as usize] = mass);
        let rest = self.materials.first().density;
        self.mass[samples..].iter_mut().zip(self.solids.volumes()).for_each(|(mass, volume)| *mass = rest * volume);
        Ok(())
    }
}

/// Continuity of these fluids, whose materials have these rest densities.
fn continuity<T: Real, K: KernelShape, const MIXED: bool>(
    kernel: SmoothingKernel<T, K>,
    fluids: &[CompressibleFluid],
    density: [T; KINDS],
) -> Continuity<T, K, MIXED> {
    let (solid, CompressibleFluid { material: common, sound_speed, .. }) = (usize::from(OBSTACLE), &fluids[0]);
    let mut diffusion = pairs(fluids, |one, other| if one == other { one.diffusion() } else { 0.0 });
    diffusion[solid].fill(T::ZERO);
    diffusion.iter_mut().for_each(|row| row[solid] = T::ZERO);
    let gravity = common.gravity.to_array().map(|g| T::from_f64(g / sound_speed.powi(2)));
    let fall = common.gravity.to_array().map(|g| T::from_f64(common.density * g / sound_speed.powi(2)));
    Continuity { kernel, diffusion, for_particle: diffusion[0], density, gravity, fall }
}

/// Momentum of these fluids in `dimension` axes.
fn momentum<T: Real, K: KernelShape, const MIXED: bool>(
    kernel: SmoothingKernel<T, K>,
    fluids: &[CompressibleFluid],
    density: [T; KINDS],
    dimension: usize,
) -> Momentum<T, K, MIXED> {
    let (solid, h) = (usize::from(OBSTACLE), fluids[0].material.smoothing_length);
    let artificial = pairs(fluids, |one, other| mean(one.artificial(), other.artificial()));
    let variance = h * h * waves::variance(kernel.shape, dimension);
    let laminar = pairs(fluids, |one, other| 2.0 * mean(one.material.viscosity, other.material.viscosity) / variance);
    let interacts = pairs(fluids, |_, _| 1.0);
    let either =
        |is: &dyn Fn(usize) -> bool| -> [T; KINDS] { std::array::from_fn(|other| if is(other) { T::ONE } else { T::ZERO }) };
    let coefficients: [_; KINDS] = std::array::from_fn(|kind| PairCoefficients {
        artificial: artificial[kind],
        laminar: laminar[kind],
        interacts: interacts[kind],
        other_is_obstacle: either(&|other| kind != solid && other == solid),
        own_is_obstacle: either(&|other| kind == solid && other != solid),
        own_acts: [T::ONE; KINDS],
        other_acts: if kind == solid { WallFactor::by_tag() } else { [T::ONE; KINDS] },
    });
    let softening = T::from_f64(0.01 * h * h);
    Momentum { kernel, coefficients, for_particle: coefficients[0], density, softening, shear: T::ZERO }
}

/// Whether a scene consists of fluids alone, without forces on them, boundaries and other bodies.
fn is_alone(scene: &Scene) -> bool {
    scene.boundaries.is_empty()
        && fluids(scene).count() == scene.bodies.len()
        && !fluids(scene).any(|(body, _)| scene.forces.iter().any(|item| item.acts_on(body)))
}

/// Harmonic mean of two viscosities, which makes the stress continuous.
fn mean(one: f64, other: f64) -> f64 {
    if one + other > 0.0 { 2.0 * one * other / (one + other) } else { 0.0 }
}
