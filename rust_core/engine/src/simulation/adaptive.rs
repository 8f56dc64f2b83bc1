//! Adaptive steps from the limit of the time step, between two times at which every step ends.
//!
//! **Blocks.** The interval H is halved recursively, into a binary tree of blocks H/2ᵏ. A block is one step if the largest
//! admissible step, at its beginning *and* at its end, is not below it:
//!
//! ```text
//!     0                               H/2                              H
//!     |---------------|-------|---|---|---|---|-------|----------------|     a close approach at H/2
//! ```
//!
//! The limit at the end is known only after the step. The step is therefore tried, and rejected if the limit at its end is
//! smaller. In reversed time the same blocks have the same ends, and are chosen again. Rare exceptions are blocks in which a
//! rejected step led to another end than its halves.
//!
//! A rule that uses the beginning alone makes smaller steps out of an approach than into it, or larger ones. The sign is
//! always the same, and the energy drifts. Source: D. M. Hernandez, W. Dehnen, Mon. Not. R. Astron. Soc. 522 (2023) 4639; for
//! the blocks S. J. Aarseth, Gravitational N-Body Simulations (2003).
//!
//! **Errors.** With a tolerance the steps follow from error estimates: see [`super::controlled`].

use super::halving::Halvings;
use super::monitor::StepSizes;
use super::{Segment, Simulation};
use crate::error::{Error, Result};
use crate::stability::Horizon;
use crate::systems::several::Division;

/// The rule of the step-size control.
#[derive(Debug, Clone, Copy)]
pub struct StepSizeRule {
    /// Safety factor: largest step in units of the present limit.
    pub safety: f64,
    /// Step without a limit [s].
    pub free: f64,
    /// Tolerance of the error per step, for error control: [m], or in the unit of the method's estimate.
    pub tolerance: Option<f64>,
}

/// An interval to be crossed in adaptive steps, and the progress in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Course {
    /// Start time [s].
    pub start: f64,
    /// Duration [s].
    pub interval: f64,
    /// Position in units of the finest block, a 2⁻⁴⁰ of the interval. With error control, 0 until the end.
    pub position: u64,
    /// Largest admissible step at the position [s], once it is known, without error control.
    pub allowed: Option<f64>,
}

impl Course {
    /// A course from its start.
    pub fn new(start: f64, interval: f64) -> Self {
        Self { start, interval, position: 0, allowed: None }
    }

    /// Whether its end is reached.
    pub fn is_complete(&self) -> bool {
        self.position == FINEST
    }
}

/// The state of the step-size control.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Adaptation {
    /// Number of steps rejected for a smaller limit at their end, or for their error.
    pub rejected: u64,
    /// Number of steps rejected for divergence.
    pub failed: u64,
    /// Smallest and largest step so far [s]; 0 before the first.
    pub range: [f64; 2],
    /// Next step of the error controller [s], and last error in units of the tolerance.
    pub control: [f64; 2],
}

/// Ratio of the interval to the smallest step: a power of two, so that halving is exact.
pub(super) const FINEST: u64 = 1 << 40;

/// The outcome of a trial step.
pub(super) enum Trial {
    Taken,
    Diverged(Error),
}

impl Simulation {
    /// Takes up to `steps` steps of a course, of sizes chosen by the rule. The steps do not depend on how the course is divided
    /// into calls.
    ///
    /// # Errors
    /// As [`Simulation::step`].
    pub fn cross(&mut self, course: &mut Course, steps: u64, rule: &StepSizeRule, interrupted: &dyn Fn() -> bool) -> Result<()> {
        let interval = course.interval;
        if !(interval.is_finite() && interval > 0.0) {
            return Err(Error::parameter("interval", "a finite number > 0", interval));
        }
        self.start(interrupted)?;
        self.set_division(self.division().map(|_| Division::default()));
        match rule.tolerance {
            None => self.advance_in_blocks(course, steps, rule, interrupted),
            Some(tolerance) => {
                let expected = "one that estimates its errors, for a tolerance";
                let estimates = || Error::parameter("integrator", expected, self.method());
                let (_, control) = self.system.error(0.0).ok_or_else(estimates)?;
                self.advance_by_errors(course, steps, rule, (tolerance, control), interrupted)
            }
        }
    }

    /// Advances in steps of the interval over powers of two, admissible at both of their ends.
    fn advance_in_blocks(
        &mut self,
        course: &mut Course,
        steps: u64,
        rule: &StepSizeRule,
        interrupted: &dyn Fn() -> bool,
    ) -> Result<()> {
        let varies = self.system.limit_varies(Horizon::Present, self.time());
        let (start, finest, mut left) = (course.start, course.interval / FINEST as f64, steps);
        let mut allowed = course.allowed.map_or_else(|| self.allowed(rule, interrupted), Ok)?;
        self.expect(allowed.min(course.interval));
        let (mut halvings, mut since) = (Halvings::default(), 0);
        // Largest block that begins at a position of the binary tree.
        let largest = |position: u64| if position == 0 { FINEST } else { position & position.wrapping_neg() };
        let mut block = largest(course.position);
        while course.position < FINEST && left > 0 {
            while block > 1 && block as f64 * finest > allowed {
                block /= 2;
            }
            let before = (self.segment, self.monitor, self.mach);
            let h = block as f64 * finest;
            self.segment = Segment { start, steps: course.position / block, dt: h };
            let halved = match self.attempt(before.0, interrupted)? {
                Trial::Taken => {
                    let end = if varies { self.allowed(rule, interrupted) } else { Ok(allowed) };
                    let end = end.inspect_err(|_| {
                        self.rollback(1);
                        (self.segment, self.monitor, self.mach) = before;
                    })?;
                    // In this form a NaN limit rejects the step.
                    let suits = end >= h;
                    if suits || block == 1 {
                        (course.position, course.allowed, allowed) = (course.position + block, Some(end), end);
                        halvings = Halvings::default();
                        self.count(h);
                        left -= 1;
                        false
                    } else {
                        self.rollback(1);
                        self.adaptation.rejected += 1;
                        true
                    }
                }
                Trial::Diverged(error) => {
                    self.fail(&mut halvings, block == 1, error)?;
                    true
                }
            };
            if halved {
                (self.segment, self.monitor, self.mach) = before;
                block /= 2;
            } else {
                block = largest(course.position);
            }
            self.poll(&mut since, !course.is_complete(), interrupted)?;
        }
        Ok(())
    }

    /// Largest admissible step of the rule in the present state [s].
    pub(super) fn allowed(&mut self, rule: &StepSizeRule, interrupted: &dyn Fn() -> bool) -> Result<f64> {
        let limit = match self.ask(interrupted, |system, time, executor| system.limit(Horizon::Present, time, executor)) {
            Err(Error::Undefined { .. }) => f64::NAN,
            limit => limit?.dt(),
        };
        Ok(if limit.is_infinite() { rule.free } else { rule.safety * limit })
    }

    /// Tries one step of the clock's length. After a divergence or an interrupt the clock is reset to `before`.
    pub(super) fn attempt(&mut self, before: Segment, interrupted: &dyn Fn() -> bool) -> Result<Trial> {
        match self.batch(1, StepSizes::Adaptive, interrupted) {
            Ok(_) => Ok(Trial::Taken),
            Err(Error::Diverged(divergence)) => {
                let error = self.with_hint(Error::Diverged(divergence), interrupted);
                self.segment = before;
                Ok(Trial::Diverged(error))
            }
            Err(other) => {
                self.segment = before;
                Err(other)
            }
        }
    }

    /// Counts a diverged step; returns its error if the step cannot be halved once more.
    pub(super) fn fail(&mut self, halvings: &mut Halvings, smallest: bool, error: Error) -> Result<()> {
        if smallest {
            return Err(error);
        }
        let outcome = halvings.count(error);
        self.adaptation.failed += u64::from(halvings.is_first());
        outcome
    }

    /// Counts an accepted step.
    pub(super) fn count(&mut self, h: f64) {
        let [smallest, largest] = self.adaptation.range;
        self.adaptation.range = [if smallest > 0.0 { smallest.min(h) } else { h }, largest.max(h)];
    }

    /// Polls for interrupts as often as in a run with equal steps.
    pub(super) fn poll(&self, since: &mut u64, unfinished: bool, interrupted: &dyn Fn() -> bool) -> Result<()> {
        *since += 1;
        // Computing the limit takes a few times as long as a step.
        if 4 * *since < self.hints.most_steps {
            return Ok(());
        }
        *since = 0;
        if unfinished && interrupted() { Err(Error::Interrupted) } else { Ok(()) }
    }
}
