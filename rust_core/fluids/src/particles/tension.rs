//! Surface tension from an energy of the color field, its gradient, and the local density.
//!
//! The color c = Σ Vⱼ W / S is 1 inside a lattice at rest, and its gradient is g = κ Σ Vⱼ ∇W. Both are sums with rest volumes V
//! over fluid of the same material, its images in walls, and obstacles. The local density s = Σ (1 − r/r₀)₊² / S₀ is a sum over
//! the fluid and its images alone, and is 1 in a close packing of particles at rest. The energy and the force are
//!
//! ```text
//! E = Σ Vᵢ [½ A (1 − cᵢ)² + ½ B |gᵢ|² + ½ C (sᵢ − 1)₊²]
//! Fᵢ = −∂E/∂xᵢ = −Vᵢ Σ Vⱼ [(aᵢ + aⱼ) κ∇W + κ∇∇W (bᵢ − bⱼ)] + Vᵢ Σ 2 (kᵢ + kⱼ) (1 − r/r₀)₊ d/r₀r
//! a = −A (1 − c)/κS,  b = B g,  k = C (s − 1)₊/S₀
//! ```
//!
//! The first two parts and their first derivatives vanish in a square or cubic lattice of that density, and nearly vanish in
//! other lattices. The fluid therefore gains neither pressure nor stiffness against shear. A and B give a relaxed surface the
//! energy σ. The first part alone pulls the outermost layer inward and clusters particles; the second alone repels the layer.
//! Once particles have left the lattice, the ratio of A to B decides the share of Laplace's pressure that the two parts exert.
//! This share is small, so that the equation of state bears the pressure.
//!
//! Particles could still pair, because pressure depends on density alone. The third part prevents it. It constrains each particle
//! once, whereas a repulsion of pairs constrains each contact, so that drops in 3D solidify as a glass.
//!
//! The force derives from this energy. Energy, momentum and angular momentum are therefore functions of positions and velocities
//! alone. At the interface of two fluids the tension is the sum of theirs.
//!
//! Sources: for the first part, cohesion by the density around both particles, S. Nugent and H. A. Posch, Phys. Rev. E 62 (2000)
//! 4968; for the second part, the gradient energy, J. W. Cahn and J. E. Hilliard, J. Chem. Phys. 28 (1958) 258; for its
//! simplified force, area minimization, N. Akinci, G. Akinci and M. Teschner, ACM Trans. Graph. 32 (2013) 182; for the third
//! part, repulsion by a local density of shorter range with its weight, P. B. Warren, Phys. Rev. E 68 (2003) 066702.

use glam::DVec3;

use super::images::WallCondition;
use super::kernel::{KernelShape, SmoothingKernel};
use super::lattice;
use super::material::{KINDS, Material, Materials, OBSTACLE, pairs};
use super::walls::FluidWalls;
use super::waves::FluidWave;
use crate::math::{AXES, Real, Vector};
use crate::neighbors::NeighborList;
use crate::neighbors::sums::Records;
use crate::parallel::Executor;
use laws::{COLOR, COLOR_SUMS, Cohesion, ColorField, Common, LOCAL_DENSITY, TensionForce};
use moduli::{SETTLED, close_packing, moduli};

mod laws;
mod moduli;

/// Range r₀ of the local density in units of the particle spacing at rest.
pub const SHORT_RANGE: f64 = 1.5;

/// Modulus C in units of σ/Δ over [`SETTLED`]. From half to eight times this value, frequencies of drops differ by less than a
/// tenth.
const REPULSION: f64 = 3.0;

/// Smallest divisor distance, in units of r₀.
const TINY: f64 = 1e-6;

/// Images have the color of their originals: free slip, no hydrostatic difference.
const FREE_SLIP: WallCondition = WallCondition { weight: DVec3::ZERO, no_slip: false };

/// Surface tension of the fluids of a scene.
pub struct Tension<V: Vector, K, const MIXED: bool> {
    color_field: ColorField<V::Scalar, K, MIXED>,
    force: TensionForce<V::Scalar, K, MIXED>,
    /// Lattice sum S.
    rest: f64,
    /// Product κS.
    rest_scale: f64,
    /// Moduli A [Pa], B [N] and C [Pa] of each material.
    moduli: [[f64; 3]; KINDS],
    /// Range r₀ [m], and the sum S₀ in close packing.
    short_range: f64,
    packed: f64,
    /// Stiffness of each material, see [`Tension::stiffness`].
    stiffness: [f64; KINDS],
    /// Sums of [`ColorField`] and [`TensionForce`] by slot.
    color_sums: Vec<[V::Scalar; COLOR_SUMS]>,
    forces: Vec<[V::Scalar; AXES]>,
}

impl<V: Vector, K: KernelShape, const MIXED: bool> Tension<V, K, MIXED> {
    /// Surface tension of `count` particles of these materials; None if no fluid has it.
    pub fn new(kernel: SmoothingKernel<V::Scalar, K>, waves: &[FluidWave], materials: &Materials, count: usize) -> Option<Self> {
        if materials.fluids.iter().all(|fluid| fluid.surface_tension == 0.0) {
            return None;
        }
        let common = materials.first();
        let ratio = common.spacing / common.smoothing_length;
        let (rest, scale) = lattice::density(kernel.shape, ratio, V::DIMENSION);
        let unit = moduli(kernel.shape, ratio, V::DIMENSION);
        let h = common.smoothing_length;
        let tension = |fluid: &Material| fluid.surface_tension / SETTLED[V::DIMENSION - 2];
        let of =
            |fluid: &Material| [unit[0] / h, unit[1] * h, REPULSION / common.spacing].map(|modulus| modulus * tension(fluid));
        let color = pairs(&materials.fluids, |one, other| if one == other { 1.0 } else { 0.0 });
        let mut local_density = color;
        // Obstacles repel by their pressure alone.
        local_density[usize::from(OBSTACLE)].fill(V::Scalar::ZERO);
        local_density.iter_mut().for_each(|row| row[usize::from(OBSTACLE)] = V::Scalar::ZERO);
        let cohesion = std::array::from_fn(|kind| Cohesion { color: color[kind], local_density: local_density[kind] });
        let short_range = SHORT_RANGE * common.spacing;
        let inverse_range = V::Scalar::from_f64(short_range.recip());
        let laws = Common { kernel, cohesion, for_particle: cohesion[0], inverse_range };
        // Stiffness of a lattice wave, from its `frequency` in the kernel, and stiffness of the repulsion.
        let (rest_scale, [packed, repelled]) = (rest * scale, close_packing(V::DIMENSION));
        let of_color = |fluid: &Material| {
            let [area, gradient, _] = of(fluid);
            let through = |wave: &FluidWave| {
                (area / rest_scale.powi(2) + gradient * (wave.number / h).powi(2)) * (wave.frequency / h).powi(2)
            };
            waves.iter().map(through).fold(0.0, f64::max)
        };
        let of_repulsion = |fluid: &Material| of(fluid)[2] * repelled / common.spacing.powi(2);
        // Obstacles are not repelled, and take the stiffness of the stiffest fluid.
        let stiffness = |kind: usize| match materials.fluids.get(kind) {
            Some(fluid) => of_color(fluid) + of_repulsion(fluid),
            None => materials.fluids.iter().map(of_color).fold(0.0, f64::max),
        };
        Some(Self {
            color_field: ColorField(laws),
            force: TensionForce {
                common: laws,
                volume: V::Scalar::from_f64(common.mass / common.density),
                tiny: V::Scalar::from_f64(TINY * short_range),
            },
            rest,
            rest_scale,
            short_range,
            packed,
            stiffness: std::array::from_fn(stiffness),
            moduli: std::array::from_fn(|kind| materials.fluids.get(kind).map_or([0.0; 3], of)),
            color_sums: vec![[V::Scalar::ZERO; COLOR_SUMS]; count],
            forces: vec![[V::Scalar::ZERO; AXES]; count],
        })
    }

    /// Computes the color sums, and rewrites the records. `volume` returns the rest volume of a member [m^D].
    fn sum_color(
        law: ColorField<V::Scalar, K, MIXED>,
        (neighbor_list, records): (&NeighborList, &mut Records<V>),
        walls: &FluidWalls,
        kind: &[u8],
        volume: &(impl Fn(usize) -> f64 + Sync),
        color_sums: &mut [[V::Scalar; COLOR_SUMS]],
        executor: &Executor,
    ) {
        let neighbors = neighbor_list.neighbors();
        records.fill(neighbors, neighbor_list.positions(), executor, &|member, record| {
            record[2 * V::DIMENSION] = V::Scalar::from_f64(volume(member)).tagged(kind[member]);
        });
        records.sum(neighbors, law, color_sums, executor);
        walls.add(law, &FREE_SLIP, (neighbor_list, records), color_sums, executor);
    }

    /// Computes the force densities, with arguments as in `sum_color`.
    pub fn update(
        &mut self,
        (neighbor_list, records): (&NeighborList, &mut Records<V>),
        walls: &FluidWalls,
        kind: &[u8],
        volume: &(impl Fn(usize) -> f64 + Sync),
        executor: &Executor,
    ) {
        let Self { color_field, force, rest, rest_scale, moduli, short_range, packed, color_sums, forces, .. } = self;
        Self::sum_color(*color_field, (neighbor_list, records), walls, kind, volume, color_sums, executor);
        let neighbors = neighbor_list.neighbors();
        let slots = neighbors.slots();
        records.fill(neighbors, neighbor_list.positions(), executor, &|member, record| {
            let (sums, kind) = (&color_sums[slots[member] as usize], kind[member]);
            let [area, gradient, repulsion] = moduli[usize::from(kind)];
            for axis in 0..V::DIMENSION {
                record[V::DIMENSION + axis] = V::Scalar::from_f64(gradient) * sums[axis];
            }
            let missing = 1.0 - sums[COLOR].to_f64() / *rest;
            let excess = (sums[LOCAL_DENSITY].to_f64() / *packed - 1.0).max(0.0);
            let repulsion = 2.0 * repulsion * excess / (*packed * *short_range);
            record[2 * V::DIMENSION] = V::Scalar::from_f64(if kind == OBSTACLE { volume(member) } else { repulsion });
            record[2 * V::DIMENSION + 1] = V::Scalar::from_f64(-area * missing / *rest_scale).tagged(kind);
        });
        records.sum(neighbors, *force, forces, executor);
        walls.add(*force, &FREE_SLIP, (neighbor_list, records), forces, executor);
    }

    /// Force density of the particle at a slot, per rest volume [N/m^D].
    #[inline]
    pub fn force(&self, slot: usize) -> &[V::Scalar; AXES] {
        &self.forces[slot]
    }

    /// Energy of all particles [J], with arguments as in `sum_color`.
    pub fn energy(
        &self,
        (neighbor_list, records): (&NeighborList, &mut Records<V>),
        walls: &FluidWalls,
        kind: &[u8],
        volume: &(impl Fn(usize) -> f64 + Sync),
        executor: &Executor,
    ) -> f64 {
        let mut color_sums = self.color_sums.clone();
        Self::sum_color(self.color_field, (neighbor_list, records), walls, kind, volume, &mut color_sums, executor);
        let energy = |(member, &slot): (usize, &u32)| {
            let (sums, moduli) = (color_sums[slot as usize].map(Real::to_f64), self.moduli[usize::from(kind[member])]);
            let square: f64 = sums[..V::DIMENSION].iter().map(|along| along * along).sum();
            let squares =
                [(1.0 - sums[COLOR] / self.rest).powi(2), square, (sums[LOCAL_DENSITY] / self.packed - 1.0).max(0.0).powi(2)];
            volume(member) * moduli.iter().zip(squares).map(|(modulus, square)| 0.5 * modulus * square).sum::<f64>()
        };
        neighbor_list.neighbors().slots().iter().enumerate().map(energy).sum()
    }

    /// Largest stiffness of a particle of a material, for a local density of at most 1.5, per rest volume [N/m^(D+1)].
    #[inline]
    pub fn stiffness(&self, kind: u8) -> f64 {
        self.stiffness[usize::from(kind)]
    }

    /// Memory [bytes].
    #[inline]
    pub fn bytes(&self) -> usize {
        std::mem::size_of_val(self.color_sums.as_slice()) + std::mem::size_of_val(self.forces.as_slice())
    }
}
