//! Zones: particles that no impulses keep apart move on together, with the mean velocity of their mass.
//!
//! A common translation conserves all distances within a zone, and momentum, but not angular momentum. Zones grow until
//! nothing meets. Source: R. Bridson, R. Fedkiw, J. Anderson, ACM Trans. Graph. 21, 594 (2002), section 7.5; zones there also
//! turn.

use std::collections::BTreeMap;

use glam::DVec3;

/// Particles in disjoint sets.
#[derive(Debug)]
pub struct Zones {
    /// Parent of each particle in the tree of its set; [`ALONE`] for particles in no set.
    parent: Vec<u32>,
    members: Vec<u32>,
}

const ALONE: u32 = u32::MAX;

impl Zones {
    /// Empty set of zones among `count` particles.
    pub fn new(count: usize) -> Self {
        Self { parent: vec![ALONE; count], members: Vec::new() }
    }

    /// Whether a particle is in a zone.
    #[inline(always)]
    pub fn contains(&self, node: u32) -> bool {
        self.parent[node as usize] != ALONE
    }

    fn root(&mut self, mut node: u32) -> u32 {
        if !self.contains(node) {
            self.parent[node as usize] = node;
            self.members.push(node);
        }
        while self.parent[node as usize] != node {
            let next = self.parent[node as usize];
            self.parent[node as usize] = self.parent[next as usize];
            node = next;
        }
        node
    }

    /// Joins the zones of some particles.
    pub fn join(&mut self, nodes: &[u32]) {
        let roots: Vec<u32> = nodes.iter().map(|&node| self.root(node)).collect();
        let first = roots.iter().copied().min().unwrap_or(0);
        for root in roots {
            self.parent[root as usize] = first;
        }
    }

    /// Gives each zone the mean velocity of its mass, as far as walls allow. A zone with fixed particles takes the velocity
    /// of the first of these.
    pub fn merge(&mut self, inverse_mass: &[f64], velocities: &mut [DVec3], within: impl Fn(&[u32], DVec3) -> DVec3) {
        let mut zones: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        self.members.sort_unstable();
        for node in self.members.clone() {
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
