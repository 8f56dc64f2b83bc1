//! Pairs of bodies of small groups that impacts throw, at up to twice the largest speed of the group.

use super::members::StepMembers;
use crate::broad;
use crate::shapes::BoundingBox;

/// Largest number of times that groups are widened by those whom they may meet.
const MOST: usize = 8;

impl StepMembers<'_> {
    /// Adds the pairs of bodies that an impact with another of their group may throw farther than their own size. Larger groups
    /// are swept, and meet nothing beyond that.
    pub fn add_thrown(&self, pairs: &mut Vec<[u32; 2]>) {
        let speeds: Vec<f64> = (0..self.count()).map(|index| self.speed(index)[0] + self.rim_speed(index)).collect();
        let mut boxes: Vec<BoundingBox> =
            (0..self.count()).map(|index| self.bounds(index).grown(self.h * speeds[index])).collect();
        let mut ways = vec![0.0_f64; self.count()];
        let mut found = Vec::new();
        for _ in 0..MOST {
            let mut roots = self.roots(pairs);
            let mut groups = vec![(0, 0.0_f64); self.count() + 1];
            let free: Vec<usize> = (0..self.free()).filter(|&index| !self.is_fixed(index)).collect();
            for &index in &free {
                let (count, fastest) = &mut groups[roots.find(index)];
                (*count, *fastest) = (*count + 1, fastest.max(speeds[index]));
            }
            let mut thrown = free;
            thrown.retain(|&index| {
                index < self.bodies.len() && {
                    let (count, fastest) = groups[roots.find(index)];
                    let way = 2.0 * self.h * fastest;
                    let is_far = (2..=self.world.solver.sequential).contains(&count) && way > ways[index].max(self.reach(index));
                    if is_far {
                        ways[index] = way;
                        boxes[index] = self.bounds(index).grown(way);
                    }
                    is_far
                }
            });
            if thrown.is_empty() {
                return;
            }
            let mut is_thrown = vec![false; self.count()];
            thrown.iter().for_each(|&index| is_thrown[index] = true);
            broad::pairs(&boxes, &is_thrown, &mut found);
            pairs.extend(found.iter().filter(|[one, other]| self.can_meet(*one as usize, *other as usize)));
            pairs.sort_unstable();
            pairs.dedup();
        }
    }
}
