//! The divergence monitor: whether a trajectory has left what its numerics can follow, and at which step.
//!
//! After every step the activity, the kinetic energy at the step's last evaluation of the forces, is compared with a threshold
//! (in every 32nd step, where nothing but an inverse-square field acts). Where it is above, or not a number, the state is
//! diagnosed: a number that is not finite is a divergence, and so is an energy balance that has risen by more than
//! `max_energy_growth` times the largest energy that the motion has shown, the scale. The threshold then becomes twice the scale, or
//! twice the activity if that is larger, so the budget is computed each time the motion has doubled, and nowhere else.
//!
//! A rise has to last for one more step, so that the onset of a force is none.
//!
//! All of it is a function of the trajectory: steps run in batches, and where one of a batch is to be diagnosed, the batch is
//! rolled back and taken again up to that step. So that little is taken twice, batches are no longer than the time since
//! the last diagnosis. What has failed leaves no trace in the scale.

use super::{Simulation, Vigilance};
use crate::error::{Divergence, Error, Result};
use crate::ledger::{Class, Ledger};
use crate::parallel::SERIAL;
use crate::stability::Horizon;
use crate::systems::{Element, Fault, Record};

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
    pub max_energy_growth: f64,
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
    pub fn new(max_energy_growth: f64, vigilance: Vigilance) -> Self {
        Self { max_energy_growth, vigilance, scale: 0.0, lowest: f64::INFINITY, balance: 0.0, threshold: 0.0, quiet: 0 }
    }

    /// Begins at a state with this energy.
    pub fn begin(&mut self, energy: &Ledger, epsilon: f64) {
        self.balance = energy.balance();
        self.observe(energy, 0.0, epsilon);
    }

    /// Takes in the energy and the activity [J] of a state; gives by how much the balance has risen if that is too much.
    pub fn observe(&mut self, energy: &Ledger, activity: f64, epsilon: f64) -> Option<f64> {
        let kinetic = energy.sum(Class::Kinetic);
        let activity = activity.max(kinetic);
        let rise = (energy.balance() - self.balance).max(0.0);
        let potential = energy.total() - kinetic;
        self.lowest = self.lowest.min(potential);
        // What has risen for no reason must not pass for energy of the motion. Rounding makes noise on the scale of the
        // numbers that the balance is the sum of; a few roundings per term, and a wide margin.
        let (dissipated, work) = (energy.sum(Class::Dissipated), energy.sum(Class::Work));
        let shown = kinetic + (potential - self.lowest) + dissipated + work.abs() - rise;
        self.scale = self.scale.max(shown).max(1e-3 * epsilon * energy.magnitude());
        // Beyond the second a rise is too much: what moves at a step's evaluation is up to five times the kinetic energy, at
        // the limit of stability, and that is at most scale + rise.
        let most = (1.0 + self.max_energy_growth).max(8.0) * self.scale;
        self.threshold = (2.0 * self.scale.max(activity)).min(most).min(f64::MAX);
        (rise > self.max_energy_growth * self.scale).then_some(rise)
    }

    /// What it remembers, for checkpoints.
    pub fn capture(&self) -> [f64; 4] {
        [self.scale, self.lowest, self.balance, self.threshold]
    }

    /// Goes on from that.
    pub fn restore(&mut self, numbers: [f64; 4]) {
        [self.scale, self.lowest, self.balance, self.threshold] = numbers;
    }

    /// Takes in an energy that a step cannot resolve.
    pub fn expect(&mut self, energy: f64) {
        self.scale = if energy.is_finite() { self.scale.max(energy) } else { self.scale };
    }
}

impl Simulation {
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
            let mach = self.system.mach();
            if mach > self.mach {
                self.mach = mach;
            }
            return Ok(steps);
        };
        // What is not finite is seen in the step after it, or at the end of a batch.
        let known = steps == 1 || (activity.len() as u64 == steps && activity[first].is_finite());
        if !known {
            self.rollback(steps);
            return self.batch(steps / 2, rule, interrupted);
        }
        self.examine(first as u64 + 1, steps, interrupted)
    }

    /// Diagnoses step number `step` of a batch of `steps` that was just taken, and gives it if the monitor lets it pass. Else
    /// the simulation stands at the step before.
    fn examine(&mut self, step: u64, steps: u64, interrupted: &dyn Fn() -> bool) -> Result<u64> {
        if step < steps {
            self.rollback(steps);
            self.advance(step, Record::LastStep, interrupted)?;
        }
        let finding = self.diagnose_or_roll_back(step, interrupted)?;
        let Some(divergence) = finding.divergence() else {
            self.monitor.quiet = 0;
            return Ok(step);
        };
        let (number, time) = (self.steps, self.time());
        self.rollback(step);
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
        self.rollback(2);
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
            self.rollback(steps);
        }
        finding
    }

    /// Which activities to record, and up to which one nothing is to be diagnosed.
    fn attention(&self, rule: Steps) -> (Record, f64) {
        // In steps that never double the energy only its overflow has to be looked for.
        let certified = || self.limit(Horizon::Certified, &SERIAL);
        let tame = self.system.is_linear() && certified().is_ok_and(|limit| 2.0 * self.segment.dt <= limit.stability);
        match self.monitor.vigilance {
            Vigilance::OutOfRange => (Record::LastStep, f64::MAX),
            Vigilance::EveryStep => (Record::EveryStep, -1.0),
            Vigilance::Active if tame => (Record::LastStep, LARGEST),
            Vigilance::Active if self.monitor.max_energy_growth.is_infinite() => (Record::EveryStep, LARGEST),
            Vigilance::Active if rule == Steps::Adaptive => (Record::EveryStep, self.monitor.threshold),
            Vigilance::Active => (Record::Sampled, self.monitor.threshold),
        }
    }

    /// What is wrong with the present state, if anything is; its energy is taken in.
    fn diagnose(&mut self, interrupted: &dyn Fn() -> bool) -> Result<Finding> {
        if let Some(Fault { element, quantity }) = self.system.fault() {
            return Ok(Finding::OutOfRange(divergence(element, quantity, "is not finite".to_owned())));
        }
        if self.monitor.vigilance == Vigilance::OutOfRange {
            return Ok(Finding::Good);
        }
        let energy = match self.ask(interrupted, |system, time, executor| system.audit(time, executor)) {
            Err(error) if is_scattered(&error) => return Ok(Finding::OutOfRange(self.scatter())),
            outcome => outcome?,
        };
        // Energies are squares: they leave the range of numbers long before the state does.
        if !energy.balance().is_finite() {
            return Ok(Finding::OutOfRange(divergence(self.system.fastest(), "energy", "is not finite".to_owned())));
        }
        let activity = self.system.activity().last().copied().unwrap_or_default();
        let rise = self.monitor.observe(&energy, activity, self.epsilon);
        Ok(rise.map_or(Finding::Good, |rise| {
            let scale = self.monitor.scale;
            let cause = format!(
                "has run away: the energy balance rose by {rise:.3e} J, where the largest energy of the motion was {scale:.3e} J"
            );
            Finding::Risen(divergence(self.system.fastest(), "energy", cause))
        }))
    }

    /// Takes in what steps of `dt` seconds cannot resolve, before the very first one: the energy of the first kick from rest.
    /// Later on the motion has shown its energy, and a kick may be that of a step that failed.
    pub(super) fn expect(&mut self, dt: f64) {
        if self.steps > 0 {
            return;
        }
        let energy = self.system.resolvable(self.time(), dt);
        self.monitor.expect(energy);
    }

    /// What is wrong where neighbors can no longer be searched.
    fn scatter(&self) -> Divergence {
        divergence(self.system.fastest(), "position", "is so far away that it cannot be told who is near whom".to_owned())
    }

    /// The error of a step, `steps` from here, in which neighbors could not be searched.
    fn scattered(&self, steps: u64) -> Error {
        let time = self.time() + steps as f64 * self.segment.dt;
        Error::Diverged(Box::new(Divergence { step: self.steps + steps, time, ..self.scatter() }))
    }

    /// Adds to a divergence what to do about it.
    pub(super) fn with_hint(&mut self, error: Error, interrupted: &dyn Fn() -> bool) -> Error {
        match error {
            Error::Diverged(divergence) => {
                // A function of the user's may fail where it is asked how stiff it is, and an impatient user may interrupt.
                let hint = self.hint(interrupted).unwrap_or_else(|_| format!("try dt = {:.3e} s", 0.25 * self.segment.dt));
                Error::Diverged(Box::new(Divergence { hint, ..*divergence }))
            }
            other => other,
        }
    }

    /// The name of the first system's method.
    pub(super) fn method(&self) -> &'static str {
        self.system.stages().first().map_or("", |stages| stages.method)
    }

    /// What to do about a divergence; asked for at the last good state.
    fn hint(&mut self, interrupted: &dyn Fn() -> bool) -> Result<String> {
        let limit = self.ask(interrupted, |system, time, executor| system.limit(Horizon::Sharp, time, executor))?;
        let dt = self.segment.dt;
        if limit.stability == 0.0 {
            let (certain, method) = (if limit.endured > 0.0 { "certain to be stable" } else { "stable" }, self.method());
            return Ok(format!("no dt is {certain} with {method} here: take another integrator"));
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

/// A divergence at an element, without the step and the hint.
fn divergence(Element { name, index }: Element, quantity: &'static str, cause: String) -> Divergence {
    Divergence { step: 0, time: 0.0, element: name, index, quantity, cause, hint: String::new() }
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
