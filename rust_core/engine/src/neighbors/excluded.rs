//! Pairs of particles that are not neighbors, however near they are.

/// The pairs, by each of their particles.
#[derive(Debug, Clone, Default)]
pub struct Excluded {
    /// The others of particle i are `others[starts[i]..starts[i + 1]]`; empty where no pair is excluded.
    starts: Vec<u32>,
    others: Vec<u32>,
}

impl Excluded {
    /// Pairs among `count` particles.
    pub fn new(count: usize, pairs: &[[u32; 2]]) -> Self {
        if pairs.is_empty() {
            return Self::default();
        }
        let mut both: Vec<[u32; 2]> = pairs.iter().flat_map(|&[one, other]| [[one, other], [other, one]]).collect();
        both.sort_unstable();
        both.dedup();
        let starts = (0..=count as u32).map(|particle| both.partition_point(|&[one, _]| one < particle) as u32).collect();
        Self { starts, others: both.into_iter().map(|[_, other]| other).collect() }
    }

    /// The particles that are no neighbors of one.
    #[inline(always)]
    pub fn of(&self, particle: usize) -> &[u32] {
        if self.others.is_empty() {
            return &[];
        }
        &self.others[self.starts[particle] as usize..self.starts[particle + 1] as usize]
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        size_of_val(self.starts.as_slice()) + size_of_val(self.others.as_slice())
    }
}
