//! Adjacency lists: one list of indices per particle, of its neighbors or of its entries among springs or hinges.

/// Lists of indices, one per particle, stored consecutively.
#[derive(Debug, Clone, Default)]
pub struct Adjacency {
    /// Offsets: the list of particle i is `entries[starts[i]..starts[i + 1]]`.
    starts: Vec<u32>,
    entries: Vec<u32>,
}

impl Adjacency {
    /// Builds the lists of `count` particles from pairs (particle, entry), with entries in the order of the pairs.
    pub fn new(count: usize, pairs: &[[u32; 2]]) -> Self {
        let mut starts = vec![0; count + 1];
        pairs.iter().for_each(|&[particle, _]| starts[particle as usize + 1] += 1);
        (0..count).for_each(|particle| starts[particle + 1] += starts[particle]);
        let (mut next, mut entries) = (starts.clone(), vec![0; pairs.len()]);
        for &[particle, entry] in pairs {
            entries[next[particle as usize] as usize] = entry;
            next[particle as usize] += 1;
        }
        Self { starts, entries }
    }

    /// Builds the neighbor lists of a graph with these edges: each end is in the list of the other.
    #[inline]
    pub fn of_graph(count: usize, edges: impl Iterator<Item = [u32; 2]>) -> Self {
        Self::new(count, &edges.flat_map(|[one, other]| [[one, other], [other, one]]).collect::<Vec<_>>())
    }

    /// Sorts every list by a key.
    pub fn sort_by_key<K: Ord>(&mut self, key: impl Fn(u32) -> K) {
        for range in self.starts.windows(2) {
            self.entries[range[0] as usize..range[1] as usize].sort_by_key(|&entry| key(entry));
        }
    }

    /// Number of particles.
    #[inline]
    pub fn count(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// List of a particle; empty if there are no entries.
    #[inline(always)]
    pub fn of(&self, particle: usize) -> &[u32] {
        if self.entries.is_empty() {
            return &[];
        }
        &self.entries[self.starts[particle] as usize..self.starts[particle + 1] as usize]
    }

    /// Memory [bytes].
    #[inline]
    pub fn bytes(&self) -> usize {
        size_of_val(self.starts.as_slice()) + size_of_val(self.entries.as_slice())
    }
}
