//! Ordering of particles for locality: spring partners are near each other in memory.

use std::collections::VecDeque;

use super::Spring;
use super::stencil;
use crate::adjacency::Adjacency;

/// Percentage of a component's springs in stencils from which on its order is kept.
const STRUCTURED: usize = 90;

/// Smallest reduction factor of the mean index distance between partners for which a component is reordered.
const GAIN: usize = 2;

/// Graph of a network.
struct Graph(Adjacency);

impl Graph {
    fn new(springs: &[Spring], count: usize) -> Self {
        let mut neighbors = Adjacency::of_graph(count, springs.iter().map(|spring| spring.ends));
        // Neighbors are sorted by degree and then by index, as in the order of E. Cuthill and J. McKee.
        let degrees: Vec<usize> = (0..count).map(|index| neighbors.of(index).len()).collect();
        neighbors.sort_by_key(|index| (degrees[index as usize], index));
        Self(neighbors)
    }

    fn neighbors(&self, index: u32) -> &[u32] {
        self.0.of(index as usize)
    }

    /// A component in breadth-first order from `start`, and its depth. The caller's buffer `level` is `FAR` for the whole
    /// component before and after the call.
    fn walk(&self, start: u32, level: &mut [u32]) -> (Vec<u32>, u32) {
        let (mut visited, mut queue) = (Vec::new(), VecDeque::from([start]));
        level[start as usize] = 0;
        let mut depth = 0;
        while let Some(index) = queue.pop_front() {
            visited.push(index);
            depth = level[index as usize];
            for &next in self.neighbors(index) {
                if level[next as usize] == FAR {
                    level[next as usize] = depth + 1;
                    queue.push_back(next);
                }
            }
        }
        for &index in &visited {
            level[index as usize] = FAR;
        }
        (visited, depth)
    }

    /// A component in reverse Cuthill–McKee order, from a pseudo-peripheral particle.
    ///
    /// Source: A. George, J. W. H. Liu, ACM Trans. Math. Softw. 5 (1979) 284.
    fn reverse_cuthill_mckee(&self, start: u32, level: &mut [u32]) -> Vec<u32> {
        let (mut best, mut depth) = self.walk(start, level);
        loop {
            let (next, farther) = self.walk(best[best.len() - 1], level);
            if farther <= depth {
                best.reverse();
                return best;
            }
            (best, depth) = (next, farther);
        }
    }
}

/// Level of an unvisited particle.
const FAR: u32 = u32::MAX;

/// A more local order, if there is one: `order[new] = old`. Connected components that are already structured or local are kept.
/// Others are permuted within their own indices. All other particles keep their indices.
pub fn ordering(springs: &[Spring], count: usize) -> Option<Vec<u32>> {
    let (_, taken) = stencil::find::<f64>(springs);
    if taken.iter().all(|&taken| taken) {
        return None;
    }
    let graph = Graph::new(springs, count);
    let mut in_stencils = vec![0; count];
    let structured = springs.iter().zip(&taken).filter(|(_, taken)| **taken);
    structured.flat_map(|(spring, _)| spring.ends).for_each(|end| in_stencils[end as usize] += 1);

    let mut order: Vec<u32> = (0..count as u32).collect();
    let (mut level, mut done, mut new_index) = (vec![FAR; count], vec![false; count], vec![0; count]);
    let mut changed = false;
    for start in 0..count as u32 {
        if done[start as usize] || graph.neighbors(start).is_empty() {
            continue;
        }
        let (mut component, _) = graph.walk(start, &mut level);
        for &index in &component {
            done[index as usize] = true;
        }
        let sum = |each: &dyn Fn(u32) -> usize| component.iter().map(|&index| each(index)).sum::<usize>();
        if sum(&|index| in_stencils[index as usize]) * 100 >= sum(&|index| graph.neighbors(index).len()) * STRUCTURED {
            continue;
        }
        component.sort_unstable();
        let better = graph.reverse_cuthill_mckee(start, &mut level);
        better.iter().zip(&component).for_each(|(&old, &new)| new_index[old as usize] = new);
        let distance = |of: &dyn Fn(u32) -> u32| -> u64 {
            let one =
                |&index: &u32| graph.neighbors(index).iter().map(|&next| u64::from(of(index).abs_diff(of(next)))).sum::<u64>();
            component.iter().map(one).sum()
        };
        if distance(&|index| index) >= GAIN as u64 * distance(&|index| new_index[index as usize]) {
            better.iter().zip(&component).for_each(|(&old, &new)| order[new as usize] = old);
            changed = true;
        }
    }
    changed.then_some(order)
}
