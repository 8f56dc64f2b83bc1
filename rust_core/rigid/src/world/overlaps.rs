//! Overlaps of bodies at the start.

use super::members::StepMembers;
use super::near::NearPairs;
use super::{CenterMotion, FreePoint, RigidWorld};
use crate::collision;

/// Overlap of two bodies at the start, or of a body and a particle.
#[derive(Debug, Clone)]
pub struct Overlap {
    /// Depth [m].
    pub depth: f64,
    /// Size of the smaller body [m].
    pub size: f64,
    /// Paths in the scene, that of a particle last.
    pub names: [String; 2],
    /// Whether the second is a particle.
    pub is_of_particle: bool,
}

impl RigidWorld {
    /// Overlaps of bodies with each other, with walls, and with particles, which are given with their paths.
    pub fn overlaps(&self, motions: &[CenterMotion], particles: &[(FreePoint, CenterMotion, String)]) -> Vec<Overlap> {
        let (points, others): (Vec<FreePoint>, Vec<CenterMotion>) =
            particles.iter().map(|(point, motion, _)| (*point, *motion)).unzip();
        let members = StepMembers { world: self, bodies: motions, points: &points, faces: &[], motions: &others, h: 0.0 };
        let dimension = if self.planar { 2 } else { 3 };
        let (bodies, free) = (self.bodies.len(), members.free());
        let name = |index: usize| {
            let own = || if index < free { &particles[index - bodies].2 } else { &self.wall_names[index - free] };
            self.names.get(index).unwrap_or_else(own).clone()
        };
        let mut overlaps = Vec::new();
        for pair in members.pairs(&mut NearPairs::default()) {
            let [one, other] = pair.map(|end| end as usize);
            let sides = [one, other].map(|end| (&self.shapes[members.surface(end).shape], members.pose(end)));
            let (gap, _) = collision::separation((sides[0].0, &sides[0].1), (sides[1].0, &sides[1].1), dimension);
            if gap < 0.0 {
                let size = members.size(one).min(members.size(other));
                let is_of_particle = (bodies..free).contains(&other);
                let names = [name(one), name(other)];
                overlaps.push(Overlap { depth: -gap, size, names, is_of_particle });
            }
        }
        overlaps
    }
}
