//! Parts that all particle methods for fluids share. They know no method and no force.
//!
//! - [`start`]: the fluids and walls of a scene, and the pressure at rest; [`material`]: densities and viscosities.
//! - [`records`]: numbers of each particle for pair sums; [`kernel`]: weights of these sums.
//! - [`lattice`]: sums in a fluid at rest; [`waves`]: frequencies of waves, which bound the time step.
//! - [`walls`]: sums over the mirror images of the particles ([`images`]); [`obstacles`]: particles of other bodies; [`solids`]:
//!   samples of rigid bodies, which are obstacles.
//! - [`surface`], [`tension`]: free surfaces, and their tension.
//! - [`gauges`], [`probes`]: forces on walls and obstacles, and pressures.

pub(crate) mod gauges;
mod image_lists;
pub(crate) mod images;
pub(crate) mod kernel;
pub(crate) mod lattice;
pub(crate) mod material;
pub(crate) mod obstacles;
pub(crate) mod probes;
pub(crate) mod records;
pub(crate) mod solids;
pub(crate) mod start;
pub(crate) mod surface;
pub(crate) mod tension;
pub(crate) mod walls;
pub(crate) mod waves;

pub use gauges::Gauges;
pub(crate) use material::{KINDS, Material, Materials, OBSTACLE};

/// Slots in a block of the passes over single particles.
pub(crate) const BLOCK: usize = 1024;
