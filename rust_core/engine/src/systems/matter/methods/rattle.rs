//! RATTLE as a method of matter: velocity Verlet with rods.
//!
//!     v½ = v + h/2 (a − M⁻¹ Jᵀ(x) λ),  x ← x + h v½ with λ so that |r| = L,
//!     v ← v½ + h/2 (a(x) − M⁻¹ Jᵀ(x) μ) with μ so that r·ṙ = 0
//!
//! RATTLE is symplectic, reversible, and of order 2; the symmetric composition of five such steps is of order 4. The
//! constraint forces act along the rods before the drift. If they acted only along the rods after it, the method would be of
//! order 1. Contacts with walls act together with the rods (`constraints/rods`). Sources: H. C. Andersen, J. Comput. Phys. 52,
//! 24 (1983); E. Hairer, C. Lubich, G. Wanner, "Geometric Numerical Integration", 2nd ed., 2006, section VII.1.4; for the
//! composition M. Suzuki, Phys. Lett. A 146, 319 (1990).

use super::coupled;
use super::explicit::Explicit;
use super::{Job, Method, MethodMemory, MethodProperties, MethodRefusals, Treatment};
use crate::catalog::Space;
use crate::error::{Error, Result};
use crate::history::History;
use crate::integrators::VelocityVerlet;
use crate::matter::Matter;
use crate::parallel::Executor;
use crate::scene::Item;
use crate::stability::{Limit, LimitCache, SpectralBound};
use crate::systems::Interval;

/// Name of the class in Python.
pub const NAME: &str = "RATTLE";

/// RATTLE method.
pub struct Rattle<V: Space> {
    /// Fractions of a step for the steps of velocity Verlet.
    parts: &'static [f64],
    verlet: Explicit<V>,
}

/// Outer steps of Suzuki's composition of order 4: 1/(4 − 4^(1/3)).
const OUTER: f64 = 0.414_490_771_794_375_7;
const ORDER_4: [f64; 5] = [OUTER, OUTER, 1.0 - 4.0 * OUTER, OUTER, OUTER];

impl<V: Space> Rattle<V> {
    /// Builds the method that an item declares.
    ///
    /// # Errors
    /// If its order is neither 2 nor 4.
    pub fn declared(item: &Item) -> Result<Self> {
        let parts: &'static [f64] = match item.number("order")? {
            2.0 => &[1.0],
            4.0 => &ORDER_4,
            other => return Err(Error::parameter(format!("{}.order", item.path), "2 or 4", other)),
        };
        Ok(Self { parts, verlet: Explicit::declared::<VelocityVerlet>(item)? })
    }
}

impl<V: Space> History for Rattle<V> {}

impl<V: Space> Method<V> for Rattle<V> {
    fn about(&self) -> MethodProperties {
        let verlet = self.verlet.about();
        MethodProperties {
            name: NAME,
            // Forces that depend on velocity are evaluated at a prediction, which no composition of steps corrects.
            orders: [if self.parts.len() > 1 { 4 } else { 2 }, 2],
            evaluations: self.parts.len(),
            sweeps: true,
            memory: MethodMemory { damping: false, ..verlet.memory },
            springs: Treatment::Rods,
            refusals: MethodRefusals {
                kinks: Some("it advances rods, springs and fields, and no density; with order=2 boundaries too"),
                ..verlet.refusals
            },
            ..verlet
        }
    }

    fn persistent(&self) -> usize {
        self.verlet.persistent()
    }

    fn error(&self, state: &Matter<V>, h: f64) -> Option<f64> {
        self.verlet.error(state, h)
    }

    fn gains_energy(&self) -> bool {
        false
    }

    fn bound(&self, bound: SpectralBound) -> SpectralBound {
        self.verlet.bound(bound)
    }

    /// Limit of velocity Verlet. The composition is stable up to ωh = 2.72 without damping, and with less in the presence of
    /// damping.
    fn limit(&self, bound: &SpectralBound, cache: &mut LimitCache) -> Limit {
        self.verlet.limit(bound, cache)
    }

    fn sharp_limit(&self, bound: SpectralBound) -> Limit {
        self.verlet.sharp_limit(bound)
    }

    fn begin(&mut self, job: Job<'_, V>, executor: &Executor) -> Result<()> {
        self.verlet.begin(job, executor)
    }

    fn advance(&mut self, job: Job<'_, V>, executor: &Executor) -> Result<()> {
        let Some((mut step, activity, interval)) = job.coupled(executor) else { return Ok(()) };
        for index in 0..interval.steps {
            let mut node = 0.0;
            for part in self.parts {
                let part_of = Interval { start: interval.time(index, node), first: 0, h: part * interval.h, steps: 1 };
                coupled::take(&self.verlet.stepper, &mut step, part_of, 0)?;
                node += part;
            }
            activity.push(step.workspace.activity.iter().sum());
            if executor.stopped() {
                break;
            }
        }
        Ok(())
    }
}
