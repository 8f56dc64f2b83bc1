//! Step-size control by error estimates.
//!
//! Each method has its [`Control`]. An embedded pair estimates the error by the difference from a result of the order below.
//! Gauss–Radau collocation estimates it by its last coefficient.

use super::adaptive::{FINEST, Trial};
use super::halving::Halvings;
use super::{Course, Segment, Simulation, StepSizeRule};
use crate::error::Result;
use crate::systems::Control;

impl Simulation {
    /// Takes up to `steps` steps of a course, whose estimated error is at most `tolerance`, by a method's control.
    pub(super) fn advance_by_errors(
        &mut self,
        course: &mut Course,
        steps: u64,
        rule: &StepSizeRule,
        (tolerance, control): (f64, Control),
        interrupted: &dyn Fn() -> bool,
    ) -> Result<()> {
        let (end, interval) = (course.start + course.interval, course.interval);
        // Not below the resolution of the clock.
        let finest = (interval / FINEST as f64).max(4.0 * f64::EPSILON * end);
        if self.adaptation.control[0] == 0.0 {
            let first = self.allowed(rule, interrupted)?;
            self.adaptation.control = [if first > 0.0 { first } else { rule.free }, 1.0];
        }
        self.expect(self.adaptation.control[0].min(interval));
        let (mut halvings, mut since, mut taken) = (Halvings::default(), 0, 0);
        loop {
            let time = self.time();
            let left = end - time;
            if left <= finest {
                course.position = FINEST;
                return Ok(());
            }
            if taken == steps {
                return Ok(());
            }
            let [wanted, last] = self.adaptation.control;
            let (h, ends) = fit(wanted.max(finest), left);
            let before = (self.segment, self.monitor, self.mach);
            self.segment = Segment { start: time, steps: 0, dt: h };
            match self.attempt(before.0, interrupted)? {
                Trial::Taken => {
                    let error = self.system.error(h).map_or(0.0, |(error, _)| error);
                    let found = (error / tolerance).clamp(control.errors[0], control.errors[1]);
                    if found <= control.accepted || h <= finest {
                        self.count(h);
                        let next = h * control.ratio(found, last);
                        // A step truncated at the end of the interval says little about a longer one.
                        self.adaptation.control = [if h < wanted { next.max(wanted) } else { next }, found];
                        if ends {
                            self.segment = Segment { start: end, steps: 0, dt: h };
                        }
                        (halvings, taken) = (Halvings::default(), taken + 1);
                    } else {
                        self.rollback(1);
                        self.adaptation.rejected += 1;
                        (self.segment, self.monitor, self.mach) = before;
                        self.adaptation.control[0] = h * control.retry(found);
                    }
                }
                Trial::Diverged(error) => {
                    self.fail(&mut halvings, h <= finest, error)?;
                    (self.segment, self.monitor, self.mach) = before;
                    self.adaptation.control[0] = 0.5 * h;
                }
            }
            self.poll(&mut since, true, interrupted)?;
        }
    }
}

/// Step for the remaining `left` seconds, and whether it is the last one. The last two steps are equal, instead of a long one
/// and a short rest.
fn fit(wanted: f64, left: f64) -> (f64, bool) {
    if wanted >= left {
        (left, true)
    } else if 2.0 * wanted > left {
        (0.5 * left, false)
    } else {
        (wanted, false)
    }
}
