//! Density by summation over the particle positions.
//!
//! The density is ρᵢ = ρ₀ [1 + κ (Σ V₀ W − S)], where V₀ is the rest volume of a particle. S and κ are such that a lattice at
//! rest has the density ρ₀, and a small compression of it is exact. All materials have the same weight, so that a light fluid is
//! not compressed by a heavy one next to it. With E = Σ m e(ρ) and p = ρ² de/dρ the force is
//!
//! ```text
//! Fᵢ = −∂E/∂xᵢ = −V₀ Σ V₀ (Pᵢ + Pⱼ) κ∇W,  P = p (ρ₀/ρ)²
//! ```
//!
//! This is the force of [`super::laws`] with V₀ in place of V and P in place of p. Energy is then a function of positions and
//! velocities alone, without drift.
//!
//! Source: J. Bonet and T.-S. L. Lok, Comput. Methods Appl. Mech. Eng. 180 (1999) 97.

use glam::DVec3;

use crate::error::{Error, Result};
use crate::math::{Real, Vector};
use crate::neighbors::NeighborList;
use crate::neighbors::sums::{Pair, PairLaw, Records};
use crate::parallel::{BlockedSlice, Executor};
use crate::particles::images::{ImagePressure, WallCondition};
use crate::particles::kernel::{KernelShape, SmoothingKernel};
use crate::particles::lattice;
use crate::particles::records::volume;
use crate::particles::walls::FluidWalls;
use crate::particles::{BLOCK, Materials};
use crate::simd::Number;

/// Smallest initial density in units of ρ₀ of a fluid that fills its domain. Next to a free surface the density is 0.8 or less.
const LEAST: f64 = 0.9;

/// Number density Σ Vⱼ W, for density by summation.
#[derive(Debug, Clone, Copy)]
struct NumberDensity<T, K> {
    kernel: SmoothingKernel<T, K>,
}

impl<V: Vector, K: KernelShape> PairLaw<V, 1> for NumberDensity<V::Scalar, K> {
    #[inline(always)]
    fn terms<N: Number<Scalar = V::Scalar>>(&self, pair: &Pair<N>) -> [N; 1] {
        [volume::<V, N>(&pair.other) * self.kernel.value(pair.distance)]
    }
}

impl<V: Vector, K: KernelShape> ImagePressure<V, 1> for NumberDensity<V::Scalar, K> {}

/// Density by summation.
pub struct Summation<V: Vector, K> {
    law: NumberDensity<V::Scalar, K>,
    /// Lattice sum S.
    rest: f64,
    /// Factor κ.
    scale: f64,
    /// Sums Σ V₀ W by slot.
    sums: Vec<[V::Scalar; 1]>,
    /// Whether the initial density has been checked.
    is_checked: bool,
}

impl<V: Vector, K: KernelShape> Summation<V, K> {
    /// Summation over `count` particles with a common kernel.
    #[inline]
    pub fn new(kernel: SmoothingKernel<V::Scalar, K>, materials: &Materials, count: usize) -> Self {
        let common = materials.first();
        let (rest, scale) = lattice::density(kernel.shape, common.spacing / common.smoothing_length, V::DIMENSION);
        Self { law: NumberDensity { kernel }, rest, scale, sums: vec![[V::Scalar::ZERO]; count], is_checked: false }
    }

    /// Sums the density of every fluid particle [kg/m³], from records of V₀.
    ///
    /// # Errors
    /// If the fluid does not fill its domain at the first summation.
    pub fn count(
        &mut self,
        (neighbor_list, records): (&NeighborList, &Records<V>),
        walls: &FluidWalls,
        (materials, kind): (&Materials, &[u8]),
        density: &mut [f64],
        executor: &Executor,
    ) -> Result<()> {
        let Self { law, rest, scale, sums, is_checked } = self;
        records.sum(neighbor_list.neighbors(), *law, sums, executor);
        let condition = WallCondition { weight: DVec3::ZERO, no_slip: false };
        walls.add(*law, &condition, (neighbor_list, records), sums, executor);
        let slots = neighbor_list.neighbors().slots();
        executor.for_each_block(BlockedSlice::new(density, BLOCK), &|densities| {
            for (member, density) in (densities.start..).zip(densities.items) {
                let Some(fluid) = materials.fluid(kind[member]) else { continue };
                *density = fluid.density * (1.0 + *scale * (sums[slots[member] as usize][0].to_f64() - *rest));
            }
        });
        if !*is_checked && !executor.stopped() {
            *is_checked = true;
            let part = |(kind, density): (&u8, &f64)| materials.fluid(*kind).map(|fluid| density / fluid.density);
            let least = kind.iter().zip(&*density).filter_map(part).fold(f64::INFINITY, f64::min);
            if least < LEAST {
                let body = materials.of_body.iter().position(|of| *of == Some(0)).unwrap_or(0);
                let found = format!("a particle in surroundings of {:.0} % of the density at rest", 100.0 * least);
                return Err(Error::parameter(format!("bodies[{body}].density_from"), "a fluid that fills its space", found)
                    .with_hint("summation has nothing to count beyond a free surface; continuity has no need of it"));
            }
        }
        Ok(())
    }

    /// Memory [bytes].
    #[inline]
    pub fn bytes(&self) -> usize {
        std::mem::size_of_val(self.sums.as_slice())
    }
}
