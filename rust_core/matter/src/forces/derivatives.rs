//! Forces with their derivatives in double precision, for implicit methods.
//!
//! The derivatives of a force are the stiffness matrix K = −∂F/∂x and the damping matrix C = −∂F/∂v. The stiffness matrix of a
//! potential is symmetric. An implicit method solves by conjugate gradients, which require symmetric matrices. Only the symmetric
//! part of other matrices is used, such as those of position-dependent damping and friction. Newton's method then converges more
//! slowly, to the same solution.
//!
//! Every symmetric matrix K of 3×3 blocks is a sum of two kinds of [`MatrixBlock`]. The block of a pair, −Kᵢⱼ, responds to the
//! difference of two displacements. The block of a single particle, Σⱼ Kᵢⱼ, vanishes where the force is invariant to translation.

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
    /// The time [s].
    pub time: f64,
}

/// Part of a symmetric matrix, for displacements u. On a single particle it acts as B u. On a pair it acts as B (u₁ − u₂) on the
/// first particle and Bᵀ (u₂ − u₁) on the second.
#[derive(Debug, Clone, Copy)]
pub struct MatrixBlock {
    /// Particles of the pair; twice the same index for a single particle.
    pub ends: [u32; 2],
    /// The block B.
    pub exact: DMat3,
    /// Substitute for B whose sum over the blocks of a force is positive semidefinite.
    pub definite: DMat3,
}

impl MatrixBlock {
    /// Block of a single particle.
    #[inline]
    pub fn of(particle: usize, exact: DMat3, definite: DMat3) -> Self {
        Self { ends: [particle as u32; 2], exact, definite }
    }
}

/// Force on a particle.
#[derive(Debug, Clone, Copy)]
pub struct Push {
    /// Particle index in the engine's order.
    pub particle: usize,
    /// Force [N].
    pub force: DVec3,
    /// Upper bound of its stiffness [N/m], for the effect of rounded positions.
    pub stiffness: f64,
}

/// A force with derivatives.
pub trait Derivatives: Send + Sync {
    /// Finds the interacting particles.
    ///
    /// # Errors
    /// If the search fails.
    fn arrange(&mut self, _at: &Motion<'_>, _executor: &Executor) -> Result<()> {
        Ok(())
    }

    /// Passes the force on each particle to `push`, separately for each pair or other group.
    fn forces(&self, at: &Motion<'_>, push: &mut dyn FnMut(Push));

    /// Passes the blocks of s K + r C to `add`, for weights [s, r].
    fn blocks(&self, at: &Motion<'_>, weights: [f64; 2], add: &mut dyn FnMut(MatrixBlock));
}

/// Stiffness or damping along and across a direction n: a nnᵀ + b (1 − nnᵀ).
#[derive(Debug, Clone, Copy, Default)]
pub struct Directed {
    /// Longitudinal coefficient a.
    pub along: f64,
    /// Transverse coefficient b.
    pub across: f64,
}

impl Directed {
    /// The matrix for the unit vector `n`.
    #[inline]
    pub fn matrix(&self, n: DVec3) -> DMat3 {
        (self.along - self.across) * outer(n, n) + self.across * DMat3::IDENTITY
    }

    /// The positive semidefinite part.
    #[must_use]
    #[inline]
    pub fn definite(&self) -> Self {
        Self { along: self.along.max(0.0), across: self.across.max(0.0) }
    }

    /// Largest absolute eigenvalue.
    #[inline]
    pub fn largest(&self) -> f64 {
        self.along.abs().max(self.across.abs())
    }
}

/// The matrix abᵀ.
#[inline]
pub fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}
