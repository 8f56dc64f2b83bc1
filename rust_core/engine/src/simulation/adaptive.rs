//! Steps that follow the motion, between two times at which every step ends.
//!
//! **Blocks.** The interval H is halved as often as need be, a binary tree of blocks H/2ᵏ, and a block is one step where the
//! largest step that the scene allows, at its beginning *and* at its end, is not below it:
//!
//! ```text
//!     0                               H/2                              H
//!     |---------------|-------|---|---|---|---|-------|----------------|     a close approach at H/2
//! ```
//!
//! The end is known only after the step, which is therefore tried, and taken back where the end asks for less. Going
//! backwards, the same blocks have the same ends, and are chosen again, but for the rare ones in which a step that was
//! tried and taken back led to another end than its halves. A rule that looks at the beginning alone makes smaller steps
//! out of an approach than into it, or larger ones, always with the same sign, and the energy drifts.
//! Source: D. M. Hernandez, W. Dehnen, Mon. Not. R. Astron. Soc. 522 (2023) 4639; for the blocks S. J. Aarseth,
//! Gravitational N-Body Simulations (2003).
//!
//! **Errors.** With a tolerance the steps follow from their errors instead: see [`super::controlled`].

use super::monitor::Steps;
use super::{Segment, Simulation};
use crate::error::{Error, Result};
use crate::stability::Horizon;

/// How to choose the steps.
#[derive(Debug, Clone, Copy)]
pub struct Rule {
    /// The largest fraction of the present limit to use.
    pub safety: f64,
    /// The step where nothing limits it [s].
    pub free: f64,
    /// The error of each step [m], if that chooses the steps.
    pub tolerance: Option<f64>,
}

/// What adaptive steps remember.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Adaptation {
    /// How many steps were taken back because their end asked for smaller ones, or because their error was too large.
    pub rejected: u64,
    /// How many steps were taken back because they diverged.
    pub failed: u64,
    /// The smallest step taken so far and the largest [s]; 0 before the first.
    pub range: [f64; 2],
    /// The step that the controller of errors wants next [s], and the last error in units of the tolerance.
    pub control: [f64; 2],
}

/// The smallest steps are the interval divided by this: a power of two, so that halving it is exact.
pub(super) const FINEST: u64 = 1 << 40;
/// How often a step that diverges is halved in a row; only then it counts as divergence.
const HALVINGS: u32 = 10;

/// How a step that was tried came out.
pub(super) enum Trial {
    Taken,
    Diverged(Error),
}

impl Simulation {
    /// Advances by an interval [s] in steps of the rule's.
    pub(super) fn advance_adaptively(&mut self, interval: f64, rule: &Rule, interrupted: &dyn Fn() -> bool) -> Result<()> {
        if !(interval.is_finite() && interval > 0.0) {
            return Err(Error::parameter("interval", "a finite number > 0", interval));
        }
        match rule.tolerance {
            None => self.advance_in_blocks(interval, rule, interrupted),
            Some(tolerance) => {
                let expected = "one that estimates its errors, for a tolerance";
                let estimates = || Error::parameter("integrator", expected, self.method());
                let (_, order) = self.system.error(0.0).ok_or_else(estimates)?;
                self.advance_by_errors(interval, rule, (tolerance, order), interrupted)
            }
        }
    }

    /// Steps that divide the interval by powers of two, and suit both of their ends.
    fn advance_in_blocks(&mut self, interval: f64, rule: &Rule, interrupted: &dyn Fn() -> bool) -> Result<()> {
        let varies = self.system.limit_varies(Horizon::Present, self.time());
        let (start, finest) = (self.time(), interval / FINEST as f64);
        let mut allowed = self.allowed(rule, interrupted)?;
        self.expect(allowed.min(interval));
        let (mut place, mut failures, mut since) = (0, 0, 0);
        // The largest block that begins where we are: it ends where a block of twice its length begins or ends.
        let largest = |place: u64| if place == 0 { FINEST } else { place & place.wrapping_neg() };
        let mut block = largest(place);
        while place < FINEST {
            while block > 1 && block as f64 * finest > allowed {
                block /= 2;
            }
            let before = (self.segment, self.monitor, self.mach);
            let h = block as f64 * finest;
            self.segment = Segment { start, steps: place / block, dt: h };
            let halved = match self.attempt(before.0, interrupted)? {
                Trial::Taken => {
                    let end = if varies { self.allowed(rule, interrupted) } else { Ok(allowed) };
                    let end = end.inspect_err(|_| {
                        self.rollback(1);
                        (self.segment, self.monitor, self.mach) = before;
                    })?;
                    // Written so that a limit that is not a number asks for less.
                    let suits = end >= h;
                    if suits || block == 1 {
                        (place, failures, allowed) = (place + block, 0, end);
                        self.count(h);
                        false
                    } else {
                        self.rollback(1);
                        self.adaptation.rejected += 1;
                        true
                    }
                }
                Trial::Diverged(error) => {
                    self.fail(&mut failures, block == 1, error)?;
                    true
                }
            };
            if halved {
                (self.segment, self.monitor, self.mach) = before;
                block /= 2;
            } else {
                block = largest(place);
            }
            self.poll(&mut since, place < FINEST, interrupted)?;
        }
        Ok(())
    }

    /// The largest step that the rule allows in the present state [s].
    pub(super) fn allowed(&mut self, rule: &Rule, interrupted: &dyn Fn() -> bool) -> Result<f64> {
        let limit = self.ask(interrupted, |system, time, executor| system.limit(Horizon::Present, time, executor))?.dt();
        Ok(if limit.is_infinite() { rule.free } else { rule.safety * limit })
    }

    /// Tries one step of the clock's length. After a divergence or an interrupt the clock is back at `before`.
    pub(super) fn attempt(&mut self, before: Segment, interrupted: &dyn Fn() -> bool) -> Result<Trial> {
        match self.batch(1, Steps::Adaptive, interrupted) {
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

    /// Counts a step that diverged; gives its error if it cannot be halved once more.
    pub(super) fn fail(&mut self, failures: &mut u32, smallest: bool, error: Error) -> Result<()> {
        *failures += 1;
        self.adaptation.failed += u64::from(*failures == 1);
        if smallest || *failures > HALVINGS { Err(error) } else { Ok(()) }
    }

    /// Counts a step that was taken.
    pub(super) fn count(&mut self, h: f64) {
        let [smallest, largest] = self.adaptation.range;
        self.adaptation.range = [if smallest > 0.0 { smallest.min(h) } else { h }, largest.max(h)];
    }

    /// Asks as often as in a run with equal steps whether it was interrupted.
    pub(super) fn poll(&self, since: &mut u64, unfinished: bool, interrupted: &dyn Fn() -> bool) -> Result<()> {
        *since += 1;
        // Looking at the limit takes a few times as long as a step.
        if 4 * *since < self.system.most_steps() {
            return Ok(());
        }
        *since = 0;
        if unfinished && interrupted() { Err(Error::Interrupted) } else { Ok(()) }
    }
}
