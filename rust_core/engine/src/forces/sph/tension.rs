//! Surface tension from an energy of the color field and its gradient.
//!
//! With the color c = Σ Vⱼ W / S, which is 1 inside a lattice at rest, and its gradient g = κ Σ Vⱼ ∇W, both over fluid of
//! the same material, its images in walls, and obstacles, with rest volumes and r₀ less than the particle spacing:
//!
//! ```text
//! E = Σ Vᵢ [½ A (1 − cᵢ)² + ½ B |gᵢ|²] + Σ ½ C (1 − r²/r₀²)₊²
//! Fᵢ = −∂E/∂xᵢ = −Vᵢ Σ Vⱼ [(aᵢ + aⱼ) κ∇W + κ∇∇W (bᵢ − bⱼ)] + Σ 2 C (1 − r²/r₀²)₊ d/r₀²,  a = −A (1 − c)/κS,  b = B g
//! ```
//!
//! The first two parts and their first derivatives vanish in every lattice of that density: the fluid gains neither
//! pressure nor stiffness against shear. A and B give a relaxed surface the energy σ. The first part alone pulls the
//! outermost layer inward and clusters particles; the second alone repels it: their ratio leaves this layer in equilibrium.
//! Pairing of particles remains possible, because pressure depends on density alone; the third part, a repulsion below r₀,
//! prevents it. At rest no pair is that close.
//!
//! Energy, momentum and angular momentum are therefore functions of positions and velocities alone. The first part is
//! cohesion as in S. Nugent and H. A. Posch, Phys. Rev. E 62 (2000) 4968, by the density around both; the second is the
//! gradient energy of J. W. Cahn and J. E. Hilliard, J. Chem. Phys. 28 (1958) 258, whose simplified force is the area
//! minimization of N. Akinci, G. Akinci and M. Teschner, ACM Trans. Graph. 32 (2013) 182. At the interface of two fluids
//! the tension is the sum of theirs.

use glam::DVec3;

use super::images::{ImagePressure, WallCondition};
use super::kernel::{self, Kernel, Shape, Wave};
use super::laws::{KINDS, OBSTACLE, content, pick, volume};
use super::start::{Material, Materials};
use super::walls::Walls;
use crate::forces::neighbor_list::NeighborList;
use crate::math::{AXES, Real, Vector};
use crate::neighbors::sums::{Pair, PairLaw, Records};
use crate::parallel::Executor;
use crate::simd::{Number, Record};

/// r₀ in units of the particle spacing at rest: spheres of this diameter fill a third of the space in 3D, and jam at two
/// thirds.
const CONTACT: f64 = 0.85;

/// C in units of σΔ^(D−1).
const FIRMNESS: f64 = 8.0;

/// Ratio of the energy of a relaxed surface to that of a flat lattice surface, in 2D and 3D: measured on drops of 20 to 30
/// spacings in 2D (0.745) and of 10 to 16 in 3D (0.45 to 0.50), with Wendland's C2 and h = 1.5 Δ.
const SETTLED: [f64; 2] = [0.75, 0.5];

/// Images have the color of their originals: free slip, no hydrostatic difference.
const FREE_SLIP: WallCondition = WallCondition { weight: DVec3::ZERO, no_slip: false };

/// Number of sums of [`ColorField`]: g along each axis, c S, and the repulsion energy over ¼ V.
const COLOR_SUMS: usize = AXES + 2;
const COLOR: usize = AXES;
const OVERLAP: usize = AXES + 1;

/// Cohesion coefficients of one material with each other one: 1 or 0 in the color, and C/V of the repulsion.
#[derive(Debug, Clone, Copy)]
struct Cohesion<T> {
    color: [T; KINDS],
    repulsion: [T; KINDS],
}

/// Common data of both laws: the coefficients of every material, and those of the particle's material.
#[derive(Debug, Clone, Copy)]
struct Common<T, K, const MIXED: bool> {
    kernel: Kernel<T, K>,
    cohesion: [Cohesion<T>; KINDS],
    for_particle: Cohesion<T>,
    /// 1/r₀² [1/m²].
    contact: T,
}

impl<T: Real, K: Shape, const MIXED: bool> Common<T, K, MIXED> {
    #[inline(always)]
    fn for_particle<V: Vector<Scalar = T>>(mut self, own: &Record<T>) -> Self {
        if MIXED {
            self.for_particle = self.cohesion[usize::from(volume::<V, _>(own).tag())];
        }
        self
    }

    /// Volume of the other particle, 0 if it does not count in the color.
    #[inline(always)]
    fn cohesive_volume<V: Vector<Scalar = T>, N: Number<Scalar = T>>(&self, pair: &Pair<N>) -> N {
        let volume = volume::<V, N>(&pair.other);
        if MIXED { volume * pick::<N, MIXED>(volume, &self.for_particle.color) } else { volume }
    }

    /// Overlap (1 − r²/r₀²)₊, and C/V times that.
    #[inline(always)]
    fn overlap<V: Vector<Scalar = T>, N: Number<Scalar = T>>(&self, pair: &Pair<N>) -> [N; 2] {
        let depth = (N::constant(1.0) - pair.square * N::of(self.contact)).max(N::constant(0.0));
        [depth, depth * pick::<N, MIXED>(volume::<V, N>(&pair.other), &self.for_particle.repulsion)]
    }
}

/// The sums of the color field.
#[derive(Debug, Clone, Copy)]
struct ColorField<T, K, const MIXED: bool>(Common<T, K, MIXED>);

impl<V: Vector, K: Shape, const MIXED: bool> PairLaw<V, COLOR_SUMS> for ColorField<V::Scalar, K, MIXED> {
    #[inline(always)]
    fn for_particle(self, own: &Record<V::Scalar>) -> Self {
        Self(self.0.for_particle::<V>(own))
    }

    #[inline(always)]
    fn terms<N: Number<Scalar = V::Scalar>>(&self, pair: &Pair<N>) -> [N; COLOR_SUMS] {
        let (cohesive_volume, distance) = (self.0.cohesive_volume::<V, N>(pair), pair.distance);
        let slope = self.0.kernel.slope(cohesive_volume, distance);
        let mut terms = [N::constant(0.0); COLOR_SUMS];
        for axis in 0..V::DIMENSION {
            terms[axis] = slope * pair.separation[axis];
        }
        terms[COLOR] = cohesive_volume * self.0.kernel.value(distance);
        let [depth, force] = self.0.overlap::<V, N>(pair);
        terms[OVERLAP] = depth * force;
        terms
    }
}

impl<V: Vector, K: Shape, const MIXED: bool> ImagePressure<V, COLOR_SUMS> for ColorField<V::Scalar, K, MIXED> {}

/// Force density [N/m^D], from records of b and a.
#[derive(Debug, Clone, Copy)]
struct TensionForce<T, K, const MIXED: bool>(Common<T, K, MIXED>);

impl<V: Vector, K: Shape, const MIXED: bool> PairLaw<V, AXES> for TensionForce<V::Scalar, K, MIXED> {
    #[inline(always)]
    fn for_particle(self, own: &Record<V::Scalar>) -> Self {
        Self(self.0.for_particle::<V>(own))
    }

    #[inline(always)]
    fn terms<N: Number<Scalar = V::Scalar>>(&self, pair: &Pair<N>) -> [N; AXES] {
        let Pair { own, other, separation, .. } = pair;
        let (cohesive_volume, distance) = (self.0.cohesive_volume::<V, N>(pair), pair.distance);
        let slope = self.0.kernel.slope(cohesive_volume, distance);
        let (mut terms, mut along) = ([N::constant(0.0); AXES], N::constant(0.0));
        for axis in 0..V::DIMENSION {
            terms[axis] = other[V::DIMENSION + axis] - own[V::DIMENSION + axis];
            along += terms[axis] * separation[axis];
        }
        let [_, repulsion] = self.0.overlap::<V, N>(pair);
        let push = self.0.kernel.bend(cohesive_volume, distance) * along + N::constant(2.0) * repulsion * N::of(self.0.contact)
            - (content::<V, N>(own) + content::<V, N>(other)) * slope;
        for axis in 0..V::DIMENSION {
            terms[axis] = slope * terms[axis] + push * separation[axis];
        }
        terms
    }
}

impl<V: Vector, K: Shape, const MIXED: bool> ImagePressure<V, AXES> for TensionForce<V::Scalar, K, MIXED> {}

/// The surface tension of the fluids of a scene.
pub struct Tension<V: Vector, K, const MIXED: bool> {
    color_field: ColorField<V::Scalar, K, MIXED>,
    force: TensionForce<V::Scalar, K, MIXED>,
    /// Lattice sum S.
    rest: f64,
    /// κS.
    rest_scale: f64,
    /// Moduli A [Pa] and B [N] of each material.
    moduli: [[f64; 2]; KINDS],
    /// [`Tension::stiffness`] of each material.
    stiffness: [f64; KINDS],
    /// Sums of [`ColorField`] and [`TensionForce`] by slot.
    color_sums: Vec<[V::Scalar; COLOR_SUMS]>,
    forces: Vec<[V::Scalar; AXES]>,
}

impl<V: Vector, K: Shape, const MIXED: bool> Tension<V, K, MIXED> {
    /// Surface tension of `count` particles of these materials; None if no fluid has it.
    pub fn new(kernel: Kernel<V::Scalar, K>, waves: &[Wave], materials: &Materials, count: usize) -> Option<Self> {
        if materials.fluids.iter().all(|fluid| fluid.surface_tension == 0.0) {
            return None;
        }
        let common = materials.first();
        let ratio = common.spacing / common.smoothing_length;
        let (rest, scale) = kernel::lattice_density::<K>(ratio, V::DIMENSION);
        let unit = moduli::<K>(ratio, V::DIMENSION);
        let h = common.smoothing_length;
        let tension = |fluid: &Material| fluid.surface_tension / SETTLED[V::DIMENSION - 2];
        let of = |fluid: &Material| [unit[0] / h, unit[1] * h].map(|modulus| modulus * tension(fluid));
        let color = materials.pairs(|one, other| if one == other { 1.0 } else { 0.0 });
        let firm = |fluid: &Material| FIRMNESS * tension(fluid) / fluid.spacing;
        let mut repulsion = materials.pairs(|one, other| if one == other { firm(one) } else { 0.0 });
        // Obstacles repel by their pressure alone.
        repulsion[usize::from(OBSTACLE)].fill(V::Scalar::ZERO);
        repulsion.iter_mut().for_each(|row| row[usize::from(OBSTACLE)] = V::Scalar::ZERO);
        let cohesion = std::array::from_fn(|kind| Cohesion { color: color[kind], repulsion: repulsion[kind] });
        let contact = V::Scalar::from_f64((CONTACT * common.spacing).powi(-2));
        let laws = Common { kernel, cohesion, for_particle: cohesion[0], contact };
        // The stiffness of a lattice wave, by its `frequency` in the kernel, and of a particle between two contacts.
        let rest_scale = rest * scale;
        let stiffness = |fluid: &Material| {
            let [area, gradient] = of(fluid);
            let through =
                |wave: &Wave| (area / rest_scale.powi(2) + gradient * (wave.number / h).powi(2)) * (wave.frequency / h).powi(2);
            let contacts = 2.0 * 4.0 * firm(fluid) / (CONTACT * fluid.spacing).powi(2);
            waves.iter().map(through).fold(0.0, f64::max) + contacts
        };
        let each: [f64; KINDS] = std::array::from_fn(|kind| materials.fluids.get(kind).map_or(0.0, stiffness));
        let stiffest = each.iter().copied().fold(0.0, f64::max);
        Some(Self {
            color_field: ColorField(laws),
            force: TensionForce(laws),
            rest,
            rest_scale,
            // An obstacle takes the stiffest fluid.
            stiffness: std::array::from_fn(|kind| if kind == usize::from(OBSTACLE) { stiffest } else { each[kind] }),
            moduli: std::array::from_fn(|kind| materials.fluids.get(kind).map_or([0.0; 2], of)),
            color_sums: vec![[V::Scalar::ZERO; COLOR_SUMS]; count],
            forces: vec![[V::Scalar::ZERO; AXES]; count],
        })
    }

    /// Computes the color sums from records that it rewrites; `volume` is the rest volume of a member [m^D].
    fn sum_color(
        law: ColorField<V::Scalar, K, MIXED>,
        (neighbor_list, records): (&NeighborList, &mut Records<V>),
        walls: &Walls,
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
        walls: &Walls,
        kind: &[u8],
        volume: &(impl Fn(usize) -> f64 + Sync),
        executor: &Executor,
    ) {
        let Self { color_field, force, rest, rest_scale, moduli, color_sums, forces, .. } = self;
        Self::sum_color(*color_field, (neighbor_list, records), walls, kind, volume, color_sums, executor);
        let neighbors = neighbor_list.neighbors();
        let slots = neighbors.slots();
        records.fill(neighbors, neighbor_list.positions(), executor, &|member, record| {
            let (sums, [area, gradient]) = (&color_sums[slots[member] as usize], moduli[usize::from(kind[member])]);
            for axis in 0..V::DIMENSION {
                record[V::DIMENSION + axis] = V::Scalar::from_f64(gradient) * sums[axis];
            }
            record[2 * V::DIMENSION] = V::Scalar::from_f64(volume(member)).tagged(kind[member]);
            let missing = 1.0 - sums[COLOR].to_f64() / *rest;
            record[2 * V::DIMENSION + 1] = V::Scalar::from_f64(-area * missing / *rest_scale);
        });
        records.sum(neighbors, *force, forces, executor);
        walls.add(*force, &FREE_SLIP, (neighbor_list, records), forces, executor);
    }

    /// Force density of the particle at a slot, per rest volume [N/m^D].
    pub fn force(&self, slot: usize) -> &[V::Scalar; AXES] {
        &self.forces[slot]
    }

    /// Energy of all particles [J], with arguments as in `sum_color`.
    pub fn energy(
        &self,
        (neighbor_list, records): (&NeighborList, &mut Records<V>),
        walls: &Walls,
        kind: &[u8],
        volume: &(impl Fn(usize) -> f64 + Sync),
        executor: &Executor,
    ) -> f64 {
        let mut color_sums = self.color_sums.clone();
        Self::sum_color(self.color_field, (neighbor_list, records), walls, kind, volume, &mut color_sums, executor);
        let energy = |(member, &slot): (usize, &u32)| {
            let (sums, [area, gradient]) = (color_sums[slot as usize].map(Real::to_f64), self.moduli[usize::from(kind[member])]);
            let missing = 1.0 - sums[COLOR] / self.rest;
            let square: f64 = sums[..V::DIMENSION].iter().map(|along| along * along).sum();
            // Each particle accounts for half of a contact's energy.
            volume(member) * (0.5 * area * missing * missing + 0.5 * gradient * square + 0.25 * sums[OVERLAP])
        };
        neighbor_list.neighbors().slots().iter().enumerate().map(energy).sum()
    }

    /// The largest stiffness of a particle of a material, per rest volume [N/m^(D+1)].
    pub fn stiffness(&self, kind: u8) -> f64 {
        self.stiffness[usize::from(kind)]
    }

    /// The memory that it takes [bytes].
    pub fn bytes(&self) -> usize {
        std::mem::size_of_val(self.color_sums.as_slice()) + std::mem::size_of_val(self.forces.as_slice())
    }
}

/// A and B for unit tension, unit smoothing length and this spacing: the outermost layer of a flat lattice is in
/// equilibrium, and the layers together have unit energy.
fn moduli<K: Shape>(spacing: f64, dimension: usize) -> [f64; 2] {
    let (rest, scale) = kernel::lattice_density::<K>(spacing, dimension);
    let kernel = Kernel::<f64, K>::new(1.0, spacing, dimension);
    // Layers count from the surface; a neighbor at x outward exists if its layer does.
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
    let [pull, lift] = [forces[0] / energies[0], forces[1] / energies[1]];
    [lift / (lift - pull) / energies[0], pull / (pull - lift) / energies[1]]
}

#[cfg(test)]
mod tests {
    use super::super::kernel::{CubicSpline, WendlandC2, WendlandC4};
    use super::*;

    #[test]
    fn both_parts_hold_a_surface_together() {
        fn check<K: Shape>() {
            for (dimension, smoothing) in [(2, 1.5), (3, 1.25), (3, 1.5)] {
                let [area, gradient] = moduli::<K>(1.0 / smoothing, dimension);
                assert!(area > 0.0 && gradient > 0.0, "{} in {dimension}D: {area} {gradient}", std::any::type_name::<K>());
            }
        }
        check::<WendlandC2>();
        check::<WendlandC4>();
        check::<CubicSpline>();
    }
}
