//! Lists of numbers, one list for each particle: its neighbors, or its places among springs or hinges.

/// The lists, one after the other.
#[derive(Debug, Clone, Default)]
pub struct Adjacency {
    /// The list of particle i is `entries[starts[i]..starts[i + 1]]`.
    starts: Vec<u32>,
    entries: Vec<u32>,
}

impl Adjacency {
    /// The lists of `count` particles: each of `pairs` is a particle and an entry of its list, in the order of these.
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

    /// The neighbors in a graph with these edges: each end is in the list of the other.
    pub fn of_graph(count: usize, edges: impl Iterator<Item = [u32; 2]>) -> Self {
        Self::new(count, &edges.flat_map(|[one, other]| [[one, other], [other, one]]).collect::<Vec<_>>())
    }

    /// Sorts every list by a key.
    pub fn sort_by_key<K: Ord>(&mut self, key: impl Fn(u32) -> K) {
        for range in self.starts.windows(2) {
            self.entries[range[0] as usize..range[1] as usize].sort_by_key(|&entry| key(entry));
        }
    }

    /// The number of particles.
    pub fn count(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// The list of a particle; empty if there are no entries at all.
    #[inline(always)]
    pub fn of(&self, particle: usize) -> &[u32] {
        if self.entries.is_empty() {
            return &[];
        }
        &self.entries[self.starts[particle] as usize..self.starts[particle + 1] as usize]
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        size_of_val(self.starts.as_slice()) + size_of_val(self.entries.as_slice())
    }
}
