//! RATTLE as a method of matter: velocity Verlet with rods.
//!
//!     v½ = v + h/2 (a − M⁻¹ Jᵀ(x) λ),  x ← x + h v½ with λ so that |r| = L,
//!     v ← v½ + h/2 (a(x) − M⁻¹ Jᵀ(x) μ) with μ so that r·ṙ = 0
//!
//! RATTLE is symplectic, reversible, and of order 2; the symmetric composition of five such steps is of order 4. The
//! constraint forces act along the rods before the drift. If they acted only along the rods after it, the method would be of
//! order 1. Contacts with walls act together with the rods ([`crate::rods`]). Sources: H. C. Andersen, J. Comput. Phys. 52,
//! 24 (1983); E. Hairer, C. Lubich, G. Wanner, "Geometric Numerical Integration", 2nd ed., 2006, section VII.1.4; for the
//! composition M. Suzuki, Phys. Lett. A 146, 319 (1990).

use super::coupled::{self, Workspace};
use super::dynamics::{Dynamics, Treatment};
use super::kernels::StageAction;
use super::method::{Explicit, Job, Method, MethodProperties};
use super::stepper::Stepper;
use crate::error::{Error, Result};
use crate::forces::Space;
use crate::history::History;
use crate::integrators::{Integrator, VelocityVerlet};
use crate::matter::Matter;
use crate::parallel::Executor;
use crate::scene::Item;
use crate::stability::{Limit, LimitCache, SpectralBound};
use crate::systems::Interval;
use crate::systems::matter::constraints::rods::Unsolved;

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

/// Takes one step of velocity Verlet with rods, of `h` seconds from `time` on.
fn step<V: Space>(
    verlet: &Stepper<V>,
    dynamics: &mut Dynamics<V>,
    matter: &mut Matter<V>,
    workspace: &mut Workspace<V>,
    (time, h): (f64, f64),
    executor: &Executor,
) -> Result<()> {
    let interval = Interval { start: time, first: 0, h, steps: 1 };
    let half = VelocityVerlet::DRIFT_KICK.map(|drift_kick| (h, drift_kick.velocity));
    if let Some([position, velocity]) = &mut workspace.before {
        position.copy_from(&matter.position);
        velocity.copy_from(&matter.velocity);
    }
    dynamics.rods.iter_mut().for_each(|rods| rods.start(matter));
    coupled::sweep(verlet, dynamics, matter, workspace, interval, time, StageAction::StageState, executor)?;
    coupled::collisions(verlet, dynamics, matter, workspace, h, executor)?;
    let Dynamics { rods, contacts, properties, .. } = dynamics;
    if let Some(rods) = rods {
        held(rods.hold_positions(matter, half), &properties.caller, executor)?;
        if let (Some(contacts), Some(drift)) = (&*contacts, half) {
            held(rods.hold_gaps(matter, (contacts, properties), drift, executor), &properties.caller, executor)?;
        }
    }
    coupled::sweep(verlet, dynamics, matter, workspace, interval, time + h, StageAction::StageUpdate(0, None), executor)?;
    let Dynamics { rods, contacts, properties, .. } = dynamics;
    if let Some(rods) = rods {
        rods.turn(|index| matter.exact_position(index), executor);
        let outcome = match contacts {
            Some(contacts) => rods.hold_velocities_at_walls(matter, (contacts, properties), h, executor),
            None => rods.hold_velocities(matter),
        };
        held(outcome, &properties.caller, executor)?;
    }
    Ok(())
}

/// Reports an interrupt, after which a projection has no meaning, or the divergence of a step whose rods have no solution.
fn held(outcome: std::result::Result<(), Unsolved>, caller: &[u32], executor: &Executor) -> Result<()> {
    executor.check()?;
    let Err(Unsolved { particle, residual }) = outcome else { return Ok(()) };
    let index = caller[particle] as usize;
    let cause = format!(
        "does not satisfy its rods: they turn too far within a step, or walls leave them no room, and a residual of {residual:.1e} rounding errors is left"
    );
    Err(Error::unsolved(index, cause))
}

impl<V: Space> History for Rattle<V> {}

impl<V: Space> Method<V> for Rattle<V> {
    fn about(&self) -> MethodProperties {
        let composed = self.parts.len() > 1;
        MethodProperties {
            name: NAME,
            order: if composed { 4 } else { 2 },
            // Forces that depend on velocity are evaluated at a prediction, which no composition of steps corrects.
            order_dissipative: 2,
            evaluations: self.parts.len(),
            sweeps: true,
            corrected_weight: 0.0,
            springs: Treatment::Rods,
            holds_rods: true,
            smooth_only: Some("it advances rods, springs and fields, and no density; with order=2 boundaries too"),
            impulses: None,
            ..self.verlet.about()
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
        if let Some(rods) = &mut job.dynamics.rods {
            rods.begin(job.state, executor)?;
        }
        self.verlet.begin(job, executor)
    }

    fn advance(&mut self, job: Job<'_, V>, executor: &Executor) -> Result<()> {
        let Job { dynamics, state, record, workspace, interval, .. } = job;
        let Some(workspace) = workspace else { return Ok(()) };
        // After a rollback or a restoration, the directions belong to another state.
        if let Some(rods) = &mut dynamics.rods {
            rods.turn(|index| state.exact_position(index), executor);
        }
        for index in 0..interval.steps {
            let mut node = 0.0;
            for part in self.parts {
                step(
                    &self.verlet.stepper,
                    dynamics,
                    state,
                    workspace,
                    (interval.time(index, node), part * interval.h),
                    executor,
                )?;
                node += part;
            }
            record.0.push(workspace.activity.iter().sum());
            if executor.stopped() {
                break;
            }
        }
        Ok(())
    }
}
