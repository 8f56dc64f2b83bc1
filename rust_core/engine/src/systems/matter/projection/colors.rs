//! Springs in groups of lanes without common particles, so that a group is computed at once and written at once.

use crate::forces::springs::Spring;
use crate::math::{AXES, Real, Vector};
use crate::matter::Span;
use crate::simd::{Gather, LANES, Lanes};

/// Springs by colors, in which no two share a particle, and these in groups of lanes.
#[derive(Debug)]
pub struct Colors<T> {
    ends: [Gather; 2],
    pub groups: Vec<Group<T>>,
}

/// The laws of the springs of a group.
#[derive(Debug)]
pub struct Group<T> {
    /// The number of lanes in use.
    pub used: usize,
    /// k h² and c h [kg], for steps of h seconds.
    pub stiffness: Lanes<T>,
    pub damping: Lanes<T>,
    pub rest_length: Lanes<T>,
    /// 1/m of both ends [1/kg].
    pub inverse_mass: [Lanes<T>; 2],
}

/// The springs of a group in their present state.
pub struct State<T> {
    /// Unit vectors n from the first end to the second, 0 where these coincide.
    pub direction: [Lanes<T>; AXES],
    /// h² [k (r − L) + c n·Δu/h], the force of the displacements u times h² [kg·m].
    pub pull: Lanes<T>,
}

impl<T: Real> Colors<T> {
    /// Groups of springs between `count` particles of these inverse masses, for steps of `h` seconds.
    pub fn new(springs: &[Spring], inverse_mass: &[T], count: usize, h: f64) -> Self {
        let mut ends: [Vec<u32>; 2] = [Vec::new(), Vec::new()];
        let mut groups = Vec::new();
        for color in colors(springs, count) {
            for chunk in color.chunks(LANES) {
                let filled: Lanes<&Spring> = std::array::from_fn(|lane| &springs[chunk[lane.min(chunk.len() - 1)] as usize]);
                let number = |of: &dyn Fn(&Spring) -> f64| filled.map(|spring| T::from_f64(of(spring)));
                (0..2).for_each(|end| ends[end].extend(filled.iter().map(|spring| spring.ends[end])));
                groups.push(Group {
                    used: chunk.len(),
                    stiffness: number(&|spring| spring.stiffness * h * h),
                    damping: number(&|spring| spring.damping * h),
                    rest_length: number(&|spring| spring.rest_length),
                    inverse_mass: std::array::from_fn(|end| filled.map(|spring| inverse_mass[spring.ends[end] as usize])),
                });
            }
        }
        Self { ends: ends.map(|ends| Gather::new(&ends, count)), groups }
    }

    /// The vectors of both ends of a group.
    #[inline(always)]
    pub fn read<V: Vector<Scalar = T>>(&self, group: usize, columns: [&[T]; AXES]) -> [[Lanes<T>; AXES]; 2] {
        let mut vectors = [[[T::ZERO; LANES]; AXES]; 2];
        for (ends, vectors) in self.ends.iter().zip(&mut vectors) {
            for axis in 0..V::DIMENSION {
                ends.read(group..group + 1, columns[axis], std::slice::from_mut(&mut vectors[axis]));
            }
        }
        vectors
    }

    /// Writes the vectors of both ends of a group.
    #[inline(always)]
    pub fn write<V: Vector<Scalar = T>>(&self, group: usize, vectors: &[[Lanes<T>; AXES]; 2], columns: &mut Span<'_, V>) {
        for (ends, vectors) in self.ends.iter().zip(vectors) {
            for axis in 0..V::DIMENSION {
                ends.write(group, self.groups[group].used, &vectors[axis], columns.axes[axis]);
            }
        }
    }

    /// The state of a group at the separations of the positions and the displacements of its ends.
    #[inline(always)]
    pub fn state<V: Vector<Scalar = T>>(
        &self,
        group: usize,
        from: &[[Lanes<T>; AXES]; 2],
        moved: &[[Lanes<T>; AXES]; 2],
    ) -> State<T> {
        let Group { stiffness, damping, rest_length, .. } = &self.groups[group];
        let (mut direction, mut square, mut along) = ([[T::ZERO; LANES]; AXES], [T::ZERO; LANES], [T::ZERO; LANES]);
        for axis in 0..V::DIMENSION {
            for lane in 0..LANES {
                let apart = moved[1][axis][lane] - moved[0][axis][lane];
                let separation = (from[1][axis][lane] - from[0][axis][lane]) + apart;
                direction[axis][lane] = separation;
                square[lane] += separation * separation;
                along[lane] += separation * apart;
            }
        }
        let mut pull = [T::ZERO; LANES];
        for lane in 0..LANES {
            let length = square[lane].sqrt();
            let inverse = if length > T::ZERO { T::ONE / length } else { T::ZERO };
            (0..V::DIMENSION).for_each(|axis| direction[axis][lane] *= inverse);
            pull[lane] = stiffness[lane] * (length - rest_length[lane]) + damping[lane] * (along[lane] * inverse);
        }
        State { direction, pull }
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        size_of_val(self.groups.as_slice()) + self.ends.iter().map(Gather::bytes).sum::<usize>()
    }
}

/// The indices of the springs of each color: each spring has the first color that is free at both ends.
fn colors(springs: &[Spring], count: usize) -> Vec<Vec<u32>> {
    let mut taken: Vec<Vec<u64>> = vec![Vec::new(); count];
    let mut colors: Vec<Vec<u32>> = Vec::new();
    for (index, spring) in springs.iter().enumerate().filter(|(_, spring)| spring.ends[0] != spring.ends[1]) {
        let [one, other] = spring.ends.map(|end| end as usize);
        let word = |particle: usize, word: usize| taken[particle].get(word).copied().unwrap_or_default();
        let mut at = 0;
        while word(one, at) | word(other, at) == u64::MAX {
            at += 1;
        }
        let color = 64 * at + (word(one, at) | word(other, at)).trailing_ones() as usize;
        for particle in [one, other] {
            let words = taken[particle].len().max(color / 64 + 1);
            taken[particle].resize(words, 0);
            taken[particle][color / 64] |= 1 << (color % 64);
        }
        colors.resize(colors.len().max(color + 1), Vec::new());
        colors[color].push(index as u32);
    }
    colors.iter_mut().for_each(|color| color.sort_by_key(|&index| springs[index as usize].ends));
    colors
}
