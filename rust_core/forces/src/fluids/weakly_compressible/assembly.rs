//! Construction of a scene's fluids: pair laws from the materials, initial densities and volumes from the positions.

use super::Fluids;
use super::gauges::Gauges;
use super::kernel::{self, KernelShape, SmoothingKernel};
use super::laws::{Continuity, Extrapolation, FORCES, KINDS, Momentum, OBSTACLE, PairCoefficients, RATES};
use super::shifting::Shifting;
use super::start::{self, Choice, Material, Materials};
use super::summation::Summation;
use super::surface::{FreeSurface, WallFactor};
use super::tension::Tension;
use super::walls::FluidWalls;
use crate::error::{Error, Result};
use crate::forces::neighbor_list::NeighborList;
use crate::math::{Real, Vector};
use crate::matter::Properties;
use crate::neighbors::sums::Records;
use crate::parallel::Executor;
use crate::scene::Scene;

impl<V: Vector, K: KernelShape, const MIXED: bool> Fluids<V, K, MIXED> {
    /// Fluids of a scene with these materials.
    pub fn new(shape: K, scene: &Scene, properties: &Properties<V>, materials: Materials, executor: &Executor) -> Result<Self> {
        let kind_of = |index: u32| materials.of_body[properties.body[index as usize] as usize];
        let members: Vec<u32> = (0..properties.count() as u32).filter(|&index| kind_of(index).is_some()).collect();
        let kind: Vec<u8> = members.iter().filter_map(|&index| kind_of(index)).collect();
        let obstacles: Vec<u32> = (0..).zip(&kind).filter(|(_, kind)| **kind == OBSTACLE).map(|(member, _)| member).collect();
        let common = materials.first();
        let h = common.smoothing_length;
        let neighbor_list = NeighborList::new(scene, properties, members, 2.0 * h)?;
        let walls = FluidWalls::new(start::walls(scene, properties.origin)?, &neighbor_list);
        let number = V::Scalar::from_f64;
        let kernel = SmoothingKernel::<V::Scalar, K>::new(shape, h, common.spacing, V::DIMENSION);
        if !kernel.steepness.is_finite() {
            let found = format!("{} for a smoothing length of {h:.3e} m", V::Scalar::NAME);
            return Err(Error::parameter("precision", "f64", found).with_hint("the kernel is steeper than it can hold"));
        }
        let same = |one: &Material, other: &Material| one == other;
        let mut diffusion = materials.pairs(|one, other| if same(one, other) { one.diffusion() } else { 0.0 });
        diffusion[usize::from(OBSTACLE)].fill(V::Scalar::ZERO);
        diffusion.iter_mut().for_each(|row| row[usize::from(OBSTACLE)] = V::Scalar::ZERO);
        let gravity = common.gravity.to_array().map(|g| number(g / common.sound_speed.powi(2)));
        let fall = common.gravity.to_array().map(|g| number(common.density * g / common.sound_speed.powi(2)));
        let density = materials.each(|fluid| fluid.density);
        let continuity = Continuity { kernel, diffusion, for_particle: diffusion[0], density, gravity, fall };
        let artificial = materials.pairs(|one, other| mean(one.artificial(), other.artificial()));
        let variance = h * h * kernel::variance(shape, V::DIMENSION);
        let laminar = materials.pairs(|one, other| 2.0 * mean(one.viscosity, other.viscosity) / variance);
        let interacts = materials.pairs(|_, _| 1.0);
        let solid = usize::from(OBSTACLE);
        let either = |is: &dyn Fn(usize) -> bool| -> [V::Scalar; KINDS] {
            std::array::from_fn(|other| if is(other) { V::Scalar::ONE } else { V::Scalar::ZERO })
        };
        let coefficients: [_; KINDS] = std::array::from_fn(|kind| PairCoefficients {
            artificial: artificial[kind],
            laminar: laminar[kind],
            interacts: interacts[kind],
            other_is_obstacle: either(&|other| kind != solid && other == solid),
            own_is_obstacle: either(&|other| kind == solid && other != solid),
            own_acts: [V::Scalar::ONE; KINDS],
            other_acts: if kind == solid { WallFactor::by_tag() } else { [V::Scalar::ONE; KINDS] },
        });
        let momentum = Momentum {
            kernel,
            coefficients,
            for_particle: coefficients[0],
            density,
            softening: number(0.01 * h * h),
            shear: V::Scalar::ZERO,
        };
        let extrapolation = Extrapolation { kernel, density, gravity: common.gravity.to_array().map(number) };
        let waves = kernel::waves(shape, V::DIMENSION);
        let measures = !(walls.is_empty() && obstacles.is_empty() && scene.probes.is_empty());
        let body = |obstacle: u32| properties.body[neighbor_list.members()[obstacle as usize] as usize] as usize;
        let bodies = || obstacles.iter().map(|&obstacle| (body(obstacle), obstacle)).collect();
        let mut fluids = Self {
            mass: kind.iter().map(|&kind| materials.fluid(kind).unwrap_or(common).mass).collect(),
            density: Vec::new(),
            saved_density: Vec::new(),
            diffused: vec![0.0; kind.len()],
            extrapolated: vec![[V::Scalar::ZERO; 2]; obstacles.len()],
            records: Records::new(neighbor_list.neighbors()),
            rates: vec![[V::Scalar::ZERO; RATES]; kind.len()],
            mirrored: vec![[V::Scalar::ZERO; RATES]; if walls.is_empty() { 0 } else { kind.len() }],
            forces: vec![[V::Scalar::ZERO; FORCES]; kind.len()],
            surface: FreeSurface::new(kernel, common, &waves, kind.len()),
            tension: Tension::new(kernel, &waves, &materials, kind.len()),
            waves,
            strongest: None,
            saved_strongest: 0.0,
            summation: materials.summation.then(|| Summation::new(kernel, &materials, kind.len())),
            shifting: None,
            gauges: measures
                .then(|| Gauges::new(shape, scene, properties.origin, &walls, 2.0 * h, (bodies(), kind.len())))
                .transpose()?,
            materials,
            kind,
            obstacles,
            neighbor_list,
            continuity,
            momentum,
            extrapolation,
            walls,
        };
        fluids.fill_space(scene, properties, executor)?;
        let is_closed = fluids.is_closed(scene, properties, executor)?;
        fluids.choose_shifting(scene, is_closed);
        fluids.choose_viscosity(is_closed);
        Ok(fluids)
    }

    /// Enables shifting if it is requested, or if the choice is automatic and shifting is safe. It is safe without a free
    /// surface. It is also safe for a fluid alone: shifts then lift nothing, and no wall deflects a surface that is not shifted.
    fn choose_shifting(&mut self, scene: &Scene, is_closed: bool) {
        let coefficient = match self.materials.shifting {
            Choice::Given(coefficient) => coefficient,
            Choice::Auto if is_closed || is_alone(scene) => start::SHIFTING,
            Choice::Auto => 0.0,
        };
        if coefficient > 0.0 {
            let common = self.materials.first();
            self.shifting = Some(Shifting::new(self.continuity.kernel, common, coefficient, self.kind.len()));
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
        let Self { neighbor_list, records, surface, walls, materials, kind, mass, density, .. } = self;
        records.fill(neighbor_list.neighbors(), neighbor_list.positions(), executor, &|member, record| {
            record[2 * V::DIMENSION] = V::Scalar::from_f64(mass[member] / density[member]).tagged(kind[member]);
        });
        surface.update((neighbor_list, records), walls, (materials, kind), density, executor);
        Ok(surface.is_closed())
    }

    /// Sets the hydrostatic density of every fluid particle, and the volume of every obstacle particle, 1/Σ W over obstacles.
    ///
    /// Source: N. Akinci et al., ACM Trans. Graph. 31 (2012) 62.
    fn fill_space(&mut self, scene: &Scene, properties: &Properties<V>, executor: &Executor) -> Result<()> {
        let at = properties.relative(&scene.positions());
        let members: Vec<usize> = self.neighbor_list.members().iter().map(|&index| index as usize).collect();
        let common = self.materials.first();
        let down = common.gravity.normalize_or_zero();
        let material = |member: usize| self.materials.fluid(self.kind[member]);
        let fluid: Vec<usize> = (0..members.len()).filter(|&member| material(member).is_some()).collect();
        let heads: Vec<(f64, f64)> =
            fluid.iter().map(|&member| (at[members[member]].dot(down), material(member).map_or(0.0, |of| of.density))).collect();
        let pressures = start::pressures(&heads, common.spacing, common.gravity.length());
        self.density = vec![common.density; members.len()];
        for (&member, pressure) in fluid.iter().zip(pressures) {
            self.density[member] = material(member).map_or(common.density, |of| of.density_under(pressure));
        }
        self.saved_density.clone_from(&self.density);
        if self.obstacles.is_empty() {
            return Ok(());
        }
        self.search(&|axis, index| at[index][axis], executor)?;
        executor.check()?;
        let weight = weight(self.momentum.kernel.shape, self.materials.first(), V::DIMENSION);
        let neighbors = self.neighbor_list.neighbors();
        for &obstacle in &self.obstacles {
            let slot = neighbors.slots()[obstacle as usize] as usize;
            let others = neighbors.of(slot).iter().map(|&other| neighbors.order()[other as usize] as usize);
            let solid = others.zip(neighbors.separation(slot)).filter(|&(other, _)| self.kind[other] == OBSTACLE);
            let near: f64 = solid.map(|(_, separation)| weight(separation.length())).sum();
            let common = self.materials.first();
            // The volume of an isolated particle is bounded; otherwise it would be that of the kernel.
            self.mass[obstacle as usize] = (common.density / (near + weight(0.0))).min(2.0 * common.mass);
        }
        Ok(())
    }
}

/// Whether a scene consists of fluids alone, without forces on them, boundaries and other bodies.
fn is_alone(scene: &Scene) -> bool {
    scene.boundaries.is_empty()
        && start::fluids(scene).count() == scene.bodies.len()
        && !start::fluids(scene).any(|(body, _)| scene.forces.iter().any(|item| item.acts_on(body)))
}

/// Kernel W(r) of a fluid, in double precision.
fn weight<K: KernelShape>(shape: K, fluid: &Material, dimension: usize) -> impl Fn(f64) -> f64 {
    let kernel = SmoothingKernel::<f64, K>::new(shape, fluid.smoothing_length, fluid.spacing, dimension);
    move |distance| kernel.value(distance)
}

/// Harmonic mean of two viscosities, which makes the stress continuous.
fn mean(one: f64, other: f64) -> f64 {
    if one + other > 0.0 { 2.0 * one * other / (one + other) } else { 0.0 }
}
