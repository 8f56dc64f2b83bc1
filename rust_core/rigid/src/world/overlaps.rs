//! Overlaps of bodies at the start.

use super::{CenterMotion, RigidWorld};
use crate::collision;
use crate::mover::Mover;
use crate::surface::Surface;

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
        let count = self.bodies.len();
        let mut movers: Vec<Mover> = motions.iter().enumerate().map(|(body, motion)| self.mover(body, motion, 1.0)).collect();
        let mut surfaces: Vec<Surface> = self.bodies.iter().map(|solid| solid.surface).collect();
        movers.extend(self.walls.iter().map(|wall| wall.mover));
        surfaces.extend(self.walls.iter().map(|wall| wall.surface));
        let dimension = if self.planar { 2 } else { 3 };
        let name = |index: usize| self.names.get(index).unwrap_or_else(|| &self.wall_names[index - count]).clone();
        let mut overlaps = Vec::new();
        for pair in self.pairs(&movers, &surfaces, count, 0.0) {
            let [one, other] = pair.map(|end| end as usize);
            let sides = [one, other].map(|end| (&self.shapes[surfaces[end].shape], movers[end].pose()));
            let (gap, _) = collision::separation((sides[0].0, &sides[0].1), (sides[1].0, &sides[1].1), dimension);
            if gap < 0.0 {
                let size = sides[0].0.reach().min(sides[1].0.reach());
                overlaps.push(Overlap { depth: -gap, size, names: [name(one), name(other)] });
            }
        }
        overlaps
    }
}
