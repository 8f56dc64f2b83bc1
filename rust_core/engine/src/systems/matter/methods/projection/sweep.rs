//! Extended position-based dynamics: sweeps over the springs, with the displacements that satisfy each spring alone.
//!
//! Let q = h² F be the multiplier of a spring, from 0 at the start of each part of a step. A sweep computes
//!
//!     Δq = (h² [k (r − L) + c n·Δu/h] − q) / (1 + (w₁ + w₂) (k h² + c h)),   u₁ ← u₁ + w₁ n Δq,  u₂ ← u₂ − w₂ n Δq
//!
//! For c = 0 this is Δλ = (−C − α̃ λ)/(w + α̃) with the compliance α̃ = 1/(k h²): the Gauss–Seidel iteration, in one fixed
//! order. For a rod α̃ = 0, and Δq = (r − L)/(w₁ + w₂). Sources: M. Macklin, M. Müller, N. Chentanez, "XPBD", MIG 2016; M.
//! Macklin et al., "Small steps in physics simulation", SCA 2019.

use super::links::{Point, ProjectionLink, gather, links, scatter};
use super::{Projector, about};
use crate::catalog::Space;
use crate::error::{Error, Result};
use crate::math::Real;
use crate::matter::{Columns, Matter};
use crate::parallel::Executor;
use crate::scene::Item;
use crate::simd::{Isa, Kernel, dispatch};
use crate::systems::matter::dynamics::Dynamics;
use crate::systems::matter::methods::MethodProperties;

/// Name of the class in Python.
pub const NAME: &str = "XPBD";

/// Projector of extended position-based dynamics.
#[derive(Debug)]
pub struct Sweeps<T> {
    substeps: usize,
    iterations: usize,
    /// Step size of the links [s].
    h: f64,
    links: Vec<ProjectionLink<T>>,
    /// Multipliers q of the links [kg·m].
    multipliers: Vec<T>,
    /// Positions and displacements [m].
    from: Vec<Point<T>>,
    displacements: Vec<Point<T>>,
}

impl<T> Sweeps<T> {
    /// Builds the projector that an item declares.
    ///
    /// # Errors
    /// If a number is missing or below 1.
    pub fn declared(item: &Item) -> Result<Self> {
        let [substeps, iterations] = [count(item, "substeps")?, count(item, "iterations")?];
        let (links, multipliers) = (Vec::new(), Vec::new());
        Ok(Self { substeps, iterations, h: 0.0, links, multipliers, from: Vec::new(), displacements: Vec::new() })
    }
}

/// Whole number of an item, at least 1.
pub fn count(item: &Item, name: &str) -> Result<usize> {
    match item.number(name)? {
        number if number >= 1.0 && number.fract() == 0.0 => Ok(number as usize),
        other => Err(Error::parameter(format!("{}.{name}", item.path), "a whole number ≥ 1", other)),
    }
}

impl<V: Space> Projector<V> for Sweeps<V::Scalar> {
    fn about(&self) -> MethodProperties {
        about(NAME, self.substeps)
    }

    fn substeps(&self) -> usize {
        self.substeps
    }

    fn begin(&mut self, _dynamics: &Dynamics<V>) {
        self.h = 0.0;
    }

    fn project(
        &mut self,
        dynamics: &Dynamics<V>,
        state: &Matter<V>,
        displacement: &mut Columns<V>,
        h: f64,
        executor: &Executor,
    ) -> Result<()> {
        if self.h != h {
            (self.h, self.links) = (h, links(&dynamics.springs, &dynamics.properties, h));
        }
        self.multipliers.clear();
        self.multipliers.resize(self.links.len(), V::Scalar::ZERO);
        gather(&state.position, &mut self.from);
        gather(displacement, &mut self.displacements);
        let Self { links, multipliers, from, displacements, .. } = self;
        for _ in 0..self.iterations {
            if executor.stopped() {
                break;
            }
            dispatch(ProjectionSweep { links, multipliers, from, displacements });
        }
        scatter(&self.displacements, displacement);
        Ok(())
    }

    fn bytes(&self) -> usize {
        let of_links = size_of_val(self.links.as_slice()) + size_of_val(self.multipliers.as_slice());
        of_links + size_of_val(self.from.as_slice()) + size_of_val(self.displacements.as_slice())
    }
}

struct ProjectionSweep<'a, T> {
    links: &'a [ProjectionLink<T>],
    multipliers: &'a mut [T],
    from: &'a [Point<T>],
    displacements: &'a mut [Point<T>],
}

impl<T: Real> Kernel for ProjectionSweep<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<S: Isa>(self, _isa: S) {
        let Self { links, multipliers, from, displacements } = self;
        for (link, multiplier) in links.iter().zip(multipliers) {
            let (direction, pull) = link.pull(from, displacements);
            let change = (pull - link.compliant * *multiplier) * link.share;
            *multiplier += change;
            let [one, other] = link.ends.map(|end| end as usize);
            let impulses = link.inverse_mass.map(|inverse_mass| inverse_mass * change);
            let [u, v] = [displacements[one], displacements[other]];
            displacements[one] = std::array::from_fn(|axis| u[axis] + impulses[0] * direction[axis]);
            displacements[other] = std::array::from_fn(|axis| v[axis] - impulses[1] * direction[axis]);
        }
    }
}
