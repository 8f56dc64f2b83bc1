//! Network of rods: one system of equations for the impulses along the rods, which satisfy all rods together.

use glam::DVec3;

use crate::error::Error;
use crate::parallel::Executor;
use crate::sparse::Factorization;

/// A pivot of A below this multiple of its largest entry makes A singular. Pivots of chains of 10⁴ rods are all above.
const SINGULAR: f64 = 1e-9;
/// A pivot of A + ε 1 below this multiple of ε belongs to a redundant rod.
const REDUNDANT: f64 = 100.0;
/// Maximum number of iterations of a projection.
const MOST_ITERATIONS: usize = 100;

/// A rod between two particles of a network.
#[derive(Debug, Clone, Copy)]
pub struct Rod {
    /// Ends, as indices of the network's particles.
    pub ends: [u32; 2],
    /// Length L [m].
    pub length: f64,
}

impl Rod {
    /// Excess of the length [m], (|r|² − L²)/2L at the positions of the ends, and its rounding error. Coordinates are rounded
    /// by `epsilon`/2 relative to themselves.
    pub fn excess(&self, [one, other]: [DVec3; 2], epsilon: f64) -> (f64, f64) {
        let residual = ((other - one).length_squared() - self.length * self.length) / (2.0 * self.length);
        (residual, epsilon * (2.0 * self.length + one.abs().max_element() + other.abs().max_element()))
    }
}

/// Velocity along a rod [m/s] for the velocities of its ends, and its rounding error.
pub fn along(direction: DVec3, [one, other]: [DVec3; 2], epsilon: f64) -> (f64, f64) {
    (direction.dot(other - one), 2.0 * epsilon * (one.length() + other.length()))
}

/// Failure of a projection: a rod whose length the iterations did not reach.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unsolved {
    /// Particle at an end of the rod.
    pub particle: usize,
    /// Residual of the rod relative to rounding errors.
    pub residual: f64,
}

/// Rods with the factorization of A = J M⁻¹ Jᵀ in their directions.
#[derive(Debug, Clone)]
pub struct Network {
    pub links: Vec<Rod>,
    /// Inverse masses 1/m of the particles [1/kg].
    pub inverse_mass: Vec<f64>,
    /// Unit vectors n from the first end to the second; zero for a rod that is left out.
    pub directions: Vec<DVec3>,
    /// Pairs of rods that meet, with the sum of ± 1/m over their common particles.
    couplings: Vec<([u32; 2], f64)>,
    factorization: Factorization,
    weights: Vec<f64>,
    diagonal: Vec<f64>,
    off_diagonal: Vec<f64>,
    /// Number of redundant rods.
    pub redundant: usize,
    /// Vectors of the particles to be projected, and their changes by the projection.
    pub vectors: Vec<DVec3>,
    pub changes: Vec<DVec3>,
    /// Impulses λ of the last projection.
    pub multipliers: Vec<f64>,
    residuals: Vec<f64>,
    buffer: Vec<f64>,
}

impl Network {
    /// Network of rods between particles with these inverse masses 1/m [1/kg].
    ///
    /// # Errors
    /// If the factorization does not fit into memory, or on an interrupt.
    pub fn new(links: Vec<Rod>, inverse_mass: Vec<f64>, executor: &Executor) -> Result<Self, Error> {
        let couplings = couplings(&links, &inverse_mass);
        let pattern: Vec<[u32; 2]> = couplings.iter().map(|&(pair, _)| pair).collect();
        let weight = |rod: &Rod| rod.ends.iter().map(|&end| inverse_mass[end as usize]).sum::<f64>();
        let weights: Vec<f64> = links.iter().map(weight).collect();
        Ok(Self {
            factorization: Factorization::new(links.len(), &pattern, executor)?,
            diagonal: weights.clone(),
            weights,
            off_diagonal: vec![0.0; couplings.len()],
            directions: vec![DVec3::ZERO; links.len()],
            residuals: vec![0.0; links.len()],
            buffer: Vec::new(),
            multipliers: vec![0.0; links.len()],
            vectors: vec![DVec3::ZERO; inverse_mass.len()],
            changes: vec![DVec3::ZERO; inverse_mass.len()],
            redundant: 0,
            links,
            inverse_mass,
            couplings,
        })
    }

    /// Factorizes A in the present directions. A singular A is shifted by `shift` times its largest entry. Ends early
    /// on an interrupt.
    pub fn factorize(&mut self, shift: f64, executor: &Executor) {
        let largest = self.weights.iter().copied().fold(0.0, f64::max);
        for ((value, &weight), direction) in self.diagonal.iter_mut().zip(&self.weights).zip(&self.directions) {
            *value = if *direction == DVec3::ZERO { largest } else { weight };
        }
        for (value, &([one, other], weight)) in self.off_diagonal.iter_mut().zip(&self.couplings) {
            *value = weight * self.directions[one as usize].dot(self.directions[other as usize]);
        }
        let small =
            |network: &Self, bound: f64| network.factorization.pivots().iter().filter(|&&pivot| pivot < bound * largest).count();
        self.factorization.factorize(&self.diagonal, 0.0, &self.off_diagonal, executor);
        self.redundant = small(self, SINGULAR);
        if self.redundant > 0 {
            self.factorization.factorize(&self.diagonal, shift * largest, &self.off_diagonal, executor);
            self.redundant = small(self, REDUNDANT * shift);
        }
    }

    /// Adds impulses along the directions until the residual of every rod vanishes. The function `residual` returns the
    /// residual of a rod and its rounding error, from the rod's index, its direction, and the vectors at its ends. Ends early on an
    /// interrupt.
    ///
    /// # Errors
    /// If the iterations do not converge; the particle is an index of the network.
    pub fn project(
        &mut self,
        residual: impl Fn(usize, &Rod, DVec3, [DVec3; 2]) -> (f64, f64),
        executor: &Executor,
    ) -> Result<(), Unsolved> {
        self.multipliers.fill(0.0);
        self.changes.fill(DVec3::ZERO);
        let (mut before, mut worst) = (f64::INFINITY, (0, 0.0));
        for iteration in 0..MOST_ITERATIONS {
            if executor.stopped() {
                return Ok(());
            }
            worst = (0, 0.0);
            for (index, rod) in self.links.iter().enumerate() {
                let ends = rod.ends.map(|end| self.vectors[end as usize]);
                let (value, rounding) = residual(index, rod, self.directions[index], ends);
                self.residuals[index] = value;
                let relative = value.abs() / rounding.max(f64::MIN_POSITIVE);
                // The divergence monitor reports states that are not finite.
                if relative.is_nan() && iteration == 0 {
                    return Ok(());
                }
                if relative > worst.1 || relative.is_nan() {
                    worst = (index, relative);
                }
            }
            if !worst.1.is_finite() {
                break;
            }
            // Rounding errors of all coupled rods add up to several times the error of one.
            if worst.1 <= 1.0 || (worst.1 <= 64.0 && worst.1 > 0.5 * before) {
                return Ok(());
            }
            before = worst.1;
            self.factorization.solve(&mut self.residuals, &mut self.buffer);
            for (index, rod) in self.links.iter().enumerate() {
                let (multiplier, [one, other]) = (self.residuals[index], rod.ends.map(|end| end as usize));
                self.multipliers[index] += multiplier;
                let impulse = multiplier * self.directions[index];
                let changes = [self.inverse_mass[one] * impulse, -self.inverse_mass[other] * impulse];
                for (end, change) in [one, other].into_iter().zip(changes) {
                    self.vectors[end] += change;
                    self.changes[end] += change;
                }
            }
        }
        Err(Unsolved { particle: self.links[worst.0].ends[1] as usize, residual: worst.1 })
    }

    /// Estimated duration of a step [ns]: a factorization and about six iterations.
    pub fn cost(&self) -> f64 {
        120.0 * self.links.len() as f64 + self.factorization.products() as f64 + 12.0 * self.factorization.len() as f64
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        self.links.len() * (size_of::<Rod>() + 80)
            + self.inverse_mass.len() * 32
            + self.couplings.len() * 24
            + self.factorization.bytes()
    }
}

/// Pairs of rods that meet in movable particles, with the sum of ± 1/m over these. The sign is + where both rods begin or
/// both end at the particle.
fn couplings(rods: &[Rod], inverse_mass: &[f64]) -> Vec<([u32; 2], f64)> {
    let mut meeting: Vec<Vec<(u32, f64)>> = vec![Vec::new(); inverse_mass.len()];
    for (index, rod) in rods.iter().enumerate() {
        for (end, sign) in rod.ends.into_iter().zip([-1.0, 1.0]) {
            meeting[end as usize].push((index as u32, sign));
        }
    }
    let mut pairs = Vec::new();
    for (rods, &inverse_mass) in meeting.iter().zip(inverse_mass).filter(|(_, inverse_mass)| **inverse_mass > 0.0) {
        for (place, &(one, sign)) in rods.iter().enumerate() {
            pairs.extend(rods[..place].iter().map(|&(other, other_sign)| ([one, other], sign * other_sign * inverse_mass)));
        }
    }
    pairs.sort_by_key(|&(pair, _)| pair);
    let mut couplings: Vec<([u32; 2], f64)> = Vec::new();
    for (pair, weight) in pairs {
        match couplings.last_mut() {
            Some((last, sum)) if *last == pair => *sum += weight,
            _ => couplings.push((pair, weight)),
        }
    }
    couplings
}
