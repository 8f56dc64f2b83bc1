//! Obstacles: particles of other bodies that displace fluid and bear its pressure.

use glam::DVec3;

use super::BLOCK;
use super::kernel::{KernelShape, SmoothingKernel};
use super::material::{KINDS, Material, Materials, OBSTACLE};
use super::records::{content, is_obstacle, pick, volume};
use crate::math::{AXES, Real, Vector};
use crate::neighbors::NeighborList;
use crate::neighbors::sums::{Pair, PairLaw, Records};
use crate::parallel::{BlockedSlice, Executor};
use crate::simd::Number;

/// Pressure extrapolated to an obstacle from the fluid, with the hydrostatic difference: Σ [pⱼ + ρ₀ g·d] W and Σ W. The
/// acceleration of the obstacle is omitted.
///
/// Source: S. Adami, X. Y. Hu and N. A. Adams, J. Comput. Phys. 231 (2012) 7057.
#[derive(Debug, Clone, Copy)]
struct Extrapolation<T, K> {
    kernel: SmoothingKernel<T, K>,
    /// Rest density ρ₀ of each material [kg/m³], 0 for obstacles.
    density: [T; KINDS],
    /// Gravitational acceleration g [m/s²].
    gravity: [T; AXES],
}

impl<V: Vector, K: KernelShape> PairLaw<V, 2> for Extrapolation<V::Scalar, K> {
    #[inline(always)]
    fn terms<N: Number<Scalar = V::Scalar>>(&self, pair: &Pair<N>) -> [N; 2] {
        let Pair { other, separation, distance, .. } = pair;
        let volume = volume::<V, N>(other);
        let weight = N::select(is_obstacle(volume), N::constant(0.0), self.kernel.value(*distance));
        let mut rise = N::constant(0.0);
        for axis in 0..V::DIMENSION {
            rise += N::of(self.gravity[axis]) * separation[axis];
        }
        [(content::<V, N>(other) + pick::<N, true>(volume, &self.density) * rise) * weight, weight]
    }
}

/// Obstacles of a scene.
#[derive(Debug)]
pub struct Obstacles<V: Vector, K> {
    /// Members that are obstacles.
    members: Vec<u32>,
    law: Extrapolation<V::Scalar, K>,
    /// Sums of [`Extrapolation`] for each obstacle.
    sums: Vec<[V::Scalar; 2]>,
}

impl<V: Vector, K: KernelShape> Obstacles<V, K> {
    /// Obstacles among members of these materials.
    pub fn new(kernel: SmoothingKernel<V::Scalar, K>, materials: &Materials, kind: &[u8]) -> Self {
        let members: Vec<u32> = (0..).zip(kind).filter(|(_, kind)| **kind == OBSTACLE).map(|(member, _)| member).collect();
        let gravity = materials.first().gravity.to_array().map(V::Scalar::from_f64);
        let law = Extrapolation { kernel, density: materials.rest_densities(), gravity };
        Self { sums: vec![[V::Scalar::ZERO; 2]; members.len()], members, law }
    }

    /// Members that are obstacles.
    #[inline]
    pub fn members(&self) -> &[u32] {
        &self.members
    }

    /// Whether there are no obstacles.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.members.is_empty()
    }

    /// Mass of the fluid in the volume of each obstacle below the member `end` [kg]. The volume is 1/Σ W over these obstacles.
    ///
    /// Source: N. Akinci et al., ACM Trans. Graph. 31 (2012) 62.
    pub fn masses(&self, neighbor_list: &NeighborList, kind: &[u8], end: usize, fluid: &Material) -> Vec<f64> {
        let kernel = SmoothingKernel::<f64, K>::new(self.law.kernel.shape, fluid.smoothing_length, fluid.spacing, V::DIMENSION);
        let neighbors = neighbor_list.neighbors();
        let mass = |&obstacle: &u32| {
            let slot = neighbors.slots()[obstacle as usize] as usize;
            let others = neighbors.of(slot).iter().map(|&other| neighbors.order()[other as usize] as usize);
            let solid = others.zip(neighbors.separation(slot)).filter(|&(other, _)| other < end && kind[other] == OBSTACLE);
            let near: f64 = solid.map(|(_, separation): (_, DVec3)| kernel.value(separation.length())).sum();
            // The volume of an isolated particle is bounded; otherwise it would be that of the kernel.
            (fluid.density / (near + kernel.value(0.0))).min(2.0 * fluid.mass)
        };
        self.members.iter().take_while(|&&obstacle| (obstacle as usize) < end).map(mass).collect()
    }

    /// Writes the pressure extrapolated from the fluid to the records of obstacles, from records of pressures.
    pub fn extrapolate_pressure(&mut self, neighbor_list: &NeighborList, records: &mut Records<V>, executor: &Executor) {
        let Self { members, law, sums } = self;
        let (neighbors, before) = (neighbor_list.neighbors(), &*records);
        executor.for_each_block(BlockedSlice::new(sums, BLOCK), &|mine| {
            let end = mine.start + mine.items.len();
            let mut extrapolated = mine.items.iter_mut();
            let slots = members[mine.start..end].iter().map(|&obstacle| neighbors.slots()[obstacle as usize] as usize);
            let few = slots.map(|slot| (slot, neighbors.list(slot), ()));
            before.sum_few(
                few,
                |()| *law,
                |_, sums| extrapolated.next().into_iter().for_each(|extrapolated| *extrapolated = sums),
            );
        });
        for (&obstacle, &[pressed, weight]) in members.iter().zip(&*sums) {
            // Negative pressures are cut off, because obstacles exert no suction.
            let pressure = if weight > V::Scalar::ZERO && pressed > V::Scalar::ZERO { pressed / weight } else { V::Scalar::ZERO };
            records.write(neighbors.slots()[obstacle as usize] as usize, |words| words[V::DIMENSION + 1] = pressure);
        }
    }

    /// Memory [bytes].
    #[inline]
    pub fn bytes(&self) -> usize {
        size_of::<u32>() * self.members.len()
    }
}
