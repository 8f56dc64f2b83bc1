//! Zones: particles that no impulses keep apart move on together, with the mean velocity of their mass.
//!
//! A common translation keeps all distances within a zone, and momentum; angular momentum it does not. Zones grow until nothing meets.
//! Source: R. Bridson, R. Fedkiw, J. Anderson, ACM Trans. Graph. 21, 594 (2002), section 7.5, whose zones turn too.

use std::collections::BTreeMap;

use glam::DVec3;

/// Particles in disjoint sets.
#[derive(Debug, Default)]
pub struct Zones {
    parent: BTreeMap<u32, u32>,
}

impl Zones {
    fn root(&mut self, node: u32) -> u32 {
        let parent = *self.parent.entry(node).or_insert(node);
        if parent == node {
            return node;
        }
        let root = self.root(parent);
        self.parent.insert(node, root);
        root
    }

    /// Joins the zones of some particles.
    pub fn join(&mut self, nodes: &[u32]) {
        let roots: Vec<u32> = nodes.iter().map(|&node| self.root(node)).collect();
        let first = roots.iter().copied().min().unwrap_or(0);
        for root in roots {
            self.parent.insert(root, first);
        }
    }

    /// Gives each zone the mean velocity of its mass, as far as walls allow it; one with fixed particles that of the first of these.
    pub fn merge(&mut self, inverse_mass: &[f64], velocities: &mut [DVec3], within: impl Fn(&[u32], DVec3) -> DVec3) {
        let nodes: Vec<u32> = self.parent.keys().copied().collect();
        let mut zones: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for node in nodes {
            zones.entry(self.root(node)).or_default().push(node);
        }
        for members in zones.values() {
            let fixed = members.iter().find(|&&node| inverse_mass[node as usize] == 0.0);
            let velocity = fixed.map_or_else(
                || {
                    let mass = |node: &u32| 1.0 / inverse_mass[*node as usize];
                    let momentum: DVec3 = members.iter().map(|node| mass(node) * velocities[*node as usize]).sum();
                    within(members, momentum / members.iter().map(mass).sum::<f64>())
                },
                |&node| velocities[node as usize],
            );
            let free = members.iter().filter(|&&node| inverse_mass[node as usize] > 0.0);
            free.for_each(|&node| velocities[node as usize] = velocity);
        }
    }
}
