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

use std::f64::consts::FRAC_2_PI;

use glam::DVec3;

use super::images::{ImagePressure, WallCondition};
use super::kernel::{self, FluidWave, KernelShape, SmoothingKernel};
use super::laws::{KINDS, OBSTACLE, content, is_obstacle, pick, volume};
use super::start::{Material, Materials};
use super::walls::FluidWalls;
use crate::forces::neighbor_list::NeighborList;
use crate::math::{AXES, Real, Vector};
use crate::neighbors::sums::{Pair, PairLaw, Records};
use crate::parallel::Executor;
use crate::simd::{Number, ParticleRecord};

/// Range r₀ of the local density in units of the particle spacing at rest.
pub const SHORT_RANGE: f64 = 1.5;

/// Modulus C in units of σ/Δ over [`SETTLED`]. From half to eight times this value, frequencies of drops differ by less than a
/// tenth.
const REPULSION: f64 = 3.0;

/// Local density s up to which the time-step bound holds. In settled drops it is 1.2 at most.
const DENSEST: f64 = 1.5;

/// Smallest divisor distance, in units of r₀.
const TINY: f64 = 1e-6;

/// Ratio A/B in 2D and 3D, in units of the ratio with which the outermost layer of a flat lattice is in equilibrium. With these
/// values the equation of state bears Laplace's pressure. They were measured with Wendland's C2 and h = 1.5 Δ, in drops of 12 to
/// 30 spacings in 2D and of 8 to 12 in 3D.
const COHESION: [f64; 2] = [1.8, 1.65];

/// Ratio of the energy of a relaxed surface to that of a flat lattice surface, in 2D and 3D, measured on the drops of
/// [`COHESION`].
const SETTLED: [f64; 2] = [0.75, 0.80];

/// Images have the color of their originals: free slip, no hydrostatic difference.
const FREE_SLIP: WallCondition = WallCondition { weight: DVec3::ZERO, no_slip: false };

/// Number of sums of [`ColorField`]: g along each axis, c S, and s S₀.
const COLOR_SUMS: usize = AXES + 2;
const COLOR: usize = AXES;
const LOCAL_DENSITY: usize = AXES + 1;

/// Flags, 1 or 0, of the materials that one material counts in the color and in the local density.
#[derive(Debug, Clone, Copy)]
struct Cohesion<T> {
    color: [T; KINDS],
    local_density: [T; KINDS],
}

/// Common data of both laws: the coefficients of every material, and those of the particle's material.
#[derive(Debug, Clone, Copy)]
struct Common<T, K, const MIXED: bool> {
    kernel: SmoothingKernel<T, K>,
    cohesion: [Cohesion<T>; KINDS],
    for_particle: Cohesion<T>,
    /// Inverse range 1/r₀ [1/m].
    inverse_range: T,
}

impl<T: Real, K: KernelShape, const MIXED: bool> Common<T, K, MIXED> {
    #[inline(always)]
    fn for_particle(mut self, tagged: T) -> Self {
        if MIXED {
            self.for_particle = self.cohesion[usize::from(tagged.tag())];
        }
        self
    }

    /// The volume, or 0 if a particle of this tag does not count in the color.
    #[inline(always)]
    fn cohesive<N: Number<Scalar = T>>(&self, tagged: N, volume: N) -> N {
        if MIXED { volume * pick::<N, MIXED>(tagged, &self.for_particle.color) } else { volume }
    }

    /// Closeness 1 − r/r₀; 0 beyond r₀, and for a particle of this tag that does not count in the local density.
    #[inline(always)]
    fn closeness<N: Number<Scalar = T>>(&self, tagged: N, distance: N) -> N {
        let closeness = (N::constant(1.0) - distance * N::of(self.inverse_range)).max(N::constant(0.0));
        if MIXED { closeness * pick::<N, MIXED>(tagged, &self.for_particle.local_density) } else { closeness }
    }
}

/// Sums of the color field.
#[derive(Debug, Clone, Copy)]
struct ColorField<T, K, const MIXED: bool>(Common<T, K, MIXED>);

impl<V: Vector, K: KernelShape, const MIXED: bool> PairLaw<V, COLOR_SUMS> for ColorField<V::Scalar, K, MIXED> {
    #[inline(always)]
    fn for_particle(self, own: &ParticleRecord<V::Scalar>) -> Self {
        Self(self.0.for_particle(volume::<V, _>(own)))
    }

    #[inline(always)]
    fn terms<N: Number<Scalar = V::Scalar>>(&self, pair: &Pair<N>) -> [N; COLOR_SUMS] {
        let (volume, distance) = (volume::<V, N>(&pair.other), pair.distance);
        let cohesive_volume = self.0.cohesive(volume, volume);
        let slope = self.0.kernel.slope(cohesive_volume, distance);
        let mut terms = [N::constant(0.0); COLOR_SUMS];
        for axis in 0..V::DIMENSION {
            terms[axis] = slope * pair.separation[axis];
        }
        terms[COLOR] = cohesive_volume * self.0.kernel.value(distance);
        let closeness = self.0.closeness(volume, distance);
        terms[LOCAL_DENSITY] = closeness * closeness;
        terms
    }
}

impl<V: Vector, K: KernelShape, const MIXED: bool> ImagePressure<V, COLOR_SUMS> for ColorField<V::Scalar, K, MIXED> {}

/// Force density [N/m^D]. The records contain b, 2k/r₀ or the volume of an obstacle, and a with the tag of the material.
#[derive(Debug, Clone, Copy)]
struct TensionForce<T, K, const MIXED: bool> {
    common: Common<T, K, MIXED>,
    /// Volume of a fluid particle at rest [m^D].
    volume: T,
    /// Smallest divisor distance [m].
    tiny: T,
}

impl<V: Vector, K: KernelShape, const MIXED: bool> PairLaw<V, AXES> for TensionForce<V::Scalar, K, MIXED> {
    #[inline(always)]
    fn for_particle(self, own: &ParticleRecord<V::Scalar>) -> Self {
        Self { common: self.common.for_particle(content::<V, _>(own)), ..self }
    }

    #[inline(always)]
    fn terms<N: Number<Scalar = V::Scalar>>(&self, pair: &Pair<N>) -> [N; AXES] {
        let Pair { own, other, separation, distance, .. } = pair;
        let (first, tagged) = (2 * V::DIMENSION, content::<V, N>(other));
        let (distance, mut cohesive_volume) = (*distance, N::of(self.volume));
        if MIXED {
            let volume = N::select(is_obstacle(tagged), other[first], cohesive_volume);
            cohesive_volume = self.common.cohesive(tagged, volume);
        }
        let slope = self.common.kernel.slope(cohesive_volume, distance);
        let (mut terms, mut along) = ([N::constant(0.0); AXES], N::constant(0.0));
        for axis in 0..V::DIMENSION {
            terms[axis] = other[V::DIMENSION + axis] - own[V::DIMENSION + axis];
            along += terms[axis] * separation[axis];
        }
        let along_pair = self.common.closeness(tagged, distance) / distance.max(N::of(self.tiny));
        let repulsion = (own[first] + other[first]) * along_pair;
        let push =
            self.common.kernel.bend(cohesive_volume, distance) * along + repulsion - (content::<V, N>(own) + tagged) * slope;
        for axis in 0..V::DIMENSION {
            terms[axis] = slope * terms[axis] + push * separation[axis];
        }
        terms
    }
}

impl<V: Vector, K: KernelShape, const MIXED: bool> ImagePressure<V, AXES> for TensionForce<V::Scalar, K, MIXED> {}

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
        let (rest, scale) = kernel::lattice_density(kernel.shape, ratio, V::DIMENSION);
        let unit = moduli(kernel.shape, ratio, V::DIMENSION);
        let h = common.smoothing_length;
        let tension = |fluid: &Material| fluid.surface_tension / SETTLED[V::DIMENSION - 2];
        let of =
            |fluid: &Material| [unit[0] / h, unit[1] * h, REPULSION / common.spacing].map(|modulus| modulus * tension(fluid));
        let color = materials.pairs(|one, other| if one == other { 1.0 } else { 0.0 });
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

    /// Largest stiffness of a particle of a material, for a local density of at most [`DENSEST`], per rest volume [N/m^(D+1)].
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

/// Sum S₀ in close packing, and the largest stiffness of the repulsion at the local density [`DENSEST`], for unit C and spacing.
///
/// Let φ = (1 − r/r₀)² be the weight, and P = Σ |dφ/dr| / S₀. A wave of displacements changes s by P ⟨|cos|⟩ at most, and P² is
/// proportional to s for a constant number of neighbors. The curvature of φ, 2/r₀², adds (s − 1) 4 Σ 2 cos²/(r₀² S₀) = (s − 1) 2
/// P²/D.
fn close_packing(dimension: usize) -> [f64; 2] {
    // Hexagonal and face-centered cubic lattice, whose second neighbors are farther than r₀.
    let [count, distance, cosine] =
        [[6.0, libm::pow(4.0 / 3.0, 0.25), FRAC_2_PI], [12.0, libm::pow(2.0, 1.0 / 6.0), 0.5]][dimension - 2];
    let closeness = 1.0 - distance / SHORT_RANGE;
    let slope = 2.0 / (SHORT_RANGE * closeness);
    let stiffness = slope * slope * (DENSEST * cosine * cosine + 2.0 * (DENSEST - 1.0) / dimension as f64);
    [count * closeness * closeness, stiffness]
}

/// Moduli A and B for unit smoothing length and this spacing. Their ratio is [`COHESION`] times that with which the outermost
/// layer of a flat lattice is in equilibrium. The layers together have unit energy.
fn moduli<K: KernelShape>(shape: K, spacing: f64, dimension: usize) -> [f64; 2] {
    let (rest, scale) = kernel::lattice_density(shape, spacing, dimension);
    let kernel = SmoothingKernel::<f64, K>::new(shape, 1.0, spacing, dimension);
    // Layers count from the surface. A neighbor at x outward exists if its layer does.
    let layer = |x: f64| (x / spacing).round();
    let layers = || (0..).map(f64::from).take_while(|row| row * spacing < 2.0);
    let over = |row: f64, of: &dyn Fn(f64, f64) -> f64| {
        kernel::over_lattice(spacing, dimension, |x, r| if layer(x) <= row { of(x, r) } else { 0.0 })
    };
    let missing = |row: f64| 1.0 - over(row, &|_, r| kernel.value(r)) / rest;
    let gradient = |row: f64| over(row, &|x, r| kernel.slope(1.0, r) * x);
    let energies = [
        spacing * layers().map(|row| 0.5 * missing(row).powi(2)).sum::<f64>(),
        spacing * layers().map(|row| 0.5 * gradient(row).powi(2)).sum::<f64>(),
    ];
    let forces = [
        over(0.0, &|x, r| (missing(0.0) + missing(-layer(x))) / (scale * rest) * kernel.slope(1.0, r) * x),
        over(0.0, &|x, r| (kernel.slope(1.0, r) + kernel.bend(1.0, r) * x * x) * (gradient(-layer(x)) - gradient(0.0))),
    ];
    let [area, gradient] = [COHESION[dimension - 2] * forces[1], -forces[0]];
    let energy = area * energies[0] + gradient * energies[1];
    [area / energy, gradient / energy]
}

#[cfg(test)]
mod tests {
    use super::super::kernel::{OtherShape, WendlandC2};
    use super::*;

    #[test]
    fn both_parts_hold_a_surface_together() {
        fn check(shape: impl KernelShape + std::fmt::Debug) {
            for (dimension, smoothing) in [(2, 1.5), (3, 1.25), (3, 1.5)] {
                let [area, gradient] = moduli(shape, 1.0 / smoothing, dimension);
                assert!(area > 0.0 && gradient > 0.0, "{shape:?} in {dimension}D: {area} {gradient}");
            }
        }
        check(WendlandC2);
        check(OtherShape::WendlandC4);
        check(OtherShape::CubicSpline);
    }
}
