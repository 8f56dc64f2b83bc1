//! Overlaps of bodies at the start.

use super::members::StepMembers;
use super::near::NearPairs;
use super::{CenterMotion, RigidWorld};
use crate::collision;

/// Overlap of two bodies at the start.
#[derive(Debug, Clone)]
pub struct Overlap {
    /// Depth [m].
    pub depth: f64,
    /// Size of the smaller body [m].
    pub size: f64,
    /// Paths of the bodies in the scene.
    pub names: [String; 2],
}

impl RigidWorld {
    /// Overlaps of bodies with each other and with walls.
    pub fn overlaps(&self, motions: &[CenterMotion]) -> Vec<Overlap> {
        let members = StepMembers { world: self, bodies: motions, points: &[], faces: &[], motions: &[], h: 0.0 };
        let dimension = if self.planar { 2 } else { 3 };
        let name = |index: usize| self.names.get(index).unwrap_or_else(|| &self.wall_names[index - self.bodies.len()]).clone();
        let mut overlaps = Vec::new();
        for pair in members.pairs(&mut NearPairs::default()) {
            let [one, other] = pair.map(|end| end as usize);
            let sides = [one, other].map(|end| (&self.shapes[members.surface(end).shape], members.pose(end)));
            let (gap, _) = collision::separation((sides[0].0, &sides[0].1), (sides[1].0, &sides[1].1), dimension);
            if gap < 0.0 {
                let size = sides[0].0.reach().min(sides[1].0.reach());
                overlaps.push(Overlap { depth: -gap, size, names: [name(one), name(other)] });
            }
        }
        overlaps
    }
}
