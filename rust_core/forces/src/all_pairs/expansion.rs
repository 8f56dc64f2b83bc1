//! Expansions of sums about the center of a cell.
//!
//! The center is weighted by the magnitudes |c| of the charges, so that it lies in the cell for any signs.

use glam::DVec3;

use super::laws::{POTENTIAL, SUMS, Tide, WORK};
use super::sums::SourceLaw;
use crate::math::{AXES, Real};
use crate::simd::{Number, ParticleRecord, WORDS};

/// Sum over the bodies of a cell, from the moments of the cell.
pub trait CellLaw<T, const CELL: usize, const SUMS: usize>: SourceLaw<T, CELL, SUMS> {
    /// Moments of the cell.
    type Moments: Moments<T, CELL>;
}

/// Moments of bodies about a center.
pub trait Moments<T, const CELL: usize>: Clone + Default + Send {
    /// Adds a body at the offset δ from the center.
    fn add_body(&mut self, body: &ParticleRecord<T>, offset: DVec3);
    /// Adds moments about a center at the offset δ from this one.
    fn add(&mut self, part: &Self, offset: DVec3);
    /// Record of the cell as a source. The first words are reserved for its position.
    fn words(&self) -> [T; CELL];
}

/// Expansion of a sum over the bodies of a cell.
#[derive(Debug, Clone, Default)]
pub struct Expansion<M> {
    /// Mean position, weighted by |c|.
    pub center: DVec3,
    /// Sum of the magnitudes Σ |c|.
    pub weight: f64,
    /// Half the side of a cube about the center that contains all bodies.
    pub half_side: f64,
    /// Radius of a sphere about the center that contains all bodies.
    pub radius: f64,
    /// Moments about the center.
    pub moments: M,
}

impl<M> Expansion<M> {
    /// Expansion of a set of bodies.
    pub fn of_bodies<T: Real, const CELL: usize>(bodies: &[ParticleRecord<T>]) -> Self
    where
        M: Moments<T, CELL>,
    {
        let place = |body: &ParticleRecord<T>| DVec3::new(body[0].to_f64(), body[1].to_f64(), body[2].to_f64());
        let weighted = bodies.iter().map(|body| (body[AXES].to_f64().abs(), place(body)));
        let mut whole = Self::about(weighted);
        for body in bodies {
            let offset = place(body) - whole.center;
            whole.half_side = whole.half_side.max(offset.abs().max_element());
            whole.radius = whole.radius.max(offset.length());
            whole.moments.add_body(body, offset);
        }
        whole
    }

    /// Expansion of a cell from those of its parts.
    pub fn of_parts<T: Real, const CELL: usize>(parts: &[Self]) -> Self
    where
        M: Moments<T, CELL>,
    {
        let mut whole = Self::about(parts.iter().map(|part| (part.weight, part.center)));
        for part in parts {
            let offset = part.center - whole.center;
            whole.half_side = whole.half_side.max(offset.abs().max_element() + part.half_side);
            whole.radius = whole.radius.max(offset.length() + part.radius);
            whole.moments.add(&part.moments, offset);
        }
        whole
    }

    /// Empty expansion about the weighted mean of positions, or about the plain mean if all weights are 0.
    fn about<T, const CELL: usize>(weighted: impl Iterator<Item = (f64, DVec3)> + Clone) -> Self
    where
        M: Moments<T, CELL>,
    {
        let weight: f64 = weighted.clone().map(|(weight, _)| weight).sum();
        let count = weighted.clone().count() as f64;
        let center = if weight > 0.0 {
            weighted.map(|(share, place)| share / weight * place).sum()
        } else {
            weighted.map(|(_, place)| place / count).sum()
        };
        Self { center, weight, half_side: 0.0, radius: 0.0, moments: M::default() }
    }
}

/// Pairs of axes of the entries of a symmetric matrix.
const ENTRIES: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

/// Adds the symmetric matrix ½ (a bᵀ + b aᵀ).
#[inline(always)]
fn add_product(matrix: &mut [f64; 6], one: DVec3, other: DVec3) {
    let (a, b) = (one.to_array(), other.to_array());
    for (entry, (row, column)) in matrix.iter_mut().zip(ENTRIES) {
        *entry += 0.5 * (a[row] * b[column] + b[row] * a[column]);
    }
}

/// Moments of the charges to second order: charge Q = Σ c, dipole P = Σ c δ, and S = Σ c δδᵀ. The trace of S is kept, because the
/// softened potential is not harmonic.
#[derive(Debug, Clone, Default)]
pub struct Multipole {
    charge: f64,
    dipole: DVec3,
    second: [f64; 6],
}

/// Words of a cell for [`Multipole`]: position, Q, P, 3/2 S and 1/2 tr S.
pub const MULTIPOLE: usize = 14;

impl<T: Real> Moments<T, MULTIPOLE> for Multipole {
    fn add_body(&mut self, body: &ParticleRecord<T>, offset: DVec3) {
        let charge = body[AXES].to_f64();
        self.charge += charge;
        self.dipole += charge * offset;
        add_product(&mut self.second, charge * offset, offset);
    }

    fn add(&mut self, part: &Self, offset: DVec3) {
        self.charge += part.charge;
        self.dipole += part.dipole + part.charge * offset;
        self.second.iter_mut().zip(&part.second).for_each(|(entry, part)| *entry += part);
        add_product(&mut self.second, 2.0 * part.dipole + part.charge * offset, offset);
    }

    fn words(&self) -> [T; MULTIPOLE] {
        let ([px, py, pz], [xx, yy, zz, xy, xz, yz]) = (self.dipole.to_array(), self.second.map(|entry| 1.5 * entry));
        [0.0, 0.0, 0.0, self.charge, px, py, pz, xx, yy, zz, xy, xz, yz, (xx + yy + zz) / 3.0].map(T::from_f64)
    }
}

/// Moments of moving charges: [`Multipole`], Σ c v, and the symmetric part F of Σ c v δᵀ, for the power to first order.
#[derive(Debug, Clone, Default)]
pub struct MovingMultipole {
    still: Multipole,
    current: DVec3,
    flow: [f64; 6],
}

/// Words of a cell for [`MovingMultipole`]: those of [`Multipole`], Σ c v, F and tr F.
pub const MOVING: usize = MULTIPOLE + 10;

impl<T: Real> Moments<T, MOVING> for MovingMultipole {
    fn add_body(&mut self, body: &ParticleRecord<T>, offset: DVec3) {
        self.still.add_body(body, offset);
        let [charge, u, v, w] = [AXES, AXES + 1, AXES + 2, AXES + 3].map(|word| body[word].to_f64());
        let current = charge * DVec3::new(u, v, w);
        self.current += current;
        add_product(&mut self.flow, current, offset);
    }

    fn add(&mut self, part: &Self, offset: DVec3) {
        Moments::<T, MULTIPOLE>::add(&mut self.still, &part.still, offset);
        self.current += part.current;
        self.flow.iter_mut().zip(&part.flow).for_each(|(entry, part)| *entry += part);
        add_product(&mut self.flow, part.current, offset);
    }

    fn words(&self) -> [T; MOVING] {
        let still: [T; MULTIPOLE] = self.still.words();
        let ([u, v, w], [xx, yy, zz, xy, xz, yz]) = (self.current.to_array(), self.flow);
        let moving = [u, v, w, xx, yy, zz, xy, xz, yz, xx + yy + zz].map(T::from_f64);
        let mut words = [T::ZERO; MOVING];
        words[..MULTIPOLE].copy_from_slice(&still);
        words[MULTIPOLE..].copy_from_slice(&moving);
        words
    }
}

/// Product of a symmetric matrix with a vector.
#[inline(always)]
fn product<N: Number>(matrix: &[N], [x, y, z]: [N; AXES]) -> [N; AXES] {
    let [xx, yy, zz, xy, xz, yz] = std::array::from_fn(|entry| matrix[entry]);
    [xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z]
}

#[inline(always)]
fn dot<N: Number>(one: [N; AXES], other: [N; AXES]) -> N {
    one[0] * other[0] + one[1] * other[1] + one[2] * other[2]
}

/// Potential of a cell, Q u − P·d u³ + ½ (3 dᵀS d u⁵ − tr S u³) with u = 1/s, and its negative gradient. The parameter is the
/// squared softening. `POLAR` is false if all charges have one sign, because P then vanishes about the center.
#[derive(Debug, Clone, Copy)]
pub struct CellAttraction<T, const POLAR: bool>(pub T);

impl<T: Real, const POLAR: bool> CellLaw<T, MULTIPOLE, SUMS> for CellAttraction<T, POLAR> {
    type Moments = Multipole;
}

impl<T: Real, const POLAR: bool> SourceLaw<T, MULTIPOLE, SUMS> for CellAttraction<T, POLAR> {
    const TERMS: usize = POTENTIAL + 1;

    #[inline(always)]
    fn terms<N: Number<Scalar = T>>(&self, offset: [N; AXES], square: N, cell: &[N; MULTIPOLE]) -> [N; SUMS] {
        let constant = N::constant;
        let (charge, dipole, trace) = (cell[3], [cell[4], cell[5], cell[6]], cell[13]);
        // Terms without 1/s are computed during the latency of its square root and division.
        let second = product(&cell[7..13], offset);
        let quadratic = dot(second, offset);
        let (u, u2) = inverse(square + N::of(self.0));
        let quadratic = quadratic * u2;
        let mut radial = charge + u2 * (constant(5.0) * quadratic - constant(3.0) * trace);
        let mut potential = charge + u2 * (quadratic - trace);
        if POLAR {
            let along = dot(dipole, offset) * u2;
            radial = radial - constant(3.0) * along;
            potential = potential - along;
        }
        let cube = u * u2;
        let (radial, tangential) = (cube * radial, cube * (u2 + u2));
        let mut terms = [constant(0.0); SUMS];
        for axis in 0..AXES {
            terms[axis] = radial * offset[axis] - tangential * second[axis];
            if POLAR {
                terms[axis] += cube * dipole[axis];
            }
        }
        terms[POTENTIAL] = u * potential;
        terms
    }
}

/// Inverse square root and inverse of a number.
#[inline(always)]
fn inverse<N: Number>(square: N) -> (N, N) {
    let inverse = N::constant(1.0) / square;
    (square.sqrt() * inverse, inverse)
}

/// [`CellAttraction`] with the power of moving charges.
#[derive(Debug, Clone, Copy)]
pub struct MovingCellAttraction<T>(pub T);

impl<T: Real> CellLaw<T, MOVING, SUMS> for MovingCellAttraction<T> {
    type Moments = MovingMultipole;
}

impl<T: Real> SourceLaw<T, MOVING, SUMS> for MovingCellAttraction<T> {
    const TERMS: usize = WORK + 1;

    #[inline(always)]
    fn terms<N: Number<Scalar = T>>(&self, offset: [N; AXES], square: N, cell: &[N; MOVING]) -> [N; SUMS] {
        let still = std::array::from_fn(|word| cell[word]);
        let mut terms = CellAttraction::<T, true>(self.0).terms(offset, square, &still);
        let (current, trace) = ([cell[14], cell[15], cell[16]], cell[23]);
        let flow = dot(product(&cell[17..23], offset), offset);
        let (u, u2) = inverse(square + N::of(self.0));
        terms[WORK] = u * u2 * (dot(current, offset) + (trace - N::constant(3.0) * (flow * u2)));
        terms
    }
}

/// Moments for [`Tide`]: the sums of its words.
#[derive(Debug, Clone, Default)]
pub struct Totals([f64; 2]);

impl<T: Real> CellLaw<T, WORDS, 2> for Tide<T> {
    type Moments = Totals;
}

impl<T: Real> Moments<T, WORDS> for Totals {
    fn add_body(&mut self, body: &ParticleRecord<T>, _offset: DVec3) {
        self.0[0] += body[AXES].to_f64();
        self.0[1] += body[AXES + 1].to_f64();
    }

    fn add(&mut self, part: &Self, _offset: DVec3) {
        self.0[0] += part.0[0];
        self.0[1] += part.0[1];
    }

    fn words(&self) -> [T; WORDS] {
        [0.0, 0.0, 0.0, self.0[0], self.0[1], 0.0, 0.0, 0.0].map(T::from_f64)
    }
}
