//! The divergence monitor: detects divergence of a trajectory, and the step at which it occurs.
//!
//! After every step the activity is compared with a threshold; under an inverse-square field alone, after every 32nd step.
//! The activity is the kinetic energy at the step's last evaluation of the forces. A state whose activity is above the
//! threshold, or NaN, is diagnosed. A quantity that is not finite is a divergence. So is a rise of the energy balance by more
//! than `max_energy_growth` times the scale, the largest energy so far. The threshold then becomes twice the scale, or twice
//! the activity if that is larger. The budget is therefore computed only when the activity has doubled.
//!
//! Without an energy, the activity of a system is its largest |value|. It may rise by at most `max_energy_growth` times its
//! largest value so far, as far as the steps resolved its growth.
//!
//! A rise has to persist for one more step, so that the onset of a force is no divergence.
//!
//! The result is a function of the trajectory alone. Steps run in batches. If a step of a batch has to be diagnosed, the
//! batch is rolled back and repeated up to that step. To limit repetition, batches are no longer than the time since the last
//! diagnosis. A failed step does not enter the scale.

use super::{Simulation, Vigilance};
use crate::error::{Divergence, Error, Result};
use crate::ledger::{Class, Ledger};
use crate::parallel::SERIAL;
use crate::stability::Horizon;
use crate::systems::{Element, Fault, RecordedSteps, System};

/// Shortest batch after a diagnosis.
const SHORTEST: u64 = 8;
/// Number of steps in which an amplitude may double and its growth is still resolved.
const RESOLVED: u64 = 32;
/// Activity [J] above which other energies may overflow.
const LARGEST: f64 = 1e300;

/// The step sizes of a batch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum StepSizes {
    Equal,
    Adaptive,
}

/// The result of a diagnosis.
enum Finding {
    Good,
    /// A quantity is not finite.
    OutOfRange(Divergence),
    /// The energy balance has risen above the threshold.
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

/// State of the monitor.
#[derive(Debug, Clone, Copy)]
pub(super) struct Monitor {
    /// Largest rise of the balance in units of the scale; infinite if only quantities that are not finite count.
    pub max_energy_growth: f64,
    /// States that are diagnosed.
    pub vigilance: Vigilance,
    /// Scale: the largest energy so far [J].
    pub scale: f64,
    /// Smallest potential energy so far, or a lower bound of it [J].
    pub lowest: f64,
    /// Energy balance at the start [J].
    pub balance: f64,
    /// Threshold of the activity for a diagnosis [J].
    pub threshold: f64,
    /// Largest |value| reached by a resolved growth so far, of systems without an energy; 0 before there was any.
    pub amplitude: f64,
    /// Step of the last diagnosis of the amplitude.
    pub followed: u64,
    /// Steps since the last diagnosis, which only set the length of batches.
    pub quiet: u64,
}

impl Monitor {
    /// A monitor without history.
    pub fn new(max_energy_growth: f64, vigilance: Vigilance) -> Self {
        let (lowest, scale) = (f64::INFINITY, 0.0);
        Self { max_energy_growth, vigilance, scale, lowest, balance: 0.0, threshold: 0.0, amplitude: 0.0, followed: 0, quiet: 0 }
    }

    /// Initializes the monitor at a state with this energy. `lowest` is a lower bound of the potential energy, if one is
    /// known.
    pub fn begin(&mut self, energy: &Ledger, lowest: Option<f64>, epsilon: f64) {
        self.lowest = lowest.unwrap_or(f64::INFINITY);
        self.balance = energy.balance();
        self.observe(energy, 0.0, epsilon);
    }

    /// Updates the scale and the threshold by the energy and the activity [J] of a state. Returns the rise of the balance if
    /// it exceeds the threshold.
    pub fn observe(&mut self, energy: &Ledger, activity: f64, epsilon: f64) -> Option<f64> {
        let kinetic = energy.sum(Class::Kinetic);
        let activity = activity.max(kinetic);
        let rise = (energy.balance() - self.balance).max(0.0);
        let potential = energy.total() - kinetic;
        self.lowest = self.lowest.min(potential);
        // A spurious rise must not count as energy of the motion. Rounding makes noise relative to the terms of the
        // balance: a few roundings per term, with a wide margin.
        let (dissipated, work) = (energy.sum(Class::Dissipated), energy.sum(Class::Work));
        let shown = kinetic + (potential - self.lowest) + dissipated + work.abs() - rise;
        self.scale = self.scale.max(shown).max(1e-3 * epsilon * energy.magnitude());
        // Above the second bound the rise is a divergence. At the limit of stability the kinetic energy at a step's
        // evaluation is up to five times that at its end, which is at most scale + rise.
        let most = (1.0 + self.max_energy_growth).max(8.0) * self.scale;
        self.threshold = (2.0 * self.scale.max(activity)).min(most).min(f64::MAX);
        (rise > self.max_energy_growth * self.scale).then_some(rise)
    }

    /// Updates the amplitude and the threshold by a state after `steps` steps. Returns the ratio of its amplitude to the
    /// largest so far, if that exceeds the threshold. A growth that doubles in fewer than [`RESOLVED`] steps does not enter.
    pub fn follow(&mut self, amplitude: f64, steps: u64) -> Option<f64> {
        let resolved = steps >= self.followed + RESOLVED || self.amplitude == 0.0;
        if resolved && amplitude > self.amplitude {
            self.amplitude = amplitude;
        }
        self.followed = steps;
        self.threshold = self.threshold.max(2.0 * amplitude);
        (amplitude > (1.0 + self.max_energy_growth) * self.amplitude).then(|| amplitude / self.amplitude)
    }

    /// The state, for checkpoints.
    pub fn capture(&self) -> [f64; 6] {
        [self.scale, self.lowest, self.balance, self.threshold, self.amplitude, self.followed as f64]
    }

    /// Restores the state.
    pub fn restore(&mut self, [scale, lowest, balance, threshold, amplitude, followed]: [f64; 6]) {
        (self.scale, self.lowest, self.balance, self.threshold) = (scale, lowest, balance, threshold);
        (self.amplitude, self.followed) = (amplitude, followed as u64);
    }

    /// Adopts the amplitude of a given state.
    pub fn expect_amplitude(&mut self, amplitude: Option<f64>) {
        self.amplitude = self.amplitude.max(amplitude.unwrap_or_default());
        self.threshold = self.threshold.max(2.0 * self.amplitude);
    }

    /// Raises the scale to an energy that a step cannot resolve.
    pub fn expect(&mut self, energy: f64) {
        self.scale = if energy.is_finite() { self.scale.max(energy) } else { self.scale };
    }
}

impl Simulation {
    /// Takes up to `most` steps, adaptive or equal, all accepted by the monitor. Returns their number.
    pub(super) fn batch(&mut self, most: u64, rule: StepSizes, interrupted: &dyn Fn() -> bool) -> Result<u64> {
        let (record, threshold) = self.attention(rule);
        let steps = match (self.monitor.vigilance, record) {
            (Vigilance::EveryStep, _) => 1,
            (_, RecordedSteps::LastStep) => most,
            _ => most.min(self.monitor.quiet.max(SHORTEST)).min(self.hints.most_recorded),
        };
        match self.advance(steps, record, interrupted) {
            Err(error) if stops_a_step(&error) && steps > 1 => return self.batch(steps / 2, rule, interrupted),
            Err(error) if is_beyond_search(&error) => return Err(self.step_beyond_search(1)),
            Err(Error::Undefined { path, found, .. }) => return Err(self.in_next_step(self.undefined(&path, &found))),
            Err(Error::Diverged(divergence)) => return Err(self.in_next_step(*divergence)),
            outcome => outcome?,
        }
        let activity = self.system.activity();
        let Some(first) = activity.iter().position(|&activity| is_above(activity, threshold)) else {
            self.monitor.quiet = self.monitor.quiet.saturating_add(steps);
            self.observe_mach();
            return Ok(steps);
        };
        // A quantity that is not finite appears in the activity of the next step, or at the end of a batch.
        let known = steps == 1 || (activity.len() as u64 == steps && activity[first].is_finite());
        if !known {
            self.rollback(steps);
            return self.batch(steps / 2, rule, interrupted);
        }
        self.examine(first as u64 + 1, steps, interrupted)
    }

    /// Diagnoses step number `step` of the last batch of `steps`, and returns it if the monitor accepts it. Otherwise the
    /// simulation stands at the step before.
    fn examine(&mut self, step: u64, steps: u64, interrupted: &dyn Fn() -> bool) -> Result<u64> {
        if step < steps {
            self.rollback(steps);
            self.advance(step, RecordedSteps::LastStep, interrupted)?;
        }
        let finding = self.diagnose_or_roll_back(step, interrupted)?;
        let Some(divergence) = finding.divergence() else {
            self.monitor.quiet = 0;
            return Ok(step);
        };
        let (number, time) = (self.steps, self.time());
        self.rollback(step);
        if step > 1 {
            self.advance(step - 1, RecordedSteps::LastStep, interrupted)?;
        }
        if matches!(finding, Finding::Risen(_)) && self.is_onset(interrupted)? {
            self.monitor.quiet = 0;
            self.advance(1, RecordedSteps::LastStep, interrupted)?;
            return Ok(step);
        }
        Err(Error::Diverged(Box::new(Divergence { step: number, time, ..divergence })))
    }

    /// Whether a rise of the balance in the next step is the onset of a force, and does not persist in the following step. At
    /// an onset the first step tallies none of the work, and a system at rest has no kinetic energy for comparison.
    fn is_onset(&mut self, interrupted: &dyn Fn() -> bool) -> Result<bool> {
        match self.advance(2, RecordedSteps::LastStep, interrupted) {
            Err(error) if stops_a_step(&error) => return Ok(false),
            outcome => outcome?,
        }
        let finding = self.diagnose_or_roll_back(2, interrupted)?;
        self.rollback(2);
        Ok(matches!(finding, Finding::Good))
    }

    /// Diagnoses the present state, and updates the scale if it is good. If the diagnosis fails, rolls back by `steps`
    /// steps.
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

    /// Activities to record, and threshold for a diagnosis.
    fn attention(&self, rule: StepSizes) -> (RecordedSteps, f64) {
        // In steps that never double the energy only overflow needs a diagnosis.
        let certified = || self.limit(Horizon::Certified, &SERIAL);
        let tame = self.hints.linear && certified().is_ok_and(|limit| 2.0 * self.segment.dt <= limit.stability);
        match self.monitor.vigilance {
            Vigilance::OutOfRange => (RecordedSteps::LastStep, f64::MAX),
            Vigilance::EveryStep => (RecordedSteps::EveryStep, -1.0),
            Vigilance::Active if tame => (RecordedSteps::LastStep, LARGEST),
            Vigilance::Active if self.monitor.max_energy_growth.is_infinite() => (RecordedSteps::EveryStep, LARGEST),
            Vigilance::Active if rule == StepSizes::Adaptive => (RecordedSteps::EveryStep, self.monitor.threshold),
            Vigilance::Active => (RecordedSteps::Sampled, self.monitor.threshold),
        }
    }

    /// Diagnoses the present state; updates the scale.
    fn diagnose(&mut self, interrupted: &dyn Fn() -> bool) -> Result<Finding> {
        if let Some(Fault { element, quantity }) = self.system.fault() {
            return Ok(Finding::OutOfRange(divergence(element, quantity, "is not finite".to_owned())));
        }
        if self.monitor.vigilance == Vigilance::OutOfRange {
            return Ok(Finding::Good);
        }
        let energy = match self.ask(interrupted, System::audit) {
            Err(error) if is_beyond_search(&error) => return Ok(Finding::OutOfRange(self.beyond_search())),
            Err(Error::Undefined { path, found, .. }) => return Ok(Finding::OutOfRange(self.undefined(&path, &found))),
            outcome => outcome?,
        };
        // Energies are squares: they overflow long before the state does.
        if !energy.balance().is_finite() {
            return Ok(Finding::OutOfRange(divergence(self.system.fastest(), "energy", "is not finite".to_owned())));
        }
        let activity = self.system.activity().last().copied().unwrap_or_default();
        let rise = self.monitor.observe(&energy, activity, self.epsilon);
        let grown = self.system.hints().amplitude.and_then(|amplitude| self.monitor.follow(amplitude, self.steps));
        if let Some(ratio) = grown {
            let cause = format!("has run away: it is {ratio:.3e} times the largest value that a resolved growth had reached");
            return Ok(Finding::Risen(divergence(self.system.fastest(), "value", cause)));
        }
        Ok(rise.map_or(Finding::Good, |rise| {
            let scale = self.monitor.scale;
            let cause = format!(
                "has run away: the energy balance rose by {rise:.3e} J, where the largest energy of the motion was {scale:.3e} J"
            );
            Finding::Risen(divergence(self.system.fastest(), "energy", cause))
        }))
    }

    /// Adds the energy that steps of `dt` seconds cannot resolve to the scale: the kinetic energy of the first kick from
    /// rest. Only before the very first step: later the scale is known, and a kick may belong to a failed step.
    pub(super) fn expect(&mut self, dt: f64) {
        if self.steps > 0 {
            return;
        }
        let energy = self.system.resolvable(self.time(), dt);
        self.monitor.expect(energy);
    }

    /// Divergence of a state whose neighbors cannot be searched.
    fn beyond_search(&self) -> Divergence {
        divergence(self.system.fastest(), "position", "is so far away that it cannot be told who is near whom".to_owned())
    }

    /// Divergence of a state at which a user-defined function is not finite.
    fn undefined(&self, path: &str, found: &str) -> Divergence {
        let cause = format!("is where {path} returns {found}");
        let hint = "make it finite there, or ".to_owned();
        Divergence { element: "the scene".to_owned(), hint, ..divergence(self.system.fastest(), "state", cause) }
    }

    /// Error of a step, `steps` from here, in which neighbors could not be searched.
    fn step_beyond_search(&self, steps: u64) -> Error {
        let time = self.time() + steps as f64 * self.segment.dt;
        Error::Diverged(Box::new(Divergence { step: self.steps + steps, time, ..self.beyond_search() }))
    }

    /// Error of the next step, in which a method's equations had no solution.
    fn in_next_step(&self, divergence: Divergence) -> Error {
        let time = self.time() + self.segment.dt;
        Error::Diverged(Box::new(Divergence { step: self.steps + 1, time, ..divergence }))
    }

    /// Replaces an error by the divergence of the present state, if that is its cause.
    pub(super) fn or_divergence(&self, error: Error) -> Error {
        if !is_beyond_search(&error) {
            return error;
        }
        let hint = "take a smaller dt, or another integrator".to_owned();
        Error::Diverged(Box::new(Divergence { step: self.steps, time: self.time(), hint, ..self.beyond_search() }))
    }

    /// Adds a hint to a divergence, after the beginning of one that it has.
    pub(super) fn with_hint(&mut self, error: Error, interrupted: &dyn Fn() -> bool) -> Error {
        match error {
            Error::Diverged(divergence) => {
                // A user-defined function may fail during the estimate of its stiffness.
                let hint = self.hint(interrupted).unwrap_or_else(|_| format!("try dt = {:.3e} s", 0.25 * self.segment.dt));
                Error::Diverged(Box::new(Divergence { hint: divergence.hint.clone() + &hint, ..*divergence }))
            }
            other => other,
        }
    }

    /// Name of the first system's method.
    pub(super) fn method(&self) -> &'static str {
        self.system.stages().first().map_or("", |stages| stages.method)
    }

    /// Hint of a divergence, computed at the last good state.
    fn hint(&mut self, interrupted: &dyn Fn() -> bool) -> Result<String> {
        let limit = self.ask(interrupted, |system, time, executor| system.limit(Horizon::Sharp, time, executor))?;
        let dt = self.segment.dt;
        if limit.stability == 0.0 {
            let (certain, method) = (if limit.endured > 0.0 { "certain to be stable" } else { "stable" }, self.method());
            return Ok(format!("no dt is {certain} with {method} here: take another integrator"));
        }
        let (most, name, term) = (limit.dt(), limit.name(), limit.term);
        let first = self.first.filter(|first| first.dt() > 0.0 && dt >= RUN_AWAY * first.dt());
        Ok(if let Some(first) = first {
            let (most, name, term) = (first.dt(), first.name(), first.term);
            format!(
                "dt = {dt:.3e} s is beyond the {name} of {most:.3e} s at the start, set by {term}; take dt = {:.3e} s",
                0.9 * most
            )
        } else if dt > RUN_AWAY * most {
            let smaller = 0.25 * dt;
            format!("the {name} set by {term} had fallen to {most:.3e} s by then; try dt = {smaller:.3e} s, or AdaptiveStep()")
        } else if dt > most {
            format!("dt = {dt:.3e} s is beyond the {name} of {most:.3e} s set by {term}; dt = {:.3e} s would hold", 0.9 * most)
        } else if most.is_finite() {
            format!("dt = {dt:.3e} s is within the {name} of {most:.3e} s at the last good state; try dt = {:.3e} s", 0.25 * dt)
        } else {
            format!("nothing bounds dt at the last good state; try dt = {:.3e} s", 0.25 * dt)
        })
    }
}

/// Ratio of the time step to its limit in a state that has run away: the limit of such a state is no advice.
const RUN_AWAY: f64 = 100.0;

/// Divergence at an element, without the step and the hint.
fn divergence(Element { name, index }: Element, quantity: &'static str, cause: String) -> Divergence {
    Divergence { step: 0, time: 0.0, element: name, index, quantity, cause, hint: String::new() }
}

/// Whether an activity is above a threshold, or NaN.
fn is_above(activity: f64, threshold: f64) -> bool {
    activity.is_nan() || activity > threshold
}

/// Whether the error belongs to a single step, independent of the steps before.
fn stops_a_step(error: &Error) -> bool {
    is_beyond_search(error)
        || matches!(error, Error::Memory { .. } | Error::Callback { .. } | Error::Undefined { .. } | Error::Diverged(_))
}

/// Whether a step failed because positions are too large for a neighbor search. Positions diverge before they overflow.
fn is_beyond_search(error: &Error) -> bool {
    matches!(error, Error::Parameter { path, .. } if path == "positions")
}
