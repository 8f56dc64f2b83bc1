//! The divergence monitor: whether a trajectory has left what its numerics can follow, and at which step.
//!
//! After every step the activity, the kinetic energy at the step's last evaluation of the forces, is compared with a threshold
//! (in every 32nd step, where nothing but an inverse-square field acts). Where it is above, or not a number, the state is
//! diagnosed: a number that is not finite is a divergence, and so is an energy balance that has risen by more than
//! `runaway` times the largest energy that the motion has shown, the scale. The threshold then becomes twice the scale, or
//! twice the activity if that is larger, so the budget is computed each time the motion has doubled, and nowhere else.
//!
//! A rise has to last for one more step, so that the onset of a force is none.
//!
//! All of it is a function of the trajectory: steps run in batches, and where one of a batch is to be diagnosed, the batch is
//! rolled back and taken again up to that step. So that little is taken twice, batches are no longer than the time since
//! the last diagnosis. What has failed leaves no trace in the scale.

use super::{Simulation, Vigilance, World};
use crate::audit::{self, Energy};
use crate::error::{Divergence, Error, Result};
use crate::math::{Real, Vector};
use crate::parallel::SERIAL;
use crate::stability::SpectralBound;
use crate::systems::matter::{Interval, Record};

/// The fewest steps after a diagnosis that may be taken again.
const SHORTEST: u64 = 8;
/// The activity [J] from which on other energies may be beyond the range of numbers.
const LARGEST: f64 = 1e300;

/// How long steps are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Steps {
    Equal,
    Adaptive,
}

/// What a diagnosis finds.
enum Finding {
    Good,
    /// A number is not finite.
    OutOfRange(Divergence),
    /// The energy balance has risen too far.
    Risen(Divergence),
}

impl Finding {
    fn divergence(&self) -> Option<Divergence> {
        match self {
            Self::Good => None,
            Self::OutOfRange(divergence) | Self::Risen(divergence) => Some(divergence.clone()),
        }
    }
}

/// What the monitor remembers.
#[derive(Debug, Clone, Copy)]
pub(super) struct Monitor {
    /// How much the balance may rise, in units of the scale; infinite where only numbers that are not finite count.
    pub runaway: f64,
    /// Which states are diagnosed.
    pub vigilance: Vigilance,
    /// The largest energy that the motion has shown [J].
    pub scale: f64,
    /// The smallest potential energy so far [J].
    pub lowest: f64,
    /// The balance at the start [J].
    pub balance: f64,
    /// The activity up to which nothing is diagnosed [J].
    pub threshold: f64,
    /// The steps since the last diagnosis. They only size the batches.
    pub quiet: u64,
}

impl Monitor {
    /// A monitor that has seen nothing.
    pub fn new(runaway: f64, vigilance: Vigilance) -> Self {
        Self { runaway, vigilance, scale: 0.0, lowest: f64::INFINITY, balance: 0.0, threshold: 0.0, quiet: 0 }
    }

    /// Takes in the energy and the activity [J] of a state; gives by how much the balance has risen if that is too much.
    pub fn observe(&mut self, energy: &Energy, activity: f64, epsilon: f64) -> Option<f64> {
        let rise = (energy.balance() - self.balance).max(0.0);
        let potential = energy.total() - energy.kinetic;
        self.lowest = self.lowest.min(potential);
        // What has risen for no reason must not pass for energy of the motion. Rounding makes noise on the scale of the
        // numbers that the balance is the sum of; a few roundings per term, and a wide margin.
        let shown = energy.kinetic + (potential - self.lowest) + energy.dissipated() + energy.work.abs() - rise;
        self.scale = self.scale.max(shown).max(1e-3 * epsilon * energy.magnitude());
        // Beyond the second a rise is too much: what moves at a step's evaluation is up to five times the kinetic energy, at
        // the limit of stability, and that is at most scale + rise.
        let most = (1.0 + self.runaway).max(8.0) * self.scale;
        self.threshold = (2.0 * self.scale.max(activity)).min(most).min(f64::MAX);
        (rise > self.runaway * self.scale).then_some(rise)
    }

    /// Takes in an energy that a step cannot resolve.
    pub fn expect(&mut self, energy: f64) {
        self.scale = if energy.is_finite() { self.scale.max(energy) } else { self.scale };
    }
}

impl<V: Vector> Simulation<V> {
    /// Takes up to `most` steps, which follow the motion or are equal, and gives how many. Each is one that the monitor lets pass.
    pub(super) fn batch(&mut self, most: u64, rule: Steps, interrupted: &dyn Fn() -> bool) -> Result<u64> {
        let (record, threshold) = self.attention(rule);
        let steps = match (self.monitor.vigilance, record) {
            (Vigilance::EveryStep, _) => 1,
            (_, Record::LastStep) => most,
            _ => most.min(self.monitor.quiet.max(SHORTEST)).min(self.system.most_recorded()),
        };
        match self.advance(steps, record, interrupted) {
            Err(error) if stops_a_step(&error) && steps > 1 => return self.batch(steps / 2, rule, interrupted),
            Err(error) if is_scattered(&error) => return Err(self.scattered(1)),
            outcome => outcome?,
        }
        let activity = self.system.activity();
        let Some(first) = activity.iter().position(|&activity| is_above(activity, threshold)) else {
            self.monitor.quiet = self.monitor.quiet.saturating_add(steps);
            let flow = self.fastest_flow();
            if flow > self.flow {
                self.flow = flow;
            }
            return Ok(steps);
        };
        // What is not finite is seen in the step after it, or at the end of a batch.
        let known = steps == 1 || (activity.len() as u64 == steps && activity[first].is_finite());
        if !known {
            self.rollback(steps)?;
            return self.batch(steps / 2, rule, interrupted);
        }
        self.examine(first as u64 + 1, steps, interrupted)
    }

    /// Diagnoses step number `step` of a batch of `steps` that was just taken, and gives it if the monitor lets it pass. Else
    /// the simulation stands at the step before.
    fn examine(&mut self, step: u64, steps: u64, interrupted: &dyn Fn() -> bool) -> Result<u64> {
        if step < steps {
            self.rollback(steps)?;
            self.advance(step, Record::LastStep, interrupted)?;
        }
        let finding = self.diagnose_or_roll_back(step, interrupted)?;
        let Some(divergence) = finding.divergence() else {
            self.monitor.quiet = 0;
            return Ok(step);
        };
        let (number, time) = (self.steps, self.segment.time());
        self.rollback(step)?;
        if step > 1 {
            self.advance(step - 1, Record::LastStep, interrupted)?;
        }
        if matches!(finding, Finding::Risen(_)) && self.is_onset(interrupted)? {
            self.monitor.quiet = 0;
            self.advance(1, Record::LastStep, interrupted)?;
            return Ok(step);
        }
        Err(Error::Diverged(Box::new(Divergence { step: number, time, ..divergence })))
    }

    /// Whether the balance that has risen in the next step has not risen too far in the one after that. Where a force sets in,
    /// the first step tallies none of its work, and where all was at rest there is nothing to compare its kinetic energy with.
    fn is_onset(&mut self, interrupted: &dyn Fn() -> bool) -> Result<bool> {
        match self.advance(2, Record::LastStep, interrupted) {
            Err(error) if stops_a_step(&error) => return Ok(false),
            outcome => outcome?,
        }
        let finding = self.diagnose_or_roll_back(2, interrupted)?;
        self.rollback(2)?;
        Ok(matches!(finding, Finding::Good))
    }

    /// Diagnoses the present state, and takes in its energy if it is good. If that cannot be done, goes back by `steps` steps.
    fn diagnose_or_roll_back(&mut self, steps: u64, interrupted: &dyn Fn() -> bool) -> Result<Finding> {
        let before = self.monitor;
        let finding = self.diagnose(interrupted);
        if !matches!(finding, Ok(Finding::Good)) {
            self.monitor = before;
        }
        if finding.is_err() {
            self.rollback(steps)?;
        }
        finding
    }

    /// Which activities to record, and up to which one nothing is to be diagnosed.
    fn attention(&self, rule: Steps) -> (Record, f64) {
        // In steps that never double the energy only its overflow has to be looked for.
        let tame = self.system.is_linear() && self.certified(&SERIAL).is_ok_and(|limit| 2.0 * self.segment.dt <= limit);
        match self.monitor.vigilance {
            Vigilance::OutOfRange => (Record::LastStep, f64::MAX),
            Vigilance::EveryStep => (Record::EveryStep, -1.0),
            Vigilance::Agitated if tame => (Record::LastStep, LARGEST),
            Vigilance::Agitated if self.monitor.runaway.is_infinite() => (Record::EveryStep, LARGEST),
            Vigilance::Agitated if rule == Steps::Adaptive => (Record::EveryStep, self.monitor.threshold),
            Vigilance::Agitated => (Record::Sampled, self.monitor.threshold),
        }
    }

    /// Goes back to before the last [`Simulation::advance`], of `steps` steps.
    pub(super) fn rollback(&mut self, steps: u64) -> Result<()> {
        self.system.rollback()?;
        self.segment.steps -= steps;
        self.steps -= steps;
        Ok(())
    }

    fn advance(&mut self, steps: u64, record: Record, interrupted: &dyn Fn() -> bool) -> Result<()> {
        let interval = Interval { start: self.segment.start, first: self.segment.steps, h: self.segment.dt, steps };
        self.system.advance(interval, record, interrupted)?;
        self.segment.steps += steps;
        self.steps += steps;
        Ok(())
    }

    /// What is wrong with the present state, if anything is; its energy is taken in.
    fn diagnose(&mut self, interrupted: &dyn Fn() -> bool) -> Result<Finding> {
        let state = self.system.state();
        for (quantity, columns) in [("position", &state.position), ("velocity", &state.velocity)] {
            if let Some(index) = columns.out_of_range() {
                return Ok(Finding::OutOfRange(self.divergence(index, quantity, "is not finite".to_owned())));
            }
        }
        if self.monitor.vigilance == Vigilance::OutOfRange {
            return Ok(Finding::Good);
        }
        let time = self.segment.time();
        let energy =
            match self.system.ask(interrupted, |dynamics, state, executor| audit::energy(dynamics, state, time, executor)) {
                Err(error) if is_scattered(&error) => return Ok(Finding::OutOfRange(self.scatter())),
                outcome => outcome?,
            };
        // Energies are squares: they leave the range of numbers long before the state does.
        if !energy.balance().is_finite() {
            return Ok(Finding::OutOfRange(self.divergence(self.fastest(), "energy", "is not finite".to_owned())));
        }
        let activity = self.system.activity().last().copied().unwrap_or_default();
        let rise = self.monitor.observe(&energy, activity.max(energy.kinetic), V::Scalar::EPSILON);
        Ok(rise.map_or(Finding::Good, |rise| {
            let scale = self.monitor.scale;
            let cause = format!(
                "has run away: the energy balance rose by {rise:.3e} J, where the largest energy of the motion was {scale:.3e} J"
            );
            Finding::Risen(self.divergence(self.fastest(), "energy", cause))
        }))
    }

    /// Takes in what steps of `dt` seconds cannot resolve, before the very first one: the energy of the first kick from rest.
    /// Later on the motion has shown its energy, and a kick may be that of a step that failed.
    pub(super) fn expect(&mut self, dt: f64) {
        if self.steps > 0 {
            return;
        }
        let (dynamics, state) = (self.system.dynamics(), self.system.state());
        let kick = dynamics.kick(&dynamics.view_of(state, self.segment.time(), &SERIAL), dt);
        self.monitor.expect(kick);
    }

    fn fastest(&self) -> usize {
        let (dynamics, state) = (self.system.dynamics(), self.system.state());
        let kinetic = |index: usize| dynamics.properties.mass[index] * state.velocity.get(index).widen().length_squared();
        let mobile = (0..state.count()).filter(|&index| !dynamics.properties.is_fixed(index));
        mobile.max_by(|&one, &other| kinetic(one).total_cmp(&kinetic(other))).unwrap_or(0)
    }

    /// What is wrong where neighbors can no longer be searched.
    fn scatter(&self) -> Divergence {
        self.divergence(self.fastest(), "position", "is so far away that it cannot be told who is near whom".to_owned())
    }

    /// The error of a step, `steps` from here, in which neighbors could not be searched.
    fn scattered(&self, steps: u64) -> Error {
        let time = self.segment.time() + steps as f64 * self.segment.dt;
        Error::Diverged(Box::new(Divergence { step: self.steps + steps, time, ..self.scatter() }))
    }

    fn divergence(&self, index: usize, quantity: &'static str, cause: String) -> Divergence {
        let particle = self.system.dynamics().properties.caller.get(index).map_or(0, |&caller| caller as usize);
        Divergence { step: 0, time: 0.0, particle, quantity, cause, hint: String::new() }
    }

    /// Adds to a divergence what to do about it.
    pub(super) fn with_hint(&self, error: Error) -> Error {
        match error {
            Error::Diverged(divergence) => {
                // A function of the user's may fail where it is asked how stiff it is.
                let hint = self.hint().unwrap_or_else(|_| format!("try dt = {:.3e} s", 0.25 * self.segment.dt));
                Error::Diverged(Box::new(Divergence { hint, ..*divergence }))
            }
            other => other,
        }
    }

    /// What to do about a divergence; asked for at the last good state.
    fn hint(&self) -> Result<String> {
        let (limit, dt) = ((self.sharpened)(self.bound(SpectralBound::directed)?), self.segment.dt);
        if limit.stability == 0.0 {
            let certain = if limit.endured > 0.0 { "certain to be stable" } else { "stable" };
            return Ok(format!("no dt is {certain} with {} here: take another integrator", self.plan.integrator));
        }
        let (most, name, term) = (limit.dt(), limit.name(), limit.term);
        Ok(if dt > most {
            format!("dt = {dt:.3e} s is beyond the {name} of {most:.3e} s set by {term}; dt = {:.3e} s would hold", 0.9 * most)
        } else if most.is_finite() {
            format!("dt = {dt:.3e} s is within the {name} of {most:.3e} s at the last good state; try dt = {:.3e} s", 0.25 * dt)
        } else {
            format!("nothing bounds dt at the last good state; try dt = {:.3e} s", 0.25 * dt)
        })
    }
}

/// Whether an activity is above a threshold; one that is not a number is.
fn is_above(activity: f64, threshold: f64) -> bool {
    activity.is_nan() || activity > threshold
}

/// Whether one step cannot be taken, whatever those before it were.
fn stops_a_step(error: &Error) -> bool {
    is_scattered(error) || matches!(error, Error::Memory { .. } | Error::Callback { .. })
}

/// Whether a step failed because particles are too far away to be searched: they diverge before their numbers do.
fn is_scattered(error: &Error) -> bool {
    matches!(error, Error::Parameter { path, .. } if path == "positions")
}
