//! Strain limits: a spring at its longest length is a rod until it is shorter again.
//!
//! Consider a spring of offset d and direction n at the start of a step. Its ends have the relative velocity v, with the
//! component u across n. The spring stays within its longest length L if n·v ≤ (√(L² − h² u²) − ‖d‖)/h. The impulse acts
//! along n, as the force of SHAKE does. Source: J.-P. Ryckaert, G. Ciccotti, H. J. C. Berendsen, J. Comput. Phys. 23, 327
//! (1977).

use glam::DVec3;

use super::{MeshContact, Origin};
use crate::error::Result;
use crate::forces::springs::{self, Spring};
use crate::scene::Scene;
use crate::solvers::impulses::Handle;

/// Largest excess of a spring over its longest length, relative to that length, that needs no further iterations.
pub const TOLERANCE: f64 = 1e-6;
/// Part of an excess that a step takes back.
const PART: f64 = 0.2;
/// Bit that distinguishes the key of a spring from the key of a pair.
const KEY: u64 = 1 << 62;

/// Spring with a strain limit.
#[derive(Debug, Clone, Copy)]
pub struct StrainLimit {
    /// Index of the spring among all springs, as declared.
    pub spring: u32,
    pub ends: [u32; 2],
    /// Longest length L [m].
    longest: f64,
}

impl StrainLimit {
    /// Strain limits of the springs of a scene.
    ///
    /// # Errors
    /// If a strain is wrong.
    pub fn declared(scene: &Scene, springs: &[Spring]) -> Result<Vec<Self>> {
        let strains = springs::strains(scene, "strain_limit")?;
        let limits = springs.iter().zip(strains).zip(0..).filter(|((_, strain), _)| strain.is_finite());
        Ok(limits
            .map(|((spring, strain), index)| Self {
                spring: index,
                ends: spring.ends,
                longest: spring.rest_length * (1.0 + strain),
            })
            .collect())
    }

    /// Key of the spring among the keys of pairs.
    pub fn key(&self) -> u64 {
        KEY | u64::from(self.spring)
    }

    /// Excess over the longest length at the end of a step of `h` seconds, relative to that length.
    pub fn excess(&self, start: &[DVec3], velocities: &[DVec3], h: f64) -> f64 {
        let [one, other] = self.ends.map(|end| start[end as usize] + h * velocities[end as usize]);
        (one - other).length() / self.longest - 1.0
    }

    /// Direction n at the start, and least velocity of the ends towards each other [m/s].
    pub fn needed(&self, start: &[DVec3], velocities: &[DVec3], h: f64) -> (DVec3, f64) {
        let [one, other] = self.ends.map(|end| end as usize);
        let (offset, velocity) = (start[one] - start[other], velocities[one] - velocities[other]);
        let length = offset.length();
        let normal = offset / length;
        let across = h * h * (velocity.length_squared() - normal.dot(velocity).powi(2));
        let room = (self.longest.powi(2) - across).max(0.0).sqrt();
        let excess = (length - self.longest).max(0.0);
        (normal, (length - excess - room + PART * excess) / h)
    }

    /// Constraint of the spring, with the impulse from the force of the last step [N·s]; None if both ends are fixed.
    pub fn constraint(&self, (normal, least): (DVec3, f64), impulse: f64, inverse_mass: &[f64]) -> Option<MeshContact> {
        let [one, other] = self.ends;
        let ends = [Handle::Particle(one), Handle::Particle(other), Handle::Fixed, Handle::Fixed];
        let mut contact =
            MeshContact::new((ends, Origin::Pair(self.key())), [1.0, -1.0, 0.0, 0.0], -normal, (least, 0.0), inverse_mass)?;
        contact.impulse = impulse;
        Some(contact)
    }
}
