//! Step-size control by embedded error estimates.
//!
//! An embedded pair estimates the error by the difference between its result and one of the order below, which is O(hᵏ)
//! with the order k of the better one. The next step is 0.9 h (1/e)^(0.7/k) (e₀/1)^(0.4/k), with the errors e of this step
//! and e₀ of the one before in units of the tolerance: a PI controller, which does not oscillate where stability limits the
//! step.
//!
//! Sources: E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed. (1993), II.4; K.
//! Gustafsson, ACM Trans. Math. Softw. 17 (1991) 533; G. Söderlind, Numer. Algorithms 31 (2002) 281.

use super::adaptive::{FINEST, Trial};
use super::halving::Halvings;
use super::{Rule, Segment, Simulation};
use crate::error::Result;

/// Safety factor: the next step over the one whose error equals the tolerance.
const SAFETY: f64 = 0.9;
/// Minimum and maximum ratio of successive steps.
const SHRINK: f64 = 0.2;
const GROW: f64 = 5.0;
/// Range of errors in the controller, in units of the tolerance; beyond it the step changes at the maximum ratio.
const COUNT: [f64; 2] = [1e-4, 1e4];

impl Simulation {
    /// Steps whose estimated error is at most `tolerance` [m], by a method of an order.
    pub(super) fn advance_by_errors(
        &mut self,
        interval: f64,
        rule: &Rule,
        (tolerance, order): (f64, u32),
        interrupted: &dyn Fn() -> bool,
    ) -> Result<()> {
        let end = self.time() + interval;
        // Not below the resolution of the clock.
        let finest = (interval / FINEST as f64).max(4.0 * f64::EPSILON * end);
        if self.adaptation.control[0] == 0.0 {
            let first = self.allowed(rule, interrupted)?;
            self.adaptation.control = [if first > 0.0 { first } else { rule.free }, 1.0];
        }
        self.expect(self.adaptation.control[0].min(interval));
        let order = f64::from(order);
        let power = |error: f64, exponent: f64| libm::pow(error, exponent / order);
        let (mut halvings, mut since) = (Halvings::default(), 0);
        loop {
            let time = self.time();
            let left = end - time;
            if left <= finest {
                return Ok(());
            }
            let [wanted, last] = self.adaptation.control;
            let (h, ends) = fit(wanted.max(finest), left);
            let before = (self.segment, self.monitor, self.mach);
            self.segment = Segment { start: time, steps: 0, dt: h };
            match self.attempt(before.0, interrupted)? {
                Trial::Taken => {
                    let error = self.system.error(h).map_or(0.0, |(error, _)| error);
                    let found = (error / tolerance).clamp(COUNT[0], COUNT[1]);
                    if found <= 1.0 || h <= finest {
                        self.count(h);
                        let next = h * change(power(found, -0.7) * power(last, 0.4));
                        // A step truncated at the end of the interval says little about a longer one.
                        self.adaptation.control = [if h < wanted { next.max(wanted) } else { next }, found];
                        if ends {
                            self.segment = Segment { start: end, steps: 0, dt: h };
                        }
                        halvings = Halvings::default();
                    } else {
                        self.rollback(1);
                        self.adaptation.rejected += 1;
                        (self.segment, self.monitor, self.mach) = before;
                        self.adaptation.control[0] = h * change(power(found, -1.0)).min(SAFETY);
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

/// The step for the remaining `left` seconds, and whether it is the last one. The last two are equal, rather than a long
/// one and a short rest.
fn fit(wanted: f64, left: f64) -> (f64, bool) {
    if wanted >= left {
        (left, true)
    } else if 2.0 * wanted > left {
        (0.5 * left, false)
    } else {
        (wanted, false)
    }
}

/// The ratio of successive steps, from the factor of equal error.
fn change(factor: f64) -> f64 {
    (SAFETY * factor).clamp(SHRINK, GROW)
}
