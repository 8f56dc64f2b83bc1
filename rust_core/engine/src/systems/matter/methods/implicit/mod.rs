//! Implicit methods for forces of any stiffness with known derivatives: backward Euler, the implicit midpoint rule and BDF2.
//!
//! With the displacement u of a step of h seconds, all three solve
//!
//!     σ M (u − y) = h² F(x + α u, β u/h + w)
//!
//! - Backward Euler: σ = α = β = 1, y = h v.
//! - Midpoint rule: σ = 2, α = ½, β = 1, y = h v.
//! - BDF2: σ = 9/4, α = 1, β = 3/2, y = d/3 + 2h (4v − v₋)/9, w = −d/2h, with the displacement d and the velocity v₋ of the
//!   step before.
//!
//! Newton's method finds u ([`newton`]). Sources: E. Hairer, S. P. Nørsett, G. Wanner, "Solving Ordinary Differential
//! Equations I", 2nd ed., 1993, sections II.7 and III.1; D. Baraff, A. Witkin, SIGGRAPH 1998, 43.

mod newton;
mod stiffness;

use glam::DVec3;

use super::coupled;
use super::{Job, Method, MethodMemory, MethodProperties, MethodRefusals, Treatment};
use crate::catalog::Space;
use crate::error::{Error, Result};
use crate::history::{Archive, History};
use crate::matter::{Blocks, Matter};
use crate::parallel::{BlockedSlice, Executor};
use crate::scene::Item;
use crate::stability::{Limit, LimitCache, SpectralBound};
use crate::systems::matter::constraints::DriftVelocity;
use crate::systems::matter::dynamics::Dynamics;
use crate::systems::matter::kernels;
use crate::systems::matter::step::MatterStep;
use crate::systems::unknown_integrator;
use newton::{Equation, Newton};

/// Scheme of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Scheme {
    BackwardEuler,
    Midpoint,
    Bdf2,
}

/// Names of the classes in Python.
const NAMES: [(&str, Scheme); 3] =
    [("BackwardEuler", Scheme::BackwardEuler), ("ImplicitMidpoint", Scheme::Midpoint), ("BDF2", Scheme::Bdf2)];

/// Registers of BDF2: the displacement d and the velocity v₋ of the step before.
const DISPLACEMENT: usize = 0;
const VELOCITY: usize = 1;

/// Implicit method.
pub struct Implicit {
    name: &'static str,
    scheme: Scheme,
    newton: Newton,
    /// Size of the step that filled the registers [s]; 0 before the first step, and after a contact.
    before: f64,
    saved: f64,
    /// Number of steps, of iterations in them, and of products.
    taken: [u64; 3],
}

impl Implicit {
    /// Builds the method that an item declares.
    ///
    /// # Errors
    /// If it is none of these methods, or its tolerance is not above 0.
    pub fn declared(item: &Item) -> Result<Self> {
        let known = NAMES.iter().find(|(name, _)| *name == item.kind);
        let &(name, scheme) = known.ok_or_else(|| unknown_integrator(item))?;
        let tolerance = item.number("tolerance")?;
        if tolerance <= 0.0 {
            return Err(Error::parameter(format!("{}.tolerance", item.path), "a number > 0", tolerance));
        }
        Ok(Self { name, scheme, newton: Newton::new(tolerance), before: 0.0, saved: 0.0, taken: [0; 3] })
    }

    /// Equation of a step of `h` seconds from `time` on, and whether it is BDF2's with a step before it.
    fn equation<V: Space>(&self, dynamics: &Dynamics<V>, matter: &Matter<V>, (time, h): (f64, f64)) -> (Equation, bool) {
        let count = matter.count();
        let velocity = |index: usize| matter.velocity.get(index).widen();
        let two_step = self.scheme == Scheme::Bdf2 && self.before == h;
        let (inertia, position, rate) = match self.scheme {
            Scheme::Midpoint => (2.0, 0.5, 1.0),
            Scheme::Bdf2 if two_step => (2.25, 1.0, 1.5),
            _ => (1.0, 1.0, 1.0),
        };
        let old = |register: usize, index: usize| matter.registers[register].get(index).widen();
        let predicted = |index: usize| {
            if two_step && !dynamics.properties.is_fixed(index) {
                old(DISPLACEMENT, index) / 3.0 + 2.0 * h / 9.0 * (4.0 * velocity(index) - old(VELOCITY, index))
            } else {
                h * velocity(index)
            }
        };
        // The offset of a fixed particle reproduces its velocity.
        let offset = |index: usize| match (two_step, dynamics.properties.is_fixed(index)) {
            (false, _) => DVec3::ZERO,
            (true, false) => old(DISPLACEMENT, index) / (-2.0 * h),
            (true, true) => -0.5 * velocity(index),
        };
        let equation = Equation {
            h,
            time: if self.scheme == Scheme::Midpoint { time + 0.5 * h } else { time + h },
            inertia,
            position,
            rate,
            from: (0..count).map(|index| matter.exact_position(index)).collect(),
            predicted: (0..count).map(predicted).collect(),
            offset: (0..count).map(offset).collect(),
        };
        (equation, two_step)
    }

    /// Takes one step from `time` on; returns the activity at its end.
    fn step<V: Space>(&mut self, step: &mut MatterStep<'_, V>, (time, h): (f64, f64)) -> Result<f64> {
        step.begin(h, self.drift());
        let (equation, two_step) = self.equation(step.dynamics, step.matter, (time, h));
        let (displacements, counts) = self.newton.solve(step.dynamics, &equation, step.executor)?;
        self.taken.iter_mut().zip([1, counts[0], counts[1]]).for_each(|(sum, count)| *sum += count);
        if self.scheme == Scheme::Midpoint {
            for (index, &u) in displacements.iter().enumerate() {
                step.workspace.position.set(index, V::narrow(equation.from[index] + equation.position * u));
                step.workspace.velocity.set(index, V::narrow(u / h));
            }
            integrate(step, (time + 0.5 * h, [h, 0.0]))?;
        }
        self.move_particles(step, &equation, &displacements);
        // Velocities without contacts, to find out whether there are any.
        step.workspace.velocity.copy_from(&step.matter.velocity);
        let changed = step.drifted(h, DriftVelocity::End, None)?;
        let MatterStep { matter, workspace, .. } = &*step;
        let mut velocities = (0..matter.count()).map(|index| (workspace.velocity.get(index), matter.velocity.get(index)));
        let touched = changed || velocities.any(|(before, after)| before != after);
        self.before = if touched { 0.0 } else { h };
        step.end(h, self.drift())?;
        if self.scheme != Scheme::Midpoint {
            let shares = if two_step { [0.5 * h, 0.5 * h] } else { [h, 0.0] };
            step.workspace.position.copy_from(&step.matter.position);
            step.workspace.velocity.copy_from(&step.matter.velocity);
            integrate(step, (time + h, shares))?;
        }
        let MatterStep { dynamics, matter, workspace, executor, .. } = step;
        let dynamics = &**dynamics;
        let work = (matter.blocks(), BlockedSlice::new(&mut workspace.activity, 1));
        executor.for_each_block(work, &|(blocks, sum): (Blocks<'_, V>, BlockedSlice<'_, f64>)| {
            sum.items[0] = kernels::activity(dynamics, &blocks) + kernels::out_of_range(dynamics, &blocks);
        });
        Ok(workspace.activity.iter().sum())
    }

    /// Moves all particles by the displacements that solve an equation.
    fn move_particles<V: Space>(&self, step: &mut MatterStep<'_, V>, equation: &Equation, displacements: &[DVec3]) {
        let (matter, properties) = (&mut *step.matter, &step.dynamics.properties);
        for index in (0..matter.count()).filter(|&index| !properties.is_fixed(index)) {
            let (u, v) = (displacements[index], matter.velocity.get(index).widen());
            let velocity = match self.scheme {
                Scheme::Midpoint => 2.0 * u / equation.h - v,
                _ => equation.rate * u / equation.h + equation.offset[index],
            };
            matter.velocity.set(index, V::narrow(velocity));
            if self.scheme == Scheme::Bdf2 {
                matter.registers[DISPLACEMENT].set(index, V::narrow(u));
                matter.registers[VELOCITY].set(index, V::narrow(v));
            }
        }
        for index in 0..matter.count() {
            let moved = equation.from[index] + displacements[index];
            matter.set_exact_position(index, moved);
        }
    }

    /// Velocity of the drift. The midpoint rule keeps the energy of modes faster than a step; impulses on its paths would
    /// raise it.
    fn drift(&self) -> Option<DriftVelocity> {
        (self.scheme != Scheme::Midpoint).then_some(DriftVelocity::End)
    }
}

/// Adds the power at the state of the workspace times `share` [s], and the power of the last evaluation times `last` [s].
fn integrate<V: Space>(step: &mut MatterStep<'_, V>, (time, shares): (f64, [f64; 2])) -> Result<()> {
    let MatterStep { dynamics, workspace, executor, .. } = step;
    dynamics.prepare_at([&workspace.position, &workspace.velocity], time, executor)?;
    coupled::accelerate(step, time, shares, true);
    Ok(())
}

/// History: the size of the step before. BDF2's registers belong to matter.
impl History for Implicit {
    fn save(&mut self) {
        self.saved = self.before;
    }

    fn rollback(&mut self) {
        std::mem::swap(&mut self.saved, &mut self.before);
    }

    fn capture(&self, archive: &mut Archive) {
        archive.write("step", [self.before]);
    }

    fn restore(&mut self, archive: &mut Archive) -> Result<()> {
        self.before = archive.read_number("step")?;
        Ok(())
    }
}

impl<V: Space> Method<V> for Implicit {
    fn about(&self) -> MethodProperties {
        let order = if self.scheme == Scheme::BackwardEuler { 1 } else { 2 };
        let registers = if self.scheme == Scheme::Bdf2 { 2 } else { 0 };
        MethodProperties {
            name: self.name,
            orders: [order, order],
            // For a step whose equation is solved in about three iterations.
            evaluations: 4,
            memory: MethodMemory { registers, readable: registers, own: 6, damping: false },
            sweeps: true,
            angle: None,
            limit: |_| f64::INFINITY,
            springs: Treatment::Solved,
            drift: self.drift(),
            refusals: MethodRefusals::default(),
        }
    }

    fn persistent(&self) -> usize {
        if self.scheme == Scheme::Bdf2 { 2 } else { 0 }
    }

    fn error(&self, _state: &Matter<V>, _h: f64) -> Option<f64> {
        None
    }

    fn gains_energy(&self) -> bool {
        false
    }

    fn note(&self) -> Option<String> {
        let [steps, iterations, products] = self.taken;
        let mean = |count: u64| count as f64 / steps as f64;
        (steps > 0).then(|| {
            format!(
                "{}: {:.1} iterations of Newton's method per step, {:.0} products with its matrix",
                self.name,
                mean(iterations),
                mean(products)
            )
        })
    }

    fn bytes(&self) -> usize {
        self.newton.bytes()
    }

    fn bound(&self, bound: SpectralBound) -> SpectralBound {
        bound
    }

    /// Limit of the time step: none, every step is stable.
    fn limit(&self, _bound: &SpectralBound, _cache: &mut LimitCache) -> Limit {
        Limit::NONE
    }

    fn sharp_limit(&self, _bound: SpectralBound) -> Limit {
        Limit::NONE
    }

    fn take_springs(&mut self, dynamics: &Dynamics<V>) {
        self.newton.begin(dynamics);
    }

    fn begin(&mut self, job: Job<'_, V>, executor: &Executor) -> Result<()> {
        self.before = 0.0;
        self.newton.begin(job.dynamics);
        job.dynamics.prepare(job.state, job.interval.start, executor)
    }

    fn advance(&mut self, job: Job<'_, V>, executor: &Executor) -> Result<()> {
        let Some((mut step, activity, interval)) = job.coupled(executor) else { return Ok(()) };
        for index in 0..interval.steps {
            activity.push(self.step(&mut step, (interval.time(index, 0.0), interval.h))?);
            if executor.stopped() {
                break;
            }
        }
        Ok(())
    }
}
