//! Slices: springs of any topology, gathered by each particle from its partners.
//!
//! The format is sliced ELLPACK: 16 consecutive particles form a slice, and each row of it holds one spring per particle. Padding
//! entries connect a particle to itself; their length of 0 makes the force exactly 0. Every spring is computed from both of its
//! ends, to the same bits, so that each particle is written once. If the springs have few kinds, all springs of a row have the
//! same kind, and the law is one number per row.
//!
//! Source: M. Kreutzer et al., SIAM J. Sci. Comput. 36 (2014) C401.

use std::collections::BTreeMap;
use std::ops::Range;

use super::Spring;
use super::law::{EndState, SpringLaw};
use super::statistics::SpringStatistics;
use crate::math::{AXES, Real, Vector};
use crate::matter::EnergySink;
use crate::simd::{Gather, LANES, Lanes, padded};
use crate::{Rates, StateView};

/// Maximum number of distinct laws by which rows are sorted.
const KINDS: usize = 256;

/// Maximum number of rows sorted by kind, in percent of unsorted rows. Unsorted rows read three more numbers per spring.
const SORTED: usize = 125;

/// Springs that belong to no stencil.
#[derive(Debug)]
pub struct Slices<T> {
    /// Number of springs.
    pub count: usize,
    /// First row of each slice, and the total number of rows.
    rows: Vec<u32>,
    /// Particle at the other end of each spring, row by row.
    partners: Gather,
    /// Spring laws.
    laws: Laws<T>,
}

/// Spring laws of every row.
#[derive(Debug)]
enum Laws<T> {
    /// One law per row, out of a few.
    Shared { kinds: Vec<SpringLaw<T>>, of: Vec<u16> },
    /// One law per spring: stiffness, damping and rest length.
    Own(Vec<[Lanes<T>; 3]>),
}

/// Access to the laws of a row.
trait LawAccess<T>: Copy {
    /// The law of each lane.
    fn row(self, row: usize) -> impl Fn(usize) -> SpringLaw<T>;
}

impl<T: Real> LawAccess<T> for (&[SpringLaw<T>], &[u16]) {
    #[inline(always)]
    fn row(self, row: usize) -> impl Fn(usize) -> SpringLaw<T> {
        let law = self.0[self.1[row] as usize];
        move |_| law
    }
}

impl<T: Real> LawAccess<T> for &[[Lanes<T>; 3]] {
    #[inline(always)]
    fn row(self, row: usize) -> impl Fn(usize) -> SpringLaw<T> {
        let [stiffness, damping, rest_length] = &self[row];
        move |lane| SpringLaw { stiffness: stiffness[lane], damping: damping[lane], rest_length: rest_length[lane] }
    }
}

/// Number of rows gathered at once.
const ROWS: usize = 16;

/// One end of each spring in some rows.
struct SpringSide<T, const ROWS: usize> {
    position: [[Lanes<T>; ROWS]; AXES],
    velocity: [[Lanes<T>; ROWS]; AXES],
}

impl<T: Real, const ROWS: usize> SpringSide<T, ROWS> {
    const EMPTY: Self = Self { position: [[[T::ZERO; LANES]; ROWS]; AXES], velocity: [[[T::ZERO; LANES]; ROWS]; AXES] };

    /// Fills the columns in use by `read`.
    #[inline(always)]
    fn fill<V: Vector<Scalar = T>, const DAMPED: bool>(&mut self, at: &StateView<'_, V>, read: impl Fn(&[T], &mut [Lanes<T>])) {
        for axis in 0..V::DIMENSION {
            read(at.position.axis(axis), &mut self.position[axis]);
            if DAMPED {
                read(at.velocity.axis(axis), &mut self.velocity[axis]);
            }
        }
    }

    /// One of the rows.
    #[inline(always)]
    fn row(&self, row: usize) -> SpringSide<T, 1> {
        SpringSide {
            position: self.position.each_ref().map(|axis| [axis[row]]),
            velocity: self.velocity.each_ref().map(|axis| [axis[row]]),
        }
    }
}

impl<T: Real> SpringSide<T, 1> {
    /// One of the ends.
    #[inline(always)]
    fn lane(&self, lane: usize) -> EndState<T> {
        EndState {
            position: self.position.each_ref().map(|axis| axis[0][lane]),
            velocity: self.velocity.each_ref().map(|axis| axis[0][lane]),
        }
    }
}

/// A spring as seen from one of its ends.
#[derive(Debug, Clone, Copy)]
struct SpringEnd<T> {
    kind: usize,
    partner: u32,
    law: SpringLaw<T>,
}

impl<T: Real> Slices<T> {
    /// Slices of springs between `count` particles.
    pub fn new(springs: &[Spring], count: usize) -> Self {
        let (ends, kinds) = ends::<T>(springs, count);
        let sorted = arrange(&ends, |end| end.kind);
        let unsorted = arrange(&ends, |_| 0);
        let total = |rows: &[Vec<SpringRow<T>>]| rows.iter().map(Vec::len).sum::<usize>();
        let shared = kinds.len() <= KINDS && total(&sorted) * 100 <= total(&unsorted) * SORTED;
        let slices = if shared { sorted } else { unsorted };
        let mut rows = vec![0];
        let (mut partners, mut of, mut own) = (Vec::new(), Vec::new(), Vec::new());
        for (slice, arranged) in slices.iter().enumerate() {
            for row in arranged {
                let law = |lane: usize| row[lane].map_or(SpringLaw::NONE, |end| end.law);
                partners.extend((0..LANES).map(|lane| row[lane].map_or((slice * LANES + lane) as u32, |end| end.partner)));
                if shared {
                    of.push(row.iter().flatten().map(|end| end.kind as u16).next().unwrap_or(0));
                } else {
                    own.push([
                        std::array::from_fn(|lane| law(lane).stiffness),
                        std::array::from_fn(|lane| law(lane).damping),
                        std::array::from_fn(|lane| law(lane).rest_length),
                    ]);
                }
            }
            rows.push((partners.len() / LANES) as u32);
        }
        let laws = if shared { Laws::Shared { kinds, of } } else { Laws::Own(own) };
        Self { count: springs.len(), rows, partners: Gather::new(&partners, padded(count)), laws }
    }

    /// Number of distinct laws by which rows are sorted; None with one law per spring.
    #[inline]
    pub fn kinds(&self) -> Option<usize> {
        match &self.laws {
            Laws::Shared { kinds, .. } => Some(kinds.len()),
            Laws::Own(_) => None,
        }
    }

    /// Memory [bytes].
    #[inline]
    pub fn bytes(&self) -> usize {
        let laws = match &self.laws {
            Laws::Shared { kinds, of } => std::mem::size_of_val(kinds.as_slice()) + std::mem::size_of_val(of.as_slice()),
            Laws::Own(own) => std::mem::size_of_val(own.as_slice()),
        };
        std::mem::size_of_val(self.rows.as_slice()) + self.partners.bytes() + laws
    }

    /// Calls `each` with the ends of every spring whose lower end is in a range.
    pub fn for_each(&self, range: Range<usize>, mut each: impl FnMut(usize, usize, &SpringLaw<T>)) {
        for slice in range.start / LANES..range.end.div_ceil(LANES) {
            for row in self.rows(slice) {
                for lane in 0..LANES {
                    let (i, j) = (slice * LANES + lane, self.partners.indices(row)[lane] as usize);
                    if i < j {
                        let law = match &self.laws {
                            Laws::Shared { kinds, of } => (kinds.as_slice(), of.as_slice()).row(row)(lane),
                            Laws::Own(own) => own.as_slice().row(row)(lane),
                        };
                        each(i, j, &law);
                    }
                }
            }
        }
    }

    /// Adds the forces and powers of the springs on the particles of a block.
    #[inline(always)]
    pub fn accumulate<V: Vector<Scalar = T>, const DAMPED: bool>(
        &self,
        block: &Range<usize>,
        at: &StateView<'_, V>,
        rates: &mut Rates<'_, V>,
    ) {
        match &self.laws {
            Laws::Shared { kinds, of } => self.gather::<V, DAMPED>((kinds.as_slice(), of.as_slice()), block, at, rates),
            Laws::Own(own) => self.gather::<V, DAMPED>(own.as_slice(), block, at, rates),
        }
    }

    #[inline(always)]
    fn gather<V: Vector<Scalar = T>, const DAMPED: bool>(
        &self,
        laws: impl LawAccess<T>,
        block: &Range<usize>,
        at: &StateView<'_, V>,
        rates: &mut Rates<'_, V>,
    ) {
        let mut far = SpringSide::<T, ROWS>::EMPTY;
        for slice in block.start / LANES..block.end / LANES {
            if self.rows(slice).is_empty() {
                continue;
            }
            let mut near = SpringSide::<T, 1>::EMPTY;
            near.fill::<V, DAMPED>(at, |column, out| out[0] = column.as_chunks().0[slice]);
            let [mut force, mut damping] = [[[T::ZERO; LANES]; AXES]; 2];
            let mut power = [T::ZERO; LANES];
            for start in self.rows(slice).step_by(ROWS) {
                let rows = start..self.rows(slice).end.min(start + ROWS);
                far.fill::<V, DAMPED>(at, |column, out| self.partners.read(rows.clone(), column, &mut out[..rows.len()]));
                for row in rows {
                    let (far, law) = (far.row(row - start), laws.row(row));
                    let [mut pulls, mut drags] = [[[T::ZERO; LANES]; AXES]; 2];
                    let mut dissipated = [T::ZERO; LANES];
                    for lane in 0..LANES {
                        let pull = law(lane).force::<V, DAMPED>(near.lane(lane), far.lane(lane));
                        dissipated[lane] = pull.power;
                        for axis in 0..V::DIMENSION {
                            (pulls[axis][lane], drags[axis][lane]) = (pull.force[axis], pull.damping[axis]);
                        }
                    }
                    for lane in 0..LANES {
                        for axis in 0..V::DIMENSION {
                            force[axis][lane] += pulls[axis][lane];
                            damping[axis][lane] += drags[axis][lane];
                        }
                        power[lane] += dissipated[lane];
                    }
                }
            }
            let place = slice * LANES - block.start;
            for axis in 0..V::DIMENSION {
                let sum = &mut rates.force.axes[axis][place..][..LANES];
                (0..LANES).for_each(|lane| sum[lane] += force[axis][lane]);
                if let Some(sum) = rates.damping.as_mut().filter(|_| DAMPED) {
                    let sum = &mut sum.axes[axis][place..][..LANES];
                    (0..LANES).for_each(|lane| sum[lane] += damping[axis][lane]);
                }
            }
            (0..LANES).for_each(|lane| rates.power[EnergySink::Damping as usize][lane] += 0.5 * power[lane].to_f64());
        }
    }

    /// Adds the springs with a lower end in a range to statistics.
    #[inline(always)]
    pub fn measure<V: Vector<Scalar = T>>(&self, range: &Range<usize>, at: &StateView<'_, V>, statistics: &mut SpringStatistics) {
        match &self.laws {
            Laws::Shared { kinds, of } => self.measure_rows::<V>((kinds.as_slice(), of.as_slice()), range, at, statistics),
            Laws::Own(own) => self.measure_rows::<V>(own.as_slice(), range, at, statistics),
        }
    }

    #[inline(always)]
    fn measure_rows<V: Vector<Scalar = T>>(
        &self,
        laws: impl LawAccess<T>,
        range: &Range<usize>,
        at: &StateView<'_, V>,
        statistics: &mut SpringStatistics,
    ) {
        let mut far = SpringSide::<T, 1>::EMPTY;
        for slice in range.start / LANES..range.end.div_ceil(LANES) {
            let mut near = SpringSide::<T, 1>::EMPTY;
            near.fill::<V, false>(at, |column, out| out[0] = column.as_chunks().0[slice]);
            for row in self.rows(slice) {
                far.fill::<V, false>(at, |column, out| self.partners.read(row..row + 1, column, out));
                let (law, partners) = (laws.row(row), self.partners.indices(row));
                for lane in 0..LANES {
                    let square = near.lane(lane).square_to::<V>(far.lane(lane));
                    statistics.add(lane, partners[lane] as usize > slice * LANES + lane, square, law(lane));
                }
            }
        }
    }

    /// The rows of a slice.
    #[inline(always)]
    fn rows(&self, slice: usize) -> Range<usize> {
        self.rows[slice] as usize..self.rows[slice + 1] as usize
    }
}

/// One spring per lane, or None.
type SpringRow<T> = [Option<SpringEnd<T>>; LANES];

/// Springs of every particle, by kind and then by partner, and the kinds.
fn ends<T: Real>(springs: &[Spring], count: usize) -> (Vec<Vec<SpringEnd<T>>>, Vec<SpringLaw<T>>) {
    let laws: Vec<SpringLaw<T>> = springs.iter().map(SpringLaw::of).collect();
    let kinds: BTreeMap<[u64; 3], SpringLaw<T>> = laws.iter().map(|law| (law.key(), *law)).collect();
    let number: BTreeMap<[u64; 3], usize> = kinds.keys().enumerate().map(|(kind, key)| (*key, kind)).collect();
    let mut ends = vec![Vec::new(); count];
    for (spring, &law) in springs.iter().zip(&laws) {
        let kind = number[&law.key()];
        let [i, j] = spring.ends;
        ends[i as usize].push(SpringEnd { kind, partner: j, law });
        ends[j as usize].push(SpringEnd { kind, partner: i, law });
    }
    for list in &mut ends {
        list.sort_by_key(|end| (end.kind, end.partner));
    }
    (ends, kinds.into_values().collect())
}

/// Rows of every slice. Each row holds springs of one `class`.
fn arrange<T: Real>(ends: &[Vec<SpringEnd<T>>], class: impl Fn(&SpringEnd<T>) -> usize) -> Vec<Vec<SpringRow<T>>> {
    let slices = ends.chunks(LANES).map(|particles| {
        let mut rows: BTreeMap<(usize, usize), SpringRow<T>> = BTreeMap::new();
        for (lane, list) in particles.iter().enumerate() {
            for run in list.chunk_by(|one, next| class(one) == class(next)) {
                for (rank, &end) in run.iter().enumerate() {
                    rows.entry((class(&end), rank)).or_insert([None; LANES])[lane] = Some(end);
                }
            }
        }
        rows.into_values().collect()
    });
    slices.collect()
}
