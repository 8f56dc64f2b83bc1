//! Detection of free surfaces and of lumps, by the sums of the kernel gradient.

use glam::DVec3;

use super::images::{ImagePressure, WallCondition};
use super::kernel::{KernelShape, SmoothingKernel};
use super::lattice;
use super::material::Material;
use super::records::volume;
use super::walls::FluidWalls;
use crate::math::{AXES, Real, Vector};
use crate::neighbors::NeighborList;
use crate::neighbors::sums::{Pair, PairLaw, Records};
use crate::parallel::Executor;
use crate::simd::Number;

/// Ratio of Σ Vⱼ |∇W| to its value inside, below which a particle is at a free surface. The ratio is two thirds in the uppermost
/// row, and 0.94 or more in the second. For ∇·r, which is about the same, E.-S. Lee et al., J. Comput. Phys. 227 (2008) 8417,
/// take 0.75 to 0.8.
const SURFACE: f64 = 0.8;

/// Kernel gradient sums: Σ Vⱼ ∇W along each axis [1/m], 0 inside the fluid and largest at a free surface; and Σ Vⱼ |∇W| [1/m],
/// which grows with compression.
#[derive(Debug, Clone, Copy)]
struct KernelGradientSum<T, K> {
    kernel: SmoothingKernel<T, K>,
}

/// Number of sums of [`KernelGradientSum`].
const GRADIENT_SUMS: usize = AXES + 1;

impl<V: Vector, K: KernelShape> PairLaw<V, GRADIENT_SUMS> for KernelGradientSum<V::Scalar, K> {
    #[inline(always)]
    fn terms<N: Number<Scalar = V::Scalar>>(&self, pair: &Pair<N>) -> [N; GRADIENT_SUMS] {
        let (distance, zero) = (pair.distance, N::constant(0.0));
        let weight = self.kernel.slope(volume::<V, N>(&pair.other), distance);
        let mut terms = [zero; GRADIENT_SUMS];
        for axis in 0..V::DIMENSION {
            terms[axis] = weight * pair.separation[axis];
        }
        // Padding of the lists has infinite distance.
        terms[AXES] = (zero - weight * distance).masked(weight.less(zero));
        terms
    }
}

impl<V: Vector, K: KernelShape> ImagePressure<V, GRADIENT_SUMS> for KernelGradientSum<V::Scalar, K> {}

/// Surroundings of a particle.
#[derive(Debug, Clone, Copy)]
pub struct Surroundings {
    /// Size of Σ Vⱼ ∇W [1/m], 0 inside the fluid.
    pub imbalance: f64,
    /// Ratio of Σ Vⱼ |∇W| to its value in a lattice.
    pub closeness: f64,
}

impl Surroundings {
    /// Whether the particle is at a free surface.
    #[inline]
    pub fn are_open(self) -> bool {
        self.closeness < SURFACE
    }
}

/// Sums that detect free surfaces of fluids and obstacles.
#[derive(Debug)]
pub struct FreeSurface<V: Vector, K> {
    law: KernelGradientSum<V::Scalar, K>,
    /// Sums of [`KernelGradientSum`] by slot.
    gradients: Vec<[V::Scalar; GRADIENT_SUMS]>,
    /// Lattice value of Σ Vⱼ |∇W| [1/m].
    lattice_gradient: f64,
}

impl<V: Vector, K: KernelShape> FreeSurface<V, K> {
    /// Surface of `count` particles of a fluid.
    pub fn new(kernel: SmoothingKernel<V::Scalar, K>, fluid: &Material, count: usize) -> Self {
        let h = fluid.smoothing_length;
        Self {
            law: KernelGradientSum { kernel },
            gradients: vec![[V::Scalar::ZERO; GRADIENT_SUMS]; count],
            lattice_gradient: lattice::gradient(kernel.shape, fluid.spacing / h, V::DIMENSION) / h,
        }
    }

    /// Computes the sums with new lists, from records of volumes.
    pub fn update(&mut self, (neighbor_list, records): (&NeighborList, &Records<V>), walls: &FluidWalls, executor: &Executor) {
        let Self { law, gradients, .. } = self;
        records.sum(neighbor_list.neighbors(), *law, gradients, executor);
        walls.add(*law, &WallCondition { weight: DVec3::ZERO, no_slip: false }, (neighbor_list, records), gradients, executor);
    }

    /// Surroundings of the particle at a slot.
    #[inline]
    pub fn around(&self, slot: usize) -> Surroundings {
        let sums = self.gradients[slot].map(Real::to_f64);
        let imbalance = sums[..AXES].iter().map(|sum| sum * sum).sum::<f64>().sqrt();
        Surroundings { imbalance, closeness: sums[AXES] / self.lattice_gradient }
    }

    /// Memory [bytes].
    #[inline]
    pub fn bytes(&self) -> usize {
        std::mem::size_of_val(self.gradients.as_slice())
    }
}
