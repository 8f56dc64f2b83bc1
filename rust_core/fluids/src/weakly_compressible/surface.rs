//! Free surfaces and fragmentation of a fluid: their effect on the highest frequency of sound and on the wall pressure.
//!
//! **Sound.** Compression raises all frequencies. A fragment adds others. A lump that moves with v towards its neighbors is
//! compressed at v·s, s = Σ Vⱼ ∇W, and at twice that rate if they approach it as fast: ω = 2c|s|. The larger of these frequencies
//! is an estimate. The largest singular values of the sum over v·∇W are 1 to 20 % below it, in dam breaks, drops, jets and sprays
//! along walls.
//!
//! **Walls.** Negative pressure would hold a particle at a mirror to its own image, and would hold a drop stretched between a
//! wall and an obstacle. Therefore a separating wall or obstacle at a free surface, where air enters between them, exerts no
//! pressure below that at rest.

use super::equation_of_state::CompressibleFluid;
use crate::error::Result;

use crate::history::{Archive, History};
use crate::math::{Real, Vector};

use crate::neighbors::NeighborList;
use crate::neighbors::sums::Records;
use crate::parallel::{BlockedSlice, Executor};
use crate::particles::kernel::{KernelShape, SmoothingKernel};
use crate::particles::surface::FreeSurface;
use crate::particles::walls::FluidWalls;
use crate::particles::waves::FluidWave;
use crate::particles::{BLOCK, KINDS, Material};

/// Wall factor: the fraction of a particle's pressure that acts on its images and on obstacles.
#[derive(Debug, Clone, Copy)]
pub struct WallFactor {
    /// Factors in the kick between two drifts, and in the next drift, in halves.
    kick: u8,
    drift: u8,
    /// Whether the particle is at a free surface.
    at_surface: bool,
}

impl WallFactor {
    /// The factor of a particle inside the fluid.
    const INTERIOR: Self = Self { kick: 2, drift: 2, at_surface: false };

    /// Updates the factors after a drift. `pulls` is set for a pressure below that at rest, and `stretched` for a separation from
    /// walls and obstacles.
    #[inline(always)]
    pub fn drifted(&mut self, pulls: bool, stretched: bool) {
        let next = if self.at_surface && pulls && stretched { 0 } else { 2 };
        // Each half of a kick belongs to its adjacent drift, so that separation dissipates no energy.
        (self.kick, self.drift) = (u8::midpoint(self.drift, next), next);
    }

    /// The factor in the kick between two drifts.
    #[inline(always)]
    pub fn kick(self) -> f32 {
        0.5 * f32::from(self.kick)
    }

    /// The factor in the next drift.
    #[inline(always)]
    pub fn drift(self) -> f32 {
        0.5 * f32::from(self.drift)
    }

    /// Tag of the factor in the kick: 0 for the full pressure, 1 for half of it, 2 for none.
    #[inline(always)]
    pub fn tag(self) -> u8 {
        2 - self.kick
    }

    /// The factors by tag.
    pub fn by_tag<T: Real>() -> [T; KINDS] {
        [1.0, 0.5, 0.0, 0.0].map(T::from_f64)
    }

    /// The values in an archive.
    fn numbers(self) -> [f64; 3] {
        [self.kick().into(), self.drift().into(), f64::from(u8::from(self.at_surface))]
    }
}

/// Free surfaces of fluids and obstacles, with their effect on the frequency of sound and on the pressure at walls.
#[derive(Debug)]
pub struct SurfaceEffects<V: Vector, K> {
    detection: FreeSurface<V, K>,
    /// Highest frequency in a lattice over the speed of sound [1/m].
    lattice_frequency: f64,
    /// Wall factor of each member.
    pub wall_factors: Vec<WallFactor>,
    /// Highest frequency of sound at the last build of the lists [1/s].
    highest: f64,
    /// Whether the lists were rebuilt since that update.
    pub is_stale: bool,
    /// Wall factors, highest frequency and staleness at the start of the batch.
    saved: (Vec<WallFactor>, f64, bool),
    /// Highest frequency in each block of members [1/s].
    block_highest: Vec<f64>,
}

impl<V: Vector, K: KernelShape> SurfaceEffects<V, K> {
    /// Surface of `count` particles of a fluid with these waves.
    pub fn new(kernel: SmoothingKernel<V::Scalar, K>, fluid: &Material, waves: &[FluidWave], count: usize) -> Self {
        Self {
            detection: FreeSurface::new(kernel, fluid, count),
            lattice_frequency: waves.iter().map(|wave| wave.frequency).fold(0.0, f64::max) / fluid.smoothing_length,
            wall_factors: vec![WallFactor::INTERIOR; count],
            highest: 0.0,
            is_stale: false,
            saved: (vec![WallFactor::INTERIOR; count], 0.0, false),
            block_highest: vec![0.0; count.div_ceil(BLOCK)],
        }
    }

    /// Highest frequency of sound [1/s].
    #[inline]
    pub fn highest(&self) -> f64 {
        self.highest
    }

    /// Whether no particle is at a free surface.
    #[inline]
    pub fn is_closed(&self) -> bool {
        self.wall_factors.iter().all(|wall_factor| !wall_factor.at_surface)
    }

    /// Computes frequencies and surface flags with new lists, from records of volumes.
    pub fn update(
        &mut self,
        (neighbor_list, records): (&NeighborList, &Records<V>),
        walls: &FluidWalls,
        (fluids, kind): (&[CompressibleFluid], &[u8]),
        density: &[f64],
        executor: &Executor,
    ) {
        let Self { detection, lattice_frequency, wall_factors, highest, is_stale, block_highest, .. } = self;
        detection.update((neighbor_list, records), walls, executor);
        let (detection, slots) = (&*detection, neighbor_list.neighbors().slots());
        executor.for_each_block((BlockedSlice::new(wall_factors, BLOCK), BlockedSlice::new(block_highest, 1)), &|(
            wall_factors,
            block_highest,
        )| {
            block_highest.items[0] = 0.0;
            for (member, wall_factor) in (wall_factors.start..).zip(wall_factors.items) {
                let Some(fluid) = fluids.get(usize::from(kind[member])) else { continue };
                let around = detection.around(slots[member] as usize);
                let lump = 2.0 * around.imbalance;
                let fastest = fluid.sound_at(density[member]) * lump.max(*lattice_frequency * around.closeness);
                block_highest.items[0] = fastest.max(block_highest.items[0]);
                wall_factor.at_surface = around.are_open();
            }
        });
        (*highest, *is_stale) = (block_highest.iter().copied().fold(0.0, f64::max), false);
    }

    /// Memory [bytes].
    #[inline]
    pub fn bytes(&self) -> usize {
        self.detection.bytes() + 2 * std::mem::size_of_val(self.wall_factors.as_slice())
    }
}

/// Saves the wall factors, the highest frequency of sound, and whether they are stale.
impl<V: Vector, K> History for SurfaceEffects<V, K> {
    fn save(&mut self) {
        self.saved.0.copy_from_slice(&self.wall_factors);
        (self.saved.1, self.saved.2) = (self.highest, self.is_stale);
    }

    fn rollback(&mut self) {
        self.wall_factors.copy_from_slice(&self.saved.0);
        (self.highest, self.is_stale) = (self.saved.1, self.saved.2);
    }

    fn capture(&self, archive: &mut Archive) {
        archive.write("wall_factors", self.wall_factors.iter().copied().flat_map(WallFactor::numbers));
        archive.write("highest_frequency", [self.highest]);
        archive.write("stale", [f64::from(u8::from(self.is_stale))]);
    }

    fn restore(&mut self, archive: &mut Archive) -> Result<()> {
        let numbers = archive.read_exactly("wall_factors", 3 * self.wall_factors.len())?.as_chunks::<3>().0;
        for (wall_factor, &[kick, drift, at_surface]) in self.wall_factors.iter_mut().zip(numbers) {
            let [kick, drift] = [kick, drift].map(|factor| (2.0 * factor) as u8);
            *wall_factor = WallFactor { kick, drift, at_surface: at_surface > 0.0 };
        }
        self.highest = archive.read_number("highest_frequency")?;
        self.is_stale = archive.read_number("stale")? > 0.0;
        Ok(())
    }
}
