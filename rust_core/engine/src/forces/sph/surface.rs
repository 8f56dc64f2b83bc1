//! Where a fluid has a surface, or is torn: how high sound is there, and whether walls hold what is there.
//!
//! **Sound.** Where particles are crowded all waves are faster. Where a fluid is torn there are others: a lump that moves with v
//! towards its neighbors is squeezed at v·s, s = Σ Vⱼ ∇W, and if those come to meet it twice as fast: ω = 2c|s|. An estimate,
//! that of the two which is higher: the largest singular values of the sum over v·∇W, in dam breaks, drops, jets and sprays
//! along walls, are 1 to 20 % below it.
//!
//! **Hold.** A wall is a mirror, and what is beside it would be held by tension towards its own image. So what leaves a wall at
//! a surface, from which air comes between, is let go: no pressure below that at rest passes between the two.

use glam::DVec3;

use super::BLOCK;
use super::images::View;
use super::kernel::{self, Kernel, Shape, Wave};
use super::laws::{KernelGradientSum, SURROUNDINGS};
use super::start::{Material, Materials};
use super::walls::Walls;
use crate::error::Result;
use crate::forces::neighbor_list::NeighborList;
use crate::history::{Archive, History};
use crate::math::{AXES, Real, Vector};
use crate::neighbors::sums::Records;
use crate::parallel::{BlockedSlice, Executor};

/// Particles with less around them than this part of Σ Vⱼ |∇W| are at a surface: two thirds is what one in the uppermost row
/// has, and 0.94 or more one in the second. By ∇·r, which is about the same, E.-S. Lee et al., J. Comput. Phys. 227 (2008) 8417
/// tell them by 0.75 to 0.8.
const BARE: f64 = 0.8;

/// How much of a particle's pressure passes through walls.
#[derive(Debug, Clone, Copy)]
pub struct WallFactor {
    /// In the kick between two drifts.
    pub kick: f32,
    /// In the next drift.
    pub drift: f32,
    /// Whether it is at a surface.
    bare: bool,
}

impl WallFactor {
    /// That of a particle in the midst of others.
    const FIRM: Self = Self { kick: 1.0, drift: 1.0, bare: false };

    /// Takes in a drift, after which the pressure is below that at rest or not, and walls stretched it or not.
    #[inline(always)]
    pub fn drifted(&mut self, pulls: bool, stretched: bool) {
        let next = if self.bare && pulls && stretched { 0.0 } else { 1.0 };
        // Half of a kick belongs to the drift before it and half to that after it: so letting go takes no energy.
        (self.kick, self.drift) = (0.5 * (self.drift + next), next);
    }

    /// As numbers to be saved.
    fn numbers(&self) -> [f64; 3] {
        [f64::from(self.kick), f64::from(self.drift), f64::from(u8::from(self.bare))]
    }
}

/// The particles of fluids and obstacles, as far as their surfaces are concerned.
#[derive(Debug)]
pub struct Surface<V: Vector, K> {
    law: KernelGradientSum<V::Scalar, K>,
    /// What it gives, in the order of slots.
    around: Vec<[V::Scalar; SURROUNDINGS]>,
    /// On a lattice: Σ Vⱼ |∇W| [1/m], and the highest frequency over the speed of sound [1/m].
    lattice: [f64; 2],
    /// How walls hold each member.
    pub wall_factors: Vec<WallFactor>,
    /// The highest frequency of sound when the lists were made [1/s].
    highest: f64,
    /// Whether the lists have been made anew since.
    pub is_stale: bool,
    /// These three when the batch began.
    saved: (Vec<WallFactor>, f64, bool),
    /// The highest frequency in each block of members [1/s].
    heights: Vec<f64>,
}

impl<V: Vector, K: Shape> Surface<V, K> {
    /// That of `count` particles of a fluid whose kernel carries these waves.
    pub fn new(kernel: Kernel<V::Scalar, K>, fluid: &Material, waves: &[Wave], count: usize) -> Self {
        let h = fluid.smoothing_length;
        let highest = waves.iter().map(|wave| wave.frequency).fold(0.0, f64::max);
        Self {
            law: KernelGradientSum { kernel },
            around: vec![[V::Scalar::ZERO; SURROUNDINGS]; count],
            lattice: [kernel::closeness::<K>(fluid.spacing / h, V::DIMENSION) / h, highest / h],
            wall_factors: vec![WallFactor::FIRM; count],
            highest: 0.0,
            is_stale: false,
            saved: (vec![WallFactor::FIRM; count], 0.0, false),
            heights: vec![0.0; count.div_ceil(BLOCK)],
        }
    }

    /// The highest frequency of sound [1/s].
    pub fn highest(&self) -> f64 {
        self.highest
    }

    /// Looks at new lists, by means of records that hold volumes.
    pub fn survey(
        &mut self,
        (neighbor_list, records): (&NeighborList, &Records<V>),
        walls: &Walls,
        (materials, kind): (&Materials, &[u8]),
        density: &[f64],
        executor: &Executor,
    ) {
        let Self { law, around, lattice: [closeness, frequency], wall_factors, highest, is_stale, heights, .. } = self;
        let neighbors = neighbor_list.neighbors();
        records.sum(neighbors, *law, around, executor);
        walls.add(*law, &View { weight: DVec3::ZERO, sticks: false }, (neighbor_list, records), around, executor);
        executor.for_each_block((BlockedSlice::new(wall_factors, BLOCK), BlockedSlice::new(heights, 1)), &|(
            wall_factors,
            heights,
        )| {
            heights.items[0] = 0.0;
            for (member, wall_factor) in (wall_factors.start..).zip(wall_factors.items) {
                let Some(fluid) = materials.fluid(kind[member]) else { continue };
                let sums = around[neighbors.slots()[member] as usize].map(Real::to_f64);
                let lump = 2.0 * sums[..AXES].iter().map(|sum| sum * sum).sum::<f64>().sqrt();
                let close = sums[AXES] / *closeness;
                let height = fluid.sound_at(density[member]) * lump.max(*frequency * close);
                heights.items[0] = height.max(heights.items[0]);
                wall_factor.bare = close < BARE;
            }
        });
        (*highest, *is_stale) = (heights.iter().copied().fold(0.0, f64::max), false);
    }

    /// The memory that it takes [bytes].
    pub fn bytes(&self) -> usize {
        std::mem::size_of_val(self.around.as_slice()) + 2 * std::mem::size_of_val(self.wall_factors.as_slice())
    }
}

/// How walls hold each member, and the highest frequency of sound.
impl<V: Vector, K> History for Surface<V, K> {
    fn save(&mut self) {
        self.saved.0.copy_from_slice(&self.wall_factors);
        (self.saved.1, self.saved.2) = (self.highest, self.is_stale);
    }

    fn rollback(&mut self) {
        self.wall_factors.copy_from_slice(&self.saved.0);
        (self.highest, self.is_stale) = (self.saved.1, self.saved.2);
    }

    fn capture(&self, archive: &mut Archive) {
        archive.write(self.wall_factors.iter().flat_map(WallFactor::numbers));
        archive.write([self.highest, f64::from(u8::from(self.is_stale))]);
    }

    fn restore(&mut self, archive: &mut Archive) -> Result<()> {
        for wall_factor in &mut self.wall_factors {
            let mut numbers = wall_factor.numbers();
            archive.read_into(&mut numbers)?;
            *wall_factor = WallFactor { kick: numbers[0] as f32, drift: numbers[1] as f32, bare: numbers[2] > 0.0 };
        }
        let mut numbers = [0.0; 2];
        archive.read_into(&mut numbers)?;
        (self.highest, self.is_stale) = (numbers[0], numbers[1] > 0.0);
        Ok(())
    }
}
