//! Forces with their derivatives, in double precision: what implicit methods ask of a force.
//!
//! The derivatives of a force are the stiffness matrix K = −∂F/∂x and the damping matrix C = −∂F/∂v. That of a potential is symmetric.
//! An implicit method solves by conjugate gradients, and takes no more than a symmetric part of those that are not, as of damping and
//! friction that change with the position: Newton's method then converges more slowly, to the same solution.
//!
//! Every symmetric matrix K of 3×3 blocks is a sum of two kinds of [`Block`]: of a pair, which responds to the difference of its
//! displacements, −Kᵢⱼ; and of a particle alone, Σⱼ Kᵢⱼ, which vanishes where a force is the same in all places.

use glam::{DMat3, DVec3};

use crate::error::Result;
use crate::parallel::Executor;

/// A state in double precision.
#[derive(Debug, Clone, Copy)]
pub struct Motion<'a> {
    /// Positions relative to the origin [m].
    pub position: &'a [DVec3],
    /// Velocities [m/s].
    pub velocity: &'a [DVec3],
    /// The origin of the positions [m].
    pub origin: DVec3,
}

/// A part of a symmetric matrix: B u of a particle whose displacement is u, or of a pair B (u₁ − u₂) on the first and
/// Bᵀ (u₂ − u₁) on the second.
#[derive(Debug, Clone, Copy)]
pub struct Block {
    /// The pair; twice the same for a particle alone.
    pub ends: [u32; 2],
    /// B.
    pub exact: DMat3,
    /// One instead of it, whose sum over the blocks of a force is positive semidefinite.
    pub definite: DMat3,
}

impl Block {
    /// The block of a particle.
    pub fn of(particle: usize, exact: DMat3, definite: DMat3) -> Self {
        Self { ends: [particle as u32; 2], exact, definite }
    }
}

/// The force on a particle.
#[derive(Debug, Clone, Copy)]
pub struct Push {
    /// Its index in the engine's order.
    pub particle: usize,
    /// The force [N].
    pub force: DVec3,
    /// An upper bound of its stiffness [N/m], by which the rounding of positions enters.
    pub stiffness: f64,
}

/// A force with derivatives.
pub trait Derivatives: Send + Sync {
    /// Finds the particles that act on each other.
    ///
    /// # Errors
    /// If that fails.
    fn arrange(&mut self, _at: &Motion<'_>, _executor: &Executor) -> Result<()> {
        Ok(())
    }

    /// Passes on the force on every particle, of each pair or other group by itself.
    fn forces(&self, at: &Motion<'_>, push: &mut dyn FnMut(Push));

    /// Passes on the blocks of s K + r C, for weights [s, r].
    fn blocks(&self, at: &Motion<'_>, weights: [f64; 2], add: &mut dyn FnMut(Block));
}

/// Stiffness or damping along and across a direction n: a nnᵀ + b (1 − nnᵀ).
#[derive(Debug, Clone, Copy, Default)]
pub struct Directed {
    /// a.
    pub along: f64,
    /// b.
    pub across: f64,
}

impl Directed {
    /// The matrix for the direction `n`.
    pub fn matrix(&self, n: DVec3) -> DMat3 {
        (self.along - self.across) * outer(n, n) + self.across * DMat3::IDENTITY
    }

    /// Its positive semidefinite part.
    #[must_use]
    pub fn definite(&self) -> Self {
        Self { along: self.along.max(0.0), across: self.across.max(0.0) }
    }

    /// The larger eigenvalue by its size.
    pub fn largest(&self) -> f64 {
        self.along.abs().max(self.across.abs())
    }
}

/// The matrix abᵀ.
pub fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}
