//! Exact detection of meshes that pass through each other.

use glam::DVec3;
use robust::{Coord3D, orient3d};

use super::SelfContacts;
use super::tree::{AxisAlignedBox, SweptBox};
use crate::parallel::Executor;

impl SelfContacts {
    /// Checks the state before the first step.
    ///
    /// # Errors
    /// The particles of an edge that passes through a triangle.
    pub fn check(&mut self, position: impl Fn(usize) -> DVec3, executor: &Executor) -> std::result::Result<(), [u32; 2]> {
        self.record(|index| [position(index), DVec3::ZERO]);
        let x = &self.start;
        let longest = self.mesh.edges.iter().map(|&[a, b]| (x[a as usize] - x[b as usize]).length()).fold(0.0, f64::max);
        let around =
            |&x: &DVec3| SweptBox { from: AxisAlignedBox::around(x, longest), way: AxisAlignedBox::around(DVec3::ZERO, 0.0) };
        let boxes: Vec<SweptBox> = x.iter().map(around).collect();
        let all = vec![true; x.len()];
        self.mesh.sort(|vertex| self.start[vertex as usize]);
        let mut found = Vec::new();
        self.mesh.pairs(&boxes, &all, executor, &mut found, &|pair, _, _| pair.has_face().then_some(pair));
        for pair in found.into_iter().flatten() {
            let [vertex, corners @ ..] = pair.nodes;
            let [p, a, b, c] = pair.gather(x);
            for &end in self.mesh.neighbors(vertex).iter().filter(|&end| !corners.contains(end)) {
                if pierces([p, x[end as usize]], [a, b, c]) {
                    return Err([vertex, end]);
                }
            }
        }
        Ok(())
    }
}

/// Whether an edge passes through a triangle, decided without rounding.
fn pierces([p, q]: [DVec3; 2], [a, b, c]: [DVec3; 3]) -> bool {
    let around = |points: &[DVec3]| {
        points.iter().fold(AxisAlignedBox::EMPTY, |sum, &point| sum.union(&AxisAlignedBox::around(point, 0.0)))
    };
    if !around(&[p, q]).overlaps(&around(&[a, b, c])) {
        return false;
    }
    let point = |x: DVec3| Coord3D { x: x.x, y: x.y, z: x.z };
    let side = |a: DVec3, b: DVec3, c: DVec3, d: DVec3| orient3d(point(a), point(b), point(c), point(d));
    let turns = [side(p, q, a, b), side(p, q, b, c), side(p, q, c, a)];
    let around = turns.iter().all(|&turn| turn > 0.0) || turns.iter().all(|&turn| turn < 0.0);
    around && side(a, b, c, p) * side(a, b, c, q).signum() < 0.0
}
