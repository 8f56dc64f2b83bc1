//! Density by summation: counted from where the particles are.
//!
//! ρᵢ = ρ₀ [1 + κ (Σ V₀ W − S)], where V₀ is the volume of a particle at rest and S and κ are such that a lattice at rest has
//! the density ρ₀, and a small compression of it is exact. Particles of all materials count alike, so that a light fluid is not
//! squeezed by a heavy one next to it. With E = Σ m e(ρ) and p = ρ² de/dρ the force is
//!
//! ```text
//! Fᵢ = −∂E/∂xᵢ = −V₀ Σ V₀ (Pᵢ + Pⱼ) κ∇W,  P = p (ρ₀/ρ)²
//! ```
//!
//! which is that of [`super::laws`] with V₀ in place of V and P in place of p (J. Bonet and T.-S. L. Lok, Comput. Methods Appl.
//! Mech. Eng. 180 (1999) 97): energy then depends on positions and velocities alone, and nothing drifts.

use glam::DVec3;

use super::BLOCK;
use super::images::View;
use super::kernel::{self, Kernel, Shape};
use super::laws::NumberDensity;
use super::start::Materials;
use super::walls::Walls;
use crate::error::{Error, Result};
use crate::forces::neighbor_list::NeighborList;
use crate::math::{Real, Vector};
use crate::neighbors::sums::Records;
use crate::parallel::{BlockedSlice, Executor};

/// Where less is counted than this part of ρ₀ at the start, something is missing. Next to a free surface it is 0.8 or less.
const LEAST: f64 = 0.9;

/// How density is counted.
pub struct Summation<V: Vector, K> {
    law: NumberDensity<V::Scalar, K>,
    /// S.
    rest: f64,
    /// κ.
    scale: f64,
    /// What is counted, in the order of slots.
    counts: Vec<[V::Scalar; 1]>,
    /// Whether it is known that the fluid fills its space.
    is_checked: bool,
}

impl<V: Vector, K: Shape> Summation<V, K> {
    /// For `count` particles of fluids that have this kernel in common.
    pub fn new(kernel: Kernel<V::Scalar, K>, materials: &Materials, count: usize) -> Self {
        let common = materials.first();
        let (rest, scale) = kernel::crowd::<K>(common.spacing / common.smoothing_length, V::DIMENSION);
        Self { law: NumberDensity { kernel }, rest, scale, counts: vec![[V::Scalar::ZERO]; count], is_checked: false }
    }

    /// Counts the density of every fluid particle [kg/m³], by means of records that hold V₀.
    ///
    /// # Errors
    /// If the fluid does not fill its space when it is counted for the first time.
    pub fn count(
        &mut self,
        (neighbor_list, records): (&NeighborList, &Records<V>),
        walls: &Walls,
        (materials, kind): (&Materials, &[u8]),
        density: &mut [f64],
        executor: &Executor,
    ) -> Result<()> {
        let Self { law, rest, scale, counts, is_checked } = self;
        records.sum(neighbor_list.neighbors(), *law, counts, executor);
        let view = View { weight: DVec3::ZERO, sticks: false };
        walls.add(*law, &view, (neighbor_list, records), counts, executor);
        let slots = neighbor_list.neighbors().slots();
        executor.for_each_block(BlockedSlice::new(density, BLOCK), &|densities| {
            for (member, density) in (densities.start..).zip(densities.items) {
                let Some(fluid) = materials.fluid(kind[member]) else { continue };
                *density = fluid.density * (1.0 + *scale * (counts[slots[member] as usize][0].to_f64() - *rest));
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

    /// The memory that it takes [bytes].
    pub fn bytes(&self) -> usize {
        std::mem::size_of_val(self.counts.as_slice())
    }
}
