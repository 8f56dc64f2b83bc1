//! Parts that all particle methods for fluids share. They know no method and no force.
//!
//! The fluids and walls of a scene are in [`start`], with the pressure at rest; the densities and viscosities of the fluids are
//! in [`material`]. A method writes a record for each particle ([`records`]) and sums its laws over pairs of records, weighted by
//! a [`kernel`]. [`walls`] repeats a law over the mirror images of the particles ([`images`]), and [`obstacles`] are particles of
//! other bodies. Sums that several methods need are here: free surfaces ([`surface`]), surface tension ([`tension`]) and the
//! pressure on obstacles. Pressures at probes and forces on walls are measured by [`gauges`]. The frequencies of plane waves
//! ([`waves`]) bound the time step.

pub(crate) mod gauges;
mod image_lists;
pub(crate) mod images;
pub(crate) mod kernel;
pub(crate) mod material;
pub(crate) mod obstacles;
pub(crate) mod probes;
pub(crate) mod records;
pub(crate) mod start;
pub(crate) mod surface;
pub(crate) mod tension;
pub(crate) mod walls;
pub(crate) mod waves;

pub use gauges::Gauges;
pub(crate) use material::{KINDS, Material, Materials, OBSTACLE};

/// Slots in a block of the passes over single particles.
pub(crate) const BLOCK: usize = 1024;
