//! Surface tension, as the energy of particles that lack neighbors of their own kind.
//!
//! With the cover c = Σ Vⱼ W / S, which is 1 inside a lattice at rest, and its gradient g = κ Σ Vⱼ ∇W, both over fluid of the same
//! kind, its images in walls, and obstacles, with volumes at rest and r₀ below the distance of particles:
//!
//! ```text
//! E = Σ Vᵢ [½ A (1 − cᵢ)² + ½ B |gᵢ|²] + Σ ½ C (1 − r²/r₀²)₊²
//! Fᵢ = −∂E/∂xᵢ = −Vᵢ Σ Vⱼ [(aᵢ + aⱼ) κ∇W + κ∇∇W (bᵢ − bⱼ)] + Σ 2 C (1 − r²/r₀²)₊ d/r₀²,  a = −A (1 − c)/κS,  b = B g
//! ```
//!
//! The first two parts and their first derivatives vanish in every lattice of that density: the fluid gains neither pressure nor
//! stiffness against shear. A and B are such that a surface that has settled has the energy σ. The first part alone
//! pulls the outermost layer in, and gathers particles; the second alone lifts it off: each has the share that leaves this
//! layer in balance. To what is left of that, a rearrangement of single particles, pressure is blind, because it knows density
//! alone; the third part keeps them from collapsing into pairs. At rest nobody is so near.
//!
//! Energy, momentum and angular momentum are so those of positions and velocities alone. The first part is cohesion as in S. Nugent
//! and H. A. Posch, Phys. Rev. E 62 (2000) 4968, by the density around both; the second is the energy of a gradient, J. W. Cahn
//! and J. E. Hilliard, J. Chem. Phys. 28 (1958) 258, whose simplified force is that of N. Akinci, G. Akinci and M. Teschner, ACM
//! Trans. Graph. 32 (2013) 182, against area. Between two fluids each has its own: the tension of the interface is their sum.

use glam::DVec3;

use super::images::{Pressed, View};
use super::kernel::{self, Kernel, Shape, Wave};
use super::laws::{KINDS, OBSTACLE, content, pick, volume};
use super::start::{Material, Materials};
use super::walls::Walls;
use crate::forces::neighbor_list::NeighborList;
use crate::math::{AXES, Real, Vector};
use crate::neighbors::sums::{Pair, PairLaw, Records};
use crate::parallel::Executor;
use crate::simd::{Number, Record};

/// r₀ in units of the distance of particles at rest: balls so large fill a third of the space in 3D, and jam at two thirds.
const CONTACT: f64 = 0.85;

/// C in units of σΔ^(D−1).
const FIRMNESS: f64 = 8.0;

/// What is left of the energy of a lattice's flat surface when its particles have settled, in 2D and 3D: measured on drops of 20 to
/// 30 spacings in 2D (0.745) and of 10 to 16 in 3D (0.45 to 0.50), with Wendland's C2 and h = 1.5 Δ.
const SETTLED: [f64; 2] = [0.75, 0.5];

/// Images in walls are as their originals.
const VIEW: View = View { weight: DVec3::ZERO, sticks: false };

/// The sums of [`ColorField`]: g along each axis, c S, and the energy of contacts over that of one.
const COVER: usize = AXES + 2;
const CROWD: usize = AXES;
const TOUCH: usize = AXES + 1;

/// Which materials hold together: 1 or 0 for those that cover each other, and C/V for those that touch each other.
#[derive(Debug, Clone, Copy)]
struct Bonds<T> {
    covers: [T; KINDS],
    touches: [T; KINDS],
}

/// What both laws know: the bonds of every kind, and those of the particle that is faced.
#[derive(Debug, Clone, Copy)]
struct Common<T, K, const MIXED: bool> {
    kernel: Kernel<T, K>,
    bonds: [Bonds<T>; KINDS],
    for_particle: Bonds<T>,
    /// 1/r₀² [1/m²].
    contact: T,
}

impl<T: Real, K: Shape, const MIXED: bool> Common<T, K, MIXED> {
    #[inline(always)]
    fn for_particle<V: Vector<Scalar = T>>(mut self, own: &Record<T>) -> Self {
        if MIXED {
            self.for_particle = self.bonds[usize::from(volume::<V, _>(own).tag())];
        }
        self
    }

    /// The volume of another, if it covers the one that is faced.
    #[inline(always)]
    fn kin<V: Vector<Scalar = T>, N: Number<Scalar = T>>(&self, pair: &Pair<N>) -> N {
        let volume = volume::<V, N>(&pair.other);
        if MIXED { volume * pick::<N, MIXED>(volume, &self.for_particle.covers) } else { volume }
    }

    /// (1 − r²/r₀²)₊, and C/V times that.
    #[inline(always)]
    fn overlap<V: Vector<Scalar = T>, N: Number<Scalar = T>>(&self, pair: &Pair<N>) -> [N; 2] {
        let depth = (N::constant(1.0) - pair.square * N::of(self.contact)).max(N::constant(0.0));
        [depth, depth * pick::<N, MIXED>(volume::<V, N>(&pair.other), &self.for_particle.touches)]
    }
}

/// What covers a particle.
#[derive(Debug, Clone, Copy)]
struct ColorField<T, K, const MIXED: bool>(Common<T, K, MIXED>);

impl<V: Vector, K: Shape, const MIXED: bool> PairLaw<V, COVER> for ColorField<V::Scalar, K, MIXED> {
    #[inline(always)]
    fn for_particle(self, own: &Record<V::Scalar>) -> Self {
        Self(self.0.for_particle::<V>(own))
    }

    #[inline(always)]
    fn terms<N: Number<Scalar = V::Scalar>>(&self, pair: &Pair<N>) -> [N; COVER] {
        let (kin, distance) = (self.0.kin::<V, N>(pair), pair.square.sqrt());
        let slope = self.0.kernel.slope(kin, distance);
        let mut terms = [N::constant(0.0); COVER];
        for axis in 0..V::DIMENSION {
            terms[axis] = slope * pair.separation[axis];
        }
        terms[CROWD] = kin * self.0.kernel.value(distance);
        let [depth, force] = self.0.overlap::<V, N>(pair);
        terms[TOUCH] = depth * force;
        terms
    }
}

impl<V: Vector, K: Shape, const MIXED: bool> Pressed<V, COVER> for ColorField<V::Scalar, K, MIXED> {}

/// The force over Vᵢ, of records that hold b and a.
#[derive(Debug, Clone, Copy)]
struct Pull<T, K, const MIXED: bool>(Common<T, K, MIXED>);

impl<V: Vector, K: Shape, const MIXED: bool> PairLaw<V, AXES> for Pull<V::Scalar, K, MIXED> {
    #[inline(always)]
    fn for_particle(self, own: &Record<V::Scalar>) -> Self {
        Self(self.0.for_particle::<V>(own))
    }

    #[inline(always)]
    fn terms<N: Number<Scalar = V::Scalar>>(&self, pair: &Pair<N>) -> [N; AXES] {
        let Pair { own, other, separation, .. } = pair;
        let (kin, distance) = (self.0.kin::<V, N>(pair), pair.square.sqrt());
        let slope = self.0.kernel.slope(kin, distance);
        let (mut terms, mut along) = ([N::constant(0.0); AXES], N::constant(0.0));
        for axis in 0..V::DIMENSION {
            terms[axis] = other[V::DIMENSION + axis] - own[V::DIMENSION + axis];
            along += terms[axis] * separation[axis];
        }
        let [_, touch] = self.0.overlap::<V, N>(pair);
        let push = self.0.kernel.bend(kin, distance) * along + N::constant(2.0) * touch * N::of(self.0.contact)
            - (content::<V, N>(own) + content::<V, N>(other)) * slope;
        for axis in 0..V::DIMENSION {
            terms[axis] = slope * terms[axis] + push * separation[axis];
        }
        terms
    }
}

impl<V: Vector, K: Shape, const MIXED: bool> Pressed<V, AXES> for Pull<V::Scalar, K, MIXED> {}

/// The surface tension of the fluids of a scene.
pub struct Tension<V: Vector, K, const MIXED: bool> {
    cover: ColorField<V::Scalar, K, MIXED>,
    pull: Pull<V::Scalar, K, MIXED>,
    /// S.
    rest: f64,
    /// κS.
    rest_scale: f64,
    /// A [Pa] and B [N] of each kind.
    moduli: [[f64; 2]; KINDS],
    /// What [`Tension::stiffness`] gives of each kind.
    stiffness: [f64; KINDS],
    /// What the laws give, in the order of slots.
    covers: Vec<[V::Scalar; COVER]>,
    forces: Vec<[V::Scalar; AXES]>,
}

impl<V: Vector, K: Shape, const MIXED: bool> Tension<V, K, MIXED> {
    /// That of `count` particles of these materials, if any has one.
    pub fn new(kernel: Kernel<V::Scalar, K>, waves: &[Wave], materials: &Materials, count: usize) -> Option<Self> {
        if materials.fluids.iter().all(|fluid| fluid.surface_tension == 0.0) {
            return None;
        }
        let common = materials.first();
        let ratio = common.spacing / common.smoothing_length;
        let (rest, scale) = kernel::crowd::<K>(ratio, V::DIMENSION);
        let unit = moduli::<K>(ratio, V::DIMENSION);
        let h = common.smoothing_length;
        let tension = |fluid: &Material| fluid.surface_tension / SETTLED[V::DIMENSION - 2];
        let of = |fluid: &Material| [unit[0] / h, unit[1] * h].map(|modulus| modulus * tension(fluid));
        let covers = materials.pairs(|one, other| if one == other { 1.0 } else { 0.0 });
        let firm = |fluid: &Material| FIRMNESS * tension(fluid) / fluid.spacing;
        let mut touches = materials.pairs(|one, other| if one == other { firm(one) } else { 0.0 });
        // A wall of obstacles is held off by its pressure.
        touches[usize::from(OBSTACLE)].fill(V::Scalar::ZERO);
        touches.iter_mut().for_each(|row| row[usize::from(OBSTACLE)] = V::Scalar::ZERO);
        let bonds = std::array::from_fn(|kind| Bonds { covers: covers[kind], touches: touches[kind] });
        let contact = V::Scalar::from_f64((CONTACT * common.spacing).powi(-2));
        let laws = Common { kernel, bonds, for_particle: bonds[0], contact };
        // That of a wave in a lattice, of which the kernel lets `frequency` through, and of a particle between two contacts.
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
            cover: ColorField(laws),
            pull: Pull(laws),
            rest,
            rest_scale,
            // An obstacle is pulled with the force on the fluid in its place.
            stiffness: std::array::from_fn(|kind| if kind == usize::from(OBSTACLE) { stiffest } else { each[kind] }),
            moduli: std::array::from_fn(|kind| materials.fluids.get(kind).map_or([0.0; 2], of)),
            covers: vec![[V::Scalar::ZERO; COVER]; count],
            forces: vec![[V::Scalar::ZERO; AXES]; count],
        })
    }

    /// Finds what covers each particle, by means of records that it writes anew; `volume` is that of a member at rest [m^D].
    fn survey(
        law: ColorField<V::Scalar, K, MIXED>,
        (neighbor_list, records): (&NeighborList, &mut Records<V>),
        walls: &Walls,
        kind: &[u8],
        volume: &(impl Fn(usize) -> f64 + Sync),
        covers: &mut [[V::Scalar; COVER]],
        executor: &Executor,
    ) {
        let neighbors = neighbor_list.neighbors();
        records.fill(neighbors, neighbor_list.positions(), executor, &|member, record| {
            record[2 * V::DIMENSION] = V::Scalar::from_f64(volume(member)).tagged(kind[member]);
        });
        records.sum(neighbors, law, covers, executor);
        walls.add(law, &VIEW, (neighbor_list, records), covers, executor);
    }

    /// Finds the forces, likewise.
    pub fn pull(
        &mut self,
        (neighbor_list, records): (&NeighborList, &mut Records<V>),
        walls: &Walls,
        kind: &[u8],
        volume: &(impl Fn(usize) -> f64 + Sync),
        executor: &Executor,
    ) {
        let Self { cover, pull, rest, rest_scale, moduli, covers, forces, .. } = self;
        Self::survey(*cover, (neighbor_list, records), walls, kind, volume, covers, executor);
        let neighbors = neighbor_list.neighbors();
        let slots = neighbors.slots();
        records.fill(neighbors, neighbor_list.positions(), executor, &|member, record| {
            let (cover, [area, gradient]) = (&covers[slots[member] as usize], moduli[usize::from(kind[member])]);
            for axis in 0..V::DIMENSION {
                record[V::DIMENSION + axis] = V::Scalar::from_f64(gradient) * cover[axis];
            }
            record[2 * V::DIMENSION] = V::Scalar::from_f64(volume(member)).tagged(kind[member]);
            let missing = 1.0 - cover[CROWD].to_f64() / *rest;
            record[2 * V::DIMENSION + 1] = V::Scalar::from_f64(-area * missing / *rest_scale);
        });
        records.sum(neighbors, *pull, forces, executor);
        walls.add(*pull, &VIEW, (neighbor_list, records), forces, executor);
    }

    /// The force on the particle at a slot, over its volume at rest [N/m^D].
    pub fn force(&self, slot: usize) -> &[V::Scalar; AXES] {
        &self.forces[slot]
    }

    /// The energy of all particles [J], likewise.
    pub fn energy(
        &self,
        (neighbor_list, records): (&NeighborList, &mut Records<V>),
        walls: &Walls,
        kind: &[u8],
        volume: &(impl Fn(usize) -> f64 + Sync),
        executor: &Executor,
    ) -> f64 {
        let mut covers = self.covers.clone();
        Self::survey(self.cover, (neighbor_list, records), walls, kind, volume, &mut covers, executor);
        let energy = |(member, &slot): (usize, &u32)| {
            let (cover, [area, gradient]) = (covers[slot as usize].map(Real::to_f64), self.moduli[usize::from(kind[member])]);
            let missing = 1.0 - cover[CROWD] / self.rest;
            let square: f64 = cover[..V::DIMENSION].iter().map(|along| along * along).sum();
            // Of a contact each has half.
            volume(member) * (0.5 * area * missing * missing + 0.5 * gradient * square + 0.25 * cover[TOUCH])
        };
        neighbor_list.neighbors().slots().iter().enumerate().map(energy).sum()
    }

    /// The largest stiffness that a particle of a kind meets, over its volume at rest [N/m^(D+1)].
    pub fn stiffness(&self, kind: u8) -> f64 {
        self.stiffness[usize::from(kind)]
    }

    /// The memory that it takes [bytes].
    pub fn bytes(&self) -> usize {
        std::mem::size_of_val(self.covers.as_slice()) + std::mem::size_of_val(self.forces.as_slice())
    }
}

/// A and B for unit tension and smoothing length and this spacing: those with which the outermost layer of a flat lattice is in
/// balance and its layers together have unit energy.
fn moduli<K: Shape>(spacing: f64, dimension: usize) -> [f64; 2] {
    let (rest, scale) = kernel::crowd::<K>(spacing, dimension);
    let kernel = Kernel::<f64, K>::new(1.0, spacing, dimension);
    // Counted from the surface; a neighbor further out by x is there if its layer is.
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
