//! Gershgorin-type bounds on the largest eigenvalue of M⁻¹K (and likewise of M⁻¹C) from its rows.
//!
//! Let each spring e join i and j with stiffness kₑ, and let each particle carry point terms of total stiffness pᵢ. The matrix of
//! a spring lies between −kₑ and kₑ times that of a spring with equal stiffness in every direction. Therefore ω² ≤ ρ, the
//! spectral radius of the non-negative matrix Q = M⁻¹(D + A + P). Here Dᵢ = dᵢ = Σ kₑ at i, Aᵢⱼ = kₑ and P = diag(p). By the
//! Perron–Frobenius theorem, Q has an eigenvector x ≥ 0 with eigenvalue ρ:
//!
//! ```text
//! (ρ − pᵢ/mᵢ) xᵢ = Σ over e at i of kₑ/mᵢ yₑ,   with yₑ = xᵢ + xⱼ.
//! ```
//!
//! Write σᵢ = dᵢ/mᵢ, qᵢ = pᵢ/mᵢ. Where ρ exceeds all q, xᵢ ≤ σᵢ y/(ρ − qᵢ), where y is the largest yₑ. The sum over the two ends
//! of this spring gives 1 ≤ σᵢ/(ρ − qᵢ) + σⱼ/(ρ − qⱼ), that is
//!
//! ```text
//! ρ ≤ largest eigenvalue of [ qᵢ + σᵢ   σᵢ      ]
//!                           [ σⱼ        qⱼ + σⱼ ]  for some spring, or ρ ≤ qᵢ for some particle.
//! ```
//!
//! Without point terms this is the bound dᵢ/mᵢ + dⱼ/mⱼ of the Gram matrix of the springs. With equal q everywhere, q is added, in
//! accord with Weyl's inequality. Fixed particles have infinite mass and move in no mode: σ = q = 0.

/// Largest row, as a rate (ω² [1/s²] or γ [1/s]), and the term that contributes most to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GershgorinRow {
    pub rate: f64,
    pub term: &'static str,
}

/// Rows of the stiffness, or of the damping, of all terms.
#[derive(Debug, Clone)]
pub struct GershgorinRows {
    /// Name of the term of the springs.
    springs: &'static str,
    /// Ends of each spring.
    ends: Vec<[u32; 2]>,
    /// Sum over the springs at each particle; empty without springs.
    joined: Vec<f64>,
    /// Sum over the point terms of each particle; empty if none.
    alone: Vec<f64>,
    /// Largest point term of each particle.
    leading: Vec<(f64, &'static str)>,
}

impl GershgorinRows {
    pub fn new(springs: &'static str) -> Self {
        Self { springs, ends: Vec::new(), joined: Vec::new(), alone: Vec::new(), leading: Vec::new() }
    }

    /// Adds a spring between two of `count` particles.
    pub fn join(&mut self, count: usize, i: usize, j: usize, value: f64) {
        if value != 0.0 {
            self.joined.resize(count, 0.0);
            self.ends.push([i as u32, j as u32]);
            self.joined[i] += value.abs();
            self.joined[j] += value.abs();
        }
    }

    /// Adds a term that acts on one of `count` particles.
    pub fn add(&mut self, count: usize, i: usize, term: &'static str, value: f64) {
        if value != 0.0 {
            self.alone.resize(count, 0.0);
            self.leading.resize(count, (0.0, ""));
            self.alone[i] += value.abs();
            if value.abs() > self.leading[i].0 {
                self.leading[i] = (value.abs(), term);
            }
        }
    }

    /// Largest row of each body, over the particles for which `counts` holds.
    pub fn largest(
        &self,
        inverse_mass: &[f64],
        body: &[u32],
        bodies: usize,
        counts: impl Fn(usize) -> bool,
    ) -> Vec<GershgorinRow> {
        let mut rows = vec![GershgorinRow { rate: 0.0, term: "" }; bodies];
        self.visit(inverse_mass, |i, _, rate, term| {
            let row = &mut rows[body[i] as usize];
            if rate > row.rate && counts(i) {
                *row = GershgorinRow { rate, term };
            }
        });
        rows
    }

    /// Largest row of each particle.
    pub fn at_particles(&self, inverse_mass: &[f64]) -> Vec<f64> {
        let mut rows = vec![0.0; inverse_mass.len()];
        self.visit(inverse_mass, |i, j, rate, _| {
            for end in [i, j] {
                rows[end] = if inverse_mass[end] > 0.0 { f64::max(rows[end], rate) } else { 0.0 };
            }
        });
        rows
    }

    /// Rate of the point terms of each particle.
    pub fn points<'a>(&'a self, inverse_mass: &'a [f64]) -> impl Fn(usize) -> f64 + 'a {
        |i| at(&self.alone, inverse_mass, i)
    }

    /// Sum over the point terms of a particle without springs; None with springs.
    pub fn alone_at(&self, i: usize) -> Option<f64> {
        let joined = self.joined.get(i).is_some_and(|&sum| sum > 0.0);
        (!joined).then(|| self.alone.get(i).copied().unwrap_or(0.0))
    }

    /// Largest point term of a particle; empty if none.
    pub fn leading(&self, i: usize) -> &'static str {
        self.leading.get(i).map_or("", |&(_, term)| term)
    }

    /// Calls `raise` for every row, with the ends of its spring, the rate and the binding term. For a point term, both ends are
    /// the particle.
    fn visit(&self, inverse_mass: &[f64], mut raise: impl FnMut(usize, usize, f64, &'static str)) {
        let at = |sums: &[f64], i: usize| at(sums, inverse_mass, i);
        for i in 0..self.alone.len() {
            raise(i, i, at(&self.alone, i), self.leading[i].1);
        }
        for &[i, j] in &self.ends {
            let (i, j) = (i as usize, j as usize);
            let (one, other) = (at(&self.joined, i), at(&self.joined, j));
            let (alone, other_alone) = (at(&self.alone, i), at(&self.alone, j));
            let half_gap = 0.5 * ((alone + one) - (other_alone + other));
            let sum = alone + one + other_alone + other;
            // An overflow is an infinite rate.
            let rate = if sum.is_finite() { 0.5 * sum + hypotenuse(half_gap, one, other) } else { f64::INFINITY };
            let strongest = if alone > other_alone { i } else { j };
            let term = if one + other >= alone.max(other_alone) { self.springs } else { self.leading(strongest) };
            raise(i, j, rate, term);
        }
    }
}

/// Sum over mass, as a rate: 0 for an empty sum, or for a fixed particle, even if the sum is infinite.
fn at(sums: &[f64], inverse_mass: &[f64], i: usize) -> f64 {
    sums.get(i).map_or(0.0, |&sum| if sum > 0.0 && inverse_mass[i] > 0.0 { sum * inverse_mass[i] } else { 0.0 })
}

/// Computes √(leg² + one·other) without overflow of the squares. `hypot` would take longer than the rest of a row.
fn hypotenuse(leg: f64, one: f64, other: f64) -> f64 {
    let sum = leg * leg + one * other;
    if sum.is_normal() { sum.sqrt() } else { libm::hypot(leg, one.sqrt() * other.sqrt()) }
}
