//! The expansion of the softened potential 1/s, s² = |d|² + ε², about the center of a cell to second order in the offsets δ of
//! its bodies: Φ = Q u − P·d u³ + ½ (3 dᵀS d u⁵ − tr S u³) with u = 1/s, Q = Σ c, P = Σ c δ and S = Σ c δδᵀ. The softened
//! potential is not harmonic, so that the trace of S acts. The power of moving sources is expanded to first order.
//!
//! The center is that of the charges' magnitudes: for masses P = 0.

use glam::DVec3;

use super::sums::SourceLaw;
use super::tree::Body;
use super::{POTENTIAL, SUMS, WORK};
use crate::math::{AXES, Real};
use crate::simd::Number;

/// The pairs of axes of a symmetric matrix's entries.
const ENTRIES: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

/// Words of a cell as a source: center, Q, P, S, and for moving sources Σ c v and the symmetric part of Σ c v δᵀ.
pub const WORDS: usize = 22;

/// The first word of Σ c v.
pub const CURRENT: usize = 13;

/// Moments of a cell.
#[derive(Debug, Clone, Default)]
pub struct Expansion {
    /// The mean position, weighted by |c|.
    pub center: DVec3,
    /// Σ |c|.
    weight: f64,
    charge: f64,
    dipole: DVec3,
    second: [f64; 6],
    current: DVec3,
    /// Entries of Σ c (v δᵀ + δ vᵀ)/2.
    flow: [f64; 6],
}

impl Expansion {
    /// The moments of bodies.
    pub fn of_bodies(bodies: &[Body]) -> Self {
        let center = center(bodies.iter().map(|body| (body.charge.abs(), body.position)));
        let mut sum = Self { center, ..Self::default() };
        for body in bodies {
            let part = Self {
                center: body.position,
                weight: body.charge.abs(),
                charge: body.charge,
                current: body.charge * body.velocity,
                ..Self::default()
            };
            sum.add(&part);
        }
        sum
    }

    /// The moments of a cell with these parts.
    pub fn of_parts(parts: &[&Self]) -> Self {
        let center = center(parts.iter().map(|part| (part.weight, part.center)));
        let mut sum = Self { center, ..Self::default() };
        parts.iter().for_each(|part| sum.add(part));
        sum
    }

    /// Adds moments about another center.
    fn add(&mut self, part: &Self) {
        let shift = (part.center - self.center).to_array();
        let (dipole, current) = (part.dipole.to_array(), part.current.to_array());
        self.weight += part.weight;
        self.charge += part.charge;
        self.dipole += part.dipole + part.charge * (part.center - self.center);
        self.current += part.current;
        for (entry, &(a, b)) in ENTRIES.iter().enumerate() {
            self.second[entry] +=
                part.second[entry] + (dipole[a] * shift[b] + shift[a] * dipole[b]) + part.charge * shift[a] * shift[b];
            self.flow[entry] += part.flow[entry] + 0.5 * (current[a] * shift[b] + shift[a] * current[b]);
        }
    }

    /// The words of the cell as a source.
    pub fn words<T: Real>(&self) -> [T; WORDS] {
        let mut words = [0.0; WORDS];
        words[..3].copy_from_slice(&self.center.to_array());
        words[3] = self.charge;
        words[4..7].copy_from_slice(&self.dipole.to_array());
        words[7..13].copy_from_slice(&self.second);
        words[13..16].copy_from_slice(&self.current.to_array());
        words[16..].copy_from_slice(&self.flow);
        words.map(T::from_f64)
    }
}

/// The weighted mean of positions; the plain mean where the weights are 0.
fn center(points: impl Iterator<Item = (f64, DVec3)> + Clone) -> DVec3 {
    let total: f64 = points.clone().map(|point| point.0).sum();
    if total > 0.0 {
        return points.map(|(weight, position)| weight / total * position).sum();
    }
    let count = points.clone().count() as f64;
    points.map(|(_, position)| position / count).sum()
}

/// The field, the potential and the power of cells, with the square of the softening.
#[derive(Debug, Clone, Copy)]
pub struct Multipole<T, const ONE_SIDED: bool>(pub T);

/// The product of a symmetric matrix with a vector.
#[inline(always)]
fn product<N: Number>(entries: &[N], vector: [N; AXES]) -> [N; AXES] {
    let [x, y, z] = vector;
    [
        entries[0] * x + entries[3] * y + entries[4] * z,
        entries[3] * x + entries[1] * y + entries[5] * z,
        entries[4] * x + entries[5] * y + entries[2] * z,
    ]
}

#[inline(always)]
fn dot<N: Number>(one: [N; AXES], other: [N; AXES]) -> N {
    one[0] * other[0] + one[1] * other[1] + one[2] * other[2]
}

impl<T: Real, const ONE_SIDED: bool> SourceLaw<T, WORDS, SUMS> for Multipole<T, ONE_SIDED> {
    #[inline(always)]
    fn terms<N: Number<Scalar = T>>(&self, offset: [N; AXES], square: N, source: &[N; WORDS]) -> [N; SUMS] {
        let c = N::constant;
        let mut terms = [c(0.0); SUMS];
        // Directions e = d/s instead of powers of 1/s, which would leave the range of f32.
        let u = c(1.0) / (square + N::of(self.0)).sqrt();
        let e = [offset[0] * u, offset[1] * u, offset[2] * u];
        let (u2, charge, dipole) = (u * u, source[3], [source[4], source[5], source[6]]);
        let trace = source[7] + source[8] + source[9];
        let second = product(&source[7..13], e);
        let (along, quadratic) = (dot(dipole, e), dot(second, e));
        terms[POTENTIAL] = u * (charge - u * along + u2 * (c(1.5) * quadratic - c(0.5) * trace));
        let radial = charge - c(3.0) * (u * along) + u2 * (c(7.5) * quadratic - c(1.5) * trace);
        for axis in 0..AXES {
            terms[axis] = u2 * (radial * e[axis] + u * dipole[axis] - c(3.0) * (u2 * second[axis]));
        }
        if ONE_SIDED {
            let flow = product(&source[16..22], e);
            let divergence = source[16] + source[17] + source[18];
            let current = [source[13], source[14], source[15]];
            terms[WORK] = u2 * (dot(current, e) + u * (divergence - c(3.0) * dot(flow, e)));
        }
        terms
    }
}
